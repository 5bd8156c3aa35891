"""The rows of a rig's table on a body: which bones there are, where each begins and ends at rest,
and how its axes lie.

Worlds are y up, metres, as of `keypose.tracker.formats.rigs.rig`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import FormatError, readable
from keypose.tracker.formats.conventions import end_site, flipped
from keypose.tracker.formats.rigs import OWN
from keypose.tracker.formats.rigs.table import SIDES, Axes, Place, Row
from keypose.tracker.geometry.rotations import Array

_LIMBS = ("upper_arm", "forearm", "thigh", "shin")
PERSON = ("waist", "chest", "head", *(f"{side}_{part}" for part in _LIMBS for side in SIDES))
"""Parts without which a body is no person to a rig."""

STILL = -1
"""Instead of a part: a bone that stands still at the world's origin."""

MIRROR = np.diag([-1.0, 1.0, 1.0])
_DIRECTIONS = {
    "forward": (0.0, 0.0, 1.0),
    "backward": (0.0, 0.0, -1.0),
    "up": (0.0, 1.0, 0.0),
    "down": (0.0, -1.0, 0.0),
}
SHORTEST_M = 1e-3
"""Of a bone; what is nearer to its head is no end of it."""


def require_person(skeleton: Skeleton, rig: str) -> None:
    """FormatError where the body lacks what every person has."""
    missing = [part for part in PERSON if part not in skeleton.body.names]
    if missing:
        raise FormatError(
            f"The rig {rig} is for a person, and the body {skeleton.body.name!r} has no "
            f"{readable(missing[0])}: choose the rig {OWN}, its own names."
        )


def named_places(skeleton: Skeleton, Ts_world_part: Array) -> dict[str, Array]:
    """Joints and landmarks (3,) in the world at rest, by name; of two alike the first."""
    places = dict(zip(skeleton.body.names, Ts_world_part[:, :3, 3], strict=True))
    for part, T in zip(skeleton.body.parts, Ts_world_part, strict=True):
        for name, p_part in part.landmarks.items():
            places.setdefault(name, T[:3, :3] @ flipped(np.array(p_part)) + T[:3, 3])
    return places


def kept_rows(rows: Sequence[Row], places: dict[str, Array]) -> list[Row]:
    """The bones whose part and place the body has."""
    return [
        row
        for row in rows
        if (not row.part or any(part in places for part in row.part))
        and (not row.at or any(places.keys() >= place.keys() for place in row.at))
    ]


def own_rows(skeleton: Skeleton, rows: Sequence[Row]) -> list[Row]:
    """A bone of its own name for every part that the rig knows nothing of, such as a racket."""
    bone_of = {
        skeleton.body.names[part_of(skeleton, row)]: row.name for row in reversed(rows) if row.part
    }
    taken, made = {row.name for row in rows}, list[Row]()
    for part in skeleton.body.parts:
        if part.name in bone_of:
            continue
        name = part.name
        while name in taken:
            name += "_"
        taken.add(name)
        bone_of[part.name] = name
        parent = None if part.parent is None else bone_of[part.parent]
        made.append(Row(name=name, parent=parent, part=(part.name,)))
    return made


def head_of(row: Row, places: dict[str, Array]) -> Array:
    """Where a bone begins in the world at rest."""
    if not row.part:
        return np.zeros(3)
    own: Place = {next(part for part in row.part if part in places): 1.0}
    place = next((place for place in row.at if places.keys() >= place.keys()), own)
    return np.asarray(sum(share * places[name] for name, share in place.items()))


def part_of(skeleton: Skeleton, row: Row) -> int:
    """The index of the first part of a row that the body has."""
    names = skeleton.body.names
    return next((names.index(part) for part in row.part if part in names), STILL)


def parents_of(rows: Sequence[Row], all_rows: Sequence[Row]) -> NDArray[np.int64]:
    """The index of each bone's parent; where that is left out, of the next one above."""
    at = {row.name: i for i, row in enumerate(rows)}
    above = {row.name: row.parent for row in all_rows}

    def parent(name: str | None) -> int:
        while name is not None and name not in at:
            name = above[name]
        return -1 if name is None else at[name]

    return np.array([parent(row.parent) for row in rows], dtype=np.int64)


def ends_of(
    skeleton: Skeleton,
    heads: Array,
    parents: NDArray[np.int64],
    parts: NDArray[np.int64],
    Ts_world_part: Array,
) -> Array:
    """Where bones end (B, 3): at the first child elsewhere, else at the end of their part,
    else as far on as their parent is long.
    """
    ends = np.empty_like(heads)
    for i, head in enumerate(heads):
        children = [k for k in np.flatnonzero(parents == i) if _apart(heads[k], head)]
        if children:
            ends[i] = heads[children[0]]
            continue
        end = head
        if parts[i] != STILL:
            T = Ts_world_part[parts[i]]
            end = T[:3, :3] @ flipped(np.array(end_site(skeleton.body.parts[parts[i]]))) + T[:3, 3]
        above = ends[parents[i]] - heads[parents[i]] if parents[i] >= 0 else np.array([0.0, 0.1, 0])
        ends[i] = end if _apart(end, head) else head + above
    return ends


def _apart(a: Array, b: Array) -> bool:
    return bool(np.linalg.norm(a - b) > SHORTEST_M)


def bone_axes(along: Array, axes: Axes | None, mirrored: bool = False) -> Array:
    """R_world_bone (3, 3) of a bone that points along (3,) at rest."""
    if axes is None:
        return np.eye(3)
    if mirrored:
        return -MIRROR @ bone_axes(MIRROR @ along, axes)
    first, second, direction = axes
    toward = np.array(_DIRECTIONS[direction])
    along = along / np.linalg.norm(along)
    across = toward - (toward @ along) * along
    if np.linalg.norm(across) < 1e-3:
        across = np.cross(along, [1.0, 0.0, 0.0])
    R = np.zeros((3, 3))
    i, k = "xyz".index(first[-1]), "xyz".index(second[-1])
    R[:, i] = -along if first[0] == "-" else along
    R[:, k] = across / np.linalg.norm(across) * (-1 if second[0] == "-" else 1)
    R[:, 3 - i - k] = np.cross(R[:, (4 - i - k) % 3], R[:, (5 - i - k) % 3])
    return R
