"""The shapes that there are, and one that the program has never heard of."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Annotated, Literal, Self

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray
from pydantic import Field

from tracker.body.body import ALL_DOFS, ROTATIONS, Body, Part
from tracker.body.shapes import (
    SIDES,
    Box,
    Cylinder,
    Frustum,
    Length,
    Mesh,
    Point,
    ShapeSize,
    Size,
    Solid,
    Wireframe,
)
from tracker.body.shapes.wireframe import ring

Floats = NDArray[np.float64]


class Capsule(Solid):
    """A rod with round ends, from tip to tip along y."""

    kind: Literal["capsule"] = "capsule"
    start_m: Length = 0.0
    end_m: Length
    radius_m: Size

    def mesh(self) -> Mesh:
        rings = self.wireframe().rings
        count, tips = len(rings), [[0.0, self.start_m, 0.0], [0.0, self.end_m, 0.0]]
        vertices = np.vstack([rings.reshape(-1, 3), tips])
        at = np.arange(count * SIDES).reshape(count, SIDES)
        on = np.roll(at, -1, axis=1)
        strips = [(at[:-1], on[:-1], at[1:]), (on[:-1], on[1:], at[1:])]
        first, last = (np.full(SIDES, count * SIDES + k) for k in (0, 1))
        caps = [(first, on[0], at[0]), (last, at[-1], on[-1])]
        faces = np.concatenate([np.stack(f, axis=-1).reshape(-1, 3) for f in (*strips, *caps)])
        return Mesh.convex(vertices, faces, np.zeros(len(faces), np.int64))

    def wireframe(self, lift_m: float = 0.0) -> Wireframe:
        sign, r = np.sign(self.end_m - self.start_m), self.radius_m
        turns = np.deg2rad([89, 75, 60, 45, 30, 15, 0])
        rise, wide = (r + lift_m) * np.sin(turns), (r + lift_m) * np.cos(turns)
        low = [ring(self.start_m + sign * (r - y), x, x) for y, x in zip(rise, wide, strict=True)]
        high = [ring(self.end_m - sign * (r - y), x, x) for y, x in zip(rise, wide, strict=True)]
        return Wireframe(np.zeros((0, 2, 3)), np.stack([*low, *high[::-1]]))

    def distance(self, p_part: Floats) -> Floats:
        ends = sorted((self.start_m, self.end_m))
        y = np.clip(p_part[:, 1], ends[0] + self.radius_m, ends[1] - self.radius_m)
        beyond = np.stack([p_part[:, 0], p_part[:, 1] - y, p_part[:, 2]], axis=1)
        return np.asarray(np.linalg.norm(beyond, axis=1) - self.radius_m)

    def marks(self) -> Floats:
        return np.array([[0.0, self.start_m, 0.0], [0.0, self.end_m, 0.0]])

    @property
    def centre(self) -> Point:
        return (0.0, (self.start_m + self.end_m) / 2, 0.0)

    @property
    def far_end(self) -> Point:
        return (0.0, max(self.start_m, self.end_m, key=abs), 0.0)

    @property
    def length_m(self) -> float:
        return abs(self.end_m - self.start_m)

    @property
    def width_m(self) -> float:
        return 2 * self.radius_m

    def half_widths(self, y: float) -> tuple[float, float]:
        return self.radius_m, self.radius_m

    def sizes(self) -> tuple[ShapeSize, ...]:
        return (
            ShapeSize("length", self.length_m, (0.0, self.end_m, 0.0)),
            ShapeSize("radius", self.radius_m, self.centre),
        )

    def with_size(self, key: str, metres: float) -> Self:
        if key == "radius":
            return self.model_copy(update={"radius_m": metres})
        return self.scaled(metres / self.length_m, 1.0)

    def scaled(self, along: float, across: float) -> Self:
        ends = {"start_m": self.start_m * along, "end_m": self.end_m * along}
        return self.model_copy(update={**ends, "radius_m": self.radius_m * across})


SHAPES: dict[str, Solid] = {
    "box": Box(low_m=(-0.1, -0.05, -0.2), high_m=(0.1, 0.3, 0.1)),
    "cylinder": Cylinder(start_m=-0.1, end_m=0.4, radius_m=0.08),
    "hanging cylinder": Cylinder(end_m=-0.5, radius_m=0.1),
    "round frustum": Frustum(end_m=0.5, start_radii_m=(0.1, 0.1), end_radii_m=(0.06, 0.06)),
    "frustum": Frustum(start_m=0.1, end_m=-0.4, start_radii_m=(0.15, 0.1), end_radii_m=(0.2, 0.14)),
    "disc": Cylinder(start_m=-0.02, end_m=0.03, radius_m=0.3),
    "capsule": Capsule(start_m=-0.05, end_m=0.45, radius_m=0.07),
    "hanging capsule": Capsule(end_m=-0.4, radius_m=0.1),
}
every_shape = pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES.keys())


@contextmanager
def capsules_listed() -> Iterator[None]:
    """A body may have capsules meanwhile, as if they stood in the list of shapes."""
    field = Part.model_fields["shape"]
    before = field.annotation
    longer = Annotated[Cylinder | Frustum | Box | Capsule, Field(discriminator="kind")]
    field.annotation = longer  # type: ignore[assignment]
    _read_anew()
    try:
        yield
    finally:
        field.annotation = before
        _read_anew()


def _read_anew() -> None:
    for model in (Part, Body):
        model.model_rebuild(force=True)


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
