"""The tracked motion as files for other programs: of the command line, the page and a batch."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from keypose.app.editor.state import EditorState
from keypose.app.export.motion_formats import FORMATS, MotionFormat
from keypose.app.orders.motion import AS_TRACKED, MotionOrder
from keypose.tracker.errors import FormatError, listed
from keypose.tracker.films.errors import FilmErrors
from keypose.tracker.formats.recording import (
    RecordedSegment,
    Recording,
    on_one_ground,
    reach,
)
from keypose.tracker.formats.sampling import at_rate, from_zero, low_passed, moved_at_keyframes
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.results import Span
from keypose.tracker.storage.tracks import Tracks

if TYPE_CHECKING:
    from keypose.tracker.video.info import Timecode


MOTION: Final = "motion"
"""What files' names begin with, but those of tables."""


@dataclass(frozen=True)
class File:
    """One file to save; `suffix` follows the session's name. left_out: what could not be written,
    sentences."""

    content: bytes
    media_type: str
    suffix: str
    left_out: str = ""


def sampled(recording: Recording, order: MotionOrder, own_times: bool) -> Recording:
    """The recording as it is asked for; `own_times` where a varying rate may stay.

    It is filtered before frames are left out, and at the film's rate, whatever rate it gets. Its
    world is that of the whole motion.
    """
    made = replace(recording.with_ground(), marker_set=order.markers, origin=order.origin)
    if order.filter_hz is not None:
        made = low_passed(made, order.filter_hz)
    if order.fps is not None:
        made = at_rate(made, float(order.fps))
    elif not own_times and not made.is_even:
        made = at_rate(made, made.rate or made.frames_per_second)
    made = made if order.frames is None else _between(made, order.frames)
    return from_zero(made) if order.from_zero else made


def _between(recording: Recording, frames: Span) -> Recording:
    """The poses of these frames of the film."""
    film = recording.film_frames
    inside = np.flatnonzero((film >= frames[0]) & (film <= frames[1]))
    if len(inside) < 2:
        raise FormatError(
            f"Of frames {frames[0]} to {frames[1]} no two have a motion: it goes from "
            f"{np.ceil(film[0]):.0f} to {np.floor(film[-1]):.0f}."
        )
    numbers = recording.frames
    return recording.between(numbers[int(inside[0])], numbers[int(inside[-1])])


def sampling_words(
    recording: Recording, order: MotionOrder, formats: Sequence[MotionFormat], stem: str = MOTION
) -> str | None:
    """What a person should know of files in these formats; None if as tracked.

    stem: what the files' names begin with.
    """
    sentences = []
    if order.filter_hz is not None:
        metres, radians = moved_at_keyframes(low_passed(recording, order.filter_hz), recording)
        sentences.append(
            f"Filtered at {order.filter_hz:g} Hz, which moves keyframes by up to "
            f"{metres * 1000:.1f} mm and {np.degrees(radians):.1f}°."
        )
    even = [name for name in formats if order.filter_hz or not FORMATS[name].own_times]
    if order.fps is None and even and not recording.is_even:
        rate = recording.rate or recording.frames_per_second
        names = listed([name.upper() for name in even])
        verb = "has" if len(even) == 1 else "have"
        sentences.append(f"The film's rate varies: {names} {verb} {rate:.6g} frames a second.")
    first = recording.frames[0] if order.frames is None else order.frames[0]
    numbered = [name.upper() for name in formats if FORMATS[name].numbered]
    if order.fps is not None and numbered:
        sentences.append(
            f"{listed(numbered)} counts {float(order.fps):.6g} frames a second, which the file "
            "cannot say: it does not come back to the film's frames."
        )
    untimed = [name.upper() for name in formats if not FORMATS[name].timed]
    untimed += numbered if order.from_zero else []
    if first and untimed:
        verb = "begins" if len(untimed) == 1 else "begin"
        sentences.append(
            f"{listed(untimed)} {verb} at frame {first} of the film, which the file cannot say."
        )
    thens = [FORMATS[name].then for name in formats if FORMATS[name].then]
    sentences += [f"{then.replace(MOTION, stem)}." for then in thens]
    return " ".join(sentences) or None


def sampling_sentences(
    bodies: Sequence[Recording], order: MotionOrder, formats: Sequence[MotionFormat]
) -> list[str]:
    """The same of several bodies: what is the same for all once, else with the body's id."""
    stem = bodies[0].body_id if len(bodies) == 1 else ""
    each = {body.body_id: sampling_words(body, order, formats, stem or MOTION) for body in bodies}
    if len(set(each.values())) == 1:
        return [words for words in [*each.values()][:1] if words]
    return [f"{body_id}: {words}" for body_id, words in each.items() if words]


def motion_files(
    format_name: MotionFormat,
    recording: Recording,
    order: MotionOrder = AS_TRACKED,
    beside: Sequence[Recording] = (),
) -> dict[str, bytes]:
    """The contents to write by file name. FormatError when the format cannot hold the motion.

    beside: other bodies that its files hold, too.
    """
    kind = FORMATS[format_name]
    made, *others = (sampled(each, order, kind.own_times) for each in (recording, *beside))
    contents = kind.contents(made, order, others)
    names = kind.names if len(contents) == len(kind.names) else (*kind.names, *kind.also)
    body_id = "" if beside or kind.of_camera else recording.body_id
    return {
        file_of_body(name, body_id): _bytes(content)
        for name, content in zip(names, contents, strict=True)
    }


def file_of_body(name: str, body_id: str) -> str:
    """A file's name of one of several bodies: of motion.bvh "second.bvh", of joints.csv
    "second_joints.csv"; as it is where the body is the only one."""
    if not body_id:
        return name
    rest = name.removeprefix(MOTION)
    return f"{body_id}{rest}" if rest != name else f"{body_id}_{name}"


def files_of_bodies(
    format_name: MotionFormat, bodies: Sequence[Recording], order: MotionOrder
) -> tuple[dict[str, bytes], list[str]]:
    """The contents to write by file name, of several bodies in one file or of each; and what could
    not be written of some, in sentences. FormatError where nothing could.

    bodies: in one world, over the same frames.
    """
    kind = FORMATS[format_name]
    if len(bodies) == 1 or kind.of_camera:
        return motion_files(format_name, bodies[0], order), []
    if kind.together is not None and (kind.scene or order.together):
        return _files_together(format_name, bodies, order)
    files, refused = _files_apart(format_name, bodies, order)
    return {name: content for own in files.values() for name, content in own.items()}, refused


def _files_together(
    format_name: MotionFormat, bodies: Sequence[Recording], order: MotionOrder
) -> tuple[dict[str, bytes], list[str]]:
    """As `files_of_bodies`: all in one file but those that it cannot hold."""
    try:
        return motion_files(format_name, bodies[0], order, bodies[1:]), []
    except FormatError:
        files, refused = _files_apart(format_name, bodies, order)
        if not refused:  # it is all together that does not suit it
            raise
    first, *others = (body for body in bodies if body.body_id in files)
    return motion_files(format_name, first, order, others), refused


def _files_apart(
    format_name: MotionFormat, bodies: Sequence[Recording], order: MotionOrder
) -> tuple[dict[str, dict[str, bytes]], list[str]]:
    """The files of each body that has some, by its id; and why others have none."""
    files, refused = dict[str, dict[str, bytes]](), list[str]()
    for body in bodies:
        try:
            files[body.body_id] = motion_files(format_name, body, order)
        except FormatError as error:
            refused.append(f"{format_name.upper()} of {body.body_id}: {error}")
    if not files:
        raise FormatError(refused[0])
    return files, refused


def outdated_files(
    format_name: MotionFormat, written: Collection[str], body_ids: Sequence[str] = ("",)
) -> list[str]:
    """Names of files of a format that this motion has nothing for: where they are, they are of one
    of before."""
    of_bodies = [file_of_body(n, b) for n in FORMATS[format_name].also for b in body_ids]
    return [name for name in of_bodies if name not in written]


def unknown_errors_words(
    format_name: MotionFormat, written: Collection[str], body_ids: Sequence[str]
) -> str | None:
    """Of which bodies a file of expected errors lacks that others have; None where none does."""
    lacking = outdated_files(format_name, written, body_ids)
    if not lacking or len(lacking) == len(outdated_files(format_name, (), body_ids)):
        return None
    verb = "was" if len(lacking) == 1 else "were"
    return (
        f"{listed(lacking)} {verb} not written: expected errors are not known there at every "
        f"frame, and {format_name.upper()} has no gaps."
    )


def _bytes(content: str | bytes) -> bytes:
    return content.encode() if isinstance(content, str) else content


def motion_archive(
    format_name: MotionFormat,
    edit: EditorState,
    order: MotionOrder = AS_TRACKED,
    folder: Path | None = None,
) -> File:
    """The motion as one file: several are packed into a zip. FormatError where frames lack.

    folder: as of `saved_motion`.
    """
    files, refused = files_of_bodies(format_name, shown_motions(edit, folder), order)
    left_out = " ".join(refused)
    if len(files) == 1:
        ((name, content),) = files.items()
        suffix = name.removeprefix("motion") if name.startswith("motion") else f"-{name}"
        return File(content, FORMATS[format_name].media_type, suffix, left_out)
    return File(_packed(files), "application/zip", f"-{format_name}.zip", left_out)


def every_format(
    edit: EditorState, order: MotionOrder = AS_TRACKED, folder: Path | None = None
) -> File:
    """The motion in every format that can hold it, in one zip; FormatError where none can.

    folder: as of `saved_motion`.
    """
    bodies, files, left_out = shown_motions(edit, folder), dict[str, bytes](), list[str]()
    for name in FORMATS:
        try:
            of_format, refused = files_of_bodies(name, bodies, order)
        except FormatError as error:
            left_out.append(f"{name.upper()}: {error}")
        else:
            files |= of_format
            left_out += refused
    if not files:
        raise FormatError(left_out[0])
    return File(_packed(files), "application/zip", "-motion.zip", " ".join(left_out))


def _packed(files: Mapping[str, bytes]) -> bytes:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(zipfile.ZipInfo(name), content, zipfile.ZIP_DEFLATED)  # no clock
    return packed.getvalue()


def saved_motion(
    session: Session,
    tracks: Tracks,
    times_s: Array,
    timecode: Timecode | None = None,
    folder: Path | None = None,
    over: Sequence[int] = (),
) -> Recording:
    """The motion that a session's results refer to.

    times_s are those of all the video's frames, timecode that of the video, where it is known.
    folder: of the session's file, beside which keypoints are that tell the errors in each of
    several films; None where they are not wanted.  over: frames that it is to have, too.
    """
    segments = session.subject.results.segments if session.subject.results else ()
    stretches = [
        RecordedSegment(first, last, s.verdict)
        for s in segments
        for first, last in _reached(s.first_frame, s.last_frame, s.unreached)
    ]

    films = _errors_in_films(session, tracks, folder)
    return Recording.of(session, tracks, stretches, times_s, timecode, films, over)


def saved_motions(
    session: Session,
    tracks: Mapping[str, Tracks],
    times_s: Array,
    timecode: Timecode | None = None,
    folder: Path | None = None,
) -> list[Recording]:
    """The motions of a session's bodies in one world, over the same frames.

    tracks: of those that are tracked, by their ids.  times_s, timecode, folder: as of
    `saved_motion`.
    """
    if len(session.bodies) == 1:
        ((body_id, own),) = tracks.items()
        return [saved_motion(session.about(body_id), own, times_s, timecode, folder)]
    abouts = {body_id: session.about(body_id) for body_id in tracks}
    over = [frame for body_id, own in tracks.items() for frame in reach(abouts[body_id], own)]
    made = [
        saved_motion(abouts[body_id], own, times_s, timecode, folder, over)
        for body_id, own in tracks.items()
    ]
    named = [replace(each, body_id=name) for each, name in zip(made, tracks, strict=True)]
    return on_one_ground(named)


def shown_motions(edit: EditorState, folder: Path | None = None) -> list[Recording]:
    """The motions that the page shows, of all bodies that are tracked as they stand, in one world
    over the same frames.

    folder: as of `saved_motion`.
    """
    abouts = [edit.about(body.id) for body in edit.doc.bodies]
    tracked = [about for about in abouts if about.finished] or [edit]
    if len(edit.doc.bodies) == 1:
        return [_shown_motion(edit, folder)]
    over = [frame for about in tracked for frame in reach(about.doc, _tracks(about))]
    made = [
        replace(_shown_motion(about, folder, over), body_id=about.doc.subject.id)
        for about in tracked
    ]
    return on_one_ground(made)


def _tracks(edit: EditorState) -> Tracks:
    """What is tracked of the body that is posed; FormatError without anything."""
    segment_results = sorted(edit.finished.values(), key=lambda t: t.first)
    if not segment_results:
        raise FormatError("There is no motion yet: pose two keyframes and track.")
    return Tracks.of(segment_results, edit.skeleton)


def _shown_motion(
    edit: EditorState, folder: Path | None = None, over: Sequence[int] = ()
) -> Recording:
    tracks = _tracks(edit)
    stretches = [
        RecordedSegment(first, last, t.verdict)
        for t in sorted(edit.finished.values(), key=lambda t: t.first)
        if t.verdict is not None
        for first, last in _reached(t.first, t.last, t.unreached)
    ]
    films = _errors_in_films(edit.doc, tracks, folder)
    return Recording.of(edit.doc, tracks, stretches, edit.times_s, edit.timecode, films, over)


def _reached(first: int, last: int, unreached: Span | None) -> list[Span]:
    """The stretches of a segment that are left without what was not reached."""
    if unreached is None:
        return [(first, last)]
    both = [(first, unreached[0] - 1), (unreached[1] + 1, last)]
    return [(a, b) for a, b in both if a < b]


def _errors_in_films(
    session: Session, tracks: Tracks, folder: Path | None
) -> tuple[FilmErrors, ...]:
    """What each film of a session of several says of its motion."""
    if folder is None or len(session.views) == 1:
        return ()
    from keypose.tracker.operations.seen_by import errors_in_films  # loads what only this needs

    return errors_in_films(session, tracks, folder)
