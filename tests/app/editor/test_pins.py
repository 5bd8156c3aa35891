"""Points that stand still are pinned over ranges of frames, and the floor is laid under them."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from keypose.app.editor.actions import ACTIONS
from keypose.app.editor.documents import ActionRefused
from keypose.app.editor.pinned import open_proposals, pinned_ends
from keypose.app.editor.shown import shown_pose
from keypose.app.editor.state import EditorState
from keypose.app.posing import tilt_and_roll
from keypose.app.state.app_state import AppState
from keypose.app.store.sections import space_values
from keypose.tracker.body.pose import Pose, joint_names, joint_positions, pose_transforms
from keypose.tracker.body.trajectory import Pass, Trajectory
from keypose.tracker.geometry.horizon import horizon_of
from keypose.tracker.geometry.rotations import exp_rotation
from keypose.tracker.session.keyframe import Keyframe
from keypose.tracker.session.pins import Pin
from keypose.tracker.session.schema import Session
from keypose.tracker.session.verdict import GOOD
from keypose.tracker.storage import changes
from keypose.tracker.storage.results import Results, segment_keys
from keypose.tracker.tracking.result import SegmentResult
from tests.app.editor.desk import after, desk

FOOT = {"do": "set_pin", "part": "left_foot"}
SOLE = ("left_heel", "left_toe")


def pinned(first: int, last: int, frame: int | None = None) -> EditorState:
    return after(desk(), {**FOOT, "frame": frame or first, "first": first, "last": last})


def spans(state: EditorState) -> list[tuple[int, int]]:
    return [pin.span for pin in state.doc.subject.pins]


def stepping(stands: tuple[int, int], m_per_frame: float = 0.05) -> EditorState:
    """The sample tracked over 0–24, the body moving sideways but for these frames."""
    edit = desk()
    pose = edit.doc.subject.keyframes[0].pose(edit.skeleton)
    frames = np.arange(25)
    moved = m_per_frame * (np.minimum(frames, stands[0]) + np.maximum(frames - stands[1], 0))
    ps = pose.p_camera_root + moved[:, None] * [1.0, 0.0, 0.0]
    path = Trajectory(0, np.repeat(pose.Rs_parent_part[None], 25, axis=0), ps)
    key = segment_keys(edit.doc)[0, 24]
    found = replace(SegmentResult.on_the_way(Pass("pass", path, 1.0), key), verdict=GOOD)
    return edit.with_results(Results({key: found}))


# --- setting


def test_a_foot_is_pinned_by_heel_and_toe_and_a_hand_by_its_joint() -> None:
    state = after(desk(), {**FOOT, "frame": 30}, {"do": "set_pin", "part": "left_hand", "frame": 3})
    assert [pin.landmarks for pin in state.doc.subject.pins] == [SOLE, ()]


@pytest.mark.parametrize("frame", [8, 10, 14])
def test_a_pin_set_where_the_foot_stands_still_lasts_as_long_as_it_stands(frame: int) -> None:
    state = after(stepping((8, 14)), {**FOOT, "frame": frame})
    ((first, last),) = spans(state)
    assert abs(first - 8) <= 1
    assert abs(last - 14) <= 1


def test_a_pin_set_where_the_foot_moves_is_five_frames_long() -> None:
    assert spans(after(stepping((24, 24)), {**FOOT, "frame": 6})) == [(4, 8)]


def test_a_foot_that_moves_off_slowly_is_not_pinned_for_ever() -> None:
    slow = after(stepping((24, 24), m_per_frame=0.008), {**FOOT, "frame": 12})
    ((first, last),) = spans(slow)
    assert first > 0
    assert last < 24


def test_where_a_pinned_foot_stands_is_known_also_beyond_its_pin() -> None:
    state = after(stepping((8, 14)), {**FOOT, "frame": 11, "first": 10, "last": 12})
    (still, *_) = space_values.still(AppState(edit=state))
    assert still == [8, 14]
    untracked = after(desk(), {**FOOT, "frame": 11})
    assert space_values.still(AppState(edit=untracked)) == [None]


@pytest.mark.parametrize(
    ("frame", "span"), [(0, (0, 24)), (30, (24, 48)), (48, (48, 72)), (72, (48, 72))]
)
def test_where_nothing_is_tracked_a_pin_lasts_from_keyframe_to_keyframe(
    frame: int, span: tuple[int, int]
) -> None:
    assert spans(after(desk(), {**FOOT, "frame": frame})) == [span]


def test_without_keyframes_a_pin_is_five_frames_long() -> None:
    assert spans(after(desk(keyframes=False), {**FOOT, "frame": 0})) == [(0, 4)]


def test_a_new_pin_ends_where_the_next_one_of_the_same_foot_begins() -> None:
    state = after(pinned(30, 40), {**FOOT, "frame": 26})
    assert spans(state) == [(30, 40), (24, 29)]


def test_a_corner_is_pinned_where_one_points_at_it() -> None:
    state = after(desk(), {"do": "go", "frame": 24})
    hand = state.doc.subject.body.parts[state.doc.subject.body.index("left_hand")]
    T = pose_transforms(state.skeleton, state.doc.subject.keyframes[1].pose(state.skeleton))
    T_hand = T[state.doc.subject.body.index("left_hand")]
    for corner in hand.shape.mesh().vertices:
        uv = state.doc.view.camera.project(T_hand[:3, :3] @ corner + T_hand[:3, 3]).tolist()
        pointed = {"do": "set_pin", "part": "left_hand", "frame": 24, "corner": uv}
        (pin,) = after(state, pointed).doc.subject.pins
        assert pin.point_m == pytest.approx(corner)
        assert pin.landmarks == ()


def test_a_corner_of_a_part_that_is_behind_the_camera_is_refused() -> None:
    state = desk()
    near = Pose.rest(state.skeleton, (0.0, 0.0, -4.0))
    keyframes = (Keyframe.of(state.skeleton, near, 24, 0.8),)
    state = state.with_doc(state.doc.changed({"keyframes": keyframes}))
    pointed = {"do": "set_pin", "part": "left_hand", "frame": 24, "corner": [5, 5]}
    with pytest.raises(ActionRefused, match="Left hand cannot be seen at frame 24"):
        after(state, pointed)


def test_heel_and_toe_are_pinned_over_frames_of_their_own() -> None:
    heel = {**FOOT, "frame": 3, "first": 0, "last": 20, "landmarks": ["left_heel"]}
    toe = {**FOOT, "frame": 3, "first": 0, "last": 30, "landmarks": ["left_toe"]}
    assert spans(after(desk(), heel, toe)) == [(0, 20), (0, 30)]


# --- changing


def test_both_ends_are_trimmed_and_stop_at_the_neighbours() -> None:
    state = after(pinned(30, 40), {**FOOT, "frame": 10, "first": 10, "last": 20})
    longer = after(state, {"do": "change_pin", "index": 1, "last": 60})
    assert spans(longer) == [(30, 40), (10, 29)]
    assert spans(after(longer, {"do": "change_pin", "index": 0, "first": 5})) == [
        (30, 40), (10, 29),
    ]  # fmt: skip
    assert spans(after(longer, {"do": "change_pin", "index": 1, "first": 70})) == [
        (30, 40), (28, 29),
    ]  # fmt: skip
    assert spans(after(longer, {"do": "change_pin", "index": 0, "last": 999}))[0] == (30, 72)


def test_a_pin_that_is_moved_keeps_its_length_against_neighbours_and_the_ends_of_the_video() -> (
    None
):
    state = after(pinned(30, 40), {**FOOT, "frame": 10, "first": 10, "last": 20})
    move = {"do": "change_pin", "index": 1}
    assert spans(after(state, {**move, "first": 25, "last": 35}))[1] == (19, 29)
    assert spans(after(state, {**move, "first": 0, "last": 10}))[1] == (0, 10)
    right = {"do": "change_pin", "index": 0, "first": 90, "last": 100}
    assert spans(after(state, right))[0] == (62, 72)


def test_one_drag_of_a_bar_is_one_step_of_undo() -> None:
    state = pinned(10, 40)
    drag = {"do": "change_pin", "index": 0, "stroke": "pin"}
    moved = after(state, *({**drag, "last": last} for last in (39, 35, 30)))
    ended = after(moved, {"do": "end_stroke", "stroke": "pin"})
    assert spans(ended) == [(10, 30)]
    assert ended.history.past[-1].label == "change a pin"
    assert spans(after(ended, {"do": "undo"})) == [(10, 40)]


def test_whole_foot_heel_or_toes_can_be_held_unless_another_pin_holds_them() -> None:
    state = after(pinned(10, 40), {"do": "change_pin", "index": 0, "landmarks": ["left_toe"]})
    assert state.doc.subject.pins[0].landmarks == ("left_toe",)
    both = after(state, {**FOOT, "frame": 12, "landmarks": ["left_heel"]})
    with pytest.raises(ActionRefused, match=r"Another pin holds this point in frames 0–24\."):
        after(both, {"do": "change_pin", "index": 0, "landmarks": list(SOLE)})


def test_a_split_pin_is_two_that_touch() -> None:
    state = pinned(10, 40)
    assert spans(after(state, {"do": "split_pin", "index": 0, "frame": 24})) == [(10, 23), (24, 40)]
    with pytest.raises(ActionRefused, match="Frame 10 does not split this pin, frames 10–40"):
        after(state, {"do": "split_pin", "index": 0, "frame": 10})


def test_an_unpinned_foot_is_had_back_with_undo() -> None:
    state = after(pinned(10, 40), {"do": "delete_pin", "index": 0})
    assert state.doc.subject.pins == ()
    assert spans(after(state, {"do": "undo"})) == [(10, 40)]


# --- proposals


PROPOSED = tuple(
    Pin(part=f"{side}_foot", landmarks=(f"{side}_heel", f"{side}_toe"), first_frame=a, last_frame=b)
    for side, a, b in (("left", 0, 9), ("right", 5, 20), ("left", 30, 50))
)


def proposing() -> EditorState:
    return replace(desk(), proposed_pins=PROPOSED)


def test_all_proposals_are_accepted_in_one_step_and_are_proposed_again_when_it_is_undone() -> None:
    state = after(proposing(), {"do": "accept_pins"})
    assert state.doc.subject.pins == PROPOSED
    assert open_proposals(state) == ()
    undone = after(state, {"do": "undo"})
    assert undone.doc.subject.pins == ()
    assert open_proposals(undone) == PROPOSED


def test_one_proposal_is_accepted_alone() -> None:
    state = after(proposing(), {"do": "accept_pins", "part": "left_foot", "first": 30})
    assert state.doc.subject.pins == PROPOSED[2:]
    assert open_proposals(state) == PROPOSED[:2]
    with pytest.raises(ActionRefused, match="No pin is proposed here any more"):
        after(state, {"do": "accept_pins", "part": "left_foot", "first": 30})


def test_dismissed_proposals_come_back_only_with_new_ones() -> None:
    state = after(proposing(), {"do": "dismiss_pins", "part": "right_foot", "first": 5})
    assert open_proposals(state) == (PROPOSED[0], PROPOSED[2])
    none = after(state, {"do": "dismiss_pins"})
    assert open_proposals(none) == ()
    assert none.history.past == ()
    assert open_proposals(none.with_proposals_anew()) == PROPOSED


def test_what_is_pinned_already_is_not_proposed() -> None:
    state = after(proposing(), {**FOOT, "frame": 35, "first": 34, "last": 36})
    assert open_proposals(state) == PROPOSED[:2]


# --- the floor


def test_the_first_pin_on_the_floor_lays_it_under_the_foot() -> None:
    state = after(desk(), {**FOOT, "frame": 24, "floor": True})
    height = state.doc.world.floor_m
    assert height is not None
    assert -3 < height < 0
    other = after(state, {"do": "set_pin", "part": "right_foot", "frame": 40, "floor": True})
    assert other.doc.world.floor_m == height
    assert after(state, {"do": "undo"}).doc.world.floor_m is None


def test_the_floor_is_given_taken_from_pinned_feet_or_forgotten() -> None:
    with pytest.raises(ActionRefused, match="No foot is pinned yet"):
        after(desk(), {"do": "floor", "pinned_feet": True})
    given = after(desk(), {"do": "floor", "height_m": -1.5})
    assert given.doc.world.floor_m == -1.5
    taken = after(given, {**FOOT, "frame": 24}, {"do": "floor", "pinned_feet": True})
    by_foot = after(desk(), {**FOOT, "frame": 36, "floor": True})
    assert taken.doc.world.floor_m == pytest.approx(by_foot.doc.world.floor_m, abs=0.02)
    assert after(taken, {"do": "floor"}).doc.world.floor_m is None
    under = after(desk(), {"do": "go", "frame": 36}, {"do": "floor", "under": "left_foot"})
    assert under.doc.world.floor_m == by_foot.doc.world.floor_m


def test_up_is_found_from_pinned_feet_in_one_step() -> None:
    with pytest.raises(ActionRefused, match="Pin two steps first"):
        after(desk(), {**FOOT, "frame": 24}, {"do": "up_from_feet"})
    other = {"do": "set_pin", "part": "right_foot", "frame": 66, "floor": True}
    pinned = after(desk(), {**FOOT, "frame": 6}, other)
    found = after(pinned, {"do": "up_from_feet"})
    assert found.doc.world.up_world is not None
    assert found.doc.world.up_from == ("feet", "set")
    assert found.doc.world.floor_m != pinned.doc.world.floor_m
    assert after(found, {"do": "undo"}).doc == pinned.doc
    drawn = after(found, {"do": "vertical", "a": (100, 40), "b": (103, 200)})
    assert drawn.doc.has_up_of_hand


def horizon(doc: Session, tilt_deg: float, roll_deg: float) -> dict[str, object]:
    """The horizon as it is seen where the camera looks down and leans by so much."""
    tilt, roll = math.radians(tilt_deg), math.radians(roll_deg)
    up = exp_rotation((0.0, 0.0, roll)) @ exp_rotation((tilt, 0.0, 0.0)) @ (0.0, -1.0, 0.0)
    ends = horizon_of(doc.view.camera, up)
    assert ends is not None
    return {"do": "horizon", "a": tuple(ends[0]), "b": tuple(ends[1])}


def test_a_drawn_horizon_shows_what_is_up_and_lays_the_floor_under_the_lower_foot() -> None:
    state = desk()
    drawn = after(state, horizon(state.doc, 6, -3))
    assert drawn.doc.world.up_world is not None
    assert tilt_and_roll(drawn.doc.world.up_world) == pytest.approx((-6, -3), abs=1e-3)
    up, pose = np.array(drawn.doc.world.up_world), shown_pose(drawn).pose
    p = joint_positions(drawn.skeleton, pose_transforms(drawn.skeleton, pose))
    names = joint_names(drawn.skeleton)
    soles = [k for k, name in enumerate(names) if name.endswith(("_heel", "_toe"))]
    assert drawn.doc.world.floor_m == pytest.approx((p[soles] @ up).min(), abs=1e-3)
    assert after(drawn, {"do": "undo"}).doc == state.doc


def test_a_drawn_horizon_lays_the_floor_under_pinned_feet_before_others() -> None:
    pinned = after(desk(), {**FOOT, "frame": 6})
    drawn = after(pinned, horizon(pinned.doc, 4, 2))
    laid = after(drawn, {"do": "floor", "pinned_feet": True})
    assert drawn.doc.world.floor_m == laid.doc.world.floor_m


def test_a_horizon_below_the_feet_is_refused_and_loses_nothing() -> None:
    state = desk()
    low = state.doc.view.camera.height - 4
    with pytest.raises(
        ActionRefused, match=r"foot stands above this line\. Draw the horizon higher\.$"
    ):
        after(state, {"do": "horizon", "a": (0, low), "b": (400, low)})


def test_a_horizon_without_a_posed_body_gives_up_alone() -> None:
    state = desk(keyframes=False)
    drawn = after(state, horizon(state.doc, 6, 0))
    assert drawn.doc.world.up_world is not None
    assert drawn.doc.world.floor_m is None


# --- keyframes


def test_a_soft_keyframe_stays_soft_however_it_is_posed_until_it_is_made_exact() -> None:
    soft = after(desk(), {"do": "soften_key", "frame": 24}, {"do": "go", "frame": 24})
    assert [k.frame for k in soft.doc.subject.keyframes if k.soft] == [24]
    posed = after(soft, {"do": "angles", "part": "head", "x": 12})
    assert [k.frame for k in posed.doc.subject.keyframes if k.soft] == [24]
    exact = after(posed, {"do": "exact_key", "frame": 24})
    assert not any(k.soft for k in exact.doc.subject.keyframes)
    assert after(exact, {"do": "exact_key", "frame": 24}) is exact


# --- while posing


def test_hands_and_feet_pinned_at_a_frame_are_known_by_the_names_of_their_handles() -> None:
    hand = {"do": "set_pin", "part": "right_hand", "frame": 20, "first": 20, "last": 30}
    knee = {"do": "set_pin", "part": "left_shin", "frame": 20, "first": 20, "last": 30}
    doc = after(pinned(10, 25), hand, knee).doc
    assert pinned_ends(doc, 9) == frozenset()
    assert pinned_ends(doc, 10) == {"left_foot"}
    assert pinned_ends(doc, 25) == {"left_foot", "right_hand"}
    assert pinned_ends(doc, 30) == {"right_hand"}


@pytest.mark.parametrize(
    "numbers",
    [{"do": "root", "x": 0.03}, {"do": "angles", "part": "left_thigh", "x": 12}],
    ids=["root", "thigh"],
)
def test_a_pinned_foot_stays_while_numbers_of_other_parts_change(numbers: dict[str, Any]) -> None:
    state = after(pinned(10, 40), {"do": "go", "frame": 24})
    before, moved = (foot_at(one) for one in (state, after(state, numbers)))
    free = foot_at(after(after(desk(), {"do": "go", "frame": 24}), numbers))
    assert np.linalg.norm(moved - before) < 0.002
    assert np.linalg.norm(free - before) > 0.01


def foot_at(state: EditorState) -> Any:
    """The left ankle at frame 24, camera frame."""
    pose = next(k for k in state.doc.subject.keyframes if k.frame == 24).pose(state.skeleton)
    return pose_transforms(state.skeleton, pose)[state.doc.subject.body.index("left_foot"), :3, 3]


# --- refusals and names

REFUSED: list[tuple[dict[str, Any], str]] = [
    ({**FOOT, "frame": 20}, r"Left foot is already pinned in frames 10–40\."),
    ({**FOOT, "part": "tail", "frame": 2}, "no part 'tail' to pin"),
    ({**FOOT, "frame": 2, "landmarks": ["left_heel", "wing"]}, "Left foot has no 'wing' to pin"),
    ({**FOOT, "frame": 2, "landmarks": ["left_toe"], "point_m": [0, 0, 0]}, "not both"),
    ({"do": "change_pin", "index": 1, "last": 5}, "This pin no longer exists"),
    ({"do": "delete_pin", "index": 1}, "This pin no longer exists"),
    ({"do": "split_pin", "index": 1, "frame": 5}, "This pin no longer exists"),
    ({"do": "floor", "height_m": 0.01}, "The floor would go through the camera"),
    ({"do": "soften_key", "frame": 5}, "Frame 5 is not a keyframe"),
    ({"do": "soften_keys", "frames": [5, 6]}, "None of these frames is a keyframe any more"),
    ({"do": "accept_pins"}, "No pin is proposed here any more"),
]


@pytest.mark.parametrize(("message", "why"), REFUSED)
def test_what_cannot_be_pinned_is_refused_in_a_sentence(message: dict[str, Any], why: str) -> None:
    with pytest.raises(ActionRefused, match=why):
        after(pinned(10, 40), message)


def test_a_body_without_the_pinned_part_is_refused() -> None:
    state = pinned(10, 40)
    renamed = state.with_doc(
        state.doc.changed(
            {"pins": (state.doc.subject.pins[0].model_copy(update={"part": "wing"}),)}
        )
    )
    with pytest.raises(ActionRefused, match="Wing is pinned and not part"):
        after(renamed, {"do": "preset", "name": "adult_female"})


@pytest.mark.parametrize(
    ("message", "label"),
    [
        ({**FOOT, "frame": 3}, "pin left foot"),
        ({"do": "delete_pin", "index": 0}, "unpin"),
        ({"do": "accept_pins"}, "accept proposed pins"),
        ({"do": "split_pin", "index": 0, "frame": 5}, "split a pin at 5"),
        ({"do": "soften_key", "frame": 50}, "approximate keyframe 50"),
        ({"do": "soften_keys", "frames": [0, 50]}, "approximate keyframes"),
        ({"do": "floor"}, "change the floor"),
    ],
)
def test_undo_names_what_was_done(message: dict[str, Any], label: str) -> None:
    assert ACTIONS.validate_python(message).label(desk()) == label  # type: ignore[union-attr]


def test_pins_are_journalled_and_made_again_from_the_journal() -> None:
    before = desk()
    messages = {**FOOT, "frame": 30, "floor": True}, {"do": "soften_key", "frame": 24}
    doc = after(before, *messages).doc
    written = json.loads(json.dumps(changes.changes(before.doc, doc)))
    assert written.keys() == {"pins", "floor_m", "keyframes"}
    assert changes.apply_changes(before.doc, written) == doc


def test_smoothness_is_switched_like_the_other_settings() -> None:
    state = after(desk(), {"do": "settings", "smooth": True})
    assert state.doc.settings.smooth is True
    assert after(state, {"do": "settings", "smooth": None}).doc.settings.smooth is None
