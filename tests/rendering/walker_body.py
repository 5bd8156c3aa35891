"""The animated human of the shared data as a body of rigid parts, with exact poses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.keeping import data_folder
from keypose.tracker.body.body import ALL_DOFS, ROTATIONS, Body, Part
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.shapes import Frustum
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.surface.placing import Placement

PLACED = Placement("m", "+y", np.array([0.0, 0.72, 3.2]))

# In the order of the file's joints; of each the joint its bone leads to, −1 to its skin's middle.
NAMES = (
    "pelvis", "belly", "chest", "neck", "head", "left_arm", "right_arm", "left_forearm",
    "right_forearm", "left_hand", "right_hand", "left_thigh", "right_thigh", "left_shin",
    "right_shin", "left_foot", "right_foot", "left_toes", "right_toes",
)  # fmt: skip
_LEADS_TO = (1, 2, 3, 4, -1, 7, 8, 9, 10, -1, -1, 13, 14, 15, 16, 17, 18, -1, -1)


@dataclass(frozen=True, eq=False)
class Human:
    """The recorded animation in the camera frame, metres.

    vertices: (F, V, 3), each place once.  faces: (T, 3).  Ts_joint: (F, J, 4, 4), exact.
    weights:  (V, J) how much each joint carries of a vertex.
    """

    vertices: Array
    faces: NDArray[np.int64]
    Ts_joint: Array
    weights: Array
    parents: NDArray[np.int64]

    @classmethod
    def load(cls) -> Human:
        """Absent where the shared data is not here."""
        with np.load(data_folder("mesh_walk") / "sequence.npz") as kept:
            p_file, faces = kept["vertices"].astype(np.float64), kept["faces"]
            Ts_file, parents = kept["joint_world"].astype(np.float64), kept["joint_parents"]
            shares, joints = kept["skin_weights"].astype(np.float64), kept["skin_joints"]
        courses = p_file.transpose(1, 0, 2).reshape(p_file.shape[1], -1).round(5)
        _, first, place = np.unique(courses, axis=0, return_index=True, return_inverse=True)
        weights = np.zeros((p_file.shape[1], Ts_file.shape[1]))
        np.add.at(weights, (np.arange(len(weights))[:, None], joints), shares)
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = PLACED.R_camera_surface, PLACED.p_camera_surface
        corners = place.reshape(-1)[faces]
        return cls(PLACED.points(p_file[:, first]), corners, T @ Ts_file, weights[first], parents)

    @property
    def frame_count(self) -> int:
        return len(self.vertices)


def body_and_poses(human: Human, Ts_joint: Array) -> tuple[Body, list[Pose]]:
    """A body sized by the first frame, and its true poses where the joints are at (F, J, 4, 4).

    Each part's y axis runs along its bone; all joints keep their places in their parents.
    """
    Rs_joint_part = _bones(human)
    parts = tuple(_part(human, j, Rs_joint_part) for j in range(len(NAMES)))
    body = Body(name="walker", parts=parts, source="Sized on the animated human itself.")
    Rs = Ts_joint[..., :3, :3] @ Rs_joint_part
    poses = []
    for frame in range(len(Rs)):
        own = [
            Rs[frame, j] if parent < 0 else Rs[frame, parent].T @ Rs[frame, j]
            for j, parent in enumerate(human.parents)
        ]
        poses.append(Pose(np.stack(own), Ts_joint[frame, 0, :3, 3]))
    return body, poses


def _bones(human: Human) -> Array:
    """Rs_joint_part (J, 3, 3): y along the bone, x as near to the picture's right as may be."""
    Ts = human.Ts_joint[0]
    frames = []
    for j, child in enumerate(_LEADS_TO):
        end = Ts[child, :3, 3] if child >= 0 else human.vertices[0][_skin(human, j)].mean(axis=0)
        y = end - Ts[j, :3, 3]
        y /= np.linalg.norm(y)
        z = np.cross((1.0, 0.0, 0.0), y)
        z /= np.linalg.norm(z)
        frames.append(Ts[j, :3, :3].T @ np.stack([np.cross(y, z), y, z], axis=1))
    return np.stack(frames)


def _skin(human: Human, j: int) -> NDArray[np.bool_]:
    """The vertices that a joint carries most of."""
    return np.asarray(human.weights.argmax(axis=1) == j)


def _part(human: Human, j: int, Rs_joint_part: Array) -> Part:
    parent, T = human.parents[j], human.Ts_joint[0, j]
    R = T[:3, :3] @ Rs_joint_part[j]
    skin = (human.vertices[0][_skin(human, j)] - T[:3, 3]) @ R
    start, end = np.percentile(skin[:, 1], [3, 97])
    low = skin[:, 1] < (start + end) / 2
    radii = [tuple(np.percentile(np.abs(half[:, [0, 2]]), 80, axis=0).clip(0.015).tolist())
             for half in (skin[low], skin[~low])]  # fmt: skip
    joint = (0.0, 0.0, 0.0)
    if parent >= 0:
        T_parent = human.Ts_joint[0, parent]
        R_parent = T_parent[:3, :3] @ Rs_joint_part[parent]
        x, y, z = (T[:3, 3] - T_parent[:3, 3]) @ R_parent
        joint = (float(x), float(y), float(z))
    shape = Frustum(start_m=start, end_m=end, start_radii_m=radii[0], end_radii_m=radii[1])
    return Part(
        name=NAMES[j],
        parent=None if parent < 0 else NAMES[parent],
        joint_m=joint,
        shape=shape,
        tracked=ALL_DOFS if parent < 0 else ROTATIONS,
    )
