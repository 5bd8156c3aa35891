"""The frames before and after one say on which side a joint lies whose bone is level."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.app.editor.documents import keyframe_of, with_drafts
from keypose.app.editor.shown import poses_beside, shown_pose
from keypose.app.editor.state import EditorState
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.depth_turn import turned_in_depth
from tests.app.editor.desk import after, desk

FRAME = 48
SHOULDER = "left_upper_arm"
ELBOW = "left_forearm"


def drafted(state: EditorState, poses: dict[int, Pose]) -> EditorState:
    """With drafts of these poses."""
    made = [keyframe_of(state.skeleton, pose, f, state.times_s) for f, pose in poses.items()]
    return state.with_doc(with_drafts(state.doc, made))


def joints(state: EditorState, pose: Pose) -> tuple[Array, Array]:
    """(3,) shoulder and elbow."""
    p = pose_transforms(state.skeleton, pose)[:, :3, 3]
    index = state.doc.subject.body.index
    return p[index(SHOULDER)], p[index(ELBOW)]


def farther_m(state: EditorState, pose: Pose) -> float:
    """How much farther away than the shoulder the elbow is, along its line of sight."""
    shoulder, elbow = joints(state, pose)
    return float((elbow - shoulder) @ elbow / np.linalg.norm(elbow))


def dragged(state: EditorState, way: Array) -> EditorState:
    """The elbow dragged on the picture by a way (2,) in pixels."""
    handle, at = {"kind": "joint", "name": "left_elbow"}, way.tolist()
    return after(state, {"do": "drag", "view": "main", "handle": handle, "from": [0, 0], "at": at})


def test_frames_between_keyframes_that_are_not_tracked_have_no_poses_of_their_own() -> None:
    state = desk()
    assert poses_beside(state, 12) == ()
    assert len(poses_beside(state, 25)) == 1, "24 is a keyframe"
    pose = shown_pose(state, 0).pose
    assert len(poses_beside(drafted(state, {11: pose, 13: pose}), 12)) == 2
    assert poses_beside(state, 0) == ()


@pytest.mark.parametrize("turned", [False, True])
def test_an_arm_that_became_level_is_bent_to_the_side_where_it_is_drafted_beside(
    turned: bool,
) -> None:
    """Its elbow is dragged out until the upper arm lies level, and back."""
    state = after(desk(), {"do": "go", "frame": FRAME})
    pose, index = shown_pose(state).pose, state.doc.subject.body.index(SHOULDER)
    camera = state.doc.view.camera
    beside = turned_in_depth(state.skeleton, camera, pose, index) if turned else pose
    assert (farther_m(state, beside) * farther_m(state, pose) < 0) == turned
    state = drafted(state, {FRAME - 1: beside, FRAME + 1: beside})
    shoulder, elbow = joints(state, pose)
    seen = camera.project(np.stack([shoulder, elbow]))
    bone_px = np.linalg.norm(elbow - shoulder) * camera.fx / shoulder[2]
    way = seen[1] - seen[0]
    out = way / np.linalg.norm(way) * bone_px - way
    level = dragged(state, out)
    assert abs(farther_m(state, shown_pose(level).pose)) < 0.02
    back = dragged(level, -out)
    assert farther_m(state, shown_pose(back).pose) * farther_m(state, beside) > 0
