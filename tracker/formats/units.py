"""Units of length for files that cannot name theirs, and whose ground the world of files is."""

from __future__ import annotations

from typing import Final, Literal, TypeAlias

FileUnit: TypeAlias = Literal["m", "cm", "in"]

FILE_UNITS: Final[dict[FileUnit, str]] = {
    "m": "life-size in Blender",
    "cm": "life-size in MotionBuilder, Maya and Daz Studio",
    "in": "inches",
}
"""What each is for."""

Origin: TypeAlias = Literal["body", "camera"]

ORIGINS: Final[dict[Origin, str]] = {
    "body": "on the floor below its first pose, x where it faces on average, as movement science "
    "has it",
    "camera": "on the floor below the camera, which looks along −z: the same for every session of "
    "a film",
}
"""Where the origin of each is; y is up, and the floor is at zero, in both."""

PER_METRE: Final[dict[FileUnit, float]] = {"m": 1.0, "cm": 100.0, "in": 1 / 0.0254}
