"""How the body looks in files that have materials."""

from __future__ import annotations

from typing import Final

ROUGHNESS: Final = 0.75


def linear(colour: tuple[int, int, int]) -> tuple[float, float, float]:
    """Light, 0 to 1, of an sRGB colour, 0 to 255."""
    red, green, blue = (_linear(channel / 255) for channel in colour)
    return red, green, blue


def _linear(value: float) -> float:
    return value / 12.92 if value <= 0.04045 else float(((value + 0.055) / 1.055) ** 2.4)
