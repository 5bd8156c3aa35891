"""Cut a piece of a picture that turns, and find it at any place, turn and scale."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.kernels.settling import settle
from keypose.tracker.solver.sigmas import PATCH_GREY2, PATCH_STRAY
from keypose.tracker.tracking.initial.templates.search import Template, cut
from keypose.tracker.video.pyramid import USABLE, FloatPicture

STEP_RAD = np.radians(3.0)
"""Turns are rounded to this: less hardly changes a small template."""


@dataclass(eq=False)
class Rotatable:
    """The surroundings of a place in one picture, as templates at any angle in the picture's plane.

    picture: (h, w, 4) as in a clip, in grey levels. wanted: (h, w) the pixels that count.
    uv: (2,) the place.
    """

    picture: FloatPicture
    wanted: NDArray[np.bool_]
    uv: Array
    half: int
    _templates: dict[int, Template | None] = field(default_factory=dict)

    def at(self, turn_rad: float) -> Template | None:
        """The template turned from the picture's u axis towards its v axis; None where too little
        of the place is to be seen."""
        step = round(turn_rad / STEP_RAD)
        if step not in self._templates:
            self._templates[step] = self._cut(step * STEP_RAD)
        return self._templates[step]

    def _cut(self, turn_rad: float) -> Template | None:
        side, middle = 2 * self.half + 1, float(self.half)
        c, s = np.cos(turn_rad), np.sin(turn_rad)
        back = np.array([[c, s], [-s, c]])  # from the template to the picture
        warp = np.column_stack([back, self.uv - back @ (middle, middle)])
        flags = cv2.WARP_INVERSE_MAP | cv2.INTER_LINEAR
        grey = cv2.warpAffine(
            np.ascontiguousarray(self.picture[..., 0]),
            warp,
            (side, side),
            flags=flags,
            borderMode=cv2.BORDER_REPLICATE,
        )
        counts = ((self.picture[..., 3] == USABLE) & self.wanted).astype(np.float32)
        counts = cv2.warpAffine(counts, warp, (side, side), flags=flags)
        piece = np.zeros((side, side, 4), np.float32)
        piece[..., 0], piece[..., 3] = grey, np.where(counts > 0.5, USABLE, 0.0)
        return cut(piece, np.array([middle, middle]), self.half, counts > 0.5)


MARGIN = 1.45
"""A patch is cut this many times as wide as it is compared, so that it can turn."""
SOFT_SHARE = 0.7
LEAST_SOFT = 5.0
"""Difference beyond which a pixel counts less: as a share of the patch's contrast, grey levels."""
LEAST_PIXELS = 40
SOLVES = 8


Place: TypeAlias = tuple[float, float, float, float]
"""u, v, turn, log scale."""


@dataclass(frozen=True)
class PatchMatch:
    """Where a patch was found: u, v in pixels, turn in radians, log scale.

    alike: the mean weight of its pixels, 0 to 1. correlation: of its brightness with the picture's,
    −1 to 1. sigma: pixels.
    """

    place: Place
    alike: float
    correlation: float
    sigma: float

    @property
    def uv(self) -> Array:
        return np.array(self.place[:2])

    @property
    def turn(self) -> float:
        return self.place[2]


@dataclass(frozen=True, eq=False)
class Patch:
    """The surroundings of a point, as one frame shows them.

    piece: (S, S, 4) as a picture of a clip, the point in its middle; what does not count is
        ignored. turned: the same for the searches. xy (K, 2), values (K,): its pixels from the
        middle and their brightness. soft: grey levels beyond which a pixel counts less.
    """

    piece: FloatPicture
    turned: Rotatable
    xy: NDArray[np.float32]
    values: NDArray[np.float32]
    soft: float

    @classmethod
    def cut(
        cls,
        picture: FloatPicture,
        place: Place,
        half: int,
        counts: NDArray[np.bool_],
    ) -> Patch | None:
        """What lies about a place of a picture, turned upright; None where too little
        counts.

        counts: (h, w) the picture's pixels that count, or (S, S) those of the piece.
        """
        wide = int(np.ceil(MARGIN * half))
        side = 2 * wide + 1
        warp = _warp(place, wide)
        flags = cv2.WARP_INVERSE_MAP | cv2.INTER_LINEAR
        upright = cv2.warpAffine(picture, warp, (side, side), flags=flags)
        if counts.shape != (side, side):
            flat = cv2.warpAffine(counts.astype(np.float32), warp, (side, side), flags=flags)
            counts = flat > 0.5
        counts = counts & (upright[..., 3] > 0.99 * USABLE)
        piece = np.ascontiguousarray(upright, np.float32)
        piece[..., 3] = np.where(counts, USABLE, 0.0)
        turned = Rotatable(piece, counts, np.array([wide, wide], np.float64), half)
        template = turned.at(0.0)
        if template is None:
            return None
        v, u = np.nonzero(counts)
        near = (np.abs(u - wide) <= half) & (np.abs(v - wide) <= half)
        if near.sum() < LEAST_PIXELS:
            return None
        xy = np.column_stack([u - wide, v - wide])[near].astype(np.float32)
        soft = max(LEAST_SOFT, SOFT_SHARE * template.contrast)
        return cls(piece, turned, xy, piece[v[near], u[near], 0], soft)

    def renew(self, picture: FloatPicture, place: Place) -> Patch | None:
        """The same patch as another picture shows it."""
        return Patch.cut(picture, place, self.turned.half, self.turned.wanted)

    def refine(self, picture: FloatPicture, place: Place) -> PatchMatch:
        """Its place to a fraction of a pixel, from a start at most a few pixels away."""
        at, spread = np.array(place, np.float64), np.empty(2)
        alike = settle(
            picture,
            self.xy,
            self.values,
            at,
            PATCH_GREY2 / PATCH_STRAY**2,
            self.soft,
            SOLVES,
            spread,
        )
        u, v, turn, scale = at.tolist()
        place = (u, v, turn, scale)
        sigma = float(np.sqrt(PATCH_GREY2 * spread.mean()))
        return PatchMatch(place, float(alike), self._correlation(picture, place), sigma)

    def _correlation(self, picture: FloatPicture, place: Place) -> float:
        """How the brightness of the patch and that of the picture at a place go together."""
        u, v, turn, log_scale = place
        c, s = np.exp(log_scale) * np.cos(turn), np.exp(log_scale) * np.sin(turn)
        columns = (u + c * self.xy[:, 0] - s * self.xy[:, 1]).astype(np.float32)
        rows = (v + s * self.xy[:, 0] + c * self.xy[:, 1]).astype(np.float32)
        left, top = max(int(columns.min()), 0), max(int(rows.min()), 0)
        near = picture[top : int(rows.max()) + 2, left : int(columns.max()) + 2, 0]
        if not near.size:
            return 0.0
        brightness = cv2.remap(near, columns - left, rows - top, cv2.INTER_LINEAR).ravel()
        ours = self.values - self.values.mean()
        theirs = brightness - brightness.mean(dtype=np.float64)
        norm = np.sqrt((ours**2).sum() * (theirs**2).sum())
        return float((ours * theirs).sum() / norm) if norm > 0 else 0.0


def _warp(place: Place, wide: int) -> Array:
    """(2, 3) from the upright piece's pixels to the picture's."""
    u, v, turn, log_scale = place
    c, s = np.exp(log_scale) * np.array([np.cos(turn), np.sin(turn)])
    back = np.array([[c, -s], [s, c]])
    return np.column_stack([back, np.array([u, v]) - back @ (wide, wide)])
