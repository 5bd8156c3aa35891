"""Tracked in the page, by `keypose track` or in a batch: the same bytes in the same files."""

from __future__ import annotations

import json
import shutil
import time
from collections.abc import Callable
from pathlib import Path
from threading import Event
from typing import Any

import pytest

from keypose import sample_videos
from keypose.app.cli.main import main
from keypose.app.jobs.batch.run_one import run_task
from keypose.app.jobs.batch.task import Task
from keypose.app.jobs.rerun import all_segments, rerun, save_found, with_settings
from keypose.app.jobs.track import Track
from keypose.app.orders.tracking import TrackOrder
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import interpolate
from keypose.tracker.errors import SessionError
from keypose.tracker.session import Keyframe
from keypose.tracker.session.pins import Pin
from keypose.tracker.storage.files import load_session, open_video_of, save_session
from keypose.tracker.tracking.tracker import Tracker
from tests.app.jobs.job_cases import segments
from tests.app.serving import Keypose, Visitor
from tests.tracker import session_cases as cases

SAMPLE = Path(sample_videos.__file__).parent / "box"
BETWEEN = 25


PIN = Pin(part="box", point_m=(0.32, 0.2, 0.24), first_frame=2, last_frame=12)


def copied(folder: Path, pins: tuple[Pin, ...] = (), **settings: Any) -> Path:
    """The box, with two segments of different length."""
    folder.mkdir(parents=True)
    shutil.copy(SAMPLE / "box.mp4", folder)
    reported = json.loads((SAMPLE / "session.json").read_text("utf-8"))
    reported["results"] = None
    reported["settings"].update(settings)
    path = folder / "session.json"
    path.write_text(json.dumps(reported), encoding="utf-8")
    session = load_session(path)
    start, end = session.subject.keyframes
    skeleton = Skeleton.of(session.subject.body)
    poses = (start.pose(skeleton), end.pose(skeleton))
    between = interpolate(*poses, start.frame, end.frame).pose(BETWEEN)
    middle = Keyframe.of(skeleton, between, BETWEEN, BETWEEN / 30)
    changed = {"keyframes": (start, middle, end), "pins": pins}
    save_session(session.changed(changed), path)
    return path


def by_the_page(path: Path) -> None:
    keypose = Keypose(str(path), "--workspace", str(path.parent / "workspace"))
    try:
        visitor = Visitor(keypose)
        visitor.do(do="track", what="all")
        visitor.until(lambda: visitor.seen["job"]["state"] == "done")
        visitor.leave()
    finally:
        code, words = keypose.end()
    assert code == 0, words


def by_the_page_until_solved(path: Path) -> None:
    keypose = Keypose(str(path), "--workspace", str(path.parent / "workspace"))
    try:
        visitor = Visitor(keypose)
        visitor.do(do="track", what="all")
        visitor.until(lambda: visitor.seen["job"]["title"].startswith("Smoothing"))
        visitor.until(lambda: visitor.seen["job"]["state"] == "done")
        visitor.leave()
    finally:
        code, words = keypose.end()
    assert code == 0, words


def by_the_command(path: Path) -> None:
    assert main(["track", str(path)]) in (0, 1)


def by_a_batch(path: Path) -> None:
    assert run_task(Task(path), lambda step: None, Event()).is_done


WAYS: dict[str, Callable[[Path], None]] = {
    "page": by_the_page,
    "track": by_the_command,
    "batch": by_a_batch,
}


@pytest.mark.parametrize(
    "settings",
    [{"quality": "full"}, {"quality": "preview", "passes": 3}],
    ids=str,
)
def test_page_command_and_batch_write_the_same_bytes(
    tmp_path: Path, settings: dict[str, Any]
) -> None:
    written = {}
    for way, by in WAYS.items():
        path = copied(tmp_path / way, **settings)
        by(path)
        results = load_session(path).subject.results
        assert results is not None
        assert all(s.key and s.quality == settings["quality"] for s in results.segments)
        written[way] = (path.read_bytes(), path.with_name(results.tracks).read_bytes())
    assert written["track"] == written["page"]
    assert written["batch"] == written["page"]


def test_page_and_command_write_the_same_motion_in_space(tmp_path: Path) -> None:
    written = {}
    for way in ("page", "track"):
        path = copied(tmp_path / way, (PIN,), quality="full", smooth=True)
        if way == "page":
            by_the_page_until_solved(path)
        else:
            by_the_command(path)
        results = load_session(path).subject.results
        assert results is not None
        (stretch,) = results.space
        assert [(pin.part, pin.first_frame, pin.last_frame) for pin in stretch.pins] == [
            ("box", 2, 12)
        ]
        written[way] = (path.read_bytes(), path.with_name(results.tracks).read_bytes())
    assert written["track"] == written["page"]


def test_a_motion_that_cannot_be_solved_for_in_space_is_kept_as_it_was_tracked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(session: Any, stretch: Any) -> None:
        raise ZeroDivisionError

    path = copied(tmp_path / "box", (PIN,), quality="preview", smooth=True)
    session = with_settings(load_session(path), TrackOrder(quality="full"))
    with open_video_of(session, path) as video:
        given = (session, path, video, all_segments(session))
        reports = list(rerun(*given, workers=1, stop=Event()))
    found = segments(reports)
    monkeypatch.setattr("keypose.app.jobs.rerun.solved", fail)
    with pytest.raises(ZeroDivisionError):
        save_found(session, path, found)
    results = load_session(path).subject.results
    assert results is not None
    assert len(results.segments) == 2
    assert results.space == ()


@pytest.mark.parametrize("workers", [1, 2])
@pytest.mark.parametrize(
    ("error", "raised"),
    [
        (SessionError("Too long."), SessionError),
        (ZeroDivisionError(), ZeroDivisionError),
        (MemoryError(), SessionError),
    ],
)
def test_an_error_in_one_segment_is_raised_after_the_others_are_reported(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    error: Exception,
    raised: type[Exception],
    workers: int,
) -> None:
    whole = Tracker.run_segment

    def run_segment(tracker: Tracker, span: Any, *given: Any) -> Any:
        if span[0] == 0:
            raise error
        return whole(tracker, span, *given)

    monkeypatch.setattr(Tracker, "run_segment", run_segment)
    path = cases.write_session(tmp_path)
    reported: list[Any] = []
    with pytest.raises(raised):
        _reports_of(reported, path, workers)
    assert [found.first for found in segments(reported)] == [4]


def _reports_of(reported: list[Any], path: Path, workers: int) -> None:
    """Track, and keep what is reported before an error."""
    session = load_session(path)
    with open_video_of(session, path) as video:
        wanted = all_segments(session)
        for report in rerun(session, path, video, wanted, workers=workers, stop=Event()):
            reported.append(report)


def test_nobody_listening_any_more_ends_the_work(tmp_path: Path) -> None:
    path = cases.write_session(tmp_path)
    session, stop = load_session(path), Event()
    with open_video_of(session, path) as video:
        reports = rerun(session, path, video, all_segments(session), workers=1, stop=stop)
        next(reports)
        reports.close()  # type: ignore[attr-defined]


def test_a_run_that_ends_stops_no_other_of_its_batch(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = copied(tmp_path / "job", quality="preview")
    session, stop, run = load_session(path), Event(), Track.run

    def ends_late(*given: Any) -> None:
        run(*given)
        time.sleep(0.3)

    monkeypatch.setattr(Track, "run", ends_late)
    with open_video_of(session, path) as video:
        list(rerun(session, path, video, all_segments(session), workers=1, stop=stop))
    assert not stop.is_set()


def test_with_nothing_found_nothing_is_written(tmp_path: Path) -> None:
    path = cases.write_session(tmp_path)
    before = path.read_bytes()
    assert save_found(load_session(path), path, ()) is None
    assert path.read_bytes() == before


def test_settings_that_are_not_asked_for_stay_the_session_s_own(tmp_path: Path) -> None:
    session = load_session(cases.write_session(tmp_path))
    assert with_settings(session, TrackOrder()) == session
    assert with_settings(session, TrackOrder(method="paper")).settings.method == "paper"
    assert (
        with_settings(session, TrackOrder(method="paper")).settings.quality
        == session.settings.quality
    )
    assert with_settings(session, TrackOrder(cues=("brightness",))).settings.cues == ("brightness",)
