"""Which parts lie under the pointer, and where a part's outline runs."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from keypose.app.posing.pointer_view import PointerView
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.ray_parts import mesh_of, parts_on_ray
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array, apply_transform
from keypose.tracker.geometry.view import NEAR_M


def parts_at(
    skeleton: Skeleton, pose: Pose, view: PointerView, at: Sequence[float]
) -> tuple[str, ...]:
    """Names of the parts seen at a point of the view, from front to back.

    A part lies where the line of sight first enters it. Behind the camera nothing is seen.
    """
    origin, direction = view.ray(at)
    near = -np.inf
    if view.camera is not None:
        near = (NEAR_M - float(view.depth(origin))) / float(direction @ view.away)
    return parts_on_ray(skeleton, pose, origin, direction, near)


def outline(skeleton: Skeleton, pose: Pose, view: PointerView, part: str) -> Array:
    """The convex outline (N, 2) of a part in view coordinates; empty when it cannot be seen."""
    i = skeleton.body.index(part)
    T = pose_transforms(skeleton, pose)[i]
    p_camera = apply_transform(T, mesh_of(skeleton.body.parts[i].shape).vertices)
    if view.camera is not None and view.depth(p_camera).min() <= NEAR_M:
        return np.zeros((0, 2))
    at = view.project(p_camera).astype(np.float32)
    return cv2.convexHull(at)[:, 0].astype(np.float64)
