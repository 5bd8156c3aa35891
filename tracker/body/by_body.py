"""What is made of a body once, as long as it is the same one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache, wraps
from typing import TypeVar

from keypose.tracker.body.body import Body

T = TypeVar("T")

BODIES = 8
"""So many bodies are remembered at once: the open one, and those of a drag of sizes."""


@dataclass(frozen=True, eq=False)
class _Key:
    """A body as a key: the object itself, for the dictionaries in it have no hash."""

    body: Body

    def __hash__(self) -> int:
        return id(self.body)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Key) and other.body is self.body


def once_per_body(make: Callable[[Body], T]) -> Callable[[Body], T]:
    """The same function, which makes a thing once for each body. What it makes is shared by all who
    ask: it must be immutable."""
    known = lru_cache(maxsize=BODIES)(lambda key: make(key.body))

    @wraps(make)
    def of(body: Body) -> T:
        return known(_Key(body))

    return of
