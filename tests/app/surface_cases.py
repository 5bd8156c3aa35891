"""A few steps of the sample's arms as a session of their own."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np

from keypose import sample_videos
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session import Keyframe, Session
from keypose.tracker.storage.files import load_session, save_session
from keypose.tracker.surface.files.sequence import MeshSequence

SAMPLE = Path(sample_videos.__file__).parent / "arms"
STEPS = 5


def meshes(folder: Path, steps: int = STEPS) -> Path:
    """The first steps of the sample, in a folder of their own."""
    folder.mkdir(parents=True)
    for file in sorted((SAMPLE / "meshes").iterdir())[:steps]:
        shutil.copy(file, folder)
    return folder


def session(steps: int = STEPS, keyframes: tuple[int, ...] = (0,), **surface: Any) -> Session:
    """Posed exactly at these frames."""
    whole = load_session(SAMPLE / "session.json")
    assert whole.view.surface is not None
    skeleton, truth = Skeleton.of(whole.subject.body), np.load(SAMPLE / "truth.npz")
    at_zero = whole.subject.keyframes[0].pose(skeleton)
    posed = []
    for frame in keyframes:
        pose = type(at_zero)(truth["Rs_parent_part"][frame], truth["ps_camera_root"][frame])
        posed.append(Keyframe.of(skeleton, pose, frame, frame / whole.view.surface.fps))
    video = whole.view.video.model_copy(update={"frame_count": steps})
    read = whole.view.surface.model_copy(update=surface)
    return whole.changed(
        {"video": video, "keyframes": tuple(posed), "surface": read, "results": None}
    )


def write_session(
    folder: Path, steps: int = STEPS, keyframes: tuple[int, ...] = (0,), **surface: Any
) -> Path:
    """The session file beside its meshes, whose fingerprint it knows."""
    of = session(steps, keyframes, **surface)
    with MeshSequence.open(meshes(folder / "meshes", steps)) as opened:
        video = of.view.video.model_copy(update={"fingerprint": opened.fingerprint()})
    path = folder / "session.json"
    save_session(of.changed({"video": video}), path)
    return path


def true_roots(steps: int = STEPS) -> Array:
    """(steps, 3) where the arms' common end is, camera frame, metres."""
    return np.asarray(np.load(SAMPLE / "truth.npz")["ps_camera_root"][:steps])


def true_rotations(steps: int = STEPS) -> Array:
    """(steps, 3, 3, 3) of the arms, in their parents' frames."""
    return np.asarray(np.load(SAMPLE / "truth.npz")["Rs_parent_part"][:steps])
