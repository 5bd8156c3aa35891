"""What drawing needs of a body besides its pose, made once for all the pictures of it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

from keypose.app.render.palette import Side, part_colours, part_sides
from keypose.app.render.shading import smooth_normal_maps
from keypose.app.render.strokes import BodyEdges
from keypose.tracker.body.raster import BodyMesh
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array, frozen


@dataclass(frozen=True, eq=False)
class Form:
    """A body's triangles, their smooth normals, their edges, and the colours of the parts."""

    mesh: BodyMesh
    normal_maps: Array
    edges: BodyEdges
    colours: Array
    sides: tuple[Side, ...]


@lru_cache(maxsize=4)
def form_of(skeleton: Skeleton) -> Form:
    """Of the same skeleton it is the same."""
    mesh = BodyMesh.of(skeleton)
    return Form(
        mesh,
        frozen(smooth_normal_maps(mesh)),
        BodyEdges.of(mesh),
        part_colours(skeleton.body),
        part_sides(skeleton.body),
    )
