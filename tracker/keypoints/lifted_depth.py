"""Give keypoints the depth that a network lifts from a second of them, with its deviation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from threading import Lock
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from keypose.tracker.body.body import Body
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.keypoints import JOINTS, Keypoints
from keypose.tracker.keypoints.lifting import OFFSETS_S, lifted, turns
from keypose.tracker.keypoints.on_body import points_on_body

_CARRIER: Final = {
    "heel": "ankle",
    "foot_index": "ankle",
    "pinky": "wrist",
    "index": "wrist",
    "thumb": "wrist",
}
"""By keypoint the joint beside which it stays; all others stay beside the shoulders."""

_LIFTING = Lock()
"""Segments are tracked beside each other; a network answers one of them at a time."""


@dataclass(frozen=True, eq=False)
class DepthLifter:
    """Lifts keypoints of one film.

    camera: of the video, with its distortion.  times_s: (F,) of every frame of the film.
    up_camera: (3,), or (F, 3) of a camera that turns; None where what is up is unknown.
    """

    camera: Camera
    times_s: Array
    up_camera: ArrayLike | None = None

    def looked_at(self, first: int, last: int) -> tuple[int, int]:
        """First and last of the frames that are looked at to lift these."""
        times = self.times_s
        low = np.searchsorted(times, times[first] + OFFSETS_S[0] - 1e-6)
        high = np.searchsorted(times, times[last] + OFFSETS_S[-1] + 1e-6) - 1
        return int(low), int(high)

    def of(self, keypoints: Keypoints, body: Body) -> Keypoints:
        """The keypoints with p_hips and depth_sigma_m of a person of the body's size, as lifted;
        what is not lifted stays beside what is. The same where they are no person's."""
        missing = [name for name in JOINTS if name not in keypoints.names]
        size_m = body_size_m(body)
        if missing or size_m is None or not len(keypoints):
            return keypoints
        rows = slice(keypoints.first_frame, keypoints.last_frame + 1)
        up = None if self.up_camera is None else np.asarray(self.up_camera)
        if up is not None and up.ndim == 2:
            up = up[rows]
        with _LIFTING:
            lifted_joints = lifted(keypoints, self.camera, self.times_s[rows], up)
        at = [lifted_joints.names.index(name) for name in JOINTS]
        axes = self._axes(lifted_joints.hips)
        p = np.einsum("nij,nkj->nki", axes, size_m * lifted_joints.p_hips[:, at])
        sigma_m = size_m * lifted_joints.sigma[:, at, 1]
        return _with_joints(keypoints, p, sigma_m)

    def _axes(self, hips: Array) -> Array:
        """(N, 3, 3) from the camera's axes to those of the landmarks: as if the middle of the hips
        (N, 2), in the plane at distance 1, were in the picture's middle."""
        if self.camera.telephoto_distance_m is not None:
            return np.broadcast_to(np.eye(3), (len(hips), 3, 3))
        return turns(hips)


def depth_along_view(keypoints: Keypoints, camera: Camera) -> Array:
    """(N, L) metres along the camera's axis from the middle of the hips, by p_hips.

    Depth that was lifted is turned from the axes of landmarks; a network's own stays as it is, as
    keyframes show by how much it is off. camera: by which the keypoints are seen.
    """
    assert keypoints.p_hips is not None
    z = keypoints.p_hips[..., 2]
    if keypoints.depth_sigma_m is None or camera.telephoto_distance_m is not None:
        return z
    hips = [keypoints.names.index(f"{side}_hip") for side in ("left", "right")]
    R_landmarks_camera = turns(
        camera.back_project(keypoints.uv[:, hips], 1.0)[..., :2].mean(axis=1)
    )
    turned = np.einsum("nlj,nj->nl", keypoints.p_hips, R_landmarks_camera[:, :, 2])
    return np.asarray(np.where(np.isfinite(turned), turned, z))


def body_size_m(body: Body) -> float | None:
    """Thigh and shin, mean of both sides, and from the middle of the hips to that of the shoulders;
    None of a body without these joints."""
    index, parts, points = points_on_body(body, JOINTS)
    if len(index) < len(JOINTS):
        return None
    skeleton = Skeleton.of(body)
    T = pose_transforms(skeleton, Pose.rest(skeleton, (0.0, 0.0, 0.0)))[parts]
    p = (T[:, :3, :3] @ points[..., None])[..., 0] + T[:, :3, 3]

    def pair(joint: str) -> Array:
        return np.asarray(p[[JOINTS.index(f"{side}_{joint}") for side in ("left", "right")]])

    chain = [pair(joint) for joint in ("hip", "knee", "ankle")]
    leg = sum(np.linalg.norm(b - a, axis=-1).mean() for a, b in pairwise(chain))
    trunk = np.linalg.norm(pair("shoulder").mean(axis=0) - pair("hip").mean(axis=0))
    return float(leg + trunk)


def _with_joints(keypoints: Keypoints, p_joints: Array, sigma_m: Array) -> Keypoints:
    """Put the joints (N, 12, 3) in their places, and what hangs on them beside them."""
    names = keypoints.names
    at = [names.index(name) for name in JOINTS]
    shape = (len(keypoints), len(names))
    own = np.full((*shape, 3), np.nan) if keypoints.p_hips is None else keypoints.p_hips
    p, sigma = own.copy(), np.full(shape, np.nan)
    # what hangs on a joint whose own depth is unknown, as of one set by hand, is unknown too
    moved = np.where(np.isfinite(p_joints), p_joints - own[:, at], 0.0)
    for k, name in enumerate(names):
        carriers = [JOINTS.index(joint) for joint in _carriers(name)]
        p[:, k] += moved[:, carriers].mean(axis=1)
    is_known = np.asarray(np.isfinite(p_joints).all(axis=-1))
    p[:, at] = np.where(is_known[..., None], p_joints, own[:, at])
    sigma[:, at] = np.where(is_known, sigma_m, np.nan)
    return replace(keypoints, p_hips=p, depth_sigma_m=sigma)


def _carriers(name: str) -> Sequence[str]:
    """The joints beside which a keypoint stays."""
    side, _, rest = name.partition("_")
    if rest in _CARRIER:
        return (f"{side}_{_CARRIER[rest]}",)
    return ("left_shoulder", "right_shoulder")
