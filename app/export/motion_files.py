"""The tracked motion as files for other programs, whichever door it leaves by."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias, get_args

import numpy as np

from app.editor.state import EditorState
from app.render.palette import SIDE_COLOURS, part_sides
from tracker.errors import FormatError
from tracker.formats.bvh import bvh
from tracker.formats.c3d import c3d
from tracker.formats.csv import angles_csv, frames_csv, joints_csv
from tracker.formats.glb import glb
from tracker.formats.npz import npz
from tracker.formats.recording import Recording, Stretch
from tracker.formats.trc import trc
from tracker.geometry.rotations import Array
from tracker.session.schema import Session
from tracker.storage.results import SegmentTrack, Span
from tracker.storage.tracks import Tracks

MotionFormat: TypeAlias = Literal["bvh", "glb", "trc", "c3d", "csv", "npz"]
FORMATS: Final[tuple[MotionFormat, ...]] = get_args(MotionFormat)

MEDIA_TYPES: dict[str, str] = {
    "bvh": "text/plain",
    "glb": "model/gltf-binary",
    "trc": "text/plain",
    "c3d": "application/octet-stream",
    "npz": "application/octet-stream",
}


@dataclass(frozen=True)
class File:
    """One file to save; `suffix` follows the session's name."""

    content: bytes
    media_type: str
    suffix: str


def motion_files(format_name: MotionFormat, recording: Recording) -> dict[str, bytes]:
    """The files by their names. FormatError where the format cannot hold the motion."""
    return {name: _bytes(content) for name, content in _contents(format_name, recording)}


def _contents(format_name: MotionFormat, recording: Recording) -> Iterator[tuple[str, str | bytes]]:
    skeleton, times_s = recording.skeleton, recording.times_s
    if format_name == "bvh":
        whole = recording.whole("BVH")
        yield "motion.bvh", bvh(skeleton, whole.trajectory, 1 / whole.frames_per_second)
    elif format_name == "glb":
        colours = {str(side): colour for side, colour in SIDE_COLOURS.items()}
        yield "motion.glb", glb(recording, part_sides(skeleton.body), colours)
    elif format_name == "trc":
        yield "motion.trc", trc(recording, "motion.trc")
    elif format_name == "c3d":
        yield "motion.c3d", c3d(recording)
    elif format_name == "npz":
        yield "motion.npz", npz(recording)
    else:
        yield "joints.csv", joints_csv(skeleton, recording.trajectory, times_s)
        yield "angles.csv", angles_csv(skeleton, recording.trajectory, times_s)
        yield "frames.csv", frames_csv(recording)


def _bytes(content: str | bytes) -> bytes:
    return content.encode() if isinstance(content, str) else content


def motion_archive(format_name: MotionFormat, edit: EditorState) -> File:
    """The motion as one file: several are packed into a zip. FormatError where frames lack."""
    files = motion_files(format_name, shown_motion(edit))
    if len(files) == 1:
        return File(next(iter(files.values())), MEDIA_TYPES[format_name], f".{format_name}")
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(zipfile.ZipInfo(name), content, zipfile.ZIP_DEFLATED)  # no clock
    return File(packed.getvalue(), "application/zip", f"-{format_name}.zip")


def saved_motion(session: Session, tracks: Tracks, times_s: Array) -> Recording:
    """The motion that a session's results refer to; times_s are those of all the video's frames."""
    segments = session.results.segments if session.results else ()
    stretches = [
        Stretch(first, last, s.verdict)
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
        Stretch(first, last, t.verdict)
        for t in found
        if t.verdict is not None
        for first, last in _reached(t.first, t.last, t.unreached)
    ]
    return Recording.of(edit.doc, _tracks(edit, found), stretches, edit.times_s)


def _reached(first: int, last: int, unreached: Span | None) -> list[Span]:
    """The stretches of a segment that are left without what was not reached."""
    if unreached is None:
        return [(first, last)]
    both = [(first, unreached[0] - 1), (unreached[1] + 1, last)]
    return [(a, b) for a, b in both if a < b]


def _tracks(edit: EditorState, found: Sequence[SegmentTrack]) -> Tracks:
    """The segments side by side, as the session's file would hold them."""
    first, last = found[0].first, found[-1].last
    count, parts = last - first + 1, edit.skeleton.part_count
    Rs, ps = np.full((count, parts, 3, 3), np.nan), np.full((count, 3), np.nan)
    rank = np.full(count - 1, -1)
    singular = np.full((count - 1, edit.skeleton.dof_count), np.nan)
    observability, residual = (np.full((count - 1, parts), np.nan) for _ in range(2))
    for track in found:
        frames = slice(track.first - first, track.last - first + 1)
        steps = slice(frames.start, frames.stop - 1)
        there, path = track.tracked, track.trajectory
        Rs[frames][there] = path.Rs_parent_part[there]
        ps[frames][there] = path.ps_camera_root[there]
        rank[steps], singular[steps] = track.rank, track.singular_values
        observability[steps], residual[steps] = track.observability, track.residual
    names = edit.skeleton.body.names
    return Tracks(first, names, Rs, ps, rank, singular, observability, residual)
