"""What the background of a film says of a camera from a file, and what would suit it better."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.camera_motion.agreement import Pair, error_px, followed_pairs
from keypose.tracker.camera_motion.background import BodyBackground
from keypose.tracker.errors import FormatError
from keypose.tracker.formats.cameras.camera_file import (
    LENS_COLUMNS,
    ROTATION_ORDERS,
    CameraFile,
    CameraReading,
    CameraWay,
)
from keypose.tracker.formats.cameras.chan import camera_of_columns
from keypose.tracker.formats.cameras.placing import FilmFrames
from keypose.tracker.formats.text import Note
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.camera_path import CameraPath, rigid_inverse
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.schema import Session
from keypose.tracker.video import Video

PLACES: Final = 4
"""Of the film at which it is looked at."""
SHORTEST = 8
LONGEST = 24
"""Frames over which points are followed."""
OFF_SHARE: Final = 1 / 500
"""Of the picture's width: points that are farther off are not the camera's."""
DOUBT_SHARE = 1 / 1500
BETTER = 0.3
"""Of the picture's width: where points are farther off, another reading is named that leaves no
more than this share of it."""
AS_GOOD: Final = 1.2
"""Of the least error: the first reading that is as good counts."""
STILL_PX: Final = 0.5
RATES: Final = (24.0, 25.0, 30.0, 50.0, 60.0, 24000 / 1001, 30000 / 1001, 60000 / 1001)
NEAREST = 2
FARTHEST = 240
"""Frames by which a file is tried earlier and later, where it is little off, and where it is much:
of many frames some make up for a lens that is a hundredth too long."""


@dataclass(frozen=True, eq=False)
class Comparison:
    """What the background says: by how much its points are off, pixels, None where it says nothing;
    and a note where they are too far off."""

    off_px: float | None
    note: Note | None = None


@dataclass(frozen=True, eq=False)
class _Said:
    """A camera as a file is read: its lens, and where it is in frames of the film."""

    camera: Camera
    way: CameraWay

    def off_px(self, pairs: list[Pair]) -> float | None:
        """By how much the points of the pairs that it knows are off."""
        ends = np.array([(pair.one, pair.other) for pair in pairs], float).ravel()
        inside = (ends >= self.way.frames[0]) & (ends <= self.way.frames[-1])
        is_inside = inside.reshape(-1, 2).all(axis=1)
        rows = np.interp(
            ends[np.repeat(is_inside, 2)], self.way.frames, np.arange(len(self.way.zoom))
        )
        there = CameraPath(self.way.Ts_world_camera, self.way.zoom).sampled(rows)
        path = CameraPath(rigid_inverse(there.Ts_camera_world), there.zoom)
        chosen = [pair for pair, is_known in zip(pairs, is_inside, strict=True) if is_known]
        return error_px(chosen, self.camera, path)


def compared(
    session: Session,
    file: str,
    camera_file: CameraFile,
    original: CameraFile,
    reading: CameraReading,
    film: FilmFrames,
    video: Video,
) -> Comparison:
    """What the background of the film says of a camera that moves.

    camera_file: its way in frames of the film.  original: as it was read, by its own frames.
    """
    camera_way = camera_file.way
    if camera_way is None or len(camera_way.frames) < 2:
        return Comparison(None)
    camera = camera_file.camera or session.view.camera
    pairs = _pairs(session, camera_way, video)
    off = _Said(camera, camera_way).off_px(pairs)
    if off is None or off <= DOUBT_SHARE * camera.width:
        return Comparison(off)
    usual_px = max(pair.way_px for pair in pairs)
    if usual_px < STILL_PX and off > OFF_SHARE * camera.width:
        return Comparison(off, Note("background still", (off,)))
    best: tuple[float, str, str] | None = None
    least = min(BETTER * off, OFF_SHARE * camera.width)
    farthest = FARTHEST if off > OFF_SHARE * camera.width else NEAREST
    for kind, value, said in _others(session, file, camera_file, original, reading, film, farthest):
        said_off_px = said.off_px(pairs)
        if (
            said_off_px is not None
            and said_off_px < least
            and (best is None or said_off_px * AS_GOOD < best[0])
        ):
            best = said_off_px, kind, value
    if best is None and off <= OFF_SHARE * camera.width:
        return Comparison(off)
    return Comparison(off, Note("background off", (off, *(best or ()))))


def _pairs(session: Session, camera_way: CameraWay, video: Video) -> list[Pair]:
    """Points followed at a few places of what the file has of the film."""
    view, count = session.view, session.view.video.frame_count
    first, last = max(int(camera_way.frames[0]), 0), min(int(camera_way.frames[-1]), count - 1)
    span = int(np.clip((last - first) // 3, SHORTEST, LONGEST))  # so that a shift leaves some
    starts = np.linspace(first, max(last - span, first), PLACES).astype(int)
    skeleton = Skeleton.of(session.subject.body)
    poses = {posed.frame: posed.pose(skeleton) for posed in session.subject.posed}
    path = session.camera_path
    zoom = None if path is None else path.zoom
    background = BodyBackground(skeleton, view.camera, poses, view.ignore_masks, zoom)

    def pictures(
        start: int, stop: int, step: int
    ) -> Iterator[tuple[int, NDArray[np.uint8] | None]]:
        for number, picture in video.frames(start, stop, step):
            grey = None if picture is None else cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY)
            yield number, None if grey is None else np.asarray(grey, np.uint8)

    size = (view.camera.width, view.camera.height)
    spans = [(start, min(start + span, last)) for start in sorted({int(s) for s in starts})]
    return followed_pairs(pictures, size, spans, background)


def _others(
    session: Session,
    file: str,
    camera_file: CameraFile,
    original: CameraFile,
    reading: CameraReading,
    film: FilmFrames,
    farthest: int,
) -> Iterable[tuple[str, str, _Said]]:
    """How else the file could be meant: what of it, as what, and the camera then."""
    assert camera_file.way is not None
    assert original.way is not None
    camera = camera_file.camera or session.view.camera
    if original.columns is not None:
        yield from _of_columns(session, file, camera_file, original.columns, reading)
    own = original.way.frames
    if (
        farthest == FARTHEST
        and original.way.clock == "numbers"
        and len(own) == len(camera_file.way.frames)
    ):
        start, began = own[0], float(camera_file.way.frames[0])
        for rate in RATES:
            if abs(rate / film.rate - 1) > 1e-3:
                frames = film.at((own - start) / rate + film.second(began))
                yield "rate", f"{rate:.5g}", _Said(camera, replace(camera_file.way, frames=frames))
    near = {*range(-farthest, farthest + 1)} - {0}
    ends = _ends(original.way, camera_file.way, len(film)) if farthest == FARTHEST else set()
    for shift in sorted(near | ends, key=abs):
        moved = replace(camera_file.way, frames=camera_file.way.frames + shift)
        offset = camera_file.way.frames[0] - _origin(original.way, film) + shift
        yield "offset", f"{round(float(offset))}", _Said(camera, moved)


def _of_columns(
    session: Session, file: str, camera_file: CameraFile, columns: Array, reading: CameraReading
) -> Iterable[tuple[str, str, _Said]]:
    """The other meanings of the columns of .chan."""
    assert camera_file.way is not None
    size = (session.view.camera.width, session.view.camera.height)
    orders = [("order", order, replace(reading, rotation_order=order)) for order in ROTATION_ORDERS]
    lenses = [("lens", lens, replace(reading, lens_column=lens)) for lens in LENS_COLUMNS]
    if columns.shape[1] < 8:
        lenses = []
    for kind, value, camera_reading in (*orders, *lenses):
        if camera_reading == reading:
            continue
        try:
            read = camera_of_columns(file, columns, size, camera_reading)
        except FormatError:
            continue  # it cannot be meant so
        if read.way is not None and len(read.way.frames) == len(camera_file.way.frames):
            camera_way = replace(read.way, frames=camera_file.way.frames, clock="frames")
            yield kind, value, _Said(read.camera or session.view.camera, camera_way)


def _origin(camera_way: CameraWay, film: FilmFrames) -> float:
    """What an offset of the file's first frame or time is counted from."""
    return (
        float(camera_way.frames[0])
        if camera_way.clock != "seconds"
        else float(camera_way.frames[0]) * film.rate
    )


def _ends(original: CameraWay, camera_way: CameraWay, count: int) -> set[int]:
    """By how many frames a file lies elsewhere that begins or ends with the film, or counts its
    frames from 0."""
    first, last = int(camera_way.frames[0]), int(camera_way.frames[-1])
    return {-first, count - 1 - last, int(original.frames[0]) - first} - {0}
