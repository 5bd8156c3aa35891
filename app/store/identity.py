"""Whether something has to be made anew: quick, because what is large is never changed in place."""

from __future__ import annotations

from typing import Any


def unchanged(old: tuple[Any, ...] | None, new: tuple[Any, ...]) -> bool:
    """By identity for what is large and immutable, by value for plain numbers and words."""
    if old is None or len(old) != len(new):
        return False
    return all(
        a is b or (isinstance(a, int | float | str) and a == b)
        for a, b in zip(old, new, strict=True)
    )
