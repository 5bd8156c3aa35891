"""Tell what is doubtful about a camera's motion, as data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal, TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array

Kind: TypeAlias = Literal[
    "no_texture", "body_fills", "cut", "not_rigid", "no_picture", "rolling_shutter", "no_parallax"
]


@dataclass(frozen=True)
class Finding:
    """Something doubtful over frames, both included.

    no_texture: too few points to follow, as where the film fades; amount: the share of frames.
    body_fills: what is not background leaves too little of the picture.  cut: the picture changes
    wholly, and the path before does not hang together with that from `first_frame`; amount 1.
    not_rigid: the points do not move as one, such as water, a crowd or a person nearer than the
    background; amount: the share of frames, or over the whole film that of points.
    no_picture: the frames cannot be read.
    rolling_shutter: rows are exposed one after another; amount: the share of the time between
    frames that it takes from the first row to the last, 0 where that is not taken out.
    no_parallax: nothing shows that the camera was elsewhere than at the first frame, so its path is
    not known; amount 1.
    """

    kind: Kind
    first_frame: int
    last_frame: int
    amount: float


SHORTEST = 3
"""Frames; shorter gaps are bridged and not reported."""
LOST_FRAMES = 4
"""After so many frames at which the camera is lost points are picked anew."""
OPEN_SHARE = 0.3
"""Share of a picture that must be background, or what hides it is why the camera is lost."""
FEWEST_SCENE = 5
"""Frames that points must be followed for, where nothing ties them to what was before."""


LEAST_CONTRAST = 0.6
"""Of the film's usual contrast: with less a picture has faded."""
MOST_CHANGE = 0.15
"""Of the film's usual contrast, by which it changes over `NEAR` frames while a picture fades."""
NEAR = 6
"""Frames."""
FAINT_GREY = 4.0
"""Standard deviation of the grey levels of a picture in which compression leaves nothing else."""
EVERY = 5
"""Rows and columns of which one is enough for the contrast."""
LITTLE = (32, 18)
"""Width and height of the pictures whose likeness is asked."""


def is_filled(usable: NDArray[np.bool_] | None) -> bool:
    """Whether what is not background leaves too little of a picture.

    usable: (H, W) pixels that may be background; None for all.
    """
    return usable is not None and bool(usable.mean() < OPEN_SHARE)


def contrast_of(picture: NDArray[np.uint8]) -> float:
    """The standard deviation of a picture's grey levels."""
    return float(picture[::EVERY, ::EVERY].std())


def are_faded(contrasts: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which pictures (N,) are faint, or fade, by their contrasts; NaN where one is not
    known. What moves in such a picture is noise and compression."""
    if not np.isfinite(contrasts).any():
        return np.zeros(len(contrasts), np.bool_)
    usual = float(np.nanmedian(contrasts))
    faded = contrasts < max(FAINT_GREY, LEAST_CONTRAST * usual)
    changes = np.abs(contrasts[NEAR:] - contrasts[:-NEAR]) > MOST_CHANGE * usual
    faded[NEAR:] |= changes
    faded[: len(changes)] |= changes
    return np.asarray(faded)


class Likeness:
    """How much each picture is like the one before: it falls where the film is cut."""

    def __init__(self) -> None:
        self._before: Array | None = None

    def of(self, picture: NDArray[np.uint8] | None) -> float:
        """The correlation of the next picture with the one before, both very small; 1 of the
        first one."""
        assert picture is not None
        little = cv2.resize(picture, LITTLE, interpolation=cv2.INTER_AREA).astype(float).ravel()
        before, self._before = self._before, little - little.mean()
        if before is None:
            return 1.0
        power = np.sqrt((before @ before) * (self._before @ self._before))
        return float(before @ self._before / power) if power > 1e-9 else 1.0


def scenes(
    keyframe: NDArray[np.int64],
    is_known: NDArray[np.bool_],
    untied: Sequence[int],
    cuts: Sequence[int],
) -> tuple[NDArray[np.bool_], list[int], tuple[int, ...]]:
    """Which frames (N,) are known, and the cuts, without scenes of too few frames, and the
    first frames of what hangs together.

    Args:
        keyframe: (N,) the number of the one that each frame was measured from.
        is_known: (N,) at which frames the camera was measured.
        untied: keyframes that are tied to nothing before them.
        cuts: frames at which the picture changed wholly.
    """
    is_known, begins = is_known.copy(), np.array([0, *untied, keyframe.max(initial=0) + 1])
    every = [
        (keyframe >= first) & (keyframe < beyond) & is_known
        for first, beyond in pairwise(begins.tolist())
    ]
    long = [scene for scene in every if scene.sum() >= FEWEST_SCENE] or every[:1]
    is_known = np.logical_or.reduce(long)
    begun = [int(np.flatnonzero(scene)[0]) for scene in long[1:]]
    ends = [0, *sorted(cuts), len(is_known)]
    lasting = [is_known[first:beyond].sum() >= FEWEST_SCENE for first, beyond in pairwise(ends)]
    kept = [cut for k, cut in enumerate(sorted(cuts)) if lasting[k] and lasting[k + 1]]
    frames = np.flatnonzero(is_known)
    ends_before = [frames[frames < first].max(initial=-1) for first in (*begun, *kept)]
    return is_known, kept, tuple(sorted({0, *(int(end) + 1 for end in ends_before)}))


def gaps(causes: Sequence[str]) -> list[Finding]:
    """Findings of the runs of frames at which nothing is known, by their most frequent cause."""
    findings: list[Finding] = []
    first, shortest = None, min(SHORTEST, len(causes))
    for frame, cause in enumerate([*causes, ""]):
        if cause and first is None:
            first = frame
        if not cause and first is not None:
            run = [c for c in causes[first:frame] if c != "cut"]
            if run and frame - first >= shortest:
                most = max(sorted(set(run)), key=run.count)
                amount = (frame - first) / len(causes)
                findings.append(Finding(most, first, frame - 1, amount))  # type: ignore[arg-type]
            first = None
    return findings
