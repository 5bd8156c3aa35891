"""Numbers as text of fixed decimals."""

from __future__ import annotations

from collections.abc import Iterable


def fixed_decimals(numbers: Iterable[float], decimals: int) -> list[str]:
    """No minus before a zero, and an empty text for what is not a number."""
    return [
        "" if number != number else f"{round(float(number), decimals) + 0.0:.{decimals}f}"  # NaN
        for number in numbers
    ]
