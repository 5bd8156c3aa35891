"""The joints of SMPL's body, and a body of ours as its kinematic tree.

Names and parents of the joints are public; where they rest is taken from our own body, which is
laid into the T of the rig `smpl` (`keypose.tracker.formats.rigs`). The model itself, its surface
and its own rest joints, is licensed apart and not needed.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import FormatError, listed
from keypose.tracker.formats.rigs.on_body import PERSON
from keypose.tracker.formats.rigs.rig import Rig, rig_of
from keypose.tracker.formats.rigs.table import table_of
from keypose.tracker.geometry.rotations import Array, transform

RIG: Final = "smpl"

JOINTS: Final = tuple(row.name for row in table_of(RIG).rows())
"""The 22 joints of the body, as SMPL, SMPL-H and SMPL-X number them."""

PARENTS: Final = tuple(
    JOINTS.index(row.parent) if row.parent else -1 for row in table_of(RIG).rows()
)

SMPL_H_JOINTS: Final = 52
"""With three joints for each of ten fingers."""


def smpl_of(skeleton: Skeleton) -> Rig:
    """The rig, whose first bones are `JOINTS`. FormatError where the body lacks one of them."""
    if not set(PERSON) <= set(skeleton.body.names):
        raise FormatError("SMPL poses are those of a whole person, and this body is no person's.")
    rig = rig_of(skeleton, RIG)
    missing = [name.replace("_", " ") for name in JOINTS if name not in rig.names]
    if missing:
        raise FormatError(f"An SMPL body is a whole person, and this one has no {listed(missing)}.")
    for joint, parent in enumerate(PARENTS):
        part, above = rig.parts[joint], rig.parts[parent]
        if parent >= 0 and part != above and skeleton.parents[part] != above:
            hung, on = (skeleton.body.names[i].replace("_", " ") for i in (part, above))
            raise FormatError(
                f"In an SMPL body the {hung} hangs on the {on}, and in this body it does not."
            )
    return rig


def rest_joints(rig: Rig) -> Array:
    """ps_rest_joint (22, 3), metres: the pelvis at the origin, y up, x to the body's left."""
    places = rig.Ts_world_bone[: len(JOINTS), :3, 3]
    return np.asarray(places - places[0])


def joints_of(ps_rest_joint: Array, Rs_parent_joint: Array, ps_world_pelvis: Array) -> Array:
    """ps_world_joint (N, 22, 3): forward kinematics of the tree.

    Rs_parent_joint: (N, 22, 3, 3), the pelvis' in the world.  ps_world_pelvis: (N, 3).
    """
    offsets = ps_rest_joint - ps_rest_joint[list(PARENTS)]
    Ts = transform(Rs_parent_joint, np.broadcast_to(offsets, Rs_parent_joint.shape[:-1]))
    Ts[:, 0, :3, 3] = ps_world_pelvis
    for joint, parent in enumerate(PARENTS):
        if parent >= 0:
            Ts[:, joint] = Ts[:, parent] @ Ts[:, joint]
    return np.asarray(Ts[..., :3, 3])
