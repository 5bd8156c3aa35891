"""The body's outline in one picture: where colour says that the body ends.

Near the posed body, histograms give each part's colours and those of its background. Across every
edge of the posed body runs a short line; along it, the likelihood that the colours change from the
part's to the others' gives the place of the edge and its variance (region-based tracking
by correspondence lines, Stoiber et al. 2020).
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.raster import BodyMesh, Raster, raster
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.geometry.view import ViewCamera

SIDE = 16
"""Colour steps along each axis of a histogram."""
NEAR_M = 0.14
"""How far around the body its background colours are learnt."""
RIM_PX = 3
CORE_PX = 2
"""What is left out on both sides of the body's edge where colours are learnt."""
AROUND_PX = 40
"""What is cut out around the body: enough for its background, and for poses nearby."""
GAP_M = 0.03
"""At an edge, what lies behind is at least so much further away."""
LEAST_LIKELY = 2e-4
CLEAREST = 3.0
"""Odds are cut at exp of this: no pixel alone decides an edge."""
TEMPER = 6.0
"""Neighbouring pixels share their colour: so many count as one."""
EVERY = 4
"""One contour pixel of so many has a line."""
CLEAR_REACH_M = 0.055
CLEAR_M = 0.02
"""An edge is clear where it is placed as well as the latter, sought so far to both sides."""
MOST_SPREAD = 0.8
"""A line whose edge may lie nearly anywhere on it (share of a uniform variance) is not used."""


@dataclass(frozen=True, eq=False)
class Colours:
    """Likelihood (P + 1, SIDE³) of every colour on each part, and behind the body (last row)."""

    likely: Array


@dataclass(frozen=True, eq=False)
class Edges:
    """M places on the posed body's edges, and where the picture has the edge.

    p_camera (M, 3), part (M,), normal (M, 2) outward in the picture.
    away_px (M,): how far outward the edge is seen; variance (M,) of that; located (M,): whether it
    is seen at all.
    """

    p_camera: Array
    part: NDArray[np.int64]
    normal: Array
    away_px: Array
    variance: Array
    located: NDArray[np.bool_]


def colour_steps(rgb: NDArray[np.uint8]) -> NDArray[np.int64]:
    """(H, W) number of every pixel's cell in a histogram."""
    cells = (rgb // (256 // SIDE)).astype(np.int64)
    return np.asarray((cells[..., 0] * SIDE + cells[..., 1]) * SIDE + cells[..., 2])


@dataclass(frozen=True, eq=False)
class Outline:
    """A cut of one picture about the body.

    pixel_m: length that one pixel spans at the body's distance.
    corner: pixel (u, v) of the whole picture at which the cut begins.
    steps (H, W): number of every pixel's colour.  usable (H, W): which pixels may be used.
    """

    skeleton: Skeleton
    camera: Camera
    mesh: BodyMesh
    view: ViewCamera
    pixel_m: float
    corner: tuple[int, int]
    steps: NDArray[np.int64]
    usable: NDArray[np.bool_]

    @classmethod
    def of(
        cls,
        skeleton: Skeleton,
        camera: Camera,
        rgb: NDArray[np.uint8],
        usable: NDArray[np.bool_],
        pose: Pose,
    ) -> Outline | None:
        """The cut of a picture (H, W, 3) about a pose; None where the body is not within it."""
        mesh, view = BodyMesh.of(skeleton), ViewCamera.of(camera)
        uv = view.project(mesh.posed(pose_transforms(skeleton, pose)))
        if not np.isfinite(uv).all():
            return None
        size = (camera.width, camera.height)
        low = np.clip(np.floor(uv.min(axis=0)) - AROUND_PX, 0, size).astype(int)
        high = np.clip(np.ceil(uv.max(axis=0)) + AROUND_PX, 0, size).astype(int)
        (left, top), (right, bottom) = low.tolist(), high.tolist()
        if min(right - left, bottom - top) < 2 * AROUND_PX:
            return None
        cut = (slice(top, bottom), slice(left, right))
        view = view.cropped(left, top, right - left, bottom - top)
        depth = float(camera.depth(pose.p_camera_root))
        pixel_m = depth / float(np.sqrt(camera.fx * camera.fy))
        steps = colour_steps(rgb[cut])
        return cls(skeleton, camera, mesh, view, pixel_m, (left, top), steps, usable[cut])

    def pixels(self, length_m: float) -> int:
        """A length at the body's distance, two pixels at least."""
        return max(2, round(length_m / self.pixel_m))

    def draw(self, pose: Pose) -> Raster:
        """The body as posed."""
        return raster(self.mesh, pose_transforms(self.skeleton, pose), self.view)

    def colours(self, shown: Raster) -> Colours:
        """The colours of each part and of what lies behind, where the body is drawn."""
        body = (shown.part >= 0).astype(np.uint8)
        near, rim = _dilate(body, self.pixels(NEAR_M)) > 0, _dilate(body, RIM_PX) > 0
        behind = _histogram(self.steps[near & ~rim & self.usable])
        likely = [self._part_histogram(shown, i, behind) for i in range(self.skeleton.part_count)]
        return Colours(np.stack([*likely, behind]))

    def _part_histogram(self, shown: Raster, part: int, behind: Array) -> Array:
        own = (shown.part == part) & self.usable
        core = cv2.erode(own.astype(np.uint8), _square(CORE_PX)) > 0
        inside = core if core.sum() >= 30 else own
        return _histogram(self.steps[inside]) if inside.any() else behind

    def edges(self, shown: Raster, colours: Colours, reach_m: float) -> Edges:
        """Where the picture has the edges of the body as drawn, up to reach_m away."""
        reach_px = self.pixels(reach_m)
        v, u, part, behind = _contour_pixels(shown)
        normal = _outward_normals(shown, v, u, part)
        kept = np.linalg.norm(normal, axis=1) > 0.5
        v, u, part, behind, normal = v[kept], u[kept], part[kept], behind[kept], normal[kept]
        along = np.arange(-reach_px, reach_px + 1)
        odds = self._line_odds(colours, v, u, part, behind, normal, along)
        sums = np.cumsum(odds, axis=1)
        chance = (2 * sums - sums[:, -1:]) / TEMPER
        chance = np.exp(chance - chance.max(axis=1, keepdims=True, initial=-np.inf))
        chance /= chance.sum(axis=1, keepdims=True)
        away = chance @ along.astype(float)
        variance = (chance * (along - away[:, None]) ** 2).sum(axis=1)
        uv = np.stack([u, v], axis=1) + np.array(self.corner, dtype=float)
        p = self.camera.back_project(uv, shown.depth[v, u].astype(float))
        located = variance < MOST_SPREAD * (2 * reach_px + 1) ** 2 / 12
        return Edges(p, part, normal, away, variance, located)

    def _line_odds(
        self,
        colours: Colours,
        v: NDArray[np.int64],
        u: NDArray[np.int64],
        part: NDArray[np.int64],
        behind: NDArray[np.int64],
        normal: Array,
        along: NDArray[np.int64],
    ) -> Array:
        """(M, 2·reach + 1) log odds that a pixel of a line is the part and not what is behind."""
        height, width = self.steps.shape
        U = np.rint(u[:, None] + normal[:, :1] * along).astype(np.int64)
        V = np.rint(v[:, None] + normal[:, 1:] * along).astype(np.int64)
        inside = (np.minimum(U, V) >= 0) & (width > U) & (height > V)
        U, V = np.clip(U, 0, width - 1), np.clip(V, 0, height - 1)
        steps = self.steps[V, U]
        ours = colours.likely[part[:, None], steps] + LEAST_LIKELY
        theirs = colours.likely[behind[:, None], steps] + LEAST_LIKELY
        odds = np.clip(np.log(ours / theirs), -CLEAREST, CLEAREST)
        return np.asarray(np.where(inside & self.usable[V, U], odds, 0.0))


def separation(outline: Outline, pose: Pose) -> float:
    """Share of the edges of a pose, hands and feet left out, that colour can place."""
    shown = outline.draw(pose)
    edges = outline.edges(shown, outline.colours(shown), CLEAR_REACH_M)
    own = np.isin(edges.part, outline.skeleton.dof_part)
    clear = edges.located & (edges.variance < (CLEAR_M / outline.pixel_m) ** 2)
    return float(clear[own].mean()) if own.any() else 0.0


def gain(outline: Outline, before: Pose, after: Pose) -> float:
    """By how much likelier (nats, mean) `after` makes the pixels that the two explain
    otherwise.

    Colours are learnt from both alike, so that neither is scored by its own.
    """
    first, second = outline.draw(before), outline.draw(after)
    likely = 0.5 * (outline.colours(first).likely + outline.colours(second).likely) + LEAST_LIKELY
    either = ((first.part >= 0) | (second.part >= 0)) & outline.usable
    if not either.any():
        return 0.0
    steps = outline.steps[either]
    odds = np.log(likely[second.part[either], steps] / likely[first.part[either], steps])
    return float(np.clip(odds, -CLEAREST, CLEAREST).mean())


def _contour_pixels(shown: Raster) -> tuple[NDArray[np.int64], ...]:
    """v, u, part and what is behind (the last row of Colours for none) of every EVERY-th pixel on
    an edge at which a part hides something further away."""
    part = shown.part.astype(np.int64)
    depth = np.where(part >= 0, shown.depth, np.float32(1e9))
    width, pixels = part.shape[1], []
    for before, after in (_neighbours(0), _neighbours(1)):
        for own, beyond in ((before, after), (after, before)):
            edge = (part[own] >= 0) & (part[beyond] != part[own])
            edge &= depth[beyond] > depth[own] + np.float32(GAP_M)
            v, u = np.nonzero(edge)
            at = (v + (own[0].start or 0)) * width + u + (own[1].start or 0)
            pixels.append(np.stack([at, part[own][v, u], part[beyond][v, u]]))
    every = np.concatenate(pixels, axis=1)
    _, first = np.unique(every[0], return_index=True)
    at, own_part, other_part = every[:, first[::EVERY]]
    return at // width, at % width, own_part, other_part


def _neighbours(axis: int) -> tuple[tuple[slice, slice], tuple[slice, slice]]:
    """Two cuts of a picture whose pixels are neighbours along an axis."""
    low, high, whole = slice(None, -1), slice(1, None), slice(None)
    return ((low, whole), (high, whole)) if axis == 0 else ((whole, low), (whole, high))


def _outward_normals(
    shown: Raster, v: NDArray[np.int64], u: NDArray[np.int64], part: NDArray[np.int64]
) -> Array:
    """(M, 2) unit normals, out of the part; zero where there is none."""
    normal = np.zeros((len(v), 2))
    for i in np.unique(part):
        at = part == i
        top, left = max(v[at].min() - 8, 0), max(u[at].min() - 8, 0)
        cut = shown.part[top : v[at].max() + 9, left : u[at].max() + 9] == i
        soft = cv2.GaussianBlur(cut.astype(np.float32), (0, 0), 2.0)
        for axis in (0, 1):
            slope = cv2.Scharr(soft, cv2.CV_32F, 1 - axis, axis)
            normal[at, axis] = -slope[v[at] - top, u[at] - left]
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    return np.asarray(np.where(length > 1e-4, normal / np.maximum(length, 1e-4), 0.0))


def _histogram(steps: NDArray[np.int64]) -> Array:
    """(SIDE³,) share of every colour, smoothed over neighbouring ones."""
    counts = np.bincount(steps, minlength=SIDE**3).astype(float).reshape(SIDE, SIDE, SIDE)
    for axis in range(3):
        padded = np.pad(counts, [(int(a == axis),) * 2 for a in range(3)], mode="edge")
        low, high = np.take(padded, range(SIDE), axis), np.take(padded, range(2, SIDE + 2), axis)
        counts = 0.5 * counts + 0.25 * low + 0.25 * high
    return np.asarray((counts / max(counts.sum(), 1e-12)).ravel())


def _dilate(mask: NDArray[np.uint8], by_px: int) -> NDArray[np.uint8]:
    return np.asarray(cv2.dilate(mask, _square(by_px)), np.uint8)


def _square(reach: int) -> NDArray[np.uint8]:
    return np.ones((2 * reach + 1, 2 * reach + 1), np.uint8)
