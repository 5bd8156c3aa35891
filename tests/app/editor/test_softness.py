"""How soft keyframes are by how they were posed, and that the motion is shown as it was solved."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from keypose.app.editor.motion import angle_curve, motion_between
from keypose.app.editor.shown import find, ghosts, shown_pose
from keypose.app.editor.state import EditorState
from keypose.tracker.body.trajectory import interpolate
from keypose.tracker.session.settings import TrackSettings
from keypose.tracker.session.verdict import GOOD
from keypose.tracker.storage.results import Results, segment_keys
from keypose.tracker.tracking.result import SegmentResult
from tests.app.editor.desk import after, desk

FRAME = 24
MAIN = {"do": "drag", "view": "main", "handle": {"kind": "root"}, "from": [300, 200]}
RIGHT = {**MAIN, "at": [312, 200]}
FARTHER = {**RIGHT, "depth": True}
FROM_THE_SIDE = {**RIGHT, "view": "side", "from": [0.0, 0.0], "at": [0.2, 0.0]}


def drafted(frame: int = 12) -> EditorState:
    """A draft that drafting the film has found."""
    state = after(desk(), {"do": "go", "frame": frame})
    pose = shown_pose(state).pose
    state = after(state, {"do": "root", "x": float(pose.p_camera_root[0])})
    draft = find(state.doc.subject.drafts, frame)
    assert draft is not None
    found = draft.model_copy(update={"drafted": True, "soft": False})
    return state.with_doc(state.doc.changed({"drafts": (found,)}))


def tracked(state: EditorState, smooth: bool = True) -> EditorState:
    """Every segment tracked, and a centimetre to the right of what is between its keyframes."""
    settings = TrackSettings(smooth=smooth)
    doc = state.doc.changed({"settings": settings})
    state, results = state.with_doc(doc), Results()
    for (first, last), key in segment_keys(doc).items():
        start, end = (find(doc.subject.keyframes, frame) for frame in (first, last))
        assert start is not None
        assert end is not None
        path = interpolate(start.pose(state.skeleton), end.pose(state.skeleton), first, last)
        R, t = path.writable()
        t[:, 0] += 0.01
        moved = type(path)(first, R, t)
        empty: Any = None
        found = SegmentResult(moved, GOOD, empty, (1.0,), ("pass",), key=key, quality="full")
        results = results.with_result(found)
    return state.with_results(results)


def softness(state: EditorState, frame: int) -> Any:
    keyframe = find(state.doc.subject.keyframes, frame)
    assert keyframe is not None
    return keyframe.soft


KEPT = {
    "a draft as it was found": ([], True),
    "a draft dragged in the picture": ([RIGHT], "depth"),
    "a draft whose arm was turned": ([{"do": "angles", "part": "left_forearm", "x": -30}], "depth"),
    "a draft put farther away": ([FARTHER], False),
    "a draft dragged from the side": ([FROM_THE_SIDE], False),
    "a draft dragged in the picture, then from the side": ([RIGHT, FROM_THE_SIDE], False),
}


@pytest.mark.parametrize("case", KEPT)
def test_a_draft_becomes_as_soft_a_keyframe_as_it_was_posed(case: str) -> None:
    messages, soft = KEPT[case]
    keyed = after(drafted(), *messages, {"do": "add_key", "frame": 12})
    assert softness(keyed, 12) == soft


DRAFTED: dict[str, tuple[list[dict[str, Any]], int, bool]] = {
    "as it is": ([], 12, True),
    "softened": ([{"do": "soften_key", "frame": 12}], 12, True),
    "met exactly": ([{"do": "exact_key", "frame": 12}], 12, False),
    "posed": ([RIGHT], 12, False),
    "turned": (
        [{"do": "key_angle", "frame": 12, "part": "head", "axis": "x", "deg": 9.0}], 12, False
    ),
    "at another frame": ([{"do": "move_key", "frame": 12, "to": 14}], 14, False),
    "shifted with others": (
        [{"do": "retime_keys", "frames": [12, 24], "to": [12, 26]}], 12, True
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", DRAFTED)
def test_a_keyframe_made_of_a_draft_counts_as_one_until_somebody_poses_it(case: str) -> None:
    messages, frame, found = DRAFTED[case]
    keyed = after(drafted(), {"do": "add_key", "frame": 12}, *messages)
    keyframe = find(keyed.doc.subject.keyframes, frame)
    assert keyframe is not None
    assert keyframe.drafted == found


def test_what_a_person_poses_from_nothing_is_exact() -> None:
    keyed = after(desk(), {"do": "go", "frame": 12}, RIGHT, {"do": "add_key", "frame": 12})
    assert softness(keyed, 12) is False


def test_a_tracked_pose_that_is_kept_counts_in_the_picture_where_the_motion_is_smoothed() -> None:
    keep = {"do": "add_key", "frame": 12}
    assert softness(after(tracked(desk()), keep), 12) == "depth"
    assert softness(after(tracked(desk(), smooth=False), keep), 12) is False
    dragged = after(tracked(desk()), {"do": "go", "frame": 12}, RIGHT, keep)
    assert softness(dragged, 12) == "depth"


def test_a_keyframe_stays_exact_until_it_is_softened_and_then_in_depth_when_it_is_posed() -> None:
    at = after(desk(), {"do": "go", "frame": FRAME})
    assert softness(after(at, RIGHT), FRAME) is False
    soft = after(at, {"do": "soften_key", "frame": FRAME})
    assert softness(after(soft, RIGHT), FRAME) == "depth"
    assert softness(after(soft, {"do": "key_angle", "frame": FRAME, "part": "head", "axis": "x",
                                 "deg": 9.0}), FRAME) is True  # fmt: skip


def test_a_soft_keyframe_is_shown_as_the_motion_passes_it_and_its_own_pose_as_a_ghost() -> None:
    exact = tracked(desk())
    soft = tracked(after(desk(), {"do": "soften_key", "frame": FRAME}))
    own = find(soft.doc.subject.keyframes, FRAME)
    assert own is not None
    there = shown_pose(soft, FRAME)
    assert there.source == "keyframe"
    assert there.pose.p_camera_root[0] == pytest.approx(own.root_m[0] + 0.01)
    assert shown_pose(exact, FRAME).pose.p_camera_root[0] == pytest.approx(own.root_m[0])
    at = after(soft, {"do": "go", "frame": FRAME})
    assert [frame for frame, _ in ghosts(at)] == [0, 48, FRAME]
    assert dict(ghosts(at))[FRAME].p_camera_root[0] == pytest.approx(own.root_m[0])


def test_play_and_curves_pass_a_soft_keyframe_without_a_jump() -> None:
    soft = tracked(after(desk(), {"do": "soften_key", "frame": FRAME}))
    roots = motion_between(soft, FRAME - 3, FRAME + 3).Ts_world_part[:, 0, :3, 3]
    steps = np.linalg.norm(np.diff(roots, 2, axis=0), axis=-1)
    assert steps.max() < 0.005
    exact = motion_between(tracked(desk()), FRAME - 3, FRAME + 3).Ts_world_part[:, 0, :3, 3]
    assert np.linalg.norm(np.diff(exact, 2, axis=0), axis=-1).max() > 0.01
    assert np.isfinite(angle_curve(soft, 0)[FRAME]).all()
