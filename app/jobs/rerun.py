"""A saved session tracked without a page: the same work as the page's, the same bytes on disk.

The page's own job does the tracking, segment by segment, and `save_results` the writing. So a
result depends on nothing but its segment's key and quality, whoever asked for it.
"""

from __future__ import annotations

import queue
import shlex
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path
from threading import Event, Thread
from typing import Any

from app.jobs import JobFailed, Report, Wanted
from app.jobs.messages import Order
from app.jobs.work import Job
from app.jobs.worker_cache import WorkerCache
from tracker.errors import KeyposeError, SessionError
from tracker.session import Session
from tracker.session import results as saved
from tracker.session.settings import Initial, MethodName, Quality
from tracker.storage.files import load_session, save_session
from tracker.storage.results import (
    Results,
    SegmentTrack,
    Span,
    load_results,
    save_results,
    segment_keys,
    tidy_tracks,
)
from tracker.video import Video

POLL_S = 0.2
"""Between two looks at whether to stop."""


def with_settings(
    session: Session,
    method: MethodName | None,
    quality: Quality | None,
    initial: Initial | None = None,
    left_out: Sequence[str] | None = None,
) -> Session:
    """The session as it is to be tracked in this run; its file keeps its own settings.

    BodyError where `left_out` names a part that the body has not.
    """
    for name in left_out or ():
        session.body.index(name)
    parts = None if left_out is None else tuple(left_out)
    wanted = {"method": method, "quality": quality, "initial": initial, "left_out": parts}
    chosen = {name: value for name, value in wanted.items() if value is not None}
    return session.model_copy(update={"settings": session.settings.model_copy(update=chosen)})


def require_trackable(session: Session, session_path: Path) -> None:
    """SessionError unless there is something to track between, and its results could be saved."""
    if session.is_newer:
        raise SessionError(
            f"{session_path.name} was written by a newer Keypose and is not changed by this one."
        )
    if session.spans:
        return
    if session.surface is not None and session.keyframes:
        raise SessionError(f"{session_path.name} is about one mesh alone; nothing moves.")
    if session.surface is not None:
        raise SessionError(
            f"{session_path.name} has no keyframe: pose the body in one of the meshes first, with "
            f"`keypose open {shlex.quote(str(session_path))}`."
        )
    count = "one keyframe" if session.keyframes else "no keyframes"
    raise SessionError(f"{session_path.name} has {count}; tracking needs two.")


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
    """Track segments at the session's quality, `workers` at a time, and tell how it goes.

    `stop` set by the caller ends it within one pass; what is finished has been told by then. The
    first error is raised last, for it does not stop the other segments.
    """
    content = session.model_copy(update={"results": None}).model_dump_json().encode()
    path, stages = str(video.info.path), (session.settings.quality,)
    order = Order(1, content, path, tuple(wanted), stages, str(session_path.parent))
    told: queue.SimpleQueue[Report | None] = queue.SimpleQueue()
    job = _Job(order, stop, told.put)
    work = Thread(target=_run, args=(job, workers, told), name="tracking")
    work.start()
    failed, ended = "", False
    try:
        while (report := _next(told)) is not None:
            failed = report.words if isinstance(report, JobFailed) else ""
            yield report
        ended = True
    finally:
        if not ended:  # who listened has gone; other sessions of a batch share `stop`
            stop.set()
        work.join()
    if failed:
        raise job.error or RuntimeError(failed)


def keep(
    tracked: Session, session_path: Path, found: Sequence[SegmentTrack]
) -> saved.Results | None:
    """Write what was found beside the session's file, which then refers to it.

    tracked: the session as it was tracked. The person may have gone on editing meanwhile: of the
    file only the results are changed, and how and where surfaces are read. Where a segment was not
    found now, an earlier result that fits stays. None, and nothing is written, when nothing was
    found.
    """
    if not found:
        return None
    every = _with_earlier(tracked, session_path, found)
    results = save_results(tracked, session_path, every).results
    update: dict[str, Any] = {"results": results}
    if tracked.surface is not None:
        update |= {"surface": tracked.surface, "video": tracked.video}
    save_session(load_session(session_path).model_copy(update=update), session_path)
    with suppress(OSError):  # what is left over does no harm
        tidy_tracks(session_path.parent)
    return results


def keep_elsewhere(
    tracked: Session, place: Path, found: Sequence[SegmentTrack]
) -> saved.Results | None:
    """Write the tracks beside another file, which is not written yet."""
    blank = tracked.model_copy(update={"results": None})
    return save_results(blank, place, _collect(found)).results


def _with_earlier(session: Session, path: Path, found: Sequence[SegmentTrack]) -> Results:
    """What was found and, where that is not whole, what is on disk and fits, if it is better."""
    spans = {track.span for track in found if not track.missing}
    if spans >= set(segment_keys(session)):
        return _collect(found)
    return _collect([*_on_disk(session, path, spans), *found])


def _on_disk(session: Session, path: Path, without: set[Span]) -> list[SegmentTrack]:
    try:
        fitting = load_results(session, path).fitting(session)
    except SessionError:  # missing or damaged: then there is nothing to keep
        return []
    return [track for span, track in fitting.items() if span not in without]


def _collect(found: Sequence[SegmentTrack]) -> Results:
    results = Results()
    for track in found:
        results = results.with_track(track, keep=results.tracks)
    return results


class _Job(Job):
    """The page's job, which remembers its first error as it was raised."""

    error: BaseException | None = None

    def _fail(self, span: Span, words: str) -> None:
        if self.error is None:
            error = sys.exception()
            too_large = isinstance(error, MemoryError)
            self.error = SessionError(words) if too_large or error is None else error
        super()._fail(span, words)


def _run(job: _Job, workers: int, told: queue.SimpleQueue[Report | None]) -> None:
    worker_cache = WorkerCache()
    try:
        with ThreadPoolExecutor(workers) as threads:
            job.run(worker_cache, threads)
    finally:
        with suppress(KeyposeError, OSError):
            worker_cache.close()
        told.put(None)


def _next(told: queue.SimpleQueue[Report | None]) -> Report | None:
    """Waits in short turns, so that signals are heard on every system."""
    while True:
        with suppress(queue.Empty):
            return told.get(timeout=POLL_S)
