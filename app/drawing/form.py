"""What drawing needs of a body besides its pose, made once for all the pictures of it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

from app.drawing.palette import Side, part_colours, part_sides
from app.drawing.shading import smooth_normal_maps
from app.drawing.strokes import BodyEdges
from tracker.geometry import Array, frozen
from tracker.raster import BodyMesh
from tracker.skeleton import Skeleton


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
