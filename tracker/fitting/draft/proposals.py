"""Frames where a person should look: the drafts to confirm as keyframes first."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.annotations import Reason

EVERY: Final = 60
"""About so many frames come to one proposal."""
APART: Final = 10
"""Frames between two proposals at least."""
ALIKE: Final = 0.05
"""Poses are about the same whose joints, seen from the hips, lie so near to one another in the
mean: a share of the body's height."""
POOR: Final[Mapping[Reason, float]] = {"residual": 0.03, "hidden": 0.5, "flip": 0.5}
"""From which value on a frame is proposed for a reason."""


@dataclass(frozen=True)
class Proposal:
    """A draft to confirm.

    parts: those it is about, empty for all.  score: how far its worst value is above the limit
    from which it is proposed, as a ratio; 0 for poses.
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
    joints: Array,
) -> tuple[Proposal, ...]:
    """The frames to confirm, ascending: the ends of stretches, between which all is tracked, what
    is in doubt, and poses that differ most from one another.

    frames (N,): those with a draft.
    doubts: by reason, values (N, L) of L limbs, whose parts are `parts`.
    joints (N, J, 3): where joints lie, seen from the hips, as shares of the body's height.
    Without any stretch there is nothing to confirm.
    """
    if not stretches:
        return ()
    poses = dict(zip(frames, joints, strict=True))
    chosen = {stretch.last: Proposal(stretch.last, "end") for stretch in stretches}
    chosen |= {stretch.first: Proposal(stretch.first, stretch.begins) for stretch in stretches}
    ends, more = len(chosen), max(2, len(frames) // EVERY)
    for candidate in _frames_over_doubt_limit(frames, doubts, parts):
        if len(chosen) < ends + (more + 1) // 2 and _is_apart(candidate.frame, chosen):
            chosen[candidate.frame] = candidate
    while len(chosen) < ends + more and (extreme := _extreme(poses, chosen)) is not None:
        chosen[extreme] = Proposal(extreme, "pose")
    return tuple(chosen[frame] for frame in sorted(chosen))


def _is_apart(frame: int, chosen: Collection[int]) -> bool:
    return all(abs(frame - chosen_frame) >= APART for chosen_frame in chosen)


def _extreme(poses: Mapping[int, Array], chosen: Collection[int]) -> int | None:
    """The frame whose pose differs most from the most similar chosen one; None where none does."""
    every = np.stack(list(poses.values()))
    away = np.min([_apart(every, poses[frame]) for frame in chosen], axis=0)
    away[[not _is_apart(frame, chosen) for frame in poses]] = 0.0
    best = int(away.argmax())
    return list(poses)[best] if away[best] > ALIKE else None


def _apart(ps_first: Array, ps_second: Array) -> Array:
    """By how much joints (…, J, 3) of poses differ in the mean."""
    return np.asarray(np.linalg.norm(ps_first - ps_second, axis=-1).mean(axis=-1))


def _frames_over_doubt_limit(
    frames: list[int], doubts: Mapping[Reason, Array], parts: tuple[str, ...]
) -> list[Proposal]:
    """Everything above its limit, the worst first."""
    proposals = []
    for reason, values in doubts.items():
        ratio = values / POOR[reason]
        for n in np.flatnonzero(ratio.max(axis=1, initial=0.0) >= 1.0):
            about = tuple(p for p, r in zip(parts, ratio[n], strict=True) if r >= 1.0)
            whole = len(about) == len(parts)
            score = round(float(ratio[n].max()), 6)
            proposals.append(Proposal(frames[n], reason, () if whole else about, score))
    return sorted(proposals, key=lambda p: (-p.score, p.frame, p.reason))
