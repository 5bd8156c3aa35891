"""Make a body's rig: its bones in the rest pose, and their motion from the body's.

Worlds here are y up, metres. A bone's frame has its origin where the bone begins; how its axes lie
at rest is the rig's to say (`keypose.tracker.formats.rigs.table`). Part frames are those of files
whose y points up (`keypose.tracker.formats.conventions`): at the body's own rest parallel to the
world.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import FormatError, listed
from keypose.tracker.formats.conventions import column_names, end_site, flipped
from keypose.tracker.formats.rigs import OWN, RIGS
from keypose.tracker.formats.rigs.on_body import (
    STILL,
    bone_axes,
    ends_of,
    head_of,
    kept_rows,
    named_places,
    own_rows,
    parents_of,
    part_of,
    require_person,
)
from keypose.tracker.formats.rigs.table import SIDES, Axes, table_of
from keypose.tracker.geometry.rotations import Array, exp_rotation, frozen, transform, transpose

_ARM = ("upper_arm", "forearm", "hand")
_LEG = ("thigh", "shin")
_DOWN = np.array([0.0, -1.0, 0.0])


def rest_pose(skeleton: Skeleton, arms_below_horizontal_deg: float | None) -> Array:
    """Ts_world_part (P, 4, 4), metres, with the root's joint above the world's origin.

    None: the body's own rest pose. Otherwise arms straight out to the sides, so far below the
    horizontal, and legs straight down, each part turned there from the own rest pose about the one
    axis that takes it; the rest of the body as in the own rest pose.
    """
    Rs = np.tile(np.eye(3), (skeleton.part_count, 1, 1))
    if arms_below_horizontal_deg is not None:
        for part, direction in _directions(arms_below_horizontal_deg).items():
            if part in skeleton.body.names:
                i = skeleton.body.index(part)
                Rs[i] = _turn_onto(_along(skeleton, i), direction)
    Ts = transform(Rs, np.zeros((skeleton.part_count, 3)))
    for i, parent in enumerate(skeleton.parents):
        if parent >= 0:
            Ts[i, :3, 3] = Ts[parent, :3, 3] + Rs[parent] @ flipped(skeleton.joints[i])
    Ts[:, 1, 3] -= _lowest(skeleton, Ts)
    return Ts


def _directions(below_deg: float) -> dict[str, Array]:
    """Where the parts of arms and legs point."""
    below = np.deg2rad(below_deg)
    directions: dict[str, Array] = {}
    for side, sign in zip(SIDES, (1.0, -1.0), strict=True):
        out = np.array([sign * np.cos(below), -np.sin(below), 0.0])
        directions |= {f"{side}_{part}": out for part in _ARM}
        directions |= {f"{side}_{part}": _DOWN for part in _LEG}
    return directions


def _along(skeleton: Skeleton, i: int) -> Array:
    """Where a part points in its own frame: to its first child's joint, or to its end."""
    children = np.flatnonzero(skeleton.parents == i)
    end = skeleton.joints[children[0]] if len(children) else end_site(skeleton.body.parts[i])
    return flipped(np.asarray(end))


def _turn_onto(start: Array, end: Array) -> Array:
    """The smallest rotation (3, 3) that takes one direction (3,) to another."""
    axis = np.cross(start, end)
    length, along = np.linalg.norm(axis), float(start @ end)
    if (
        length < 1e-9
    ):  # parallel: nothing to do; opposed: any axis across, here the one to the front
        return np.asarray(exp_rotation(np.array([0.0, 0.0, 0.0 if along >= 0 else np.pi])))
    return np.asarray(exp_rotation(axis / length * np.arctan2(length, along)))


def _lowest(skeleton: Skeleton, Ts_world_part: Array) -> float:
    """y of the body's lowest point."""
    heights = (
        flipped(part.shape.mesh().vertices) @ T[1, :3] + T[1, 3]
        for part, T in zip(skeleton.body.parts, Ts_world_part, strict=True)
    )
    return float(min(h.min() for h in heights))


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
        """The bone that carries the body through space: the root, or the first bone below one that
        stands still. All others keep their places on theirs."""
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
    require_person(skeleton, name)
    table = table_of(name)
    Ts_world_part = rest_pose(skeleton, table.arms_below_horizontal_deg)
    places = named_places(skeleton, Ts_world_part)
    rows = kept_rows(table.rows(), places)
    rows += own_rows(skeleton, rows)
    heads = np.array([head_of(row, places) for row in rows])
    parents = parents_of(rows, (*table.rows(), *rows))
    parts = np.array([part_of(skeleton, row) for row in rows], dtype=np.int64)
    ends = ends_of(skeleton, heads, parents, parts, Ts_world_part)
    Rs = np.stack(
        [
            bone_axes(
                end - head,
                None if parallel or not row.part else row.axes,
                mirrored=table.mirrored and row.side == "right",
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
    ends = ends_of(skeleton, heads, parents, parts, Ts)
    is_single = skeleton.part_count == 1  # such as a box, which points nowhere
    axes = None if parallel or is_single else OWN_AXES
    Rs = np.stack([bone_axes(ends[i] - heads[i], axes) for i in parts])
    return _rig(OWN, column_names(skeleton), parents, parts, Rs, heads, ends, Ts)


def _rig(
    name: str,
    names: Sequence[str],
    parents: NDArray[np.int64],
    parts: NDArray[np.int64],
    Rs_world_bone: Array,
    heads: Array,
    ends: Array,
    Ts_world_part: Array,
) -> Rig:
    ends_bone = np.einsum("bji,bj->bi", Rs_world_bone, ends - heads)
    return Rig(
        name,
        tuple(names),
        parents,
        parts,
        frozen(transform(Rs_world_bone, heads)),
        frozen(ends_bone),
        frozen(Ts_world_part),
    )


def _local(Ts_world_bone: Array, parents: NDArray[np.int64]) -> Array:
    Ts = Ts_world_bone.copy()
    inner = np.flatnonzero(parents >= 0)
    Ts[inner] = np.linalg.inv(Ts_world_bone[parents[inner]]) @ Ts_world_bone[inner]
    return Ts
