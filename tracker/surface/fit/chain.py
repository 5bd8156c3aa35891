"""Steps fitted one after another, each from the one before; two such chains as one.

SURFACE §4.3.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from tracker.errors import SurfaceError
from tracker.geometry import Array, exp_rotation, log_rotation, transpose
from tracker.pose import Pose
from tracker.skeleton import Skeleton
from tracker.surface.fit.measuring import StepFit, measure, misfit
from tracker.surface.fit.model import SurfaceModel
from tracker.surface.fit.options import Options
from tracker.surface.fit.pairing import Observed
from tracker.surface.fit.solving import Fit, fit_pose
from tracker.surface.steps import Steps

TROUBLE = 0.05
"""Of the observed surface: when so much is not explained, another start is tried."""
TRUST_POWER = 2
"""How sharply the chain is preferred whose surfaces lie nearer, in powers of squared distance."""


@dataclass(frozen=True, eq=False)
class Link:
    """One step of a chain.

    step:    None where the surface of the step could not be used; the pose is then the one before.
    problem: why, in a sentence.
    """

    frame: int
    pose: Pose
    step: StepFit | None
    problem: str = ""


def follow(
    model: SurfaceModel, steps: Steps, start: Pose, frames: Sequence[int], options: Options
) -> Iterator[Link]:
    """Fit the steps of these frames in their order, the first one from `start`."""
    pose, ahead = start, None
    for frame in frames:
        try:
            observed = Observed.of(steps.mesh(frame), options)
        except SurfaceError as error:
            yield Link(frame, pose, None, str(error))
            continue
        fit, step = _fitted(model, observed, pose, ahead, options)
        pose, ahead = fit.pose, _gone_on(pose, fit.pose)
        yield Link(frame, pose, step)


def _fitted(
    model: SurfaceModel, observed: Observed, pose: Pose, ahead: Pose | None, options: Options
) -> tuple[Fit, StepFit]:
    """The step fitted from the pose before; where that leaves much unexplained, also from where
    the body would be if its motion went on, and the better of the two."""
    fit = fit_pose(model, observed, pose, options)
    step = measure(model, observed, fit)
    if ahead is None or options.solves == 0 or step.unexplained < TROUBLE:
        return fit, step
    other = fit_pose(model, observed, ahead, options)
    if misfit(model, observed, other.pairs) >= misfit(model, observed, fit.pairs):
        return fit, step
    return other, measure(model, observed, other)


def _gone_on(before: Pose, now: Pose) -> Pose:
    """The pose after as much motion again."""
    turn = transpose(before.Rs_parent_part) @ now.Rs_parent_part
    return Pose(now.Rs_parent_part @ turn, 2 * now.p_camera_root - before.p_camera_root)


def filled(links: Sequence[Link]) -> list[Link]:
    """Links of consecutive frames; where a step could not be used, its pose leads over evenly."""
    good = [k for k, link in enumerate(links) if link.step is not None]
    whole = list(links)
    for before, after in pairwise(good):
        for k in range(before + 1, after):
            share = (k - before) / (after - before)
            pose = _mixed(links[before].pose, links[after].pose, share)
            whole[k] = replace(links[k], pose=pose)
    return whole


def blended(skeleton: Skeleton, forward: Link, backward: Link, share: float) -> Link:
    """One link of the two that chains from both keyframes have at a frame.

    share: how far the frame lies from the first keyframe to the second, 0 to 1. Each part leans to
    the chain whose surfaces lie nearer to each other, on that part and on what hangs from it.
    """
    if forward.step is None or backward.step is None:
        between = _mixed(forward.pose, backward.pose, share)
        return Link(forward.frame, between, None, forward.problem)
    ahead = _pull(skeleton, forward.step, 1.0 - share)
    behind = _pull(skeleton, backward.step, share)
    back = behind / np.maximum(ahead + behind, 1e-30)
    better = forward if ahead[0] >= behind[0] else backward
    return Link(forward.frame, _mixed(forward.pose, backward.pose, back), better.step)


def _pull(skeleton: Skeleton, step: StepFit, nearness: float) -> Array:
    """(P,) how much a chain counts for each part."""
    square = np.where(np.isfinite(step.residual), step.residual**2, 0.0) + 1e-9
    weight = np.where(np.isfinite(step.residual), step.counts, 0.0) + 1e-6
    below = skeleton.below.T
    mean = (below @ (weight * square)) / (below @ weight)
    return np.asarray(max(nearness, 1e-3) / mean**TRUST_POWER)


def _mixed(one: Pose, other: Pose, share: Array | float) -> Pose:
    """From one pose (share 0) to the other (share 1), part by part."""
    shares = np.broadcast_to(np.asarray(share, dtype=np.float64), (len(one.Rs_parent_part),))
    turn = log_rotation(transpose(one.Rs_parent_part) @ other.Rs_parent_part)
    Rs = one.Rs_parent_part @ exp_rotation(shares[:, None] * turn)
    root = (1 - shares[0]) * one.p_camera_root + shares[0] * other.p_camera_root
    return Pose(Rs, root)
