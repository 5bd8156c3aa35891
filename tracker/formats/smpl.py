"""Give a body of ours as SMPL's kinematic tree, and write its motion as an AMASS archive.

Names and parents of the joints are public; where they rest is taken from our own body, which is
laid into the T of the rig `smpl` (`keypose.tracker.formats.rigs`). The model itself, its surface
and its own rest joints, is licensed apart and not needed.

    poses            (N, 156)  rotation vectors of 52 joints, radians, each in its parent's frame:
                               the pelvis' in the world, 21 of the body, then 15 of each hand, which
                               are zero. Zero everywhere is the rest pose, a T
    trans            (N, 3)    where the pelvis is, metres
    mocap_framerate  ()        frames a second
    betas, dmpls     (16,), (N, 8)  zero: the mean shape, no soft tissue
    gender           ()        "neutral"
    rest_joints      (22, 3)   ours besides: where the body's joints are in the rest pose, metres,
                               the pelvis at the origin, y up, x to the body's left

World: that of all files (`keypose.tracker.body.ground`), turned so that z is up: its −z is y here.

No model is needed to write it. With `rest_joints`, forward kinematics gives our joints to rounding.
With a licensed model instead, limbs have its lengths, and point beside ours by as much as its own
rest pose departs from a straight T, a few degrees. The model adds where its pelvis rests, J₀, to
`trans`, some 20 cm that are the same at every frame: take `trans − J₀` where the place in the world
matters. The trunk bends where the body does: of a waist and a chest, at spine1 alone.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import FormatError, listed
from keypose.tracker.formats.conventions import parts_in_world
from keypose.tracker.formats.recording import Recording
from keypose.tracker.formats.rigs.on_body import PERSON
from keypose.tracker.formats.rigs.rig import Rig, rig_of
from keypose.tracker.formats.rigs.table import table_of
from keypose.tracker.geometry.rotations import Array, log_rotation, transform
from keypose.tracker.storage.archive import archive_bytes

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


BETAS = 16
DMPLS = 8
"""Columns of shape and of soft tissue that AMASS files have."""

Z_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""From a world whose y points up, by a quarter turn about x."""


def amass(recording: Recording) -> bytes:
    """The bytes of the file.

    FormatError where the body is no person's, where frames are not tracked, or without two times.
    """
    rig, whole = smpl_of(recording.skeleton), recording.whole("AMASS")
    T_world_camera = transform(Z_UP, np.zeros(3)) @ whole.T_world_camera
    Rs_parent_bone, trans = rig.motion(parts_in_world(whole, T_world_camera))
    poses = np.zeros((len(whole), SMPL_H_JOINTS, 3))
    poses[:, : len(JOINTS)] = log_rotation(Rs_parent_bone[:, : len(JOINTS)])
    return archive_bytes(
        {
            "poses": poses.reshape(len(whole), -1),
            "trans": trans,
            "mocap_framerate": np.array(whole.frames_per_second),
            "betas": np.zeros(BETAS),
            "dmpls": np.zeros((len(whole), DMPLS)),
            "gender": np.array("neutral"),
            "rest_joints": rest_joints(rig),
        }
    )
