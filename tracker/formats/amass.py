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

World: z up, on the floor, as in `tracker.formats.ground`. Tree and rest pose as in
`tracker.formats.smpl`.

No model is needed to write it. With `rest_joints`, forward kinematics gives our joints to rounding.
With a licensed model instead, limbs have its lengths, and point beside ours by as much as its own
rest pose departs from a straight T, a few degrees. The model adds where its pelvis rests, J₀, to
`trans`, some 20 cm that are the same at every frame: take `trans − J₀` where the place in the world
matters. The trunk bends where the body does: of a waist and a chest, at spine1 alone.
"""

from __future__ import annotations

import numpy as np

from tracker.formats.axes import FLIP
from tracker.formats.ground import ground_from_camera
from tracker.formats.recording import Recording
from tracker.formats.smpl import JOINT_COUNT, JOINTS, RestBody, rotations_of
from tracker.geometry.rotations import log_rotation
from tracker.storage.archive import archive_bytes

BETAS, DMPLS = 16, 8


def amass(recording: Recording) -> bytes:
    """The bytes of the file.

    FormatError where the body is no person's, where frames are not tracked, or without two times.
    """
    rest, whole = RestBody.of(recording.skeleton), recording.whole("AMASS")
    R_ground_camera, p_ground_camera = ground_from_camera(whole)
    Ts_camera_part = whole.trajectory.transforms(whole.skeleton)
    Rs_ground_part = R_ground_camera @ Ts_camera_part[..., :3, :3] * FLIP
    poses = np.zeros((len(whole), JOINT_COUNT, 3))
    poses[:, : len(JOINTS)] = log_rotation(rotations_of(rest, Rs_ground_part))
    ps_camera_root = whole.trajectory.ps_camera_root
    return archive_bytes(
        {
            "poses": poses.reshape(len(whole), -1),
            "trans": ps_camera_root @ R_ground_camera.T + p_ground_camera,
            "mocap_framerate": np.array(whole.frames_per_second),
            "betas": np.zeros(BETAS),
            "dmpls": np.zeros((len(whole), DMPLS)),
            "gender": np.array("neutral"),
            "rest_joints": rest.ps_rest_joint,
        }
    )
