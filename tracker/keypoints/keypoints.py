"""Keypoints of one body over frames, whoever found them."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.geometry.steady import SteadyCamera
from keypose.tracker.keypoints.person_mask import PersonMask

if TYPE_CHECKING:
    from keypose.tracker.session.annotations import KeypointCorrection

JOINTS: Final = tuple(
    f"{side}_{joint}"
    for joint in ("shoulder", "elbow", "wrist", "hip", "knee", "ankle")
    for side in ("left", "right")
)
"""The names of the twelve joints that every detector of people knows."""
_SIDES: Final = {"left": "right", "right": "left"}


@dataclass(frozen=True, eq=False)
class Keypoints:
    """Keypoints of one body over consecutive frames.

    first_frame: of the video.
    names:       of the L keypoints: `JOINTS`, and others such as nose, left_heel.
    uv:          (N, L, 2) pixels of the video as it was filmed, lens distortion included; centres
                 at integers, NaN where nothing was found.
    visibility:  (N, L) from 0 to 1, how sure it is that the keypoint is seen; 0 where uv is NaN.
    p_hips:      (N, L, 3) metres, in axes parallel to the picture's (x right, y down, z away),
                 the middle of the hips at 0; NaN where unknown. None where no depth is known.
    by_hand:     (N, L) where a person decides, not the detector: of those set or said to be unseen,
                 and of those that another body covers. None where of none.
    depth_sigma_m: (N, L) standard deviation of p_hips along the view; NaN where that is unknown.
                 None where it is everywhere.
    masks:       N, where the person is in the picture; None in frames where that is unknown.
                 None where it is of all.
    """

    first_frame: int
    names: tuple[str, ...]
    uv: Array
    visibility: Array
    p_hips: Array | None = None
    by_hand: NDArray[np.bool_] | None = None
    masks: tuple[PersonMask | None, ...] | None = None
    depth_sigma_m: Array | None = None

    def __len__(self) -> int:
        return len(self.uv)

    @property
    def last_frame(self) -> int:
        return self.first_frame + len(self) - 1

    def over(self, first_frame: int, last_frame: int) -> Keypoints:
        """The keypoints of exactly these frames, unseen where there are none."""
        count = last_frame - first_frame + 1
        low, high = max(first_frame, self.first_frame), min(last_frame, self.last_frame) + 1

        def cut(rows: Array, missing: float) -> Array:
            out = np.full((count, *rows.shape[1:]), missing)
            if low < high:
                here = slice(low - self.first_frame, high - self.first_frame)
                out[low - first_frame : high - first_frame] = rows[here]
            return out

        depth = None if self.p_hips is None else cut(self.p_hips, np.nan)
        by_hand = None if self.by_hand is None else cut(self.by_hand.astype(float), 0.0) > 0
        uv, visibility = cut(self.uv, np.nan), cut(self.visibility, 0.0)
        frames = range(first_frame, last_frame + 1)
        masks = None if self.masks is None else tuple(self.mask(frame) for frame in frames)
        sigma = None if self.depth_sigma_m is None else cut(self.depth_sigma_m, np.nan)
        return Keypoints(first_frame, self.names, uv, visibility, depth, by_hand, masks, sigma)

    def steadied(self, steady: SteadyCamera) -> Keypoints:
        """As a steady camera would have seen them."""
        frames = range(self.first_frame, self.last_frame + 1)
        pixels = [steady.pixels(uv, frame) for uv, frame in zip(self.uv, frames, strict=True)]
        masks = self.masks and tuple(
            mask and mask.steadied(steady, frame)
            for mask, frame in zip(self.masks, frames, strict=True)
        )
        return replace(self, uv=np.array(pixels).reshape(self.uv.shape), masks=masks)

    def mask(self, frame: int) -> PersonMask | None:
        """Where the person is in the picture of a frame; None where that is unknown."""
        here = self.masks is not None and self.first_frame <= frame <= self.last_frame
        return self.masks[frame - self.first_frame] if self.masks and here else None

    def overlaid(self, keypoints: Keypoints) -> Keypoints:
        """Put others, of the same names, in place of those there are of their frames; unseen in
        frames of neither. By nobody's hand.
        """
        first = min(self.first_frame, keypoints.first_frame)
        last = max(self.last_frame, keypoints.last_frame)
        below, above = self.over(first, last), keypoints.over(first, last)
        own = np.zeros(len(below), np.bool_)
        own[keypoints.first_frame - first : keypoints.last_frame + 1 - first] = True
        rows = own[:, None]
        depth = None
        if below.p_hips is not None and above.p_hips is not None:
            depth = np.where(rows[..., None], above.p_hips, below.p_hips)
        uv = np.where(rows[..., None], above.uv, below.uv)
        visibility = np.where(rows, above.visibility, below.visibility)
        frames = range(first, last + 1)
        masks = [(keypoints if own[n - first] else self).mask(n) for n in frames]
        return Keypoints(
            first, self.names, uv, visibility, depth, masks=tuple(masks) if any(masks) else None
        )

    def without(self, frames: Collection[int]) -> Keypoints:
        """Nothing seen in some frames."""
        if not frames:
            return self
        rows = np.array(sorted(frames)) - self.first_frame
        uv, visibility = self.uv.copy(), self.visibility.copy()
        uv[rows], visibility[rows] = np.nan, 0.0
        masks = self.masks and tuple(
            None if n in frames else mask for n, mask in enumerate(self.masks, self.first_frame)
        )
        p_hips = None if self.p_hips is None else self.p_hips.copy()
        if p_hips is not None:
            p_hips[rows] = np.nan
        return replace(self, uv=uv, visibility=visibility, p_hips=p_hips, masks=masks)

    def exchanged(self) -> Keypoints:
        """Exchange left and right, but for what a person set."""
        order = [self.names.index(other_side(name, self.names)) for name in self.names]
        stays = np.zeros(self.visibility.shape, np.bool_) if self.by_hand is None else self.by_hand

        def other(rows: Array) -> Array:
            own = stays.reshape(*stays.shape, *(1,) * (rows.ndim - 2))
            return np.where(own, rows, rows[:, order])

        depth, sigma = (
            None if values is None else other(values)
            for values in (self.p_hips, self.depth_sigma_m)
        )
        return replace(
            self,
            uv=other(self.uv),
            visibility=other(self.visibility),
            p_hips=depth,
            depth_sigma_m=sigma,
        )

    def corrected(self, corrections: Sequence[KeypointCorrection]) -> Keypoints:
        """Apply what a person said of some of them: seen there for sure, or not at all. Depth is
        not known then: what was found there may have been something else.
        """
        uv, visibility = self.uv.copy(), self.visibility.copy()
        depth = None if self.p_hips is None else self.p_hips.copy()
        by_hand = np.zeros(visibility.shape, np.bool_)
        for each in corrections:
            if (
                not self.first_frame <= each.frame <= self.last_frame
                or each.joint not in self.names
            ):
                continue
            at = each.frame - self.first_frame, self.names.index(each.joint)
            uv[at], visibility[at] = each.uv or np.nan, float(each.uv is not None)
            by_hand[at] = True
            if depth is not None:
                depth[at] = np.nan
        if not by_hand.any():
            return self
        return replace(self, uv=uv, visibility=visibility, p_hips=depth, by_hand=by_hand)


def other_side(name: str, names: Sequence[str]) -> str:
    """The name of the same keypoint on the other side of the body; its own where there is none."""
    swapped = "_".join(_SIDES.get(word, word) for word in name.split("_"))
    return swapped if swapped in names else name


def joints_in(keypoints: Keypoints, values: Array) -> Array:
    """(N, J, …) of `JOINTS` among values (N, L, …) of keypoints; NaN of those that it has not."""
    joints = np.full((len(values), len(JOINTS), *values.shape[2:]), np.nan)
    for number, name in enumerate(JOINTS):
        if name in keypoints.names:
            joints[:, number] = values[:, keypoints.names.index(name)]
    return joints
