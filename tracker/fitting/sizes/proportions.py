"""The sizes of a body as numbers to solve for: how long and how thick each kind of part is.

Both sides of a body share their sizes. A number is the logarithm of a ratio, 0 changes nothing.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.body import Body
from keypose.tracker.body.modify import resized
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.posed import free_skeleton

SIDES = ("left_", "right_")


@dataclass(frozen=True, eq=False)
class Proportions:
    """G groups of parts that share two sizes each: S = 2 G numbers, [length, thickness] in turn.

    skeleton: the body, every part free to turn; groups: part indices, first the one that names it.
    """

    body: Body
    skeleton: Skeleton
    groups: tuple[tuple[int, ...], ...]

    @classmethod
    def of(cls, body: Body) -> Proportions:
        """Parts and their other sides together."""
        groups: dict[str, list[int]] = {}
        for i, name in enumerate(body.names):
            groups.setdefault(_kind(body, name), []).append(i)
        return cls(body, free_skeleton(body), tuple(tuple(group) for group in groups.values()))

    @property
    def count(self) -> int:
        return 2 * len(self.groups)

    @property
    def names(self) -> tuple[str, ...]:
        """What each group is called: "forearm" for both of them."""
        return tuple(_kind(self.body, self.body.names[group[0]]) for group in self.groups)

    @cached_property
    def group_of(self) -> NDArray[np.int64]:
        """(P,) the group of every part."""
        group_of = np.zeros(len(self.body.parts), dtype=np.int64)
        for g, group in enumerate(self.groups):
            group_of[list(group)] = g
        return group_of

    @cached_property
    def is_trunk(self) -> NDArray[np.bool_]:
        """(P,) the parts in the middle of a body that has two sides: waist, chest, neck, head."""
        sizes = np.bincount(self.group_of)
        return np.asarray((sizes == 1)[self.group_of] & bool((sizes > 1).any()))

    def ratios(self, sizes: Array) -> Array:
        """(P, 3) how much larger every part is along its x, y and z."""
        return np.exp(sizes).reshape(-1, 2)[self.group_of][:, (1, 0, 1)]

    def skeleton_at(self, sizes: Array) -> Skeleton:
        """The skeleton of these sizes: children's joints go along with the surface."""
        ratios, parents = self.ratios(sizes), self.skeleton.parents
        carried = np.where((parents >= 0)[:, None], ratios[np.maximum(parents, 0)], 1.0)
        return replace(self.skeleton, joints=self.skeleton.joints * carried)

    def body_at(self, sizes: Array) -> Body:
        """The body of these sizes."""
        body = self.body
        for g, group in enumerate(self.groups):
            long, thick = np.exp(sizes[2 * g : 2 * g + 2])
            if long == thick == 1.0:
                continue
            for i in group:
                name = body.names[i]
                body = resized(body, name, length_factor=long, thickness_factor=thick, linked=False)
        return body

    def metres(self) -> Array:
        """(S,) each size as the body has it: the length, and how wide it is on average."""
        shapes = [self.body.parts[group[0]].shape for group in self.groups]
        return np.array([size for shape in shapes for size in (shape.length_m, shape.width_m)])


def _kind(body: Body, name: str) -> str:
    """The name without its side, where the other side is there as well."""
    for side, opposite in (SIDES, SIDES[::-1]):
        bare = name.removeprefix(side)
        if bare != name and opposite + bare in body.names:
            return bare
    return min(name, body.mirror_of(name))
