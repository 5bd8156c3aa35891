"""The last solve in the worker: an order, its reports, its end; and without a page the same."""

from __future__ import annotations

from pathlib import Path
from threading import Event
from typing import Any

import numpy as np
import pytest

from keypose.app.jobs import rerun
from keypose.app.jobs.job import Failed, Finished, Progress, Report
from keypose.app.jobs.rerun import save_found, save_tracks_beside
from keypose.app.jobs.space import SolveSpace
from keypose.tracker.errors import SessionError
from keypose.tracker.operations import solve_space as space
from keypose.tracker.operations.solve_space import solved
from keypose.tracker.session import Session
from keypose.tracker.session.references import Repeats
from keypose.tracker.space.result import SpaceResult
from keypose.tracker.storage.files import load_session, save_session
from keypose.tracker.storage.results import load_results
from keypose.tracker.storage.tracks import load_tracks
from tests.app.jobs import job_cases
from tests.app.jobs.job_cases import NUMBER
from tests.app.jobs.test_job_runner import Office, office
from tests.tracker.operations.space_cases import PIN, both, cases, pinned, session, smooth

__all__ = ["office"]


def order(of: Session) -> SolveSpace:
    return SolveSpace.of(of, both(of).unsolved(of))


def reported(job: SolveSpace, cancelled: Event | None = None) -> list[Report]:
    return job_cases.reported(job, None, cancelled)


def solution(of: Session) -> SpaceResult:
    """The one stretch that a job solves for."""
    one, end = reported(order(of))
    assert isinstance(one, Progress)
    assert (one.share, end) == (1, Finished(NUMBER))
    assert isinstance(one.partial, SpaceResult)
    return one.partial


def test_an_order_reports_every_stretch_and_then_its_end() -> None:
    of = smooth(pinned())
    one = solution(of)
    assert one.key == both(of).unsolved(of)[0].key
    assert one.span == (0, 8)
    (pin,) = one.pins
    assert (pin.part, pin.landmarks, pin.first_frame, pin.last_frame) == (
        PIN.part, PIN.landmarks, *PIN.span
    )  # fmt: skip
    assert 0 <= pin.usual_off_m <= pin.off_m
    assert both(of).with_space(one).unsolved(of) == []


@pytest.mark.parametrize(
    "repeats", [None, Repeats(frames=(2, 6)), Repeats(frames=(2, 6), even=False)],
    ids=["no copies", "copies between", "copies instead"],
)  # fmt: skip
def test_exact_keyframes_stay_where_they_are_posed(repeats: Repeats | None) -> None:
    of = smooth(pinned())
    of = of.changed({"video": of.view.video.model_copy(update={"repeats": repeats})})
    one = solution(of)
    for keyframe in of.subject.keyframes:
        pose, wanted = one.motion.pose(keyframe.frame), keyframe.pose(cases.SKELETON)
        np.testing.assert_allclose(pose.p_camera_root, wanted.p_camera_root, atol=1e-9)
        np.testing.assert_allclose(pose.Rs_parent_part, wanted.Rs_parent_part, atol=1e-6)


def test_a_pin_that_an_exact_keyframe_contradicts_names_it() -> None:
    whole = session(pins=(PIN.model_copy(update={"first_frame": 0, "last_frame": 8}),))
    one = solution(whole)
    (pin,) = one.pins
    assert pin.off_m > 0.01
    assert pin.keyframe in (0, 4, 8)


def test_a_cancelled_order_says_so_and_reports_nothing_half_done() -> None:
    cancelled = Event()
    cancelled.set()
    assert reported(order(smooth()), cancelled) == [Finished(NUMBER, cancelled=True)]


def test_a_fault_is_reported_in_one_sentence_and_is_no_end(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: Any) -> Any:
        raise ZeroDivisionError

    monkeypatch.setattr(space, "solved", fail)
    (failed,) = reported(order(smooth()))
    assert isinstance(failed, Failed)
    assert failed.words.startswith("Smoothing failed with an internal error")
    assert failed.words.endswith("The motion is as it was tracked.")
    assert "\n" not in failed.words


async def test_the_worker_solves_as_it_is_done_without_one(office: Office) -> None:
    of = smooth(pinned())
    stretches = both(of).unsolved(of)
    here = solved(of, stretches[0])

    job = office.tracking.start(SolveSpace.of(of, stretches))
    assert office.tracking.job == job
    assert await office.ended(job) == Finished(job)
    assert office.tracking.job is None
    (report,) = office.of(job, Progress)
    assert report.partial.key == here.key
    np.testing.assert_array_equal(report.partial.motion.ps_camera_root, here.motion.ps_camera_root)
    np.testing.assert_array_equal(report.partial.motion.Rs_parent_part, here.motion.Rs_parent_part)
    assert report.partial.pins == here.pins


async def test_a_newer_job_ends_one_that_solves(office: Office) -> None:
    of = smooth(pinned())

    jobs = [office.tracking.start(order(of)) for _ in range(3)]
    assert await office.ended(jobs[-1]) == Finished(jobs[-1])
    for job in jobs:
        assert len(office.of(job, Finished)) == 1


# --- without a page


def found(of: Session) -> list[Any]:
    return list(both(of).fitting(of).values())


def test_what_is_saved_without_a_page_is_solved(tmp_path: Path) -> None:
    of, path = smooth(pinned()), tmp_path / "session.json"
    save_session(of, path)
    results = save_found(of, path, found(of))
    assert results is not None
    assert [(s.first_frame, s.last_frame) for s in results.space] == [(0, 8)]
    again = load_session(path)
    assert load_results(again, path).unsolved(again) == []
    assert load_tracks(again, path).before_space is not None


def test_what_is_saved_without_pins_and_smoothing_is_not_solved(tmp_path: Path) -> None:
    of, path = session(), tmp_path / "session.json"
    save_session(of, path)
    results = save_found(of, path, found(of))
    assert results is not None
    assert results.space == ()
    assert load_tracks(load_session(path), path).before_space is None


def test_a_failed_solve_loses_nothing_of_what_was_tracked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> Any:
        raise SessionError("It cannot be solved.")

    of, path = smooth(pinned()), tmp_path / "session.json"
    save_session(of, path)
    beside = tmp_path / "copy" / "session.json"
    beside.parent.mkdir()
    monkeypatch.setattr(rerun, "solved", fail)
    with pytest.raises(SessionError, match="cannot be solved"):
        save_found(of, path, found(of))
    with pytest.raises(SessionError, match="cannot be solved"):
        save_tracks_beside(
            of,
            beside,
            found(of),
            lambda them: save_session(of.changed({"results": them}), beside),
        )
    for place in (path, beside):
        assert len(load_results(load_session(place), place).fitting(of)) == 2


def test_a_segment_tracked_anew_is_solved_from_what_was_tracked_of_the_others(
    tmp_path: Path,
) -> None:
    """Not from their motion in space: solved twice, it would depend on its history."""
    of, path = smooth(pinned()), tmp_path / "session.json"
    save_session(of, path)
    first, second = found(of)
    save_found(of, path, [first, second])
    before = path.read_bytes(), (tmp_path / load_tracks_name(path)).read_bytes()
    save_found(load_session(path), path, [second])
    assert (path.read_bytes(), (tmp_path / load_tracks_name(path)).read_bytes()) == before


def load_tracks_name(path: Path) -> str:
    results = load_session(path).subject.results
    assert results is not None
    return results.tracks
