"""One template of the first keyframe followed frame by frame (INITIAL §3.1)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.tracking.initial.templates.rotatable import Rotatable
from keypose.tracker.tracking.initial.templates.search import GreyPicture, Match, find_match

TurnAt: TypeAlias = Callable[[int, Array], float]
"""Radians by which the template is turned in the n-th frame if it lies at this place (2,)."""

SPREAD_RAD = np.radians(9.0)
"""A limb may be turned by this much more or less than its predicted place says."""
POOR_GREY = 8.0
"""Grey levels by which a match may be worse than a flat template would be."""
MOST_POOR = 12
"""Frames on end through which a part that is not seen is taken to move on evenly."""
SLOWING = 0.7
"""The share of its speed that remains after each of them."""
SETTLED = 3
"""Pixels within which a place is looked for once more when its turn is known."""


@dataclass(frozen=True, eq=False)
class TemplateTrack:
    """Where a template was found: uv (N, 2) pixels. lost: the frame from which on it was not."""

    uv: Array
    lost: int | None


def follow_template(
    template: Rotatable, shown: Sequence[GreyPicture], turn_at: TurnAt, reach: int
) -> TemplateTrack:
    """Follow a template through all pictures, the first being its own.

    It is expected to move on as it last did, also while it is not found, up to MOST_POOR frames.
    """
    uv = np.tile(np.asarray(template.uv, np.float64), (len(shown), 1))
    step, poor = np.zeros(2), 0
    for n in range(1, len(shown)):
        expected = uv[n - 1] + step
        match = _best_match(template, shown[n], n, expected, turn_at, reach + 2 * poor)
        if match is None:
            poor += 1
            uv[n] = expected
            step *= SLOWING
            if poor > MOST_POOR or not _is_inside(shown[n], expected):
                return TemplateTrack(uv, n - poor + 1)
            continue
        poor, uv[n] = 0, match.uv
        step = uv[n] - uv[n - 1]
    return TemplateTrack(uv, None if not poor else len(shown) - poor)


def _best_match(
    template: Rotatable,
    shown: GreyPicture,
    n: int,
    expected: Array,
    turn_at: TurnAt,
    reach: int,
) -> Match | None:
    """The best match of a few turns; None where none is any good."""
    about = turn_at(n, expected)
    turns = (about, about - SPREAD_RAD, about + SPREAD_RAD)
    tried = [_find_turned(template, shown, expected, turn, reach) for turn in turns]
    matches = [match for match in tried if match is not None]
    if not matches:
        return None
    best = min(matches, key=lambda match: match.miss)  # of equal ones the first
    place = np.array(best.uv)
    again = _find_turned(template, shown, place, turn_at(n, place), SETTLED)
    return again if again is not None and again.miss < best.miss else best


def _find_turned(
    template: Rotatable, shown: GreyPicture, uv: Array, turn: float, reach: int
) -> Match | None:
    piece = template.at(turn)
    if piece is None:
        return None
    match = find_match(piece, shown, uv, reach)
    poor = match.miss > piece.contrast + POOR_GREY or not _is_inside(shown, np.array(match.uv))
    return None if poor else match


def _is_inside(shown: GreyPicture, uv: Array) -> bool:
    height, width = shown.grey.shape
    return bool((uv > -0.5).all() and uv[0] < width - 0.5 and uv[1] < height - 0.5)
