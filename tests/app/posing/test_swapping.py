"""Left and right exchanged where they are seen."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.app.editor.documents import ActionRefused
from keypose.app.editor.posing import Exchange
from keypose.app.editor.state import EditorState
from keypose.app.editor.update import Undo, update
from keypose.app.posing import opening_pose, swap_left_right
from keypose.tracker.body.pose import Pose, joint_names, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.session import Session
from keypose.tracker.solver.posed import BodyPoints
from tests.tracker.formats import recordings

Floats = NDArray[np.float64]


def _seen(session: Session, pose: Pose) -> dict[str, Floats]:
    """Pixels of joints and landmarks by their names."""
    skeleton = Skeleton.of(session.subject.body)
    places = [((i, (0.0, 0.0, 0.0)),) for i in range(skeleton.part_count)]
    places += [
        ((i, p),)
        for i, part in enumerate(session.subject.body.parts)
        for p in part.landmarks.values()
    ]
    uv = session.view.camera.project(
        BodyPoints(skeleton, tuple(places)).at(pose_transforms(skeleton, pose))
    )
    return dict(zip(joint_names(skeleton), uv, strict=True))


def _other(name: str) -> str:
    swapped = {"left": "right", "right": "left"}
    side, _, rest = name.partition("_")
    return f"{swapped[side]}_{rest}" if side in swapped else name


@pytest.mark.parametrize("frame", [0, 48])
def test_the_left_limbs_are_seen_where_the_right_ones_were(frame: int) -> None:
    session = recordings.session("person")
    skeleton = Skeleton.of(session.subject.body)
    pose = next(k for k in session.subject.keyframes if k.frame == frame).pose(skeleton)
    before = _seen(session, pose)
    after = _seen(session, swap_left_right(skeleton, session.view.camera, pose))
    away = [np.linalg.norm(after[_other(name)] - uv) for name, uv in before.items()]
    stayed = [np.linalg.norm(after[name] - uv) for name, uv in before.items()]
    assert np.mean(away) < 1.5
    assert np.mean(stayed) > 20.0


def test_a_really_filmed_man_is_turned_around_at_about_his_distance() -> None:
    session = recordings.session("balance")
    skeleton = Skeleton.of(session.subject.body)
    pose = session.subject.keyframes[0].pose(skeleton)
    found = swap_left_right(skeleton, session.view.camera, pose)
    assert found.p_camera_root[2] == pytest.approx(pose.p_camera_root[2], rel=0.1)
    before, after = _seen(session, pose), _seen(session, found)
    assert np.mean([np.linalg.norm(after[_other(n)] - uv) for n, uv in before.items()]) < 8.0


def _state(session: Session) -> EditorState:
    return EditorState(
        doc=session.changed({"results": None}),
        skeleton=Skeleton.of(session.subject.body),
        file_times_s=np.arange(session.view.video.frame_count) / 30,
        opening=opening_pose(session.subject.body, session.view.camera),
        frame=0,
        selected=session.subject.body.parts[0].name,
    )


def test_the_page_exchanges_and_takes_back_in_one_step() -> None:
    state = _state(recordings.session("person"))
    after = update(state, Exchange())
    assert after.doc.subject.keyframes[0] != state.doc.subject.keyframes[0]
    assert after.doc.subject.keyframes[1:] == state.doc.subject.keyframes[1:]
    assert update(after, Undo()).doc == state.doc


def test_a_box_has_no_sides_to_exchange() -> None:
    with pytest.raises(ActionRefused, match="no left and right"):
        update(_state(recordings.session("box")), Exchange())
