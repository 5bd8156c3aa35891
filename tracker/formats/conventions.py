"""Conventions of the files that are written: axes, names, decimals, end sites, colours.

Frames of parts have y up in files, where ours have it down: they are turned by half a turn about x,
F = diag(1, −1, −1); a point becomes F p, a rotation F R F.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Final

import numpy as np

from keypose.tracker.body.body import Part
from keypose.tracker.body.pose import joint_names
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.formats.recording import Recording
from keypose.tracker.geometry.rotations import Array

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
    """Where a part without children ends, in its own frame, metres: in its farthest landmark
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


def parts_in_world(recording: Recording, T_world_camera: Array) -> Array:
    """Ts_world_part (N, P, 4, 4) in a world whose y points up; NaN where not tracked."""
    Ts = T_world_camera @ recording.trajectory.transforms(recording.skeleton)
    Ts[..., :3, :3] *= FLIP
    return np.asarray(Ts)
