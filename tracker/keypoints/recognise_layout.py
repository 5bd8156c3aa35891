"""In which order keypoints without names are listed, recognised by what the limbs would look like.

In the right order a limb joins neighbouring joints, is about as long as the one on the other side
and keeps its length from frame to frame; in a wrong one it leads across the body.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.layouts import LAYOUTS

CLEARLY: Final = 0.75
"""The best order's implausibility is below this share of the next one's. A person with all joints
seen is below it in each of hundreds of random poses, by a single frame."""
LEAST_LIMBS: Final = 10
"""Limbs seen in all frames together that are enough to judge by."""

_LIMBS: Final = (
    ("nose", "{}_eye"),
    ("{}_eye", "{}_ear"),
    ("{}_shoulder", "{}_elbow"),
    ("{}_elbow", "{}_wrist"),
    ("{}_shoulder", "{}_hip"),
    ("{}_hip", "{}_knee"),
    ("{}_knee", "{}_ankle"),
    ("{}_ankle", "{}_heel"),
    ("{}_ankle", "{}_big_toe"),
)
"""One side's."""


def recognised_layout(layouts: Sequence[str], uv: Array) -> str | None:
    """The layout whose limbs are clearly the most plausible; None where none is.

    layouts: names in `LAYOUTS`, all of L keypoints. uv: (N, L, 2) pixels, NaN where not seen.
    """
    if len(layouts) == 1:
        return layouts[0]
    lengths = {layout: _limb_lengths(layout, uv) for layout in layouts}
    if min(int(np.isfinite(limb_lengths).sum()) for limb_lengths in lengths.values()) < LEAST_LIMBS:
        return None
    facts = np.array([_implausibilities(limb_lengths) for limb_lengths in lengths.values()])
    is_known = np.isfinite(facts).all(0)
    total = facts[:, is_known].sum(1)
    best, next_best = np.argsort(total)[:2]
    return layouts[best] if total[best] < CLEARLY * total[next_best] else None


def _limb_lengths(layout: str, uv: Array) -> Array:
    """(N, 2, B) by frame, side and limb, as shares of how far the keypoints are spread."""
    names = LAYOUTS[layout]
    ends = [
        [[names.index(end.format(side)) for end in limb] for limb in _LIMBS]
        for side in ("left", "right")
    ]
    a, b = np.moveaxis(np.array(ends), -1, 0)
    lengths = np.linalg.norm(uv[:, a] - uv[:, b], axis=-1)
    return np.asarray(lengths / _spread(uv)[:, None, None])


def _spread(uv: Array) -> Array:
    """(N,) root mean square distance of a frame's keypoints from their middle, NaN without two."""
    is_known = np.asarray(np.isfinite(uv).all(-1))
    count = np.maximum(is_known.sum(1), 1)
    known_uv = np.where(is_known[..., None], uv, 0.0)
    middle = known_uv.sum(1) / count[:, None]
    away = np.where(is_known, ((known_uv - middle[:, None]) ** 2).sum(-1), 0.0)
    spread = np.sqrt(away.sum(1) / count)
    return np.where(spread > 0, spread, np.nan)


def _implausibilities(lengths: Array) -> tuple[float, float, float]:
    """How long the limbs are, how unlike on both sides, and how changing over the frames."""
    return (
        _mean(lengths),
        _mean(np.abs(lengths[:, 0] - lengths[:, 1])),
        _mean(np.abs(np.diff(lengths, axis=0))),
    )


def _mean(values: Array) -> float:
    finite = values[np.isfinite(values)]
    return float(finite.mean()) if len(finite) else np.nan
