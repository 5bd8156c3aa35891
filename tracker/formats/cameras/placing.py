"""Say which frame of the film each moment of a file's camera is."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.errors import FormatError
from keypose.tracker.formats.cameras.camera_file import CameraWay
from keypose.tracker.formats.text import Note
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import Array

SAME_FRAME: Final = 0.02
"""Of a frame, by which times of files are rounded."""


@dataclass(frozen=True, eq=False)
class FilmFrames:
    """The frames of a film: their times (F,), seconds from the first, and the number of the first
    image file; None where it is no such files, or they are not numbered consecutively."""

    times_s: Array
    first_number: int | None = None

    def __len__(self) -> int:
        return len(self.times_s)

    @property
    def rate(self) -> float:
        """Frames a second, on average."""
        seconds = float(self.times_s[-1] - self.times_s[0])
        return (len(self) - 1) / seconds if seconds > 0 else 1.0

    def at(self, times_s: Array) -> Array:
        """The frames, in fractions, at these seconds; beyond the film by its mean rate."""
        frames = np.interp(times_s, self.times_s, np.arange(len(self)))
        before, after = times_s - self.times_s[0], times_s - self.times_s[-1]
        return np.asarray(frames + self.rate * (np.minimum(before, 0) + np.maximum(after, 0)))

    def second(self, frame: float) -> float:
        """When a frame is, in fractions of it; beyond the film by its mean rate."""
        inside = min(max(frame, 0.0), len(self) - 1.0)
        at = float(np.interp(inside, np.arange(len(self)), self.times_s))
        return at + (frame - inside) / self.rate


def placed(
    file: str,
    camera_way: CameraWay,
    film: FilmFrames,
    offset_frames: int | None = None,
) -> tuple[CameraWay, tuple[Note, ...]]:
    """The way in frames of the film, and what was taken for granted.

    offset_frames: the film's frame at the file's frame or second 0. FormatError where nothing of
    it lies in the film.
    """
    frames, why = _frames(camera_way, film, offset_frames)
    inside = (frames > -SAME_FRAME) & (frames < len(film) - 1 + SAME_FRAME)
    if not inside.any():
        raise FormatError(_outside(file, camera_way, film))
    notes: tuple[Note, ...] = ()
    if why:
        ends = (float(each) for each in (*camera_way.frames[[0, -1]], *frames[[0, -1]]))
        notes = (Note("camera frames", (why, *ends)),)
    return _on_frames(_with_spans_from(camera_way, frames), frames, len(film)), notes


def _with_spans_from(camera_way: CameraWay, frames: Array) -> CameraWay:
    """The way whose spans without scale lie as far from its first moment as in its file."""
    began = camera_way.begins if camera_way.clock == "seconds" else float(camera_way.frames[0])
    shift = round(float(frames[0]) - (frames[0] if began is None else began))
    return replace(
        camera_way, unscaled=tuple((a + shift, b + shift) for a, b in camera_way.unscaled)
    )


def _frames(camera_way: CameraWay, film: FilmFrames, offset: int | None) -> tuple[Array, str]:
    """The film's frames (K,), in fractions, and the reason for them; none where they are said."""
    if camera_way.clock == "seconds":
        if offset is None and camera_way.begins is not None:  # the file itself says so
            return film.at(
                camera_way.frames - camera_way.frames[0] + film.second(camera_way.begins)
            ), ""
        return film.at(
            camera_way.frames + film.second(offset or 0)
        ), "times" if offset is None else ""
    numbers = camera_way.frames.astype(float)
    if offset is not None or camera_way.clock == "frames":
        return numbers + (offset or 0), ""
    return _by_numbers(camera_way, film)


def _by_numbers(camera_way: CameraWay, film: FilmFrames) -> tuple[Array, str]:
    """Frames of a file that may count as the film's image files do, from 1, or from 0."""
    numbers, count, first = camera_way.frames.astype(float), len(film), film.first_number
    if first and numbers[0] >= first and numbers[-1] < first + count:
        return numbers - first, "files"
    if camera_way.clock == "names" and numbers[0] >= 1 and numbers[-1] <= count:
        return numbers - 1, "from 1"
    whole = len(numbers) == count and numbers[-1] - numbers[0] == count - 1
    if whole and numbers[0] != 0:
        return numbers - numbers[0], "whole"
    return numbers, ""


def _outside(file: str, camera_way: CameraWay, film: FilmFrames) -> str:
    ends = " to ".join(f"{number:.6g}" for number in camera_way.frames[[0, -1]])
    unit = "seconds" if camera_way.clock == "seconds" else "frames"
    begin = "" if camera_way.clock == "seconds" else f", such as {-int(camera_way.frames[0])}"
    end = f"{film.times_s[-1]:.6g}" if camera_way.clock == "seconds" else f"{len(film) - 1}"
    return (
        f"{file} has {unit} {ends}, and the film 0 to {end}: say which frame of the film the "
        f"file's 0 is, with --offset-frames or as the start frame{begin}."
    )


def _on_frames(camera_way: CameraWay, frames: Array, count: int) -> CameraWay:
    """The way at whole frames: as it is said there, or else at those of the film between its
    moments, also where keys are seconds apart."""
    whole = np.rint(frames).astype(np.int64)
    steps = np.diff(whole)
    is_whole = bool((np.abs(frames - whole) < SAME_FRAME).all())
    if is_whole and ((steps == 1) if camera_way.clock == "seconds" else (steps > 0)).all():
        return _film_way(camera_way, whole, camera_way.Ts_world_camera, camera_way.zoom)
    first = max(int(np.ceil(frames[0] - SAME_FRAME)), 0)
    last = min(int(np.floor(frames[-1] + SAME_FRAME)), count - 1)
    wanted: NDArray[Any] = np.arange(first, last + 1) if first <= last else whole[:1]
    # a camera goes straight in the world, so its poses there are what lies between two of them
    there = CameraPath(camera_way.Ts_world_camera, camera_way.zoom)
    between = there.sampled(np.interp(wanted, frames, np.arange(len(frames))))
    return _film_way(camera_way, wanted, between.Ts_camera_world, between.zoom)


def _film_way(camera_way: CameraWay, frames: NDArray[Any], Ts: Array, zoom: Array) -> CameraWay:
    return replace(
        camera_way, frames=frames, Ts_world_camera=Ts, zoom=zoom, clock="frames", begins=None
    )
