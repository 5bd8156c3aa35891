"""A body's rig: its bones at rest, and their motion from the body's.

Worlds here are y up, metres. A bone's frame has its origin where the bone begins; how its axes lie
at rest is the rig's to say (`tracker.formats.rigs.table`). Part frames are those of files whose y
points up (`tracker.formats.axes`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tracker.body.skeleton import Skeleton
from tracker.errors import FormatError, listed
from tracker.formats.axes import flipped
from tracker.formats.end_sites import end_site
from tracker.formats.names import column_names
from tracker.formats.rigs import OWN, RIGS
from tracker.formats.rigs.rest_pose import rest_pose
from tracker.formats.rigs.table import SIDES, Axes, Place, Row, table_of
from tracker.geometry.rotations import Array, frozen, transform, transpose

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
OWN_AXES: Axes = ("y", "z", "forward")
"""As Blender's bones lie, whose y points along them."""


@dataclass(frozen=True, eq=False)
class Rig:
    """B bones, parents before children, the root first. In its rest pose the body stands on the
    floor y = 0 and faces +z, its left toward +x.

    name:          of the rig, one of `RIGS`.
    names:         (B,) of the bones, each once.
    parents:       (B,) −1 for the root.
    parts:         (B,) the body's part that a bone turns with; `STILL` for none.
    Ts_world_bone: (B, 4, 4) at rest.
    ends_bone:     (B, 3) where each ends, in its own frame.
    Ts_world_part: (P, 4, 4) the body's parts at rest.
    """

    name: str
    names: tuple[str, ...]
    parents: NDArray[np.int64]
    parts: NDArray[np.int64]
    Ts_world_bone: Array
    ends_bone: Array
    Ts_world_part: Array

    def __len__(self) -> int:
        return len(self.names)

    @property
    def mover(self) -> int:
        """The bone that carries the body through space; all others keep their places on theirs."""
        return int(np.argmax(self.parts != STILL))

    @property
    def Ts_parent_bone(self) -> Array:
        """(B, 4, 4) at rest; the root's in the world."""
        return _local(self.Ts_world_bone, self.parents)

    @property
    def Ts_part_bone(self) -> Array:
        """(B, 4, 4) of each bone in its part's frame, where it stays; of one without, its rest."""
        return np.stack(
            [
                T if part == STILL else np.linalg.inv(self.Ts_world_part[part]) @ T
                for part, T in zip(self.parts, self.Ts_world_bone, strict=True)
            ]
        )

    @property
    def bone_of_part(self) -> NDArray[np.int64]:
        """(P,) the first bone that turns with each part: what is fixed to the part hangs on it."""
        parts = np.arange(len(self.Ts_world_part))
        return np.asarray((self.parts[:, None] == parts).argmax(axis=0))

    def motion(self, Ts_world_part: Array) -> tuple[Array, Array]:
        """Rs_parent_bone (N, B, 3, 3) and ps_parent_mover (N, 3): the curves of a motion.

        Ts_world_part: (N, P, 4, 4) of the body's parts, y up. All other bones keep the positions
        of `Ts_parent_bone`.
        """
        Rs_world_bone = np.tile(np.eye(3), (len(Ts_world_part), len(self), 1, 1))
        moving = self.parts != STILL
        Rs_part_bone = self.Ts_part_bone[:, :3, :3]
        Rs_world_part = Ts_world_part[:, self.parts[moving], :3, :3]
        Rs_world_bone[:, moving] = Rs_world_part @ Rs_part_bone[moving]
        Rs = Rs_world_bone.copy()
        inner = np.flatnonzero(self.parents >= 0)
        Rs[:, inner] = transpose(Rs_world_bone[:, self.parents[inner]]) @ Rs_world_bone[:, inner]
        T_part = Ts_world_part[:, self.parts[self.mover]]
        p_part = self.Ts_part_bone[self.mover, :3, 3]
        return Rs, T_part[:, :3, :3] @ p_part + T_part[:, :3, 3]


def rig_of(skeleton: Skeleton, name: str = OWN, *, parallel: bool = False) -> Rig:
    """The rig of a body by its name. FormatError where there is none, or the body is no person.

    parallel: at rest all bones are parallel to the world, as formats without a rest pose of their
    own have them, BVH above all.
    """
    if name not in RIGS:
        raise FormatError(f"There is no rig {name[:40]!r}: the rigs are {listed(list(RIGS))}.")
    if name == OWN:
        return _own(skeleton, parallel)
    _require_person(skeleton, name)
    table = table_of(name)
    Ts_world_part = rest_pose(skeleton, table.arms_below_horizontal_deg)
    places = _named_places(skeleton, Ts_world_part)
    rows = _kept(table.rows(), places)
    rows += _own_rows(skeleton, rows)
    heads = np.array([_head(row, places) for row in rows])
    parents = _parents(rows, (*table.rows(), *rows))
    parts = np.array([_part(skeleton, row) for row in rows], dtype=np.int64)
    ends = _ends(skeleton, heads, parents, parts, Ts_world_part)
    Rs = np.stack(
        [
            _frame(
                end - head,
                None if parallel else row.axes,
                row.side == "right" and table.mirrored and not parallel,
            )
            for row, head, end in zip(rows, heads, ends, strict=True)
        ]
    )
    return _rig(name, [row.name for row in rows], parents, parts, Rs, heads, ends, Ts_world_part)


def _own(skeleton: Skeleton, parallel: bool) -> Rig:
    """A bone for every part, and one for every landmark, which lies on its part as that does."""
    Ts = rest_pose(skeleton, None)
    owners = [i for i, part in enumerate(skeleton.body.parts) for _ in part.landmarks]
    parts = np.array([*range(skeleton.part_count), *owners], dtype=np.int64)
    parents = np.array([*skeleton.parents, *owners], dtype=np.int64)
    marks = [
        Ts[i, :3, 3] + flipped(np.array(p))
        for i, part in enumerate(skeleton.body.parts)
        for p in part.landmarks.values()
    ]
    heads = np.array([*Ts[:, :3, 3], *marks])
    ends = _ends(skeleton, heads, parents, parts, Ts)
    is_single = skeleton.part_count == 1  # such as a box, which points nowhere
    axes = None if parallel or is_single else OWN_AXES
    Rs = np.stack([_frame(ends[i] - heads[i], axes, False) for i in parts])
    return _rig(OWN, column_names(skeleton), parents, parts, Rs, heads, ends, Ts)


def _rig(
    name: str, names: Sequence[str], parents: NDArray[np.int64], parts: NDArray[np.int64],
    Rs_world_bone: Array, heads: Array, ends: Array, Ts_world_part: Array,
) -> Rig:  # fmt: skip
    ends_bone = np.einsum("bji,bj->bi", Rs_world_bone, ends - heads)
    return Rig(
        name, tuple(names), parents, parts, frozen(transform(Rs_world_bone, heads)),
        frozen(ends_bone), frozen(Ts_world_part),
    )  # fmt: skip


def _require_person(skeleton: Skeleton, rig: str) -> None:
    missing = [part for part in PERSON if part not in skeleton.body.names]
    if missing:
        raise FormatError(
            f"The rig {rig} is for a person, and the body {skeleton.body.name!r} has no "
            f"{missing[0].replace('_', ' ')}: choose the rig {OWN}, its own names."
        )


def _named_places(skeleton: Skeleton, Ts_world_part: Array) -> dict[str, Array]:
    """Joints and landmarks (3,) in the world at rest, by name; of two alike the first."""
    places = dict(zip(skeleton.body.names, Ts_world_part[:, :3, 3], strict=True))
    for part, T in zip(skeleton.body.parts, Ts_world_part, strict=True):
        for name, p_part in part.landmarks.items():
            places.setdefault(name, T[:3, :3] @ flipped(np.array(p_part)) + T[:3, 3])
    return places


def _kept(rows: Sequence[Row], places: dict[str, Array]) -> list[Row]:
    """The bones whose part and place the body has."""
    return [
        row
        for row in rows
        if (not row.part or any(part in places for part in row.part))
        and (not row.at or any(places.keys() >= place.keys() for place in row.at))
    ]


def _own_rows(skeleton: Skeleton, rows: Sequence[Row]) -> list[Row]:
    """A bone of its own name for every part that the rig knows nothing of, such as a racket."""
    bone_of = {
        skeleton.body.names[_part(skeleton, row)]: row.name for row in reversed(rows) if row.part
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


def _head(row: Row, places: dict[str, Array]) -> Array:
    """Where a bone begins in the world at rest."""
    if not row.part:
        return np.zeros(3)
    own: Place = {next(part for part in row.part if part in places): 1.0}
    place = next((place for place in row.at if places.keys() >= place.keys()), own)
    return np.asarray(sum(share * places[name] for name, share in place.items()))


def _part(skeleton: Skeleton, row: Row) -> int:
    names = skeleton.body.names
    return next((names.index(part) for part in row.part if part in names), STILL)


def _parents(rows: Sequence[Row], all_rows: Sequence[Row]) -> NDArray[np.int64]:
    """The index of each bone's parent; where that is left out, of the next one above."""
    at = {row.name: i for i, row in enumerate(rows)}
    above = {row.name: row.parent for row in all_rows}

    def parent(name: str | None) -> int:
        while name is not None and name not in at:
            name = above[name]
        return -1 if name is None else at[name]

    return np.array([parent(row.parent) for row in rows], dtype=np.int64)


def _ends(
    skeleton: Skeleton, heads: Array, parents: NDArray[np.int64], parts: NDArray[np.int64],
    Ts_world_part: Array,
) -> Array:  # fmt: skip
    """Where bones end (B, 3): at the first child elsewhere, else at the end of their part, else as
    far on as their parent is long."""
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


def _frame(along: Array, axes: Axes | None, mirrored: bool) -> Array:
    """R_world_bone (3, 3) of a bone that points along (3,) at rest."""
    if axes is None:
        return np.eye(3)
    if mirrored:
        return -MIRROR @ _frame(MIRROR @ along, axes, False)
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


def _local(Ts_world_bone: Array, parents: NDArray[np.int64]) -> Array:
    Ts = Ts_world_bone.copy()
    inner = np.flatnonzero(parents >= 0)
    Ts[inner] = np.linalg.inv(Ts_world_bone[parents[inner]]) @ Ts_world_bone[inner]
    return Ts
