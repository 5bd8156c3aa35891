"""What was tracked ahead is drafts with a record; both go when they are outdated, in one step."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from keypose.app.editor.actions import ACTIONS
from keypose.app.editor.advice import Suggestion, next_step, with_way_ahead
from keypose.app.editor.ahead import found_sentence, start_frame, with_followed
from keypose.app.editor.documents import ActionRefused
from keypose.app.editor.drafted import LABEL, drafted_session
from keypose.app.editor.shown import shown_pose
from keypose.app.editor.state import EditorState
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.session.annotations import Direction, Stop
from keypose.tracker.session.schema import Session
from keypose.tracker.tracking.ahead.follow import FoundAhead
from tests.app.editor.desk import after, desk
from tests.tracker.session_cases import flat

HIDDEN = Stop(cause="not_seen", part="right_forearm", behind="chest")


def one_key(frame: int = 24) -> EditorState:
    """A desk with one keyframe alone."""
    state = desk()
    keys = tuple(k for k in state.doc.subject.keyframes if k.frame == frame)
    return state.with_doc(state.doc.changed({"keyframes": keys}))


def found(state: EditorState, frame: int = 24, to: int = 40, stop: Stop = HIDDEN) -> FoundAhead:
    """The keyframe's pose, moved by a centimetre a frame."""
    pose = shown_pose(state, frame).pose
    first, last = min(frame, to), max(frame, to)
    away = np.abs(np.arange(first, last + 1) - frame)[:, None] * (0.01, 0.0, 0.0)
    Rs = np.repeat(pose.Rs_parent_part[None], last - first + 1, axis=0)
    way: Direction = "forward" if to >= frame else "backward"
    return FoundAhead(frame, way, Trajectory(first, Rs, pose.p_camera_root + away), stop)


def followed(to: int = 40) -> EditorState:
    state = one_key()
    return with_followed(state, found(state, to=to))


def drafts(doc: Session) -> list[int]:
    return [draft.frame for draft in doc.subject.drafts]


@pytest.mark.parametrize("to", [40, 8])
def test_the_followed_frames_are_drafts_and_one_undo_takes_them_back(to: int) -> None:
    before = one_key()
    state = with_followed(before, found(before, to=to))
    assert drafts(state.doc) == [f for f in range(min(24, to), max(24, to) + 1) if f != 24]
    assert shown_pose(state, to).source == "draft"
    assert state.history.past[-1].label == "track ahead"
    back = after(state, {"do": "undo"})
    assert back.doc == before.doc
    again = after(back, {"do": "redo"})
    assert again.doc == state.doc


def test_both_ways_stand_side_by_side() -> None:
    state = followed(40)
    state = with_followed(state, found(state, to=10))
    assert drafts(state.doc) == [*range(10, 24), *range(25, 41)]
    assert len(state.doc.subject.ahead) == 2


def test_followed_once_more_replaces_what_was_followed_before() -> None:
    state = followed(40)
    state = with_followed(state, found(state, to=30))
    assert drafts(state.doc) == list(range(25, 31))
    assert [record.to_frame for record in state.doc.subject.ahead] == [30]


def test_next_is_the_last_frame_that_can_be_trusted() -> None:
    doc = followed(40).doc
    step = next_step((24,), doc, {})
    assert (step.frame, step.kind) == (40, "key")
    assert step.title == "Check frame 40, then press K"
    assert step.detail == (
        "Tracked ahead to 40. Right forearm may be wrong from there, hidden behind the chest"
    )


def test_a_keyframe_alone_can_be_followed_on_and_then_back() -> None:
    assert next_step((24,), one_key().doc, {}).ahead == "forward"
    assert next_step((24,), with_too_little(one_key()).doc, {}).ahead == "backward"
    last = one_key(72)
    assert next_step((72,), last.doc, {}).ahead == "backward"


def test_beyond_the_last_keyframe_it_leads_on_beside_what_is_to_be_mended() -> None:
    doc = one_key().doc
    mend = Suggestion(12, "Add a keyframe at 12", "Most drift in 0–24", "key")
    assert with_way_ahead(mend, (24,), doc) == replace(mend, ahead="forward")
    assert with_way_ahead(replace(mend, kind="track"), (24,), doc).ahead is None


def with_too_little(state: EditorState) -> EditorState:
    """Followed over two frames, which are no gain."""
    return with_followed(state, found(state, to=26))


def test_k_keeps_the_draft_as_a_keyframe_and_the_others_go() -> None:
    state = followed(40)
    pose = shown_pose(state, 40).pose
    keyed = after(state, {"do": "add_key", "frame": 40})
    assert keyed.keys == (24, 40)
    assert not keyed.doc.subject.drafts
    assert not keyed.doc.subject.ahead
    kept = keyed.doc.subject.keyframes[-1]
    assert np.allclose(kept.pose(keyed.skeleton).p_camera_root, pose.p_camera_root)
    assert not kept.followed
    assert after(keyed, {"do": "undo"}).doc == state.doc


OUTDATING: list[dict[str, Any]] = [
    {"do": "delete_key", "frame": 24},
    {"do": "move_key", "frame": 24, "to": 20},
    {"do": "duplicate_key", "frame": 24, "to": 60},
    {"do": "key_angle", "frame": 24, "part": "left_shin", "axis": "x", "deg": 12.0},
    {"do": "height", "cm": 190.0},
    {"do": "field_of_view", "deg": 40.0},
]


@pytest.mark.parametrize("edit", OUTDATING, ids=lambda edit: edit["do"])
def test_what_outdates_it_takes_it_away_in_the_same_step(edit: dict[str, Any]) -> None:
    state = followed(40)
    changed = after(state, edit)
    assert not changed.doc.subject.ahead
    assert not changed.doc.subject.drafts
    assert after(changed, {"do": "undo"}).doc == state.doc


@pytest.mark.parametrize(
    "edit",
    [
        {"do": "settings", "quality": "preview"},
        {"do": "key_angle", "frame": 30, "part": "left_shin", "axis": "x", "deg": 12.0},
    ],
    ids=["settings", "draft"],
)
def test_other_edits_leave_it(edit: dict[str, Any]) -> None:
    state = after(followed(40), {"do": "go", "frame": 30})
    if edit["do"] == "key_angle":
        edit = {"do": "angles", "part": "left_shin", "x": 12.0}
    assert after(state, edit).doc.subject.ahead == state.doc.subject.ahead


def test_a_pose_of_ones_own_stays() -> None:
    """Posed before it is not covered, and posed since it is not taken away."""
    own = after(one_key(), {"do": "go", "frame": 30}, {"do": "angles", "part": "left_shin", "x": 9})
    state = with_followed(own, found(own))
    assert state.doc.subject.drafts[5] == own.doc.subject.drafts[0]
    changed = after(state, {"do": "go", "frame": 35}, {"do": "angles", "part": "left_shin", "x": 9})
    gone = after(changed, {"do": "delete_key", "frame": 24})
    assert drafts(gone.doc) == [30, 35]


def test_drafting_the_whole_film_takes_its_place() -> None:
    state = followed(40)
    poses = {30: shown_pose(state, 30).pose}
    body, times_s = state.doc.subject.body, state.times_s
    doc = drafted_session(state.doc, (28, 32), body, poses, None, (), times_s, None)
    drafted = state.with_step(doc, LABEL)
    assert drafts(drafted.doc) == [30]
    assert not drafted.doc.subject.ahead


def test_where_it_cannot_begin_it_says_why() -> None:
    with pytest.raises(ActionRefused, match="Pose a frame and add it as a keyframe first"):
        start_frame(desk(keyframes=False).doc, "forward")
    with pytest.raises(
        ActionRefused, match=r"The keyframe at 72 is the video's last frame: nothing"
    ):
        start_frame(desk().doc, "forward")
    with pytest.raises(
        ActionRefused, match=r"The keyframe at 0 is the video's first frame: nothing"
    ):
        start_frame(desk().doc, "backward")
    with pytest.raises(ValueError, match="direction"):
        ACTIONS.validate_python({"do": "track_ahead", "direction": "sideways"})


def test_it_is_said_how_far_it_came_and_why_no_farther() -> None:
    state = one_key()

    def message(to: int, **stop: Any) -> str:
        return found_sentence(found(state, to=to, stop=Stop(**stop)))

    assert message(40, cause="clip_end") == "Tracked ahead to 40. The video ends there."
    assert message(2, cause="cut") == "Tracked back to 2. Another scene begins after it."
    assert message(24, cause="uncertain", part="left_shin") == (
        "Nothing tracked from 24: left shin may be wrong right after it. "
        "Pose the next keyframe by hand."
    )


def test_a_record_that_does_not_fit_the_session_is_refused() -> None:
    doc = flat(followed(40).doc)
    doc["ahead"][0]["to_frame"] = 400
    with pytest.raises(ValueError, match="ahead: frame 400 lies beyond the video's last, 72"):
        Session.begin(**doc)
    doc["ahead"][0] |= {"to_frame": 40, "stop": {"cause": "uncertain", "part": "wing"}}
    with pytest.raises(ValueError, match="ahead: the body has no part 'wing'"):
        Session.begin(**doc)
