"""Track a saved session without a page: the same work as the page's, the same bytes on disk.

The page's own job does the tracking, segment by segment, and `save_results` the writing. So a
result depends on nothing but its segment's key and quality, whoever asked for it.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing, suppress
from pathlib import Path
from threading import Event
from typing import Any

from keypose.app.jobs.job import Context, Finished, Report
from keypose.app.jobs.progress import Wanted
from keypose.app.jobs.track import Track
from keypose.app.jobs.worker_cache import WorkerCache
from keypose.app.orders.tracking import DraftOrder, TrackOrder, said
from keypose.app.words.untrackable import why_untrackable
from keypose.tracker.errors import KeyposeError, SessionError
from keypose.tracker.operations.solve_space import solved
from keypose.tracker.session import Session
from keypose.tracker.session import results as saved
from keypose.tracker.storage.files import load_session, save_session
from keypose.tracker.storage.results import (
    Results,
    Span,
    load_results,
    save_results,
    segment_keys,
    tidy_tracks,
)
from keypose.tracker.tracking.pool import Cancelled, stream
from keypose.tracker.tracking.result import SegmentResult
from keypose.tracker.video import Video
from keypose.tracker.video.clip_loader import ONCE


def with_settings(session: Session, order: TrackOrder | DraftOrder) -> Session:
    """The session with the settings of an order; its file is not written.

    BodyError where the order leaves out a part that the body has not.
    """
    asked = said(order)
    for name in asked.get("left_out", ()):
        session.subject.body.index(name)
    settings = session.settings.model_copy(update=asked)
    return session.changed({"settings": settings})


def with_repeats(session: Session, video: Video, first: int, last: int) -> Session:
    """The session with the repeated frames of its film, looked for in these frames where it has
    none; itself where there are none."""
    reference = session.view.video
    if reference.repeats is not None or not session.evidence.can_be_damaged:
        return session
    deque(video.examine(first, min(last, video.info.frame_count - 1)), maxlen=0)
    repeats = video.repeats()
    if not repeats.frames:
        return session
    return session.changed({"video": reference.model_copy(update={"repeats": repeats})})


def require_trackable(session: Session, session_path: Path) -> None:
    """SessionError unless there is something to track between, and its results could be saved."""
    if session.is_newer:
        raise SessionError(
            f"{session_path.name} was written by a newer Keypose and is not changed by this one."
        )
    if session.spans:
        return
    raise SessionError(why_untrackable(session, session_path))


def all_segments(session: Session) -> tuple[Wanted, ...]:
    """Every segment, with its key."""
    return tuple((*span, key) for span, key in segment_keys(session).items())


def rerun(
    session: Session,
    session_path: Path,
    video: Video,
    wanted: Sequence[Wanted],
    *,
    workers: int,
    stop: Event,
) -> Iterator[Report]:
    """Track segments at the session's quality, `workers` at a time, and report how it goes.

    `stop` set by the caller ends it within one pass; what is finished has been reported by then.
    The first error is raised last, for it does not stop the other segments.
    """
    stages = (session.settings.quality,)
    job = Track.of(session, video.info.path, wanted, stages, session_path.parent)

    def work(send: Callable[[Report], None]) -> None:
        worker_cache = WorkerCache(ONCE)
        try:
            with ThreadPoolExecutor(workers) as threads:
                job.run(Context(1, worker_cache, threads, stop.is_set, send))
            send(Finished(1))
        except Cancelled:
            send(Finished(1, cancelled=True))
        finally:
            with suppress(KeyposeError, OSError):
                worker_cache.close()

    with closing(stream(work, stop)) as reports:  # other sessions of a batch share `stop`
        yield from reports


def save_found(
    tracked: Session, session_path: Path, segment_results: Sequence[SegmentResult]
) -> saved.Results | None:
    """Write what was found beside the session's file, which then refers to it.

    tracked: the session as it was tracked. The person may have gone on editing meanwhile: of the
    file only the results are changed, and how and where surfaces are read. Where a segment was not
    found now, an earlier result that fits stays. None, and nothing is written, when nothing was
    found. Where the motion cannot be solved for in space it is written as it was tracked, and the
    error raised after that.
    """
    if not segment_results:
        return None
    every = _with_earlier(tracked, session_path, segment_results)
    every = _with_bonded(tracked, session_path, every)
    written = _solved_and_saved(tracked, every, lambda every: _save(tracked, session_path, every))
    for body_id in tracked.bonded:
        _solve_again(session_path, body_id)
    return written


def _with_bonded(session: Session, path: Path, results: Results) -> Results:
    """The results beside those on disk of the bodies that bonds join to the posed one."""
    there = load_session(path)
    for body_id in session.bonded:
        with suppress(SessionError):  # missing or damaged: then it holds nothing
            results = results.beside(load_results(there.about(body_id), path))
    return results


def _solve_again(path: Path, body_id: str) -> None:
    """Solve for a body's motion in space where a body that bonds join to it was tracked anew."""
    file = load_session(path)
    about = file.about(body_id)
    results = load_results(about, path)
    if results.unsolved(about):
        again = save_results(about, path, _in_space(about, results))
        save_session(again.about(file.subject.id), path)


def _save(tracked: Session, session_path: Path, every: Results) -> saved.Results | None:
    results = save_results(tracked, session_path, every).subject.results
    update: dict[str, Any] = {"results": results}
    update |= {name: tracked.value(name) for name in tracked.evidence.run_fields}
    file = load_session(session_path)
    there = file.about(tracked.subject.id)
    if tracked.view.video.repeats is not None and "video" not in update:
        repeats = {"repeats": tracked.view.video.repeats}
        update["video"] = there.view.video.model_copy(update=repeats)
    save_session(there.changed(update).about(file.subject.id), session_path)
    with suppress(OSError):  # what is left over does no harm
        tidy_tracks(session_path.parent)
    return results


def save_tracks_beside(
    tracked: Session,
    place: Path,
    segment_results: Sequence[SegmentResult],
    refer: Callable[[saved.Results | None], None],
) -> saved.Results | None:
    """Write the tracks beside another file, which `refer` writes: it receives their names.

    Where the motion cannot be solved for in space both are written as it was tracked, and the error
    raised after that.
    """
    blank = tracked.changed({"results": None})

    def save(every: Results) -> saved.Results | None:
        results = save_results(blank, place, every).subject.results
        refer(results)
        return results

    return _solved_and_saved(blank, _collect(segment_results), save)


def _solved_and_saved(
    session: Session, results: Results, save: Callable[[Results], saved.Results | None]
) -> saved.Results | None:
    try:
        results = _in_space(session, results)
    finally:
        written = save(results)
    return written


def _in_space(session: Session, results: Results) -> Results:
    """Solve for the motion of every stretch in space."""
    for stretch in results.unsolved(session):
        results = results.with_space(solved(session, stretch))
    return results


def _with_earlier(
    session: Session, path: Path, segment_results: Sequence[SegmentResult]
) -> Results:
    """What was found and, where that is not whole, what is on disk and fits, if it is
    better.
    """
    spans = {track.span for track in segment_results if not track.missing}
    if spans >= set(segment_keys(session)):
        return _collect(segment_results)
    return _collect([*_on_disk(session, path, spans), *segment_results])


def _on_disk(session: Session, path: Path, without: set[Span]) -> list[SegmentResult]:
    """The motion as tracked: what was solved in space would be smoothed again."""
    try:
        fitting = load_results(session, path).fitting(session)
    except SessionError:  # missing or damaged: then there is nothing to keep
        return []
    return [track.as_tracked for span, track in fitting.items() if span not in without]


def _collect(segment_results: Sequence[SegmentResult]) -> Results:
    results = Results()
    for track in segment_results:
        results = results.with_result(track, keep=results.by_key)
    return results
