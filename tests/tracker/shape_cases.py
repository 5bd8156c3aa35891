"""Every shape that there is, in several forms."""

from __future__ import annotations

import pytest
import trimesh

from keypose.tracker.body.body import ALL_DOFS, ROTATIONS, Body, Part
from keypose.tracker.body.shapes import Box, Capsule, Cylinder, Disc, Frustum, Mesh, Solid

SHAPES: dict[str, Solid] = {
    "box": Box(low_m=(-0.1, -0.05, -0.2), high_m=(0.1, 0.3, 0.1)),
    "cylinder": Cylinder(start_m=-0.1, end_m=0.4, radius_m=0.08),
    "hanging cylinder": Cylinder(end_m=-0.5, radius_m=0.1),
    "round frustum": Frustum(end_m=0.5, start_radii_m=(0.1, 0.1), end_radii_m=(0.06, 0.06)),
    "frustum": Frustum(start_m=0.1, end_m=-0.4, start_radii_m=(0.15, 0.1), end_radii_m=(0.2, 0.14)),
    "flat cylinder": Cylinder(start_m=-0.02, end_m=0.03, radius_m=0.3),
    "disc": Disc(low_m=(-0.06, -0.2, -0.2), high_m=(0.06, 0.2, 0.2)),
    "hanging disc": Disc(low_m=(-0.15, 0.1, -0.02), high_m=(0.15, 0.5, 0.03), axis="z"),
    "capsule": Capsule(start_m=-0.05, end_m=0.45, radius_m=0.07),
    "hanging capsule": Capsule(end_m=-0.4, radius_m=0.1),
    "ball": Capsule(start_m=-0.1, end_m=0.1, radius_m=0.1),
    "flat capsule": Capsule(start_m=-0.05, end_m=0.15, radius_m=0.12),
}
every_shape = pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES.keys())


def pair_of(shape: Solid) -> Body:
    """A root of this shape, and on both sides of it a limb of this shape that turns freely."""
    far = shape.far_end
    limbs = [
        Part(
            name=f"{side}_limb",
            parent="trunk",
            joint_m=(x, far[1] / 2, 0.0),
            shape=shape,
            tracked=ROTATIONS,
            landmarks={f"{side}_tip": far},
        )
        for side, x in (("left", 0.4), ("right", -0.4))
    ]
    trunk = Part(name="trunk", shape=shape, tracked=ALL_DOFS)
    pair = (("left_limb", "right_limb"),)
    return Body(name="pair", parts=(trunk, *limbs), mirror_pairs=pair)


def solid_of(mesh: Mesh) -> trimesh.Trimesh:
    """The mesh as trimesh has it."""
    return trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
