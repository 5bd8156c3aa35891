"""How much of a part other parts hide from the camera."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tracker.body.pose import Pose, pose_transforms
from tracker.body.raster import BodyMesh, raster
from tracker.geometry.view import ViewCamera

if TYPE_CHECKING:
    from tracker.tracking.scene import Scene


def hidden_share(scene: Scene, pose: Pose, part: int) -> tuple[float, int | None]:
    """Of a part's near side that lies in the picture, the share which other parts cover, and the
    part that covers most of it; 1 and None where nothing of it lies in the picture."""
    skeleton, points = scene.skeleton, scene.points
    Ts = pose_transforms(skeleton, pose)
    own = slice(points.starts[part], points.starts[part + 1])
    R, p = Ts[part, :3, :3], Ts[part, :3, 3]
    p_camera = points.points[own] @ R.T + p
    near = ((points.normals[own] @ R.T) * p_camera).sum(axis=-1) < 0
    uv = np.round(scene.camera.project(p_camera[near])).astype(int)
    inside = ((uv >= 0) & (uv < (scene.camera.width, scene.camera.height))).all(axis=-1)
    if not inside.any():
        return 1.0, None
    u, v = uv[inside].T
    seen = raster(BodyMesh.of(skeleton), Ts, ViewCamera.of(scene.camera)).part[v, u]
    others = seen[(seen >= 0) & (seen != part)]
    if not len(others):
        return 0.0, None
    return len(others) / len(seen), int(np.bincount(others).argmax())
