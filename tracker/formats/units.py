"""Units of length for files that cannot name theirs."""

from __future__ import annotations

from typing import Final, Literal, TypeAlias

FileUnit: TypeAlias = Literal["m", "cm", "in"]

FILE_UNITS: Final[dict[FileUnit, str]] = {
    "m": "life-size in Blender",
    "cm": "life-size in MotionBuilder, Maya and Daz Studio",
    "in": "inches",
}
"""What each is for."""

PER_METRE: Final[dict[FileUnit, float]] = {"m": 1.0, "cm": 100.0, "in": 1 / 0.0254}
