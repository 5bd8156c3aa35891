"""Points on the body's surface that a keyframe shows, and when a base trajectory hides them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.raster import BodyMesh, Raster, raster
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.geometry.view import ViewCamera
from keypose.tracker.tracking.initial.templates.ends import Followed
from keypose.tracker.tracking.scene import Scene

NEAR_M = 0.07
"""Surface points no further than this from an anchor decide whether it is hidden."""
STILL_SEEN = 0.4
"""Of those that the keyframe shows, how many must be seen for it not to be."""


@dataclass(frozen=True, eq=False)
class Anchor:
    """A point (3,) of a part's surface, in its frame, that a keyframe shows at uv (2,).

    shows: (h, w) the pixels of that keyframe that move as the point does. is_seen: False where the
    keyframe does not show the part; the point then lies within.
    """

    part: int
    p_part: Array
    uv: Array
    shows: NDArray[np.bool_]
    size_m: float
    is_seen: bool


def find_anchor(scene: Scene, point: Followed, T: Array, seen: Raster, half: int) -> Anchor:
    """Where a keyframe shows the part about a point.

    T (4, 4): the part in the camera frame. The pixel nearest to where the point would be seen
    through the part is taken, if it lies within `half` pixels along both axes.
    """
    uv, p_part = scene.camera.project(T[:3, :3] @ point.p_part + T[:3, 3]), point.p_part
    rows, columns = np.nonzero(seen.part == point.part)
    is_seen = bool(len(rows) and np.isfinite(uv).all())
    if is_seen:
        nearest = int(np.argmin(np.hypot(columns - uv[0], rows - uv[1])))
        at = np.array([columns[nearest], rows[nearest]], np.float64)
        is_seen = bool(np.abs(at - uv).max() <= half)
    if is_seen:
        p_camera = scene.camera.back_project(at, float(seen.depth[rows[nearest], columns[nearest]]))
        uv, p_part = at, T[:3, :3].T @ (p_camera - T[:3, 3])
    shows = np.isin(seen.part, point.rigid)
    return Anchor(point.part, p_part, uv, shows, point.size_m, is_seen)


def hidden(
    scene: Scene, motion: Trajectory, anchors: Sequence[tuple[Anchor, bool]]
) -> NDArray[np.bool_]:
    """(A, N) whether a motion has what is about each anchor turned away or behind another part.

    anchors: each with whether the first frame of the motion shows it, or else the last one.
    """
    mesh, view = BodyMesh.of(scene.skeleton), ViewCamera.of(scene.camera)
    seen = np.zeros((len(anchors), len(motion)))
    about = [_about(scene, anchor) for anchor, _ in anchors]
    for n, T in enumerate(motion.transforms(scene.skeleton)):
        depth = raster(mesh, T, view).depth
        for a, ((anchor, _), chosen) in enumerate(zip(anchors, about, strict=True)):
            seen[a, n] = _seen_count(scene, T[anchor.part], chosen, depth)
    shown = np.array(
        [row[0] if first else row[-1] for row, (_, first) in zip(seen, anchors, strict=True)]
    )
    return np.asarray(seen < STILL_SEEN * shown.reshape(-1, 1))


def _about(scene: Scene, anchor: Anchor) -> NDArray[np.int64]:
    """Indices of the surface points near an anchor."""
    first, beyond = scene.points.starts[anchor.part : anchor.part + 2]
    away = np.linalg.norm(scene.points.points[first:beyond] - anchor.p_part, axis=1)
    return np.asarray(first + np.flatnonzero(away < max(NEAR_M, 1.01 * away.min(initial=0.0))))


def _seen_count(
    scene: Scene, T: Array, chosen: NDArray[np.int64], depth: NDArray[np.float32]
) -> int:
    """How many of these surface points are seen, their part at T (4, 4)."""
    p_camera = scene.points.points[chosen].astype(np.float64) @ T[:3, :3].T + T[:3, 3]
    normals = scene.points.normals[chosen].astype(np.float64) @ T[:3, :3].T
    facing = np.einsum("ij,ij->i", normals, p_camera) < 0
    uv = np.rint(np.nan_to_num(scene.camera.project(p_camera), nan=-1.0)).astype(np.int64)
    height, width = depth.shape
    inside = facing & ((uv >= 0) & (uv < (width, height))).all(axis=1)
    over = depth[uv[inside, 1], uv[inside, 0]] < p_camera[inside, 2] - scene.visibility.tolerance
    return int((~over).sum())
