"""Triangulate joints by aniposelib and Pose2Sim, in an environment of their own.

    python triangulate.py FILMS.npz JOINTS.npz

FILMS: xy (2, F, J, 2) pixels without distortion, NaN where a joint is not seen; likelihood
(2, F, J); K (2, 3, 3), T (2, 4, 4) camera from world; bones (B, 2) whose lengths stay.
JOINTS: an array (F, J, 3) of each method, NaN where it leaves a joint empty.
"""

import sys

import cv2
import numpy as np
from aniposelib.cameras import Camera, CameraGroup
from Pose2Sim.triangulation import triangulation_from_best_cameras

LIKELY = 0.3
REPROJECTION_PX = 15
"""Pose2Sim's defaults."""


def main(films: str, joints: str) -> None:
    """Read, triangulate, write."""
    given = np.load(films)
    group = CameraGroup([_camera(K, T) for K, T in zip(given["K"], given["T"], strict=True)])
    xy, count = given["xy"], given["xy"].shape[1:3]
    linear = group.triangulate(xy.reshape(2, -1, 2)).reshape(*count, 3)
    found = {
        "aniposelib, linear": linear,
        "aniposelib, optimised": group.optim_points(
            xy, linear, constraints=given["bones"], scores=given["likelihood"]
        ),
        "Pose2Sim, weighted": _by_pose2sim(given),
    }
    np.savez(joints, **found)


def _camera(K: np.ndarray, T: np.ndarray) -> Camera:
    turn = cv2.Rodrigues(T[:3, :3])[0].ravel()
    size = (2 * K[:2, 2]).tolist()
    return Camera(matrix=K, dist=np.zeros(5), size=size, rvec=turn, tvec=T[:3, 3], name="film")


def _by_pose2sim(given: np.lib.npyio.NpzFile) -> np.ndarray:
    """As its own loop has it: what is less likely than its threshold is not seen."""
    xy, likelihood = given["xy"], given["likelihood"]
    likelihood = np.where(np.isfinite(xy).all(axis=-1) & (likelihood >= LIKELY), likelihood, np.nan)
    matrices = [K @ T[:3] for K, T in zip(given["K"], given["T"], strict=True)]
    asked = {
        "triangulation": {
            "reproj_error_threshold_triangulation": REPROJECTION_PX,
            "min_cameras_for_triangulation": 2,
        }
    }
    joints = np.full((*xy.shape[1:3], 3), np.nan)
    for frame, joint in np.ndindex(*joints.shape[:2]):
        seen = [xy[:, frame, joint, 0], xy[:, frame, joint, 1], likelihood[:, frame, joint]]
        joints[frame, joint] = triangulation_from_best_cameras(asked, seen, seen, matrices, {})[0]
    return joints


if __name__ == "__main__":
    main(*sys.argv[1:])
