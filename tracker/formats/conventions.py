"""Conventions of the files that are written: axes, floor, names, decimals, end sites, colours.

The frame whose y points up is the camera frame turned by half a turn about x, F = diag(1, −1, −1).
A part's frame is turned likewise: a point of it becomes F p, a rotation F R F. The floor's world
has its origin on the floor below the camera, which looks along −z as nearly as the floor allows.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from keypose.tracker.body.body import Part
from keypose.tracker.body.ground import floor_height, lowest_heights
from keypose.tracker.body.pose import joint_names
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import FormatError
from keypose.tracker.formats.recording import Recording
from keypose.tracker.geometry.rotations import Array, transform

FLIP = np.array([1.0, -1.0, -1.0])
"""The diagonal of F."""


def flipped(points: Array) -> Array:
    """Points (..., 3) in the file's frames instead of ours."""
    return np.asarray(points * FLIP)


def fixed_decimals(numbers: Iterable[float], decimals: int) -> list[str]:
    """No minus before a zero, and an empty text for what is not a number."""
    return [
        "" if number != number else f"{round(float(number), decimals) + 0.0:.{decimals}f}"  # NaN
        for number in numbers
    ]


def column_names(skeleton: Skeleton) -> tuple[str, ...]:
    """Names as of `joint_names`; a landmark whose name is not the only one carries its part's."""
    names = joint_names(skeleton)
    owners = [part.name for part in skeleton.body.parts for _ in part.landmarks]
    landmarks = names[skeleton.part_count :]
    pairs = zip(owners, landmarks, strict=True)
    marks = (f"{owner}.{name}" if names.count(name) > 1 else name for owner, name in pairs)
    return (*skeleton.body.names, *marks)


def single_words(names: Sequence[str]) -> tuple[str, ...]:
    """The names without blanks and braces, which end a name in some formats; still different."""
    words: list[str] = []
    for name in names:
        word = "".join("_" if c.isspace() or c in "{}" else c for c in name)
        while word in words:
            word += "_"
        words.append(word)
    return tuple(words)


def end_site(part: Part) -> tuple[float, float, float]:
    """Return where a part without children ends, in its own frame, metres: in its farthest landmark
    or, when it has none, in the end of its shape.
    """
    if part.landmarks:
        return max(part.landmarks.values(), key=lambda p: float(np.linalg.norm(p)))
    return part.shape.far_end


ROUGHNESS: Final = 0.75


def linear(colour: tuple[int, int, int]) -> tuple[float, float, float]:
    """Light, 0 to 1, of an sRGB colour, 0 to 255."""
    red, green, blue = (_linear(channel / 255) for channel in colour)
    return red, green, blue


def _linear(value: float) -> float:
    return value / 12.92 if value <= 0.04045 else float(((value + 0.055) / 1.055) ** 2.4)


_FORWARD, _PICTURE_UP = np.array([0.0, 0.0, 1.0]), np.array([0.0, -1.0, 0.0])
_STEEP = 0.02
"""Of a direction, the level share below which it says nothing of where that points."""


def floor_from_camera(recording: Recording) -> Array:
    """T_world_camera (4, 4), from the camera frame (x right, y down, z forward) to this world.

    The floor is where it was set or found, or else where the body stands lowest (`body.floor`).
    FormatError where neither is known.
    """
    up = recording.up_camera
    back = -_level(up)
    R = np.stack([np.cross(up, back), up, back])
    return transform(R, np.array([0.0, -_floor_m(recording), 0.0]))


def with_floor(recording: Recording) -> Recording:
    """The recording with its floor's height given, so that parts of it stand on the same floor;
    itself where no frame is tracked."""
    if recording.floor_m is not None or not recording.tracks.tracked.any():
        return recording
    return replace(recording, floor_m=_floor_m(recording))


def parts_in_world(recording: Recording, T_world_camera: Array) -> Array:
    """Ts_world_part (N, P, 4, 4) in a world whose y points up; NaN where not tracked."""
    Ts = T_world_camera @ recording.trajectory.transforms(recording.skeleton)
    Ts[..., :3, :3] *= FLIP
    return np.asarray(Ts)


def _level(up: Array) -> Array:
    """(3,) where the camera looks, made level; straight down, what is above in its picture."""
    for direction in (_FORWARD, _PICTURE_UP):
        level = direction - (direction @ up) * up
        length = float(np.linalg.norm(level))
        if length > _STEEP:
            break
    return np.asarray(level / length)


def _floor_m(recording: Recording) -> float:
    """The floor's height along up from the camera, metres."""
    tracked = recording.tracks.tracked
    if recording.floor_m is None and not tracked.any():
        raise FormatError("No frame is tracked.")
    Ts = recording.trajectory.transforms(recording.skeleton)[tracked]
    lowest = lowest_heights(recording.skeleton, Ts, recording.up_camera) if len(Ts) else ()
    return floor_height(recording.floor_m, lowest)
