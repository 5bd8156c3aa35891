"""Three arms of 1 m: joined at one end as a tripod, or one after the other as a chain.

An arm lies along its part's +y, from its joint at 0 to its tip at 1 m.  SURFACE §5.1
"""

from __future__ import annotations

from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.body import ALL_DOFS, ROTATIONS, Body, Part
from keypose.tracker.body.shapes import Box, Frustum, Mesh, Shape
from keypose.tracker.geometry.rotations import Array

Kind: TypeAlias = Literal["tripod", "chain"]

LENGTH_M = 1.0
NAMES = ("arm_a", "arm_b", "arm_c")

APEX_M = 0.07
FLANK_M = 0.18
BACK_M = 0.08
"""The tripod's cross-section at the tip: a wedge of 120° toward the middle, and its back."""
HUB_SHARE = 0.35
"""The tripod's arms are thinner by this where they meet."""

END_M = 0.03
MIDDLE_M = 0.11
DEPTH_M = 0.08
"""Half the chain's width at the joints and halfway, and half its depth."""


def arms_body(kind: Kind) -> Body:
    """The body to pose: the first arm is the root, the others turn about its ends."""
    joint = (0.0, 0.0, 0.0) if kind == "tripod" else (0.0, LENGTH_M, 0.0)
    parents = (None, NAMES[0], NAMES[0] if kind == "tripod" else NAMES[1])
    parts = [
        Part(
            name=name,
            parent=parent,
            joint_m=joint if parent else (0.0, 0.0, 0.0),
            shape=_shape(kind),
            tracked=ROTATIONS if parent else ALL_DOFS,
            landmarks={f"tip_{name[-1]}": (0.0, LENGTH_M, 0.0)},
        )
        for name, parent in zip(NAMES, parents, strict=True)
    ]
    return Body(name=kind, parts=tuple(parts), source="Three arms of 1 m, made up.")


def arm_mesh(kind: Kind) -> Mesh:
    """The true, closed surface of one arm in its part's frame, sides flat."""
    rings = _tripod_rings() if kind == "tripod" else _chain_rings()
    count, sides = rings.shape[:2]
    vertices = np.vstack([rings.reshape(-1, 3), rings[0].mean(axis=0), rings[-1].mean(axis=0)])
    first, last = len(vertices) - 2, len(vertices) - 1
    faces = []
    for j in range(sides):
        k = (j + 1) % sides
        for i in range(count - 1):
            a, b, c, d = i * sides + j, i * sides + k, (i + 1) * sides + k, (i + 1) * sides + j
            faces += [(a, b, c), (a, c, d)]
        end = (count - 1) * sides
        faces += [(first, k, j), (last, end + j, end + k)]
    return Mesh(vertices, _outward(vertices, np.array(faces)), np.zeros(len(faces), np.int64))


def _tripod_rings() -> Array:
    """(R, 5, 3) cross-sections from the hub to the tip."""
    across = FLANK_M * np.sin(np.pi / 3)
    flank = -APEX_M + FLANK_M * np.cos(np.pi / 3)
    outline = np.array([(-APEX_M, 0), (flank, across), (BACK_M, across),
                        (BACK_M, -across), (flank, -across)])  # fmt: skip
    ys = np.linspace(-0.03, LENGTH_M, 12)
    shares = HUB_SHARE + (1 - HUB_SHARE) * np.clip(ys / LENGTH_M, 0, 1)
    return np.stack([_ring(share * outline, y) for y, share in zip(ys, shares, strict=True)])


def _chain_rings() -> Array:
    """(R, 4, 3) cross-sections from joint to joint."""
    ys = np.linspace(-0.02, LENGTH_M + 0.02, 15)
    bulge = 1 - np.abs(np.clip(ys, 0, LENGTH_M) - LENGTH_M / 2) / (LENGTH_M / 2)
    widths = END_M + (MIDDLE_M - END_M) * bulge
    corners = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)])
    return np.stack([_ring(corners * (w, DEPTH_M), y) for y, w in zip(ys, widths, strict=True)])


def _ring(xz: Array, y: float) -> Array:
    return np.column_stack([xz[:, 0], np.full(len(xz), y), xz[:, 1]])


def _outward(vertices: Array, faces: NDArray[np.int64]) -> NDArray[np.int64]:
    """The faces turned about where the volume they enclose would be negative."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    volume = np.einsum("fi,fi->", np.cross(a, b), c)
    return (faces if volume > 0 else faces[:, ::-1]).astype(np.int64)


def _shape(kind: Kind) -> Shape:
    if kind == "chain":
        return Box(low_m=(-0.08, 0.0, -DEPTH_M), high_m=(0.08, LENGTH_M, DEPTH_M))
    return Frustum(end_m=LENGTH_M, start_radii_m=(0.03, 0.06), end_radii_m=(BACK_M, 0.15))
