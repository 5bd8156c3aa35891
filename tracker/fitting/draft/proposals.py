"""Frames where a person should look: the drafts to confirm as keyframes first."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.annotations import Reason

EVERY: Final = 60
"""About so many frames come to one proposal."""
APART: Final = 10
"""Frames between two proposals at least."""
POOR: Final[Mapping[Reason, float]] = {"residual": 0.03, "hidden": 0.5, "flip": 0.5}
"""From which value on a frame is proposed for a reason."""


@dataclass(frozen=True)
class Proposal:
    """A draft to confirm.

    parts: those it is about, empty for all.  score: how far its worst value is above the limit
    from which it is proposed, as a ratio; 0 for the ends.
    """

    frame: int
    reason: Reason
    parts: tuple[str, ...] = ()
    score: float = 0.0


class FrameRange(NamedTuple):
    """First and last draft of a stretch of frames, and why it begins: "start" or "person"."""

    first: int
    last: int
    begins: Reason


def proposed(
    frames: list[int],
    stretches: Sequence[FrameRange],
    doubts: Mapping[Reason, Array],
    parts: tuple[str, ...],
) -> tuple[Proposal, ...]:
    """The frames to confirm, ascending.

    frames (N,): those with a draft.
    doubts: by reason, values (N, L) of L limbs, whose parts are `parts`.
    """
    chosen = {one.last: Proposal(one.last, "end") for one in stretches}
    chosen |= {one.first: Proposal(one.first, one.begins) for one in stretches}
    candidates = _frames_over_doubt_limit(frames, doubts, parts)
    most = len(chosen) + max(1, len(frames) // EVERY) + 1
    for candidate in candidates:
        if len(chosen) >= most:
            break
        if all(abs(candidate.frame - frame) >= APART for frame in chosen):
            chosen[candidate.frame] = candidate
    return tuple(chosen[frame] for frame in sorted(chosen))


def _frames_over_doubt_limit(
    frames: list[int], doubts: Mapping[Reason, Array], parts: tuple[str, ...]
) -> list[Proposal]:
    """Everything above its limit, the worst first."""
    found = []
    for reason, values in doubts.items():
        ratio = values / POOR[reason]
        for n in np.flatnonzero(ratio.max(axis=1, initial=0.0) >= 1.0):
            about = tuple(p for p, r in zip(parts, ratio[n], strict=True) if r >= 1.0)
            whole = len(about) == len(parts)
            score = round(float(ratio[n].max()), 6)
            found.append(Proposal(frames[n], reason, () if whole else about, score))
    return sorted(found, key=lambda p: (-p.score, p.frame, p.reason))
