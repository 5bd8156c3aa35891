"""The person sample with its true motion at every frame."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.session import Keyframe
from keypose.tracker.storage.files import load_session, save_session
from tests.app.serving import ROOT

PERSON = ROOT / "sample_videos" / "person"


def true_poses() -> list[Keyframe]:
    """The true pose of every frame."""
    skeleton = Skeleton.of(load_session(PERSON / "session.json").subject.body)
    with np.load(PERSON / "truth.npz") as truth:
        poses = list(zip(truth["Rs_parent_part"], truth["ps_camera_root"], strict=True))
    return [Keyframe.of(skeleton, Pose(*pose), n, n / 30) for n, pose in enumerate(poses)]


def change_session(path: Path, **fields: Any) -> None:
    """Save a session anew with these fields, and without keyframes of parts."""
    session = load_session(path)
    save_session(session.changed({"part_keyframes": (), **fields}), path)
