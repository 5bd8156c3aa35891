"""Keypoints of one body over frames, whoever found them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from tracker.geometry.rotations import Array

JOINTS: Final = tuple(
    f"{side}_{joint}"
    for joint in ("shoulder", "elbow", "wrist", "hip", "knee", "ankle")
    for side in ("left", "right")
)
"""The names of the twelve joints that every detector of people knows."""


@dataclass(frozen=True, eq=False)
class Keypoints:
    """Keypoints of one body over consecutive frames.

    first_frame: of the video.
    names:       of the L keypoints: `JOINTS`, and others such as nose, left_heel.
    uv:          (N, L, 2) pixels of the video as it was filmed, lens distortion included; centres
                 at integers, NaN where nothing was found.
    visibility:  (N, L) from 0 to 1, how sure it is that the keypoint is seen; 0 where uv is NaN.
    p_hips:      (N, L, 3) metres, in axes parallel to the picture's (x right, y down, z away),
                 the middle of the hips at 0; NaN where unknown. None where nothing tells depth.
    """

    first_frame: int
    names: tuple[str, ...]
    uv: Array
    visibility: Array
    p_hips: Array | None = None

    def __len__(self) -> int:
        return len(self.uv)

    @property
    def last_frame(self) -> int:
        return self.first_frame + len(self) - 1

    def over(self, first_frame: int, last_frame: int) -> Keypoints:
        """Those of exactly these frames, unseen where there are none."""
        count = last_frame - first_frame + 1
        low, high = max(first_frame, self.first_frame), min(last_frame, self.last_frame) + 1

        def cut(rows: Array, missing: float) -> Array:
            out = np.full((count, *rows.shape[1:]), missing)
            if low < high:
                here = slice(low - self.first_frame, high - self.first_frame)
                out[low - first_frame : high - first_frame] = rows[here]
            return out

        depth = None if self.p_hips is None else cut(self.p_hips, np.nan)
        return Keypoints(
            first_frame, self.names, cut(self.uv, np.nan), cut(self.visibility, 0.0), depth
        )

    def exchanged(self) -> Keypoints:
        """With left and right exchanged."""
        order = [self.names.index(_other_side(name, self.names)) for name in self.names]
        depth = None if self.p_hips is None else self.p_hips[:, order]
        return replace(
            self, uv=self.uv[:, order], visibility=self.visibility[:, order], p_hips=depth
        )


def _other_side(name: str, names: tuple[str, ...]) -> str:
    for one, other in (("left_", "right_"), ("right_", "left_")):
        if name.startswith(one) and other + name.removeprefix(one) in names:
            return other + name.removeprefix(one)
    return name
