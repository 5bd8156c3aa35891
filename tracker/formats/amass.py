"""The motion as an AMASS archive, the poses of SMPL-H that motion research and generators read.

    poses            (N, 156)  rotation vectors of 52 joints, radians, each in its parent's frame:
                               the pelvis' in the world, 21 of the body, then 15 of each hand, which
                               are zero. Zero everywhere is the rest pose, a T
    trans            (N, 3)    where the pelvis is, metres
    mocap_framerate  ()        frames a second
    betas, dmpls     (16,), (N, 8)  zero: the mean shape, no soft tissue
    gender           ()        "neutral"
    rest_joints      (22, 3)   ours besides: where the body's joints are in the rest pose, metres,
                               the pelvis at the origin, y up, x to the body's left

World: z up on the floor, the camera above the origin and looking along +y as nearly as the floor
allows. Tree and rest pose: `keypose.tracker.formats.smpl`.

No model is needed to write it. With `rest_joints`, forward kinematics gives our joints to rounding.
With a licensed model instead, limbs have its lengths, and point beside ours by as much as its own
rest pose departs from a straight T, a few degrees. The model adds where its pelvis rests, J₀, to
`trans`, some 20 cm that are the same at every frame: take `trans − J₀` where the place in the world
matters. The trunk bends where the body does: of a waist and a chest, at spine1 alone.
"""

from __future__ import annotations

import numpy as np

from keypose.tracker.formats.conventions import floor_from_camera, parts_in_world
from keypose.tracker.formats.recording import Recording
from keypose.tracker.formats.smpl import JOINTS, SMPL_H_JOINTS, rest_joints, smpl_of
from keypose.tracker.geometry.rotations import log_rotation, transform
from keypose.tracker.storage.archive import archive_bytes

BETAS, DMPLS = 16, 8

Z_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""From a world whose y points up, by a quarter turn about x."""


def amass(recording: Recording) -> bytes:
    """The bytes of the file.

    FormatError where the body is no person's, where frames are not tracked, or without two times.
    """
    rig, whole = smpl_of(recording.skeleton), recording.whole("AMASS")
    T_world_camera = transform(Z_UP, np.zeros(3)) @ floor_from_camera(whole)
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
