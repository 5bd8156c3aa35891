"""The tracked motion as files for other programs: of the command line, the page and a batch."""

from __future__ import annotations

import io
import zipfile
from dataclasses import dataclass

from app.editor.state import EditorState
from app.export.motion_formats import FORMATS, MotionFormat
from tracker.errors import FormatError
from tracker.formats.recording import RecordedSegment, Recording
from tracker.geometry.rotations import Array
from tracker.session.schema import Session
from tracker.storage.results import Span
from tracker.storage.tracks import Tracks


@dataclass(frozen=True)
class File:
    """One file to save; `suffix` follows the session's name."""

    content: bytes
    media_type: str
    suffix: str


def motion_files(format_name: MotionFormat, recording: Recording) -> dict[str, bytes]:
    """The contents to write by file name. FormatError when the format cannot hold the motion."""
    kind = FORMATS[format_name]
    contents = kind.write(recording)
    return {name: _bytes(one) for name, one in zip(kind.names, contents, strict=True)}


def _bytes(content: str | bytes) -> bytes:
    return content.encode() if isinstance(content, str) else content


def motion_archive(format_name: MotionFormat, edit: EditorState) -> File:
    """The motion as one file: several are packed into a zip. FormatError where frames lack."""
    files = motion_files(format_name, shown_motion(edit))
    if len(files) == 1:
        return File(next(iter(files.values())), FORMATS[format_name].media_type, f".{format_name}")
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(zipfile.ZipInfo(name), content, zipfile.ZIP_DEFLATED)  # no clock
    return File(packed.getvalue(), "application/zip", f"-{format_name}.zip")


def saved_motion(session: Session, tracks: Tracks, times_s: Array) -> Recording:
    """The motion that a session's results refer to; times_s are those of all the video's frames."""
    segments = session.results.segments if session.results else ()
    stretches = [
        RecordedSegment(first, last, s.verdict)
        for s in segments
        for first, last in _reached(s.first_frame, s.last_frame, s.unreached)
    ]
    return Recording.of(session, tracks, stretches, times_s)


def shown_motion(edit: EditorState) -> Recording:
    """The motion that the page shows: of those segments that are tracked as they stand."""
    found = sorted((t for t in edit.fitting.values() if t.finished), key=lambda t: t.first)
    if not found:
        raise FormatError("There is no motion yet: pose two keyframes and track.")
    stretches = [
        RecordedSegment(first, last, t.verdict)
        for t in found
        if t.verdict is not None
        for first, last in _reached(t.first, t.last, t.unreached)
    ]
    return Recording.of(edit.doc, Tracks.of(found, edit.skeleton), stretches, edit.times_s)


def _reached(first: int, last: int, unreached: Span | None) -> list[Span]:
    """The stretches of a segment that are left without what was not reached."""
    if unreached is None:
        return [(first, last)]
    both = [(first, unreached[0] - 1), (unreached[1] + 1, last)]
    return [(a, b) for a, b in both if a < b]
