"""Drafts found anew for another up direction still show what posed keyframes gave them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from keypose.app.jobs.lift import LiftDrafts
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import KeypointError
from keypose.tracker.keypoints.keypoints import JOINTS
from keypose.tracker.session import Session
from keypose.tracker.session.annotations import Drafted
from keypose.tracker.session.keyframe import Keyframe
from keypose.tracker.storage.sidecars import save_keypoints
from tests.tracker import session_cases as cases
from tests.tracker.fitting.draft.clips import CAMERA, joints_of, walk

FRAMES = 40
POSED = 20
BESIDE_PX = (9.0, -6.0)
ELBOW = JOINTS.index("left_elbow")
WALK = walk(FRAMES, 60)
NEAR = range(POSED + 1, POSED + 6)


class Quiet:
    """A worker that nobody cancels."""

    def report(self, *_: Any, **__: Any) -> None: ...

    def cancelled(self) -> bool:
        return False


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> tuple[Session, Path]:
    """A network that puts an elbow beside where the arm bends, and one frame that is posed."""
    given, skeleton = cases.session(), Skeleton.of(WALK.body)
    video = given.view.video.model_copy(
        update={"frame_count": FRAMES, "width": CAMERA.width, "height": CAMERA.height}
    )
    posed = Keyframe.of(skeleton, WALK.poses[POSED], POSED, POSED / 30)
    fields = {
        "video": video, "camera": CAMERA, "body": WALK.body, "keyframes": (posed,),
        "up_world": (0.0, -1.0, 0.0), "drafted": Drafted(first_frame=0, last_frame=FRAMES - 1),
    }  # fmt: skip
    uv = WALK.keypoints.uv.copy()
    uv[:, ELBOW] += BESIDE_PX
    path = tmp_path_factory.mktemp("walk") / "session.json"
    keypoints = replace(WALK.keypoints, uv=uv)
    made = given.changed(fields)
    return save_keypoints(made, path, keypoints, "network", network="0", seeds=(0,)), path.parent


def lifted(session: Session, folder: Path) -> dict[int, Pose]:
    frames = frozenset(range(FRAMES)) - {POSED}
    quiet: Any = Quiet()
    return dict(LiftDrafts(b"", "", str(folder), frames).work(session, quiet))


def off_px(poses: dict[int, Pose]) -> float:
    found = CAMERA.project(joints_of(WALK.body, [poses[frame] for frame in NEAR]))
    truth = CAMERA.project(WALK.joints_m[NEAR.start : NEAR.stop])
    return float(np.linalg.norm(found - truth, axis=-1)[:, ELBOW].mean())


def test_drafts_near_a_posed_keyframe_have_learned_from_it(session: tuple[Session, Path]) -> None:
    doc, folder = session
    alone = lifted(doc.changed({"keyframes": ()}), folder)
    beside = lifted(doc, folder)
    assert POSED not in beside
    assert off_px(beside) < 0.8 * off_px(alone)


def test_without_their_keypoints_they_cannot_be_found_anew(session: tuple[Session, Path]) -> None:
    doc, folder = session
    with pytest.raises(KeypointError, match="keypoints of the drafts are gone"):
        lifted(doc.changed({"keypoints": None}), folder)
