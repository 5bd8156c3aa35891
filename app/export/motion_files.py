"""The tracked motion as files for other programs: of the command line, the page and a batch."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from keypose.app.editor.state import EditorState
from keypose.app.export.motion_formats import FORMATS, MotionFormat
from keypose.app.orders.motion import AS_TRACKED, MotionOrder
from keypose.tracker.errors import FormatError, listed
from keypose.tracker.formats.recording import RecordedSegment, Recording
from keypose.tracker.formats.sampling import at_rate, from_zero, low_passed, moved_at_keyframes
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.operations.seen_by import errors_in_films
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.results import Span
from keypose.tracker.storage.tracks import Tracks

if TYPE_CHECKING:
    from keypose.tracker.video.info import Timecode


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
    recording: Recording, order: MotionOrder, formats: Sequence[MotionFormat]
) -> str | None:
    """What a person should know of files in these formats; None if as tracked."""
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
    sentences += [f"{FORMATS[name].then}." for name in formats if FORMATS[name].then]
    return " ".join(sentences) or None


def motion_files(
    format_name: MotionFormat, recording: Recording, order: MotionOrder = AS_TRACKED
) -> dict[str, bytes]:
    """The contents to write by file name. FormatError when the format cannot hold the motion."""
    kind = FORMATS[format_name]
    made = sampled(recording, order, kind.own_times)
    contents = kind.contents(made, order)
    names = kind.names if len(contents) == len(kind.names) else (*kind.names, *kind.also)
    return {name: _bytes(content) for name, content in zip(names, contents, strict=True)}


def outdated_files(format_name: MotionFormat, written: Collection[str]) -> list[str]:
    """Names of files of a format that this motion has nothing for: where they are, they are of one
    of before."""
    return [name for name in FORMATS[format_name].also if name not in written]


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
    files = motion_files(format_name, shown_motion(edit, folder), order)
    if len(files) == 1:
        ((name, content),) = files.items()
        return File(content, FORMATS[format_name].media_type, name.removeprefix("motion"))
    return File(_packed(files), "application/zip", f"-{format_name}.zip")


def every_format(
    edit: EditorState, order: MotionOrder = AS_TRACKED, folder: Path | None = None
) -> File:
    """The motion in every format that can hold it, in one zip; FormatError where none can.

    folder: as of `saved_motion`.
    """
    recording, files, left_out = shown_motion(edit, folder), dict[str, bytes](), []
    for name in FORMATS:
        try:
            files |= motion_files(name, recording, order)
        except FormatError as error:
            left_out.append(f"{name.upper()}: {error}")
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
) -> Recording:
    """The motion that a session's results refer to.

    times_s are those of all the video's frames, timecode that of the video, where it is known.
    folder: of the session's file, beside which keypoints are that tell the errors in each of
    several films; None where they are not wanted.
    """
    segments = session.subject.results.segments if session.subject.results else ()
    stretches = [
        RecordedSegment(first, last, s.verdict)
        for s in segments
        for first, last in _reached(s.first_frame, s.last_frame, s.unreached)
    ]
    films = () if folder is None else errors_in_films(session, tracks, folder)
    return Recording.of(session, tracks, stretches, times_s, timecode, films)


def shown_motion(edit: EditorState, folder: Path | None = None) -> Recording:
    """The motion that the page shows: of those segments that are tracked as they stand.

    folder: as of `saved_motion`.
    """
    segment_results = sorted(
        (t for t in edit.fitting.values() if t.finished), key=lambda t: t.first
    )
    if not segment_results:
        raise FormatError("There is no motion yet: pose two keyframes and track.")
    stretches = [
        RecordedSegment(first, last, t.verdict)
        for t in segment_results
        if t.verdict is not None
        for first, last in _reached(t.first, t.last, t.unreached)
    ]
    tracks = Tracks.of(segment_results, edit.skeleton)
    films = () if folder is None else errors_in_films(edit.doc, tracks, folder)
    return Recording.of(edit.doc, tracks, stretches, edit.times_s, edit.timecode, films)


def _reached(first: int, last: int, unreached: Span | None) -> list[Span]:
    """The stretches of a segment that are left without what was not reached."""
    if unreached is None:
        return [(first, last)]
    both = [(first, unreached[0] - 1), (unreached[1] + 1, last)]
    return [(a, b) for a, b in both if a < b]
