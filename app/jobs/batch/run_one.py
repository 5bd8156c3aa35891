"""Run one session of a batch: lock, read, track, write, export; whatever happens, a summary."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from threading import Event
from typing import Final, TypeAlias

from keypose.app.document.folder_lock import NAME as LOCK
from keypose.app.document.folder_lock import LockedElsewhere, SessionLock
from keypose.app.export.motion_files import files_of_bodies, outdated_files, saved_motions
from keypose.app.export.motion_formats import FORMATS
from keypose.app.jobs.batch.finding import SESSION
from keypose.app.jobs.batch.make_session import (
    PICTURE,
    add_notes,
    is_made_here,
    make_session,
    notes_of,
)
from keypose.app.jobs.batch.task import (
    Export,
    PlaceToReview,
    SegmentSummary,
    Step,
    Summary,
    Task,
)
from keypose.app.jobs.find_camera import find_saved, is_camera_wanted, with_found
from keypose.app.jobs.job import Finished, Progress
from keypose.app.jobs.progress import Wanted
from keypose.app.jobs.rerun import (
    all_segments,
    require_trackable,
    rerun,
    save_found,
    with_repeats,
    with_settings,
)
from keypose.app.jobs.stand import BodyStood, stood_together
from keypose.app.jobs.track import found_in
from keypose.app.jobs.wire import failure_message
from keypose.app.orders.motion import AS_TRACKED, MotionOrder
from keypose.app.words.bodies import after_id
from keypose.app.words.camera import unscaled_words
from keypose.app.words.films import film_errors_words
from keypose.app.words.review import row_of_place
from keypose.app.words.standing import refused_words, soles_words, standing_words
from keypose.tracker.errors import FormatError, KeyposeError, SessionError, listed
from keypose.tracker.formats.verdict_words import verdict_words
from keypose.tracker.operations.seen_by import errors_in_films
from keypose.tracker.review.places import review_of, worst_of_all
from keypose.tracker.session import Session
from keypose.tracker.session.bodies import id_and_name
from keypose.tracker.session.verdict import VERDICT_KINDS
from keypose.tracker.storage.atomic import make_folder, write_file
from keypose.tracker.storage.files import (
    load_session,
    open_video_of,
    save_session,
    with_present_fingerprints,
)
from keypose.tracker.storage.results import Results, Span, load_results, save_results
from keypose.tracker.storage.tracks import load_tracks
from keypose.tracker.tracking.pool import Cancelled, SegmentFinished
from keypose.tracker.tracking.result import SegmentResult
from keypose.tracker.video import Video

BY_HAND: Final = (
    "The session was begun by hand: it was tracked as it stands, and not stood on the floor."
)
STANDS_ALREADY: Final = "It was stood on the floor before, and stays so."


def export_of(
    session: Path,
    folder: Path,
    out: Path | None,
    formats: tuple[str, ...],
    order: MotionOrder = AS_TRACKED,
) -> Export:
    """Where the files of a session in `folder` go: beside it, or to the same place below
    `out`.

    A session that is not called session.json gives its name to its files.
    """
    place = session.parent if out is None else out / session.parent.relative_to(folder)
    prefix = "" if session.name == SESSION else f"{session.stem}-"
    return Export(formats, place, prefix, order)


def places(export: Export) -> list[Path]:
    """The files that there will be."""
    names = [name for kind in FORMATS if kind in export.formats for name in FORMATS[kind].names]
    return [export.folder / f"{export.prefix}{name}" for name in names]


def export_motion(session_path: Path, export: Export) -> tuple[str, ...]:
    """Write the motion of all bodies that are tracked in every format; the files. FormatError when
    one cannot be."""
    session = load_session(session_path)
    tracks = {
        body.id: load_tracks(session.about(body.id), session_path)
        for body in session.bodies
        if body.results is not None
    }
    folder = session_path.parent
    with open_video_of(session, session_path) as video:
        times_s = session.evidence.times_s(video.info.times_s)
        bodies = saved_motions(session, tracks, times_s, video.info.timecode, folder)
    make_folder(export.folder, error=FormatError)
    written = []
    for format_name in FORMATS:
        if format_name not in export.formats:
            continue
        files, refused = files_of_bodies(format_name, bodies, export.order)
        if refused:
            raise FormatError(" ".join(refused))
        for name, content in files.items():
            place = export.folder / f"{export.prefix}{name}"
            write_file(place, content, overwrite=True)
            written.append(str(place))
        for name in outdated_files(format_name, files, [body.body_id for body in bodies]):
            (export.folder / f"{export.prefix}{name}").unlink(missing_ok=True)
    return tuple(written)


SendStep: TypeAlias = Callable[[Step], None]


def run_task(task: Task, send: SendStep, stop: Event) -> Summary:
    """Do it. `stop` set ends it within one pass; what was finished is kept."""
    began = time.monotonic()
    return _failure_as_summary(task, send, stop).after(time.monotonic() - began)


def _failure_as_summary(task: Task, send: SendStep, stop: Event) -> Summary:
    name = str(task.session)
    try:
        with _folder_of(task), SessionLock.take(task.session.parent):
            if task.film is not None:
                make_session(task, task.film, send, stop)
            summary = _track_missing(task, send, stop)
            if not summary.is_done:
                return replace(summary, notes=_notes_of(task))
            return _finished(task, summary, send, stop)
    except Cancelled:
        return Summary(name, "interrupted", notes=_notes_of(task))
    except LockedElsewhere as held:
        return Summary(name, "open", f"{str(held)[:1].upper()}{str(held)[1:]}: left alone.")
    except MemoryError:
        return Summary(name, "failed", "There is not enough memory: use fewer workers.")
    except Exception as error:  # noqa: BLE001 — a fault, reported as such; the other sessions go on
        words = failure_message(error, "Keypose ran into an internal error ({}).")
        return Summary(name, "failed", words)


@contextmanager
def _folder_of(task: Task) -> Iterator[None]:
    """The folder of the session, made where a film has none yet; it goes again where nothing came
    of that."""
    folder = task.session.parent
    if task.film is None or folder.is_dir():
        yield
        return
    make_folder(folder, error=SessionError)
    try:
        yield
    finally:
        if [path.name for path in folder.iterdir()] == [LOCK]:
            with suppress(OSError):  # somebody else has taken it meanwhile
                (folder / LOCK).unlink()
                folder.rmdir()


@dataclass(eq=False)
class _Found:
    """What tracking found, and how it ended."""

    tracks: list[SegmentResult]
    cancelled: bool = False
    error: KeyposeError | None = None

    @property
    def is_whole(self) -> bool:
        """Whether nothing ended it before its time."""
        return self.error is None and not self.cancelled


def _track_missing(task: Task, send: SendStep, stop: Event) -> Summary:
    session = load_session(task.session)
    abouts = (session.about(body.id) for body in session.bodies)
    require_trackable(next((about for about in abouts if about.spans), session), task.session)
    session = _as_exported(session, task.session)
    asked = with_settings(session, task.order)
    if is_camera_wanted(asked):
        session = with_found(session, find_saved(asked, task.session))
        save_session(session, task.session)
    outcomes = dict[str, _Found]()
    for body_id in dict.fromkeys([session.subject.id, *(body.id for body in session.bodies)]):
        about = _as_exported(load_session(task.session), task.session).about(body_id)
        if not about.spans:
            continue
        asked = with_settings(about, task.order)
        outcomes[body_id] = _track_body(task, about, asked, send, stop)
        if not outcomes[body_id].is_whole:
            break
    return _summary(task, outcomes)


def _track_body(
    task: Task, session: Session, asked: Session, send: SendStep, stop: Event
) -> _Found:
    """Track the body that is posed, and save what was found.

    asked: the session with the settings of the task.
    """
    wanted = _missing(asked, task.session) if task.missing_only else all_segments(asked)
    outcome = _Found([])
    if wanted:
        with open_video_of(session, task.session) as video:
            asked = with_repeats(asked, video, wanted[0][0], wanted[-1][1])
            outcome = _track(task, asked, video, wanted, send, stop)
        save_found(asked, task.session, outcome.tracks)
    return outcome


def _finished(task: Task, summary: Summary, send: SendStep, stop: Event) -> Summary:
    """The summary of a session that is tracked: stood on the floor and exported, as was asked for,
    and with what is to be reviewed of a film that nobody has looked at. Cancelled once `stop` is
    set."""
    if task.film is not None and is_made_here(task.session):
        add_notes(task.session, _stood_words(task, send, stop))
        summary = _reviewed(task, summary)
    elif task.film is not None:
        summary = replace(summary, notes=(BY_HAND,))
    more = (*_films_words(task.session), *_bodies_words(task.session))
    summary = replace(summary, notes=(*summary.notes, *more))
    if task.export is None:
        return summary
    _leave_when(stop)
    send(Step(0, stage="export"))
    words = unscaled_words(load_session(task.session))
    summary = replace(summary, notes=(*summary.notes, words)) if words else summary
    try:
        return replace(summary, exported=export_motion(task.session, task.export))
    except FormatError as error:
        return replace(summary, state="failed", words=str(error))


def _films_words(session_path: Path) -> tuple[str, ...]:
    """How far joints lie from where each of several films shows them; nothing of one film."""
    session = load_session(session_path)
    if not session.views[1:]:
        return ()
    tracks = load_tracks(session, session_path)
    words = film_errors_words(errors_in_films(session, tracks, session_path.parent))
    return (words,) if words else ()


def _bodies_words(session_path: Path) -> tuple[str, ...]:
    """How many segments of each of several bodies there are of each verdict."""
    session, sentences = load_session(session_path), list[str]()
    if len(session.bodies) == 1:
        return ()
    for body in session.bodies:
        segments = () if body.results is None else body.results.segments
        kinds = Counter(segment.verdict.kind for segment in segments)
        counts = [f"{kinds[kind]} {kind}" for kind in VERDICT_KINDS if kinds[kind]]
        words = (
            f"{listed(counts)} of {len(segments)} segment{'s' * (len(segments) > 1)}"
            if counts
            else "not tracked"
        )
        sentences.append(f"{id_and_name(body)}: {words}.")
    return tuple(sentences)


def _leave_when(stop: Event) -> None:
    if stop.is_set():
        raise Cancelled


def _stood_words(task: Task, send: SendStep, stop: Event) -> tuple[str, ...]:
    """Stand the motion on its floor, unless it does or is not to; what that changed, or why it
    cannot be."""
    session = load_session(task.session)
    if session.world.floor_m is not None:
        return () if task.stand else (STANDS_ALREADY,)
    if not task.stand:
        return ()
    _leave_when(stop)
    send(Step(0, stage="stand"))
    tracked = [body.id for body in session.bodies if body.results is not None]
    try:
        whole, standing, refused = stood_together(session, task.session, tracked, stop.is_set)
    except SessionError as error:
        return (f"Not stood on the floor: {error}",)
    for body_id, each in standing.items():
        saved = save_results(whole.about(body_id), task.session, each.results)
        whole = saved.about(session.subject.id)
    save_session(whole, task.session)
    words = [
        after_id(sentence, body_id, session)
        for body_id, each in standing.items()
        for sentence in _standing_words(each)
    ]
    for body_id, why in refused.items():
        refusal = refused_words(why, next(iter(standing)))
        words.append(after_id(refusal, body_id, session))
    return tuple(words)


def _standing_words(each: BodyStood) -> tuple[str, ...]:
    soles = each.soles
    words = standing_words(each.done, beside=each.beside)
    return words, *([] if soles is None else [soles_words(soles)])


def _reviewed(task: Task, summary: Summary) -> Summary:
    """The summary with what was decided and where to look, the worst first."""
    session = load_session(task.session)
    abouts = {body.id: session.about(body.id) for body in session.bodies}
    places_of = {}
    for body_id, about in abouts.items():
        review = review_of(about, load_results(about, task.session))
        places_of[body_id] = review.above(review.goal_px)
    to_review = tuple(
        PlaceToReview(
            place.frame,
            *row_of_place(place)[1:],
            body=_id_of_several(abouts[body_id]),
        )
        for body_id, place in worst_of_all(places_of)
    )
    picture = task.session.with_name(PICTURE)
    return replace(
        summary,
        notes=_notes_of(task),
        places=to_review,
        person=str(picture) if picture.is_file() else None,
    )


def _notes_of(task: Task) -> tuple[str, ...]:
    return () if task.film is None else notes_of(task.session)


def _as_exported(session: Session, path: Path) -> Session:
    """Refresh what may have been exported again."""
    if session.evidence.is_known_by_fingerprint:
        return session
    with open_video_of(session, path) as video:
        return with_present_fingerprints(session, path, video)


def _missing(asked: Session, path: Path) -> Sequence[Wanted]:
    """The segments without a result that fits, of at least the quality asked for."""
    try:
        results = load_results(asked, path)
    except SessionError:  # missing or damaged: as if never tracked
        results = Results()
    return results.wanted(asked)


def _track(
    task: Task, asked: Session, video: Video, wanted: Sequence[Wanted], send: SendStep, stop: Event
) -> _Found:
    from keypose.tracker.warm import needed, warm

    warm(needed(asked))
    outcome, percent = _Found([]), 0
    try:
        for report in rerun(asked, task.session, video, wanted, workers=task.threads, stop=stop):
            if isinstance(report, Finished):
                outcome.cancelled = report.cancelled
            if not isinstance(report, Progress):
                continue
            before, percent = percent, int(100 * report.share)
            if isinstance(event := found_in(report), SegmentFinished):
                outcome.tracks.append(event.result)
                send(Step(percent, _segment_json(event.result)))
            elif percent != before:
                send(Step(percent))
    except KeyposeError as error:
        outcome.error = error
    return outcome


def _segment_json(track: SegmentResult) -> dict[str, object]:
    return {
        "first_frame": track.first,
        "last_frame": track.last,
        "verdict": track.kind,
        "words": "" if track.verdict is None else verdict_words(track.verdict),
    }


def _summary(task: Task, outcomes: Mapping[str, _Found]) -> Summary:
    """Summarise the session as it stands on disk now.

    outcomes: by the ids of the bodies that were tracked.
    """
    now = load_session(task.session)
    results = now.subject.results
    fresh = {
        body_id: {track.span for track in outcome.tracks} for body_id, outcome in outcomes.items()
    }
    segments = tuple(
        summary
        for body in now.bodies
        for summary in _segments(now.about(body.id), fresh.get(body.id, set()))
    )
    summary = Summary(
        str(task.session),
        "tracked" if any(fresh.values()) else "kept",
        tracks=None if results is None else results.tracks,
        segments=segments,
    )
    for outcome in outcomes.values():
        if outcome.error is not None:
            return replace(summary, state="failed", words=str(outcome.error))
        if outcome.cancelled:
            return replace(summary, state="interrupted")
    abouts = (now.about(body_id) for body_id in outcomes)
    if any(_missing(with_settings(about, task.order), task.session) for about in abouts):
        words = "Edited while it was tracked: some segments are out of date again."
        return replace(summary, words=words)
    return summary


def _segments(about: Session, fresh: Container[Span]) -> Iterator[SegmentSummary]:
    """The segments of one body; `fresh` are those tracked now."""
    results = about.subject.results
    for segment in () if results is None else results.segments:
        yield SegmentSummary(
            segment.first_frame,
            segment.last_frame,
            segment.verdict.kind,
            verdict_words(segment.verdict),
            segment.quality or about.settings.quality,
            fresh=(segment.first_frame, segment.last_frame) in fresh,
            body=_id_of_several(about),
        )


def _id_of_several(about: Session) -> str | None:
    """The body's id, None where the session has only one."""
    return about.subject.id if len(about.bodies) > 1 else None
