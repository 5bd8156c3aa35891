"""The wire picture: outlines and rings as smooth lines, what lies behind drawn fainter."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.app.render.palette import INK, SIDE_COLOURS, WHITE, Canvas, Colour, Side, on_canvas
from keypose.app.render.shading import CREASE_COSINE, Mask, face_normals
from keypose.tracker.body.raster import BodyMesh, Raster
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.geometry.view import ViewCamera

OCCLUDED_OPACITY = 0.28
DEPTH_SLACK_M = 0.02
"""A line counts as seen when it lies at most this far behind the surface in front of it."""

PIECE_PX = 6.0
SHIFT = 4
"""OpenCV draws at fractions of 1/2**SHIFT pixel."""

Coverage: TypeAlias = NDArray[np.uint8]


@dataclass(frozen=True, eq=False)
class BodyEdges:
    """The edges of a body's mesh that can become lines.

    ends:  (E, 2) vertex indices.
    faces: (E, 2) the two faces that meet there.
    sharp: (E,) True where they meet at a crease.
    """

    ends: NDArray[np.int64]
    faces: NDArray[np.int64]
    sharp: Mask

    @classmethod
    def of(cls, mesh: BodyMesh) -> BodyEdges:
        sides = np.concatenate(
            [mesh.faces[:, [0, 1]], mesh.faces[:, [1, 2]], mesh.faces[:, [2, 0]]]
        )
        face = np.tile(np.arange(len(mesh.faces)), 3)
        sides.sort(axis=1)
        order = np.lexsort(sides.T)
        ends, faces = sides[order][::2], face[order].reshape(-1, 2)  # closed: every edge twice
        normals = face_normals(mesh.vertices, mesh.faces)
        cosine = np.einsum("ei,ei->e", normals[faces[:, 0]], normals[faces[:, 1]])
        return cls(ends, faces, cosine < CREASE_COSINE)


@dataclass(frozen=True, eq=False)
class Lines:
    """Short straight pieces of line.

    uv:     (N, 2, 2) their ends, pixels.
    part:   (N,) the part they belong to.
    hidden: (N,) True where something is in front.
    """

    uv: Array
    part: NDArray[np.int64]
    hidden: Mask


def body_lines(
    mesh: BodyMesh, edges: BodyEdges, Ts_camera_part: Array, view: ViewCamera, raster: Raster
) -> Lines:
    """Outlines and creases of every part, cut into pieces that are wholly seen or wholly hidden."""
    p_eye = mesh.posed(view.T_view_camera @ Ts_camera_part)
    toward = _facing(mesh, p_eye, view)[edges.faces]
    outline = np.logical_xor(toward[:, 0], toward[:, 1])
    drawn = outline | edges.sharp
    own_back = ~(toward[:, 0] | toward[:, 1])[drawn]
    ends = p_eye[edges.ends[drawn]]
    part = mesh.vertex_part[edges.ends[drawn, 0]]
    pieces, of_edge = _cut(*_before(ends, view), view)
    behind = _is_behind(pieces.mean(axis=1), view, raster)
    uv = view.project(pieces)
    visible = np.isfinite(uv).all(axis=(1, 2)) & (np.abs(uv) < 30_000).all(axis=(1, 2))
    return Lines(uv[visible], part[of_edge][visible], (behind | own_back[of_edge])[visible])


def _facing(mesh: BodyMesh, p_eye: Array, view: ViewCamera) -> Mask:
    """Which faces (F,) face the camera."""
    normals = face_normals(p_eye, mesh.faces)
    rays = view.rays(p_eye[mesh.faces[:, 0]])
    facing: Mask = (normals * rays).sum(axis=1) < 0.0
    return facing


def _before(ends: Array, view: ViewCamera) -> tuple[Array, NDArray[np.int64]]:
    """Edges (N, 2, 3) cut off at the near plane, without those that lie wholly nearer."""
    z, near = ends[..., 2], view.near_m
    visible = np.flatnonzero((z >= near).any(axis=1))
    if not np.isfinite(near):
        return ends, visible
    cut = ends[visible].copy()
    for this, beyond in ((0, 1), (1, 0)):
        short = cut[:, this, 2] < near
        a, b = cut[short, this], cut[short, beyond]
        share = (near - a[:, 2]) / (b[:, 2] - a[:, 2])
        cut[short, this] = a + share[:, None] * (b - a)
        cut[short, this, 2] = near
    return cut, visible


def _cut(
    ends: Array, names: NDArray[np.int64], view: ViewCamera
) -> tuple[Array, NDArray[np.int64]]:
    """Pieces (M, 2, 3) of edges (N, 2, 3), each a few pixels long, and the name of its edge."""
    uv = view.project(ends)
    length = np.linalg.norm(uv[:, 1] - uv[:, 0], axis=1)
    counts = np.clip(np.ceil(np.nan_to_num(length) / PIECE_PX), 1, 200).astype(np.int64)
    edge = np.repeat(np.arange(len(ends)), counts)
    number = np.arange(len(edge)) - np.repeat(np.cumsum(counts) - counts, counts)
    shares = (number[:, None] + np.array([0.0, 1.0])) / counts[edge][:, None]
    start, step = ends[edge, :1], ends[edge, 1:] - ends[edge, :1]
    return start + shares[:, :, None] * step, names[edge]


def _is_behind(p_eye: Array, view: ViewCamera, raster: Raster) -> Mask:
    """Which points (M, 3) lie behind the surface seen there, one pixel of tolerance
    included.
    """
    depth = cv2.dilate(np.minimum(raster.depth, 1e6), np.ones((3, 3), np.uint8))
    uv = np.rint(np.nan_to_num(view.project(p_eye), nan=-1.0))
    inside = (uv >= 0).all(axis=1) & (uv < (view.width, view.height)).all(axis=1)
    behind = np.zeros(len(p_eye), dtype=bool)
    u, v = uv[inside].astype(np.int64).T
    behind[inside] = p_eye[inside, 2] > depth[v, u] + DEPTH_SLACK_M
    return behind


def paint_lines(
    canvas: Canvas,
    lines: Lines,
    sides: tuple[Side, ...],
    thickness: int,
    colours: Mapping[Side, Colour] = SIDE_COLOURS,
) -> None:
    """Draw lines over a canvas in place, seen ones with a dark halo under them."""
    side = np.array(sides)[lines.part]
    _blend(canvas, INK, 0.35, _coverage(canvas, lines.uv[~lines.hidden], thickness + 2))
    for name, colour in colours.items():
        for hidden, opacity in ((True, OCCLUDED_OPACITY), (False, 1.0)):
            chosen = (side == name) & (lines.hidden == hidden)
            _blend(canvas, colour, opacity, _coverage(canvas, lines.uv[chosen], thickness))


def paint_dots(canvas: Canvas, uv: Array, radius: float) -> None:
    """White dots with a dark rim at pixels (N, 2), over a canvas in place."""
    for colour, size in ((INK, radius * 1.5), (WHITE, radius)):
        mask = np.zeros(canvas.shape[:2], np.uint8)
        for u, v in uv[np.isfinite(uv).all(axis=1) & (np.abs(uv) < 30_000).all(axis=1)]:
            centre = (round(u * 2**SHIFT), round(v * 2**SHIFT))
            cv2.circle(mask, centre, round(size * 2**SHIFT), 255, -1, cv2.LINE_AA, SHIFT)
        _blend(canvas, colour, 1.0, mask)


def _coverage(canvas: Canvas, uv: Array, thickness: int) -> Coverage:
    """How much of every pixel (H, W) the pieces (N, 2, 2) cover, 0 to 255."""
    mask = np.zeros(canvas.shape[:2], np.uint8)
    pieces = list(np.rint(uv * 2**SHIFT).astype(np.int32))
    cv2.polylines(mask, pieces, False, 255, thickness, cv2.LINE_AA, SHIFT)
    return mask


def _blend(canvas: Canvas, colour: Colour, opacity: float, coverage: Coverage) -> None:
    """Only what is covered is looked at: lines are thin."""
    touched = np.flatnonzero(coverage != 0)  # a mask of truth values is searched far quicker
    share = opacity * (coverage.reshape(-1)[touched] / 255.0)
    flat = canvas.reshape(-1, canvas.shape[2])
    before = flat[touched]
    flat[touched] = before + share[:, None] * (on_canvas(colour, canvas) - before)
