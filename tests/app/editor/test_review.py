"""The places to look at, the worst first, and what a person says of them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from keypose.app.cli.main import main
from keypose.app.editor.documents import ActionRefused
from keypose.app.editor.state import EditorState
from keypose.app.state.app_state import AppState
from keypose.app.store.sections import Sections
from keypose.app.words.review import label_of_place, reason_of_place
from keypose.tracker.body.pose import pose_transforms
from keypose.tracker.body.trajectory import Pass, interpolate
from keypose.tracker.review.places import Review, review_of, worst_of_all
from keypose.tracker.review.problems import Problem
from keypose.tracker.review.segments import JudgedSegments
from keypose.tracker.session.annotations import Drafted
from keypose.tracker.session.verdict import GOOD, Verdict
from keypose.tracker.storage.files import save_session
from keypose.tracker.storage.results import Results, save_results, segment_keys
from keypose.tracker.tracking.result import Diagnostics, SegmentResult
from tests.app.editor.desk import after, desk
from tests.app.store.test_sections import expecting

RIGHT_PX = 3.5
"""Of joints that are right."""
FOREARM = {"frame": 10, "part": "right_forearm"}


def doubting(**peaks: tuple[int, float]) -> EditorState:
    """The sample tracked: parts in doubt around a frame, by so many pixels."""
    edit = desk()
    parts = edit.skeleton.part_count
    error = np.full((73, parts), np.nan)
    for part in ("chest", "head", *peaks):
        error[:, edit.doc.subject.body.index(part)] = RIGHT_PX
    for part, (frame, px) in peaks.items():
        error[frame - 1 : frame + 2, edit.doc.subject.body.index(part)] = px - 1
        error[frame, edit.doc.subject.body.index(part)] = px
    error[[0, 24, 48, 72]] *= 0
    poses = {key.frame: key.pose(edit.skeleton) for key in edit.doc.subject.keyframes}
    found = {}
    for (first, last), key in segment_keys(edit.doc).items():
        path = interpolate(poses[first], poses[last], first, last)
        rows = Diagnostics.side_by_side((), 25, parts, edit.skeleton.dof_count)
        rows = replace(rows, expected_error=error[first : last + 1])
        track = SegmentResult.on_the_way(Pass("pass", path, 1.0), key)
        found[key] = replace(track, verdict=GOOD, diagnostics=rows)
    return edit.with_results(Results(found))


def first_segment(state: EditorState) -> SegmentResult:
    return state.results.by_key[segment_keys(state.doc)[0, 24]]


def with_segment(state: EditorState, found: SegmentResult) -> EditorState:
    return state.with_results(Results({**state.results.by_key, found.key: found}))


ARM_AND_FOOT = {"right_forearm": (10, 14.0), "left_foot": (40, 8.0)}


def reviewed(state: EditorState) -> Review:
    return review_of(state.doc, state.results)


def named(state: EditorState) -> list[tuple[int, str | None]]:
    return [(place.frame, place.part) for place in reviewed(state).places]


def test_the_worst_place_comes_first_each_at_its_worst_frame() -> None:
    state = doubting(**ARM_AND_FOOT)
    assert named(state) == [(10, "right_forearm"), (40, "left_foot")]
    first, second = reviewed(state).places
    assert (first.px, first.frames) == (14.0, (9, 11))
    assert label_of_place(first) == "Right forearm"
    assert second.px == 8.0


def test_the_places_of_several_bodies_are_one_list_the_worst_first() -> None:
    arm, foot = reviewed(doubting(**ARM_AND_FOOT)).places
    (knee,) = reviewed(doubting(right_forearm=(20, 10.0))).places
    assert worst_of_all({"body": (arm, foot), "second": (knee,)}) == [
        ("body", arm),
        ("second", knee),
        ("body", foot),
    ]


def test_a_place_is_as_many_centimetres_off_as_its_pixels_are_at_its_depth() -> None:
    state = doubting(**ARM_AND_FOOT)
    place = reviewed(state).places[0]
    assert place.cm is not None
    p = place.end_m
    uv = state.doc.view.camera.project(np.stack([p, p + np.array([place.cm / 100, 0.0, 0.0])]))
    assert np.linalg.norm(uv[1] - uv[0]) == pytest.approx(14.0, rel=0.02)


def test_where_depth_is_told_the_centimetres_are_those_of_space() -> None:
    state = doubting(**ARM_AND_FOOT)
    before, track = reviewed(state), first_segment(state)
    depth = np.full((25, state.skeleton.part_count), 0.05)
    told = replace(track.diagnostics, expected_depth=depth)
    after_it = reviewed(with_segment(state, replace(track, diagnostics=told)))
    across, in_space = before.places[0].cm, after_it.places[0].cm
    assert across is not None
    assert in_space == pytest.approx(np.hypot(across, 5.0), rel=0.02)
    assert after_it.places[0].px == before.places[0].px
    assert before.cm is not None
    assert after_it.cm is not None
    assert after_it.cm > before.cm + 1


def guessed(state: EditorState, frame: int, part: str, depth_m: float) -> EditorState:
    """The same with depth that is known to 4 mm, but for a part around a frame."""
    track = first_segment(state)
    errors = np.full((25, state.skeleton.part_count), 0.5)
    depth = np.full(errors.shape, 0.004)
    depth[frame - 2 : frame + 3, state.doc.subject.body.index(part)] = depth_m
    known = replace(track.diagnostics, expected_error=errors, expected_depth=depth)
    return with_segment(state, replace(track, diagnostics=known))


def test_what_is_a_guess_in_depth_is_a_place_as_large_as_it_is_from_the_side() -> None:
    state = guessed(doubting(), 12, "right_forearm", 0.2)
    (place,) = reviewed(state).places
    assert (place.cause, place.part, place.frames) == ("depth", "right_forearm", (10, 14))
    assert reason_of_place(place) == "a guess in depth, 10–14"
    assert place.cm == pytest.approx(20.0, rel=0.1)
    assert place.px == pytest.approx(0.2 * place.px_per_m, rel=0.1)
    assert isinstance(place.why, Problem)
    assert place.why.remedy == "key"  # a look at the picture does not settle it
    assert named(guessed(doubting(), 12, "right_forearm", 0.04)) == []


def test_where_its_limb_is_in_doubt_in_the_picture_the_place_is_one() -> None:
    state = doubting(right_forearm=(12, 14.0))
    errors = first_segment(state).diagnostics.expected_error
    both = guessed(state, 12, "right_forearm", 0.2)
    track = first_segment(both)
    both = with_segment(
        both, replace(track, diagnostics=replace(track.diagnostics, expected_error=errors))
    )
    (place,) = reviewed(both).places
    assert place.cause != "depth"
    assert place.cm is not None
    assert place.cm > 20


def test_joints_that_are_right_are_no_place_to_look_at() -> None:
    assert named(doubting()) == []


def test_the_goal_is_one_that_the_video_allows() -> None:
    state = doubting(**ARM_AND_FOOT)
    found = reviewed(state)
    assert found.goal_px == 5
    assert found.right_px is not None
    assert RIGHT_PX <= found.right_px < 5
    assert [place.frame for place in found.above(8)] == [10]
    error = np.full((25, state.skeleton.part_count), 5.6)
    error[[0, -1]] = 0
    large = expecting(error).edit
    assert large is not None
    assert reviewed(large).goal_px == 8


def test_of_a_tall_person_the_goal_is_not_what_two_people_who_mark_a_joint_differ_by(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(JudgedSegments, "height_px", lambda *_: 600.0)
    found = reviewed(doubting(**ARM_AND_FOOT))
    assert (found.goal_px, found.right_px) == (8, 7.5)
    assert [place.px for place in found.above(found.goal_px)] == [14.0]


def test_what_is_accepted_stays_away_and_is_one_step_of_undo() -> None:
    state = doubting(**ARM_AND_FOOT)
    accepted = after(state, {"do": "accept_place", **FOREARM})
    assert named(accepted) == [(40, "left_foot")]
    assert accepted.history.past[-1].label == "accept right forearm"
    (message,) = reviewed(accepted).answered
    assert (message.answer, message.frame, message.first_frame, message.last_frame) == (
        "accepted",
        10,
        9,
        11,
    )
    assert accepted.doc.subject.keyframes == state.doc.subject.keyframes
    assert named(after(accepted, {"do": "undo"})) == named(state)


def test_one_look_settles_all_limbs_and_moments_near_it_and_the_same_is_not_asked_again() -> None:
    """The worst one stands for them, and an answer to it is one to all."""
    near = {"right_forearm": (10, 14.0), "right_upper_arm": (10, 9.0), "left_foot": (5, 13.0)}
    state = doubting(**near)
    assert named(state) == [(10, "right_forearm")]
    assert named(after(state, {"do": "accept_place", **FOREARM})) == []
    assert named(after(state, {"do": "cannot_tell", **FOREARM})) == []


def test_there_are_few_places_however_much_is_in_doubt() -> None:
    every = {
        name: (frame, 20.0 + frame) for frame, name in enumerate(desk().doc.subject.body.names, 3)
    }
    assert len(named(doubting(**every))) <= 3


def test_it_comes_back_when_the_motion_there_is_another_one() -> None:
    accepted = after(doubting(**ARM_AND_FOOT), {"do": "accept_place", **FOREARM})
    found = first_segment(accepted)
    path = found.trajectory
    moved = replace(path, ps_camera_root=path.ps_camera_root + np.array([0.03, 0.0, 0.0]))
    other = with_segment(accepted, replace(found, trajectory=moved))
    assert (10, "right_forearm") in named(other)
    assert reviewed(other).answered == ()


def test_what_cannot_be_told_leaves_the_list_and_its_segment_to_be_checked() -> None:
    state = doubting(**ARM_AND_FOOT)
    found = first_segment(state)
    verdict = Verdict.check("uncertain", (9, 11), "right_forearm")
    state = with_segment(state, replace(found, verdict=verdict))
    left = after(state, {"do": "cannot_tell", **FOREARM})
    assert named(left) == [(40, "left_foot")]
    first, *_ = Sections().changed(AppState(edit=left))["segments"]
    assert (first["state"], first["go"], first["part"]) == ("check", 10, "right_forearm")
    accepted = after(state, {"do": "accept_place", **FOREARM})
    first, *_ = Sections().changed(AppState(edit=accepted))["segments"]
    assert (first["state"], first["short"]) == ("good", "Reviewed")


def test_where_nothing_is_to_be_reviewed_an_answer_is_refused() -> None:
    with pytest.raises(ActionRefused, match="nothing left to review at frame 3"):
        after(doubting(**ARM_AND_FOOT), {"do": "accept_place", "frame": 3, "part": "head"})


def test_what_hides_a_part_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(JudgedSegments, "occluder", lambda *_: "head")
    place = reviewed(doubting(right_forearm=(10, 14.0))).places[0]
    assert (place.cause, reason_of_place(place)) == ("not_seen", "hidden behind the head, 9–11")


def test_the_reason_is_seldom_more_than_that_the_passes_differ(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(JudgedSegments, "occluder", lambda *_: None)
    place = reviewed(doubting(right_forearm=(10, 14.0))).places[0]
    assert reason_of_place(place) == "tracked from either keyframe, it differs"


def test_a_limb_that_was_keyed_by_itself_is_right_there() -> None:
    state = after(doubting(**ARM_AND_FOOT), {"do": "go", "frame": 10})
    found = first_segment(state)
    keyed = after(state, {"do": "key_parts", "frame": 10, "parts": ["right_forearm"]})
    again = replace(found, key=segment_keys(keyed.doc)[0, 24])
    places = named(keyed.with_results(Results({again.key: again})))
    assert (10, "right_forearm") not in places


def drafting() -> EditorState:
    """Drafts at 30 and 40, the second of which is to be confirmed."""
    edit = desk()
    pose = edit.doc.subject.keyframes[1]
    drafts = tuple(
        pose.model_copy(update={"frame": frame, "time_s": frame / 30}) for frame in (30, 40)
    )
    places = [{"frame": 40, "reason": "flip", "parts": ["left_forearm"]}]
    given = {"first_frame": 30, "last_frame": 40, "places": places}
    update = {"drafts": drafts, "drafted": Drafted.model_validate(given)}
    return edit.with_doc(edit.doc.changed(update))


def test_a_draft_to_confirm_is_a_place_and_becomes_a_keyframe_when_it_is_accepted() -> None:
    state = drafting()
    (place,) = reviewed(state).places
    assert (place.frame, place.px) == (40, None)
    assert reason_of_place(place) == "left forearm may point the other way"
    Ts = pose_transforms(state.skeleton, state.doc.subject.drafts[1].pose(state.skeleton))
    assert (
        np.linalg.norm(place.end_m - Ts[state.doc.subject.body.index("left_forearm"), :3, 3]) < 0.5
    )
    keyed = after(state, {"do": "accept_place", "frame": 40, "part": "left_forearm"})
    assert 40 in keyed.keys
    assert named(keyed) == []
    left = after(state, {"do": "cannot_tell", "frame": 40, "part": "left_forearm"})
    assert named(left) == []


def test_answers_are_saved_and_the_list_is_read_without_the_page(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    state = doubting(**ARM_AND_FOOT)
    path = tmp_path / "session.json"
    save_session(save_results(state.doc, path, state.results), path)
    assert main(["review", str(path)]) == 0
    reported = capsys.readouterr().out.splitlines()
    assert reported[0].split() == ["frame", "part", "expected", "error", "reason"]
    assert reported[1].startswith("   10  Right forearm  ≈ 14 px")
    assert reported[-1] == "2 places left above 5 px."
    frame = int(reported[1].split()[0])
    assert main(["review", str(path), "--frames", f"{frame}-{frame}"]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == "1 place left above 5 px."
    done = after(
        state,
        {"do": "accept_place", **FOREARM},
        {"do": "cannot_tell", "frame": 40, "part": "left_foot"},
    )
    save_session(save_results(done.doc, path, done.results), path)
    assert main(["review", str(path)]) == 0
    reported = capsys.readouterr().out.splitlines()
    assert reported == [
        "2 places reviewed, 1 accepted. Nobody can tell: left foot at 40.",
        "Nothing left above 5 px.",
    ]
    assert main(["review", str(path), "--json"]) == 0
    assert '"places": []' in capsys.readouterr().out


def test_what_is_to_be_tracked_first_is_listed_first(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    state = doubting(**ARM_AND_FOOT)
    path = tmp_path / "session.json"
    saved = save_results(state.doc, path, state.results)
    other = saved.settings.model_copy(update={"cues": ("keypoints",)})
    save_session(saved.changed({"settings": other}), path)
    assert main(["review", str(path)]) == 0
    first, *_, last = capsys.readouterr().out.splitlines()
    assert "tracking first: the tracked motion is out of date (settings have changed)." in first
    assert last.endswith("left above 5 px so far.")
    save_session(saved.changed({"results": None}), path)
    assert main(["review", str(path)]) == 0
    assert capsys.readouterr().out.splitlines()[0].endswith("tracking first.")
