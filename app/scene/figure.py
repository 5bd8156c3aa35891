"""The parts of a body as the page's views draw them: smooth meshes, rims, wires, outlines.

Everything is in the frame of its own part, metres, single precision, as viser sends it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.body import Body
from keypose.tracker.body.shapes import SIDES, Shape
from keypose.tracker.geometry.rotations import Array

Vertices: TypeAlias = NDArray[np.float32]
Mask: TypeAlias = NDArray[np.bool_]
Faces: TypeAlias = NDArray[np.uint32]
Segments: TypeAlias = NDArray[np.float32]
"""(N, 2, 3) the ends of straight lines."""

DASH_M = 0.015
"""Length of a dash, and of the gap after it."""

LIFT_M = 0.0008
"""Lines lie this far off the surface, so that it does not cover half of them."""


def part_mesh(shape: Shape) -> tuple[Vertices, Faces]:
    """A closed mesh whose normals, taken at its vertices, are smooth along a round side only."""
    mesh = shape.mesh()
    # A vertex on a crease is there once for each side that meets in it.
    of_side = mesh.faces + len(mesh.vertices) * mesh.sides[:, None]
    own, faces = np.unique(of_side, return_inverse=True)
    vertices = mesh.vertices[own % len(mesh.vertices)]
    return vertices.astype(np.float32), faces.reshape(-1, 3).astype(np.uint32)


def hull_mesh(shape: Shape, lift_m: float) -> tuple[Vertices, Faces]:
    """A closed mesh lying so far outside of a part's, faces outward."""
    mesh = shape.mesh()
    corners = mesh.vertices[mesh.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = normals / np.where(lengths > 0, lengths, 1.0)
    # Every side that meets in a vertex counts once, into however many triangles it is cut.
    at_vertex = np.column_stack([mesh.faces.ravel(), np.repeat(normals.round(3), 3, axis=0)])
    meeting = np.unique(at_vertex, axis=0)
    ways = np.zeros_like(mesh.vertices)
    np.add.at(ways, meeting[:, 0].astype(int), meeting[:, 1:])
    ways /= np.maximum(np.linalg.norm(ways, axis=1, keepdims=True), 1e-9)
    lifted = mesh.vertices + lift_m * ways
    return lifted.astype(np.float32), mesh.faces.astype(np.uint32)


def rim_lines(shape: Shape) -> Segments:
    """The creases of a shape, such as the rims of a round one, the edges of a box."""
    return _single(shape.wireframe(LIFT_M).creases)


def wire_lines(shape: Shape) -> Segments:
    """Lines along a round side; none where nothing is round."""
    lines, _ = shape.wireframe(LIFT_M).along()
    return _single(lines)


@dataclass(frozen=True, eq=False)
class Outline:
    """The strips of a body's round sides, from which silhouette lines are picked for a viewpoint.

    strip_part: (G,) the part each strip belongs to.
    low:     (G, SIDES, 3) its first ring.  high: its second.
    normals: (G, SIDES, 3) outward, of a strip between a ring's point and the next.
    seams:   (Q, 2) strips of one part that meet: the second of the first is the first of the other.
    """

    strip_part: NDArray[np.int64]
    low: Array
    high: Array
    normals: Array
    seams: NDArray[np.int64]

    @classmethod
    def of(cls, body: Body) -> Outline:
        rings = [part.shape.wireframe(LIFT_M).rings for part in body.parts]
        counts = [max(len(each) - 1, 0) for each in rings]
        part = np.repeat(np.arange(len(rings)), counts)
        low = np.concatenate([each[:-1] for each in rings])
        high = np.concatenate([each[1:] for each in rings])
        along = high - low
        normals = np.cross(np.roll(low, -1, axis=1) - low, along)
        middle = (low + high).mean(axis=1, keepdims=True) / 2
        inward = np.einsum("gsi,gsi->gs", normals, (low + high) / 2 - middle) < 0
        normals[inward] *= -1
        first = np.flatnonzero(part[1:] == part[:-1])
        return cls(part, low, high, normals, np.column_stack([first, first + 1]))

    @property
    def part(self) -> NDArray[np.int64]:
        """(L,) the part each of the `lines` belongs to."""
        of_seams = np.repeat(self.strip_part[self.seams[:, 0]], SIDES)
        return np.concatenate([np.repeat(self.strip_part, 2), of_seams])

    def lines(self, Ts_camera_part: Array, direction: Array | None = None) -> Segments:
        """The lines (L, 2, 3), camera frame, where round sides turn away: two along each strip,
        and around each seam those between a strip that does and one that does not.

        direction: (3,) that of parallel rays in the camera frame; None for rays from the camera.
        Always as many: in the place of those that are not seen there is one of their part that is,
        and of a part without any, such as a side seen end-on, a dot on the rim.
        """
        T = Ts_camera_part[self.strip_part]
        R, p = T[:, :3, :3], T[:, :3, 3]
        if direction is None:
            # Seen from the part: the rays start at the camera's origin.
            viewpoint = -np.einsum("gji,gj->gi", R, p)
            rays = self.low - viewpoint[:, None]
        else:
            rays = np.einsum("gji,j->gi", R, direction)[:, None]
        away = (self.normals * rays).sum(axis=2) > 0
        (ends, seen), (around, seen_around) = self._along(away), self._around(away)
        lines = self._filled_up(np.concatenate([ends, around]), np.append(seen, seen_around))
        T = Ts_camera_part[self.part]
        return _single(np.einsum("lij,lkj->lki", T[:, :3, :3], lines) + T[:, None, :3, 3])

    def _along(self, away: Mask) -> tuple[Array, Mask]:
        """(2 G, 2, 3) lines along the strips, in their parts' frames; which of them are seen."""
        turns = away != np.roll(away, 1, axis=1)
        order = np.argsort(~turns, axis=1, kind="stable")[:, :2]
        at = np.arange(len(order))[:, None]
        ends = np.stack([self.low[at, order], self.high[at, order]], axis=2)
        return ends.reshape(-1, 2, 3), turns[at, order].ravel()

    def _around(self, away: Mask) -> tuple[Array, Mask]:
        """(SIDES Q, 2, 3) lines around the seams, likewise."""
        first, second = self.seams.T
        ring = self.low[second]
        ends = np.stack([ring, np.roll(ring, -1, axis=1)], axis=2)
        return ends.reshape(-1, 2, 3), (away[first] != away[second]).ravel()

    def _filled_up(self, lines: Array, seen: Mask) -> Array:
        """Lines (L, 2, 3) with others in the place of those that are not seen."""
        seen_first = np.lexsort((~seen, self.part))
        _, first, number = np.unique(self.part[seen_first], return_index=True, return_inverse=True)
        stand_in = np.empty(len(lines), dtype=np.int64)
        stand_in[seen_first] = seen_first[first[number]]
        at = np.where(seen | ~seen[stand_in], np.arange(len(lines)), stand_in)
        starts = lines[at, 0]
        ends = np.where(seen[at, None], lines[at, 1], starts + _DOT)
        return np.stack([starts, ends], axis=1)


_DOT = np.array([0.0, 1e-5, 0.0])


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
