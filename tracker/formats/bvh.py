"""The motion as BVH (Biovision hierarchy), which animation programs read.

World of the file: that of all files (`keypose.tracker.body.ground`), y up. Bones are
those of a rig (`keypose.tracker.formats.rigs`), at rest parallel to the world, as BVH has no other:
where all rotations are zero the body stands in the rig's rest pose and faces +z. Bones of landmarks
are left out.

Lengths are in the unit that is asked for, which the file cannot name; angles are degrees. Channels:
position, then Z, Y, X rotation for the root and for the bone that carries the body, where that is
another one; Z, Y, X rotation for the others. R = Rz·Ry·Rx, as the order of the channels says.
Angles run on smoothly from frame to frame, past half a turn where the motion does. Where a bone has
position channels its offset is zero: programs disagree on whether channels add to it. A bone
without children has an end site. Frames are evenly spaced, as BVH knows nothing else.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from keypose.tracker.errors import FormatError
from keypose.tracker.formats.conventions import fixed_decimals, single_words
from keypose.tracker.formats.rigs import OWN
from keypose.tracker.formats.rigs.rig import Rig
from keypose.tracker.formats.rotation_curves import smooth_euler
from keypose.tracker.formats.units import PER_METRE, FileUnit
from keypose.tracker.geometry.rotations import Array

DECIMALS = 6
"""Of centimetres and degrees."""

_PLACE = "Xposition Yposition Zposition"
_TURN = "Zrotation Yrotation Xrotation"


def bvh(rig: Rig, Ts_world_part: Array, seconds_per_frame: float, unit: FileUnit = "m") -> str:
    """The text of the file. FormatError when the time between frames is not positive.

    rig: as of `rig_of(…, parallel=True)`.  Ts_world_part: (N, P, 4, 4) of the body's parts, y up.
    """
    if not 0.0 < seconds_per_frame < np.inf:
        raise FormatError("A BVH file needs a positive time between its frames.")
    tree = _Tree(rig, PER_METRE[unit])
    motion = [
        "MOTION",
        f"Frames: {len(Ts_world_part)}",
        f"Frame Time: {seconds_per_frame:.9f}",
        *(_row(values) for values in tree.channels(Ts_world_part)),
    ]
    return "\n".join(["HIERARCHY", *tree.lines(0), *motion]) + "\n"


@dataclass(frozen=True, eq=False)
class _Tree:
    """A rig's bones as BVH has them; lengths are so many of the file's units a metre."""

    rig: Rig
    per_metre: float

    @property
    def _bones(self) -> range:
        """A body's own rig has its landmarks after its parts."""
        return range(len(self.rig.Ts_world_part) if self.rig.name == OWN else len(self.rig))

    def _children(self, bone: int) -> list[int]:
        return [k for k in self._bones if self.rig.parents[k] == bone]

    def _is_placed(self, bone: int) -> bool:
        return bone in (0, self.rig.mover)

    def _end(self, bone: int) -> Array:
        """Where a bone without children ends, in its frame: at its farthest landmark, if
        any.
        """
        marks = [k for k in range(len(self.rig)) if self.rig.parents[k] == bone]
        ends = self.rig.Ts_parent_bone[marks, :3, 3] if marks else self.rig.ends_bone[[bone]]
        return np.asarray(ends[np.linalg.norm(ends, axis=1).argmax()])

    def lines(self, bone: int, indent: str = "") -> Iterator[str]:
        """The hierarchy from a bone on."""
        offset, inner = self.rig.Ts_parent_bone[bone, :3, 3], f"{indent}  "
        placed, name = self._is_placed(bone), single_words(self.rig.names)[bone]
        yield f"{indent}{'JOINT' if bone else 'ROOT'} {name}"
        yield f"{indent}{{"
        yield f"{inner}OFFSET {self._place(np.zeros(3) if placed else offset)}"
        yield f"{inner}CHANNELS " + (f"6 {_PLACE} {_TURN}" if placed else f"3 {_TURN}")
        children = self._children(bone)
        for child in children:
            yield from self.lines(child, inner)
        if not children:
            end = self._place(self._end(bone))
            yield from (f"{inner}End Site", f"{inner}{{", f"{inner}  OFFSET {end}", f"{inner}}}")
        yield f"{indent}}}"

    def _depth_first(self, bone: int) -> Iterator[int]:
        yield bone
        for child in self._children(bone):
            yield from self._depth_first(child)

    def channels(self, Ts_world_part: Array) -> Array:
        """(N, C) values of the channels in the file's order."""
        Rs_parent_bone, ps_parent_mover = self.rig.motion(Ts_world_part)
        angles = np.rad2deg(smooth_euler(Rs_parent_bone))
        columns = []
        for bone in self._depth_first(0):
            if self._is_placed(bone):
                moves = bone == self.rig.mover
                columns.append(ps_parent_mover * (self.per_metre if moves else 0.0))
            columns.append(angles[:, bone])
        return np.concatenate(columns, axis=1)

    def _place(self, p: Array) -> str:
        return _row(p * self.per_metre)


def _row(values: Sequence[float] | Array) -> str:
    return " ".join(fixed_decimals(values, DECIMALS))
