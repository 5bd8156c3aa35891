"""The parts of a body as the page's views draw them: smooth meshes, rims, wires, outlines.

Everything is in the frame of its own part, metres, single precision, as viser sends it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from tracker.body.body import Body
from tracker.body.shapes import SIDES, Box, Shape
from tracker.geometry.rotations import Array

Vertices: TypeAlias = NDArray[np.float32]
Faces: TypeAlias = NDArray[np.uint32]
Segments: TypeAlias = NDArray[np.float32]
"""(N, 2, 3) the ends of straight lines."""

WIRES = 8
"""Lines along a round side. Lines cost most where the browser has no graphics card."""

DASH_M = 0.015
"""Length of a dash, and of the gap after it."""

LIFT_M = 0.0008
"""Lines lie this far off the surface, so that it does not cover half of them."""


def part_mesh(shape: Shape) -> tuple[Vertices, Faces]:
    """A closed mesh whose normals, taken at its vertices, are smooth along a round side only."""
    if isinstance(shape, Box):
        return _box_mesh(shape)
    low, high = _rings(shape)
    middles = [ring.mean(axis=0, keepdims=True) for ring in (low, high)]
    vertices = np.concatenate([low, high, low, high, *middles])
    i = np.arange(SIDES)
    k = (i + 1) % SIDES
    faces = np.concatenate(
        [
            np.column_stack([i, k, SIDES + i]),
            np.column_stack([k, SIDES + k, SIDES + i]),
            np.column_stack([2 * SIDES + i, 2 * SIDES + k, np.full(SIDES, 4 * SIDES)]),
            np.column_stack([3 * SIDES + i, 3 * SIDES + k, np.full(SIDES, 4 * SIDES + 1)]),
        ]
    )
    return _outward(vertices, faces)


def rim_lines(shape: Shape) -> Segments:
    """The creases of a shape: both rims of a round one, the twelve edges of a box."""
    if isinstance(shape, Box):
        return _box_edges(shape)
    rings = np.stack(_rings(shape, LIFT_M))
    return _single(np.stack([rings, np.roll(rings, -1, axis=1)], axis=2).reshape(-1, 2, 3))


def wire_lines(shape: Shape) -> Segments:
    """Lines along a round side; none on a box."""
    if isinstance(shape, Box):
        return np.zeros((0, 2, 3), dtype=np.float32)
    low, high = _rings(shape, LIFT_M)
    step = SIDES // WIRES
    return _single(np.stack([low[::step], high[::step]], axis=1))


@dataclass(frozen=True, eq=False)
class Outline:
    """The sides of a body's round parts, from which an eye picks two lines each.

    part:    (G,) the part each round side belongs to.
    low:     (G, SIDES, 3) its first rim.  high: its second.
    normals: (G, SIDES, 3) outward, of the strip between a rim point and the next.
    """

    part: NDArray[np.int64]
    low: Array
    high: Array
    normals: Array

    @classmethod
    def of(cls, body: Body) -> Outline:
        shapes = [(i, p.shape) for i, p in enumerate(body.parts) if not isinstance(p.shape, Box)]
        rings = [_rings(shape, LIFT_M) for _, shape in shapes]
        low = np.array([ring[0] for ring in rings]).reshape(-1, SIDES, 3)
        high = np.array([ring[1] for ring in rings]).reshape(-1, SIDES, 3)
        along = high - low
        normals = np.cross(np.roll(low, -1, axis=1) - low, along)
        middle = (low + high).mean(axis=1, keepdims=True) / 2
        inward = np.einsum("gsi,gsi->gs", normals, (low + high) / 2 - middle) < 0
        normals[inward] *= -1
        return cls(np.array([i for i, _ in shapes], dtype=np.int64), low, high, normals)

    def lines(self, Ts_camera_part: Array, direction: Array | None = None) -> Segments:
        """The two lines (G, 2, 2, 3), camera frame, where each round side turns away.

        direction: (3,) that of parallel rays in the camera frame; None for rays from the camera.
        A side seen end-on has no such line; it gets a dot on its rim instead.
        """
        T = Ts_camera_part[self.part]
        R, p = T[:, :3, :3], T[:, :3, 3]
        if direction is None:
            # Seen from the part: the rays start at the camera's origin.
            eye = -np.einsum("gji,gj->gi", R, p)
            rays = self.low - eye[:, None]
        else:
            rays = np.einsum("gji,j->gi", R, direction)[:, None]
        away = (self.normals * rays).sum(axis=2) > 0
        turns = away != np.roll(away, 1, axis=1)
        order = np.argsort(~turns, axis=1, kind="stable")[:, :2]
        at = np.arange(len(order))[:, None]
        seen = turns[at, order]
        starts, ends = self.low[at, order], self.high[at, order]
        ends = np.where(seen[..., None], ends, starts + _DOT)
        both = np.stack([starts, ends], axis=2)
        return _single(np.einsum("gij,gksj->gksi", R, both) + p[:, None, None])


def _rings(shape: Shape, lift: float = 0.0) -> tuple[Array, Array]:
    """The rims (SIDES, 3) of a round shape at its two ends, `lift` off its surface."""
    assert not isinstance(shape, Box)
    if shape.kind == "cylinder":
        radii = ((shape.radius_m, shape.radius_m),) * 2
    else:
        radii = (shape.start_radii_m, shape.end_radii_m)
    turn = np.arange(SIDES) * (2 * np.pi / SIDES)
    outward = np.sign(shape.start_m - shape.end_m) * lift
    low, high = (
        np.column_stack([(rx + lift) * np.cos(turn), np.full(SIDES, y), (rz + lift) * np.sin(turn)])
        for y, (rx, rz) in zip((shape.start_m + outward, shape.end_m - outward), radii, strict=True)
    )
    return low, high


_DOT = np.array([0.0, 1e-5, 0.0])
_CORNERS = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=np.float64)
_BOX_SIDES = np.array(
    [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
)


def _box_mesh(shape: Box) -> tuple[Vertices, Faces]:
    """Four vertices of its own for every side, so that each is flat."""
    low, high = np.array(shape.low_m), np.array(shape.high_m)
    vertices = (low + _CORNERS * (high - low))[_BOX_SIDES].reshape(-1, 3)
    first = np.arange(6)[:, None] * 4
    faces = np.concatenate([first + np.array([0, 1, 2]), first + np.array([0, 2, 3])])
    return _outward(vertices, faces)


def _box_edges(shape: Box) -> Segments:
    low, high = np.array(shape.low_m) - LIFT_M, np.array(shape.high_m) + LIFT_M
    corners = low + _CORNERS * (high - low)
    ends = [(i, i | bit) for i in range(8) for bit in (1, 2, 4) if not i & bit]
    return _single(corners[np.array(ends)])


def _outward(vertices: Array, faces: NDArray[np.int64]) -> tuple[Vertices, Faces]:
    """Turn every face away from the middle of the (convex) shape."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    outside = np.einsum("fi,fi->f", np.cross(b - a, c - a), (a + b + c) / 3 - vertices.mean(0))
    turned = np.where((outside < 0)[:, None], faces[:, ::-1], faces)
    return vertices.astype(np.float32), turned.astype(np.uint32)


def _single(segments: Array) -> Segments:
    return np.ascontiguousarray(segments, dtype=np.float32)


def trail_lines(p_camera: Array, present: int) -> Segments:
    """A way (N, 3) as lines: whole up to the point `present`, dashed after it."""
    steps = np.stack([p_camera[:-1], p_camera[1:]], axis=1)
    return _single(np.concatenate([steps[:present], _dashed(p_camera[max(present, 0) :])]))


def _dashed(p_camera: Array) -> Array:
    """Pieces (M, 2, 3) of a way (N, 3), of even length with gaps as long."""
    if len(p_camera) < 2:
        return np.zeros((0, 2, 3))
    lengths = np.linalg.norm(np.diff(p_camera, axis=0), axis=1)
    run = np.concatenate([[0.0], np.cumsum(lengths)])
    count = int(np.clip(run[-1] / (2 * DASH_M), 1, 2000))
    at = np.linspace(0.0, run[-1], 2 * count + 1)[:-1].reshape(-1, 2)
    return np.stack([np.interp(at, run, p_camera[:, k]) for k in range(3)], axis=-1)
