"""The named ways to track a segment, as data."""

from __future__ import annotations

from dataclasses import dataclass, replace

from tracker.refine import Refinement
from tracker.session.schema import TrackSettings


@dataclass(frozen=True)
class Paper:
    """DRIFT as printed: interpolation, least squares with a hard cut, the printed score."""

    passes: int = 8
    inner: int = 5
    patience: int = 3
    """Passes without a new best score after which the cycle ends."""


@dataclass(frozen=True)
class Keypose:
    """Ours: followed from both keyframes, robust passes, then the whole segment at once.

    of: one surface point of so many is followed, the one with the strongest gradient.
    inner, stop: solves of a frame pair at most, and the step (rad, m) that ends them.
    """

    passes: int
    of: int
    chain_inner: int
    refinement: Refinement
    inner: int = 5
    stop: float = 1e-3


FULL = Keypose(4, 4, 4, Refinement((4, 3, 3), of=2))
FAST = Keypose(2, 4, 4, Refinement((2, 2, 0), of=2))
PREVIEW = Keypose(1, 8, 2, Refinement((2, 0, 0), of=8))

Method = Paper | Keypose


def method_of(settings: TrackSettings) -> Method:
    """The method that settings name."""
    if settings.method == "paper":
        return Paper(settings.passes or Paper.passes)
    base = {"full": FULL, "fast": FAST, "preview": PREVIEW}[settings.quality]
    return replace(base, passes=settings.passes or base.passes)
