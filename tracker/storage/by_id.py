"""Immutable objects as keys of caches."""

from __future__ import annotations

from typing import Any


class ById:
    """An immutable object as a cache key, by identity: quicker than by its contents."""

    def __init__(self, it: Any) -> None:
        self.it = it

    def __hash__(self) -> int:
        return id(self.it)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ById) and self.it is other.it
