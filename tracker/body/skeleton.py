"""Turn a body into arrays for the numerics, once per body.

Degrees of freedom are the tracked motions of all parts in the order of the parts, translations
before rotations: the columns of DRIFT's A.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache, wraps
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.body import ALL_DOFS, Body, Dof
from keypose.tracker.geometry.rotations import Array, frozen

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
    made_for = lru_cache(maxsize=BODIES)(lambda key: make(key.body))

    @wraps(make)
    def of(body: Body) -> T:
        return made_for(_Key(body))

    return of


TRANSLATION_SCALE_M = 0.3
"""Column scale of translations before singular values are compared with those of rotations:
the lever at which one radian moves a point as far as one unit of translation."""


@dataclass(frozen=True, eq=False)
class Skeleton:
    """Arrays of one body: P parts, D tracked degrees of freedom.

    parents:  (P,) index of the parent, −1 for the root (always part 0).
    joints:   (P, 3) joint in the parent's frame, metres.
    dof_part: (D,) part each degree of freedom turns or moves.
    dof_turns: (D,) 1 for a rotation, 0 for a translation.
    dof_axis: (D,) axis 0, 1, 2 in the part's own frame.
    below:    (P, P) True where part [i] is part [k] or hangs below it.
    """

    body: Body
    parents: NDArray[np.int64]
    joints: Array
    dof_part: NDArray[np.int64]
    dof_turns: NDArray[np.int64]
    dof_axis: NDArray[np.int64]
    below: NDArray[np.bool_]

    @classmethod
    def of(cls, body: Body) -> Skeleton:
        """The arrays of a validated body, made once for each."""
        return _skeleton(body)

    @property
    def part_count(self) -> int:
        return len(self.parents)

    @property
    def dof_count(self) -> int:
        return len(self.dof_part)

    @property
    def dof_names(self) -> tuple[str, ...]:
        """Such as "chest rx"."""
        kinds = zip(self.dof_part, self.dof_turns, self.dof_axis, strict=True)
        return tuple(f"{self.body.names[i]} {'tr'[turns]}{'xyz'[a]}" for i, turns, a in kinds)

    @cached_property
    def limbs(self) -> NDArray[np.int64]:
        """(P,) the limb each part belongs to: parts that follow one another without branching."""
        limb = np.arange(self.part_count)
        for i, parent in enumerate(self.parents):
            if parent > 0 and (self.parents == parent).sum() == 1:
                limb[i] = limb[parent]
        limb.setflags(write=False)
        return limb

    @property
    def column_scale(self) -> Array:
        """(D,) what one unit of each degree of freedom is worth when A's columns are compared."""
        return np.where(self.dof_turns == 1, 1.0, TRANSLATION_SCALE_M)


@once_per_body
def _skeleton(body: Body) -> Skeleton:
    places = {name: place for place, name in enumerate(body.names)}
    parents = [-1 if p.parent is None else places[p.parent] for p in body.parts]
    dofs = [(i, dof) for i, part in enumerate(body.parts) for dof in _ordered(part.tracked)]
    return Skeleton(
        body=body,
        parents=_integers(parents),
        joints=frozen([part.joint_m for part in body.parts]).reshape(-1, 3),
        dof_part=_integers([i for i, _ in dofs]),
        dof_turns=_integers([dof[0] == "r" for _, dof in dofs]),
        dof_axis=_integers(["xyz".index(dof[1]) for _, dof in dofs]),
        below=_below(parents),
    )


def _ordered(tracked: tuple[Dof, ...]) -> list[Dof]:
    return sorted(tracked, key=ALL_DOFS.index)


def _integers(values: list[int] | list[bool]) -> NDArray[np.int64]:
    array = np.array(values, dtype=np.int64)
    array.setflags(write=False)
    return array


def _below(parents: list[int]) -> NDArray[np.bool_]:
    below = np.eye(len(parents), dtype=bool)
    for i, parent in enumerate(parents):
        if parent >= 0:
            below[i] |= below[parent]
    below.setflags(write=False)
    return below
