"""Photo-consistency: whether the cameras that see a place of a surface agree on how it looks.

On phantom volume, and where a surface was reconstructed badly, they do not.  SURFACE §3.2
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.kernels.patches import correlate
from keypose.tracker.kernels.raster import PERSPECTIVE, fill
from keypose.tracker.surface.cameras.views import Grey, Lenses, View, stack_pictures
from keypose.tracker.surface.mesh import SurfaceMesh

SPACING_PX = 1.0
"""Between the samples of a patch, which so is 7 pixels wide."""

SLACK_PX = 3.0
"""A vertex this far behind what a view sees first is still seen: the depth of a slanted face
changes by about as much within a pixel."""

LEAST_COSINE = 0.35
"""Of the angle between a surface's normal and the way to a camera that is compared."""

NEAR_M = 0.01


@dataclass(frozen=True, eq=False)
class Agreement:
    """How well the cameras agree on each vertex.

    zncc:    (V,) mean zero-mean normalised cross correlation over all pairs that see it; −1 where
             fewer than two do.
    seen_by: (V,) number of cameras that see it.
    """

    zncc: Array
    seen_by: NDArray[np.int64]


def consistency(mesh: SurfaceMesh, views: Sequence[View], pictures: Sequence[Grey]) -> Array:
    """Mean ZNCC (V,) of a mesh in the views' world; pictures (H, W) as an ideal lens takes them."""
    return agreement(mesh, views, pictures).zncc


def agreement(mesh: SurfaceMesh, views: Sequence[View], pictures: Sequence[Grey]) -> Agreement:
    """The same with the number of views."""
    zncc, seen_by = np.full(len(mesh.vertices), -1.0), np.zeros(len(mesh.vertices), np.int64)
    if views:
        lenses, stack = Lenses.of(views), stack_pictures(pictures, 0)
        correlate(
            np.ascontiguousarray(mesh.vertices), np.ascontiguousarray(mesh.normals),
            lenses.Ts, lenses.lenses, lenses.sizes, stack, _nearness(mesh, views, stack.shape),
            SPACING_PX, SLACK_PX, LEAST_COSINE, zncc, seen_by,
        )  # fmt: skip
    return Agreement(zncc, seen_by)


def _nearness(
    mesh: SurfaceMesh, views: Sequence[View], shape: tuple[int, ...]
) -> NDArray[np.float32]:
    """(K, H, W) 1/z of the mesh's first face in every pixel, −inf where there is none."""
    nearness = np.full(shape, -np.inf, np.float32)
    shown = np.empty(shape[1:], np.int32)
    for view, buffer in zip(views, nearness, strict=True):
        shown.fill(-1)
        c = view.camera
        projection = np.array([PERSPECTIVE, c.fx, c.fy, c.cx, c.cy, 1.0])
        p_view = np.ascontiguousarray(view.of_view(mesh.vertices))
        fill(p_view, mesh.faces, projection, NEAR_M, buffer, shown)
    return nearness
