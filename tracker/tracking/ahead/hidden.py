"""How much of a part other parts hide from the camera."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.raster import BodyMesh, raster
from keypose.tracker.geometry.view import ViewCamera

if TYPE_CHECKING:
    from keypose.tracker.tracking.scene import Scene


def hidden_share(scene: Scene, pose: Pose, part: int) -> tuple[float, int | None]:
    """The share of a part's near side that other parts cover or that lies outside the picture; and
    the part that covers most of it, None where more of it is outside."""
    skeleton, points, camera = scene.skeleton, scene.points, scene.camera
    Ts = pose_transforms(skeleton, pose)
    own = slice(points.starts[part], points.starts[part + 1])
    R, p = Ts[part, :3, :3], Ts[part, :3, 3]
    p_camera = points.points[own] @ R.T + p
    near = ((points.normals[own] @ R.T) * p_camera).sum(axis=-1) < 0
    if not near.any():
        return 0.0, None
    uv = np.round(camera.project(p_camera[near])).astype(int)
    inside = ((uv >= 0) & (uv < np.array([camera.width, camera.height]))).all(axis=-1)
    u, v = uv[inside].T
    seen = raster(BodyMesh.of(skeleton), Ts, ViewCamera.of(camera)).part[v, u]
    covering = seen[(seen >= 0) & (seen != part)]
    outside = int((~inside).sum())
    behind = int(np.bincount(covering).argmax()) if len(covering) > outside else None
    return (len(covering) + outside) / len(uv), behind
