"""What the fit makes of an observed surface, vertex by vertex: for colours on the page."""

from __future__ import annotations

from typing import Literal, TypeAlias

import numpy as np

from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.kernels.cells import grid_of, nearest
from keypose.tracker.surface.fit.model import SurfaceModel
from keypose.tracker.surface.fit.options import Options
from keypose.tracker.surface.fit.pairing import REACH_SHARE, clearance
from keypose.tracker.surface.mesh import SurfaceMesh

Kind: TypeAlias = Literal["contact", "distance"]

_ANY_NORMAL = -2.0


def vertex_scalars(model: SurfaceModel, mesh: SurfaceMesh, pose: Pose, kind: Kind) -> Array:
    """(V,) of a step's mesh in the camera frame, the body at a pose.

    contact: ρ_c of the body's nearest point, 0 to 1.
    distance: metres to the body's surface, REACH_SHARE of its size where that is farther.
    """
    posed = model.posed(pose_transforms(model.skeleton, pose))
    grid, reach = grid_of(posed.p, 2 * model.spacing_m), REACH_SHARE * model.size_m
    found, square = np.empty(len(mesh.vertices), np.int64), np.empty(len(mesh.vertices))
    nearest(
        mesh.vertices, mesh.normals, posed.p, posed.normals, grid, reach, _ANY_NORMAL, found, square
    )
    if kind == "distance":
        return np.sqrt(square)
    clear = clearance(model, posed, grid, Options(floor=False))
    return np.where(found >= 0, clear[found], 1.0)
