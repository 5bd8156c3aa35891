"""Find how long a path's unit is, in metres, by a body that moves smoothly.

A hand that holds a camera shakes, and a body does not shake with it. The body is tracked in metres
in the camera's frame; in the world it is at q + s c, with the camera at c in the path's unit and q
what it sees, turned. The right s leaves it the least acceleration. That is known less surely than
from feet that stand, which it helps to find.
"""

from __future__ import annotations

import numpy as np

from keypose.tracker.camera_motion.metric import PathScale
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.robust import GemanMcClure

ALONG_SHARE = 0.05
"""How much acceleration along the view counts, which is tracked less surely."""
ROUNDS = 20
KERNEL = 2.0
ALIKE = 3.0
"""Neighbouring frames err alike: so many count as one."""
LEAST_SURE = 0.35


def scale_from_smoothness(path: CameraPath, first_frame: int, p_camera: Array) -> PathScale | None:
    """The scale that leaves a point of the body, (n, 3) metres in the camera's frame from a frame
    on, the least acceleration in the world; None where the camera shook too little to tell it."""
    if len(p_camera) < 8:
        return None
    Ts = path.Ts_world_camera[first_frame : first_frame + len(p_camera)]
    q = np.einsum("nab,nb->na", Ts[:, :3, :3], p_camera)
    view = (q / np.linalg.norm(q, axis=1, keepdims=True))[1:-1]
    a, b = (_across(np.diff(x, 2, axis=0), view) for x in (q, Ts[:, :3, 3]))
    weights, s = np.ones(len(a)), 0.0
    for _ in range(ROUNDS):
        power = float((weights[:, None] * b * b).sum())
        if power <= 0:
            return None
        s = -float((weights[:, None] * a * b).sum()) / power
        left = np.linalg.norm(a + s * b, axis=1)
        spread = max(float(np.median(left)), 1e-12)
        weights = GemanMcClure(KERNEL * spread).weight(left)
    sd = spread * np.sqrt(ALIKE / power)
    if not s > 0 or sd > LEAST_SURE * s:
        return None
    return PathScale(s, float(sd), 1)


def _across(x: Array, view: Array) -> Array:
    along = (x * view).sum(axis=1, keepdims=True) * view
    return np.asarray(x - (1 - ALONG_SHARE) * along)
