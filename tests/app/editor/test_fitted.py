"""A pose and sizes that were fitted are taken over as one step; a start is chosen at the door."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.app.editor.body import require_sizes_to_fit, with_body, with_sizes_fitted
from keypose.app.editor.documents import ActionRefused
from keypose.app.editor.posing import pose_to_fit, with_pose_fitted
from keypose.app.editor.shown import shown_pose
from keypose.app.editor.state import EditorState
from keypose.app.posing import with_height
from keypose.tracker.body.body import Body
from keypose.tracker.body.pose import Pose
from keypose.tracker.errors import KeyposeError
from keypose.tracker.session.schema import Session
from tests.app.editor.desk import after, desk
from tests.app.film_beside_cases import with_film

BACK = {"do": "undo"}


def nudged(pose: Pose, metres: float = 0.02) -> Pose:
    return Pose(pose.Rs_parent_part, pose.p_camera_root + np.array([metres, 0, 0]))


def test_a_fitted_keyframe_is_one_step_and_undo_is_exact() -> None:
    before = after(desk(), {"do": "go", "frame": 24})
    pose = nudged(pose_to_fit(before))
    done = with_pose_fitted(before, 24, pose)
    assert done.keys == before.keys
    assert shown_pose(done).source == "keyframe"
    np.testing.assert_allclose(shown_pose(done).pose.p_camera_root, pose.p_camera_root)
    assert done.history.past[-1].label == "fit the pose"
    undone = after(done, BACK)
    assert undone.doc is before.doc
    assert undone.frame == 24


def test_a_pose_fitted_between_keyframes_is_a_draft_and_k_keeps_it() -> None:
    before = after(desk(), {"do": "go", "frame": 10})
    done = with_pose_fitted(before, 10, nudged(pose_to_fit(before)))
    assert shown_pose(done).source == "draft"
    kept = after(done, {"do": "add_key", "frame": 10})
    assert 10 in kept.keys
    np.testing.assert_allclose(
        shown_pose(kept).pose.p_camera_root, shown_pose(done).pose.p_camera_root
    )


def test_a_pose_is_fitted_where_it_was_asked_for_though_one_has_gone_on() -> None:
    there = after(desk(), {"do": "go", "frame": 24})
    elsewhere = after(there, {"do": "go", "frame": 60})
    done = with_pose_fitted(elsewhere, 24, nudged(shown_pose(there).pose))
    assert done.frame == 60
    assert after(done, BACK).frame == 24


def test_without_a_pose_nothing_can_be_fitted() -> None:
    with pytest.raises(ActionRefused, match="Pose the body roughly first"):
        pose_to_fit(desk(keyframes=False))


def test_sizes_want_two_keyframes() -> None:
    with pytest.raises(ActionRefused, match="Needs 2 keyframes"):
        require_sizes_to_fit(after(desk(keyframes=False), {"do": "add_key", "frame": 0}))
    require_sizes_to_fit(desk())


def sized(state: EditorState, height_cm: float = 190.0, focal: float = 1.0) -> EditorState:
    body, camera = with_height(state.doc.subject.body, height_cm), state.doc.view.camera
    camera = camera.model_copy(update={"fx": focal * camera.fx, "fy": focal * camera.fy})
    poses = {k.frame: nudged(k.pose(state.skeleton)) for k in state.doc.subject.keyframes}
    return with_sizes_fitted(state, body, camera, poses)


def test_fitted_sizes_are_one_step_with_all_keyframes_and_undo_is_exact() -> None:
    before = desk()
    done = sized(before)
    assert done.doc.subject.body != before.doc.subject.body
    assert done.skeleton.body is done.doc.subject.body
    assert done.keys == before.keys
    for old, new in zip(before.doc.subject.keyframes, done.doc.subject.keyframes, strict=True):
        assert new.root_m[0] == pytest.approx(old.root_m[0] + 0.02)
        assert new.time_s == old.time_s
    undone = after(done, BACK)
    assert undone.doc is before.doc
    assert after(undone, {"do": "redo"}).doc is done.doc


def test_a_draft_goes_as_much_farther_away_as_the_fitted_lens_is_longer() -> None:
    drafted = after(desk(), {"do": "go", "frame": 10}, {"do": "root", "x": 0.3})
    done = sized(drafted, focal=1.2)
    (old,), (new,) = drafted.doc.subject.drafts, done.doc.subject.drafts
    assert new.root_m == pytest.approx((old.root_m[0], old.root_m[1], 1.2 * old.root_m[2]))


def test_all_that_is_posed_and_the_other_films_cameras_are_as_much_farther_away() -> None:
    drafted = after(desk(), {"do": "go", "frame": 10}, {"do": "root", "x": 0.3})
    state = drafted.with_doc(with_film(drafted.doc))
    poses = {k.frame: k.pose(state.skeleton) for k in state.doc.subject.keyframes}
    body, camera = state.doc.subject.body, state.doc.view.camera
    done = with_sizes_fitted(state, body, camera, poses, larger=1.1, apart=0.9)
    (old,), (new,) = state.doc.subject.drafts, done.doc.subject.drafts
    assert new.root_m == pytest.approx([1.1 * each for each in old.root_m])
    before, film = state.doc.views[1], done.doc.views[1]
    assert film.p_camera_world == pytest.approx([0.9 * p for p in before.p_camera_world], abs=1e-6)
    assert film.R_camera_world_wxyz == before.R_camera_world_wxyz
    assert after(done, BACK).doc is state.doc


def test_sizes_that_put_a_joint_behind_the_camera_are_refused() -> None:
    state = desk()
    near = {
        k.frame: Pose.rest(state.skeleton, (0.0, 0.0, 0.01)) for k in state.doc.subject.keyframes
    }
    with pytest.raises(KeyposeError, match="behind the camera"):
        with_sizes_fitted(state, state.doc.subject.body, state.doc.view.camera, near)


def test_another_body_forgets_parts_left_out_that_it_does_not_have() -> None:
    state = desk()
    settings = state.doc.settings.model_copy(update={"left_out": ("left_hand", "head")})
    state = state.with_doc(state.doc.changed({"settings": settings}))
    reported = state.doc.subject.body.model_dump()
    reported["parts"] = [part for part in reported["parts"] if part["name"] != "left_hand"]
    reported["mirror_pairs"] = [
        pair for pair in reported["mirror_pairs"] if "left_hand" not in pair
    ]
    doc = with_body(state, Body.model_validate(reported))
    assert doc.settings.left_out == ("head",)
    assert Session.model_validate_json(doc.model_dump_json()).subject.body == doc.subject.body
