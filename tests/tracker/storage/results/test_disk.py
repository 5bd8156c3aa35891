"""Results into a session's tracks file and out of it again."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from keypose.tracker.body.pose import Pose
from keypose.tracker.errors import SessionError
from keypose.tracker.session import Keyframe, Session
from keypose.tracker.storage.files import load_session, save_session
from keypose.tracker.storage.results import (
    Results,
    load_all_results,
    load_results,
    save_all_results,
    save_results,
)
from keypose.tracker.storage.tracks import load_tracks, save_result
from keypose.tracker.tracking.result import SegmentResult
from tests.app.results_cases import both, passing, session, track
from tests.tracker import session_cases as cases


def saved(results: Results, folder: Path, of: Session) -> tuple[Session, Path]:
    path = folder / "session.json"
    save_session(save_results(of, path, results), path)
    return load_session(path), path


def assert_same(one: SegmentResult, other: SegmentResult) -> None:
    assert (one.span, one.key, one.quality, one.verdict, one.best_pass) == (
        (other.span, other.key, other.quality, other.verdict, other.best_pass)
    )
    np.testing.assert_array_equal(one.scores, other.scores)
    for (column, rows), (same, its_rows) in zip(
        one.diagnostics.arrays(), other.diagnostics.arrays(), strict=True
    ):
        assert column == same
        np.testing.assert_array_equal(rows, its_rows)
    mine, its = one.trajectory, other.trajectory
    assert mine.first_frame == its.first_frame
    np.testing.assert_array_equal(mine.Rs_parent_part, its.Rs_parent_part)
    np.testing.assert_array_equal(mine.ps_camera_root, its.ps_camera_root)


def knowing(found: SegmentResult, gains: np.ndarray) -> SegmentResult:
    """A result that says what keyframes would mend."""
    diagnostics = dataclasses.replace(found.diagnostics, expected_gain=gains)
    return dataclasses.replace(found, diagnostics=diagnostics)


def at(frame: int) -> Keyframe:
    return Keyframe.of(cases.SKELETON, cases.pose(frame / 9), frame, frame / 25)


def test_results_come_back_from_the_disk_as_they_were(tmp_path: Path) -> None:
    of = session()
    results = Results().with_result(track(of, 0, 4, "preview")).with_result(track(of, 4, 8))
    again, path = saved(results, tmp_path, of)
    loaded = load_results(again, path).fitting(again)
    assert list(loaded) == [(0, 4), (4, 8)]
    for span, found in results.fitting(of).items():
        assert_same(loaded[span], found)


def test_what_a_keyframe_would_mend_comes_back_with_the_segments_that_know_it(
    tmp_path: Path,
) -> None:
    of, gains = session(), np.array([0.0, 1.0, 5.0, 2.0, 0.0])
    known = knowing(track(of, 4, 8), gains)
    again, path = saved(Results().with_result(track(of, 0, 4)).with_result(known), tmp_path, of)
    loaded = load_results(again, path).fitting(again)
    assert loaded[0, 4].diagnostics.expected_gain is None
    np.testing.assert_array_equal(loaded[4, 8].diagnostics.expected_gain, gains)


def test_gaps_between_results_stay_gaps(tmp_path: Path) -> None:
    of = session(keyframes=tuple(at(frame) for frame in (0, 2, 4, 8)))
    results = Results().with_result(track(of, 0, 2)).with_result(track(of, 4, 8))
    again, path = saved(results, tmp_path, of)
    assert load_tracks(again, path).runs(tracked=False) == "3"
    loaded = load_results(again, path)
    assert list(loaded.fitting(again)) == [(0, 2), (4, 8)]
    assert [w[:2] for w in loaded.wanted(again)] == [(2, 4)]


def test_what_was_tracked_by_the_command_line_fits_too(tmp_path: Path) -> None:
    path = tmp_path / "session.json"
    of = save_result(session(), path, cases.result())
    assert list(load_results(of, path).fitting(of)) == [(0, 4), (4, 8)]


def moved(of: Session) -> Session:
    pose = of.subject.keyframes[2].pose(cases.SKELETON)
    far = Pose(pose.Rs_parent_part, pose.p_camera_root * 1.01)
    last = Keyframe.of(cases.SKELETON, far, 8, 8 / 25)
    return of.changed({"keyframes": (*of.subject.keyframes[:2], last)})


def static(of: Session) -> Session:
    return of.changed({"settings": of.settings.model_copy(update={"static_camera": True})})


def narrower(of: Session) -> Session:
    return of.changed({"camera": of.view.camera.model_copy(update={"fx": 80.0})})


def by_the_paper(of: Session) -> Session:
    return of.changed({"settings": of.settings.model_copy(update={"method": "paper"})})


@pytest.mark.parametrize("known", [True, False], ids=["with keys", "by the command line"])
def test_a_result_of_another_pose_is_kept_and_does_not_fit(tmp_path: Path, known: bool) -> None:
    path = tmp_path / "session.json"
    of = session()
    of = save_results(of, path, both(of)) if known else save_result(of, path, cases.result())
    loaded = load_results(moved(of), path)
    assert list(loaded.fitting(moved(of))) == [(0, 4)]
    assert len(loaded) == 2
    assert loaded.states(moved(of)) == {(0, 4): "good", (4, 8): "outdated"}


def test_what_was_tracked_of_another_body_makes_no_segment_outdated(tmp_path: Path) -> None:
    path, of = tmp_path / "session.json", session()
    of = save_results(of, path, both(of))
    beside = moved(of).subject.model_copy(update={"id": "body-2", "results": None})
    of = of.model_copy(update={"bodies": (of.subject, beside)})
    loaded, _ = load_all_results(of, path)
    assert loaded.states(of) == dict.fromkeys(of.spans, "outdated"), "it may hide the first"
    assert loaded.states(of.about("body-2"))[4, 8] == "none"


@pytest.mark.parametrize("change", [narrower, by_the_paper])
def test_results_of_another_setup_are_kept_and_do_not_fit(tmp_path: Path, change: object) -> None:
    assert callable(change)
    path = tmp_path / "session.json"
    of = change(save_result(session(), path, cases.result()))
    loaded = load_results(of, path)
    assert len(loaded) == 2
    assert loaded.fitting(of) == {}


def test_a_setting_the_file_does_not_show_is_known_by_the_key(tmp_path: Path) -> None:
    of = session()
    again, path = saved(both(of), tmp_path, of)
    assert load_results(static(again), path).fitting(static(again)) == {}
    assert len(load_results(static(again), path).fitting(again)) == 2


def test_only_what_fits_and_is_finished_is_written(tmp_path: Path) -> None:
    of = session()
    results = Results().with_result(track(of, 0, 4)).with_result(passing(of, 4, 8, 0.1))
    again, path = saved(results.with_result(track(moved(of), 4, 8)), tmp_path, of)
    assert again.subject.results is not None
    assert [s.first_frame for s in again.subject.results.segments] == [0]
    assert len(load_results(again, path)) == 1


def test_the_lowest_quality_is_reported_of_the_whole_and_each_segment_s_own_beside_it(
    tmp_path: Path,
) -> None:
    of = session()
    results = Results().with_result(track(of, 0, 4, "preview")).with_result(track(of, 4, 8))
    again, _ = saved(results, tmp_path, of)
    assert again.subject.results is not None
    assert again.subject.results.quality == "preview"
    assert [s.quality for s in again.subject.results.segments] == ["preview", "full"]


def test_with_nothing_to_write_the_session_keeps_what_it_had(tmp_path: Path) -> None:
    of = session()
    again, path = saved(both(of), tmp_path, of)
    before = sorted(tmp_path.iterdir())
    assert save_results(narrower(again), path, both(of)).subject.results == again.subject.results
    assert sorted(tmp_path.iterdir()) == before


def test_a_session_that_was_never_tracked_has_no_results(tmp_path: Path) -> None:
    assert len(load_results(session(), tmp_path / "session.json")) == 0


def test_a_damaged_tracks_file_is_reported_in_one_sentence(tmp_path: Path) -> None:
    of = session()
    again, path = saved(both(of), tmp_path, of)
    assert again.subject.results is not None
    (tmp_path / again.subject.results.tracks).write_bytes(b"no archive")
    with pytest.raises(SessionError, match=r"is damaged: .*\.$"):
        load_results(again, path)


def two_tracked(folder: Path) -> tuple[Session, Path]:
    """Two bodies, the second a little farther, both tracked and saved."""
    first = session()
    farther = [
        keyframe.model_copy(update={"root_m": (0.0, 0.0, keyframe.root_m[2] + 1.0)})
        for keyframe in first.subject.keyframes
    ]
    second = first.subject.model_copy(update={"id": "body-2", "keyframes": tuple(farther)})
    of_two = first.model_copy(update={"bodies": (first.subject, second)})
    results = both(of_two.about("body"))
    for first_frame, last_frame in ((0, 4), (4, 8)):
        result = track(of_two.about("body-2"), first_frame, last_frame, bend=0.2)
        results = results.with_result(result)
    path = folder / "session.json"
    save_session(save_all_results(of_two, path, results), path)
    return load_session(path), path


def test_the_motions_of_all_bodies_are_saved_and_read_each_with_its_own(tmp_path: Path) -> None:
    of_two, path = two_tracked(tmp_path)
    results, problem = load_all_results(of_two, path)
    assert (len(results), problem) == (4, "")
    for body in of_two.bodies:
        assert [*results.fitting(of_two.about(body.id))] == [(0, 4), (4, 8)]


def test_a_motion_that_cannot_be_read_takes_no_other_with_it(tmp_path: Path) -> None:
    of_two, path = two_tracked(tmp_path)
    damaged = of_two.bodies[1].results
    assert damaged is not None
    (tmp_path / damaged.tracks).write_bytes(b"no tracks")
    results, problem = load_all_results(of_two, path)
    assert len(results) == 2
    assert damaged.tracks in problem
