"""The expected gain of one more keyframe in a segment, frame by frame.

The error of a tracked motion is not seen, but it goes with what is: the drift that was corrected,
how far the chains from the two keyframes lie apart, how much of the motion the picture does not
determine, and how far the other trajectories lie from the one chosen. On rendered motions with
known truth these predict a segment's mean error to within a factor of 1.8, from a third of a pixel
to fifty.

The gain grows with the error of the whole segment, and is largest where the error is: where a
motion turns or is fast, not simply in the middle. On the same motions this needed fewer
keyframes than choosing the frame that lowers the sum of all errors most.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.tracking.segment import extent_px

if TYPE_CHECKING:
    from keypose.tracker.tracking.cycle import Outcome
    from keypose.tracker.tracking.diagnostics.observability import Observation
    from keypose.tracker.tracking.scene import Scene

ERROR = 0.22
DRIFT_POWER = 2 / 3
"""Mean error in pixels = ERROR · drift^DRIFT_POWER · apart^(1 − DRIFT_POWER) · (1 + unseen)."""
LEAST_PX = 0.05
"""Chains count as at least this far apart."""
MOST_PX = 200.0
"""Anything further away than this is lost; how far does not matter."""
EVEN = 0.6
"""Weight of a segment's frames, beside that of its drift, in how errors grow over time."""
MENDED = 0.6
"""Share of a segment's error that one keyframe removes."""
LOST_EXTENT = 0.15
"""Mean error, as a share of the body's extent in the picture, where both chains were lost."""


def expected_gain(scene: Scene, outcome: Outcome, observation: Observation) -> Array:
    """(N,) pixels of error that a keyframe at each frame is expected to remove.

    Pixels of the pictures worked on: the mean over the body, summed over the segment's frames. Zero
    at the keyframes that are there.
    """
    if outcome.joints is not None:
        by_joint = outcome.joints.expected_error(scene.skeleton.part_count)
        return _gain(np.nanmean(by_joint, axis=1) * outcome.joints.height_px)
    clock = _clock(outcome)
    error = _error_px(scene, outcome, observation) * 6 * clock * (1 - clock)
    others = _others_px(scene, outcome)
    if others is not None:
        error = np.sqrt(error * others)
    error[[0, -1]] = 0.0  # rounding may take it slightly outside
    return _gain(error)


def _gain(error: Array) -> Array:
    """(N,) the share of a segment's error that a keyframe removes, most of it where most is."""
    return np.asarray(MENDED * error.sum() * error / max(float(error.max()), 1e-12))


def _error_px(scene: Scene, outcome: Outcome, observation: Observation) -> Array:
    """(N,) the segment's expected mean error, more at less observable frames."""
    gave_up = outcome.diverged and outcome.passes[outcome.best].what == "interpolation"
    if gave_up or not outcome.followed:
        return np.full(len(outcome.trajectory), LOST_EXTENT * extent_px(scene, outcome.trajectory))
    drift = _capped(outcome.drift_px).mean(axis=1).sum()
    share = np.linspace(0.0, 1.0, len(outcome.apart_px))
    apart = (_capped(outcome.apart_px).mean(axis=1) * 4 * share * (1 - share)).mean()
    if not outcome.apart_px.any():  # no chains from both keyframes: drift alone counts
        apart = drift
    evidence = drift**DRIFT_POWER * (apart + LEAST_PX) ** (1 - DRIFT_POWER)
    return np.asarray(ERROR * evidence * (1 + _unseen(observation)))


def _others_px(scene: Scene, outcome: Outcome) -> Array | None:
    """(N,) how far the other trajectories lie from the chosen one; None where there are none."""
    kept = scene.mark_pixels(outcome.trajectory)
    others = [p.trajectory for i, p in enumerate(outcome.passes) if i != outcome.best]
    if not others:
        return None
    apart = [np.linalg.norm(scene.mark_pixels(path) - kept, axis=-1) for path in others]
    return np.asarray(_capped(np.stack(apart)).mean(axis=(0, 2)))


def _clock(outcome: Outcome) -> Array:
    """(N,) from 0 to 1: how much of the segment's drift, and of its frames, has gone by."""
    drift = np.concatenate([[0.0], np.cumsum(_capped(outcome.drift_px).mean(axis=1))])
    even = np.linspace(0.0, 1.0, len(drift))
    if drift[-1] <= 0:
        return even
    return np.asarray(EVEN * even + (1 - EVEN) * drift / drift[-1])


def _unseen(observation: Observation) -> Array:
    """(N,) mean share of the motion that is not observed; 0 where nothing was measured."""
    is_measured = np.isfinite(observation.diagnostics.observability)
    unseen = np.where(
        is_measured, 1 - np.nan_to_num(observation.diagnostics.observability), 0.0
    ).sum(axis=1)
    share = unseen / np.maximum(is_measured.sum(axis=1), 1)
    return np.concatenate([share[:1], share])


def _capped(distances_px: Array) -> Array:
    return np.nan_to_num(distances_px, nan=MOST_PX).clip(0, MOST_PX)
