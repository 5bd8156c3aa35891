"""Fit steps one after another, each from the one before (SURFACE §4.3).

The surface that moves with the body is that of one step. What of it was not the body's, such as
volume that no camera could see past, has no counterpart at other steps, and draws ever new places.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from keypose.tracker.body.pose import Pose
from keypose.tracker.errors import SurfaceError
from keypose.tracker.geometry.rotations import Array, frozen, transpose
from keypose.tracker.surface.fit.measuring import StepFit, measure, misfit, point_weights
from keypose.tracker.surface.fit.model import SurfaceModel
from keypose.tracker.surface.fit.options import Options
from keypose.tracker.surface.fit.pairing import TargetSurface
from keypose.tracker.surface.fit.solving import SurfaceRegistration, fit_pose
from keypose.tracker.surface.mesh import Steps

OFF_SHARE = 0.0025
"""Of the surface's size: a point that is off by as much, on the average, counts half."""
OFF_MOST_SHARE = 0.015
"""Of the surface's size: farther off than that no point is taken to be; the pose may be wrong."""
FORETRUST = 3.0
"""Prior: so many steps at which every point lay on the surface."""


@dataclass(frozen=True, eq=False)
class PointReliability:
    """What the steps so far showed of V points; read-only.

    off:   (V,) how far each was from the observed surface, metres, summed over the steps.
    steps: (V,) at how many it counted.
    """

    off: Array
    steps: Array

    @classmethod
    def of(cls, model: SurfaceModel) -> PointReliability:
        """Before the first step."""
        nothing = frozen(np.zeros(len(model.own)))
        return cls(nothing, nothing)

    def after(self, model: SurfaceModel, fit: SurfaceRegistration) -> PointReliability:
        """The reliability after one more step, fitted with that model."""
        pairs = fit.pairs
        there = slice(pairs.forward)
        gap = pairs.target[there] - fit.posed.p
        off = np.abs(np.einsum("vi,vi->v", gap, pairs.normals[there]))
        counted = point_weights(model, pairs)
        capped = np.minimum(off, OFF_MOST_SHARE * model.size_m)
        return PointReliability(frozen(self.off + counted * capped), frozen(self.steps + counted))

    def apply_to(self, model: SurfaceModel) -> SurfaceModel:
        """The model with its points weighted by how far off they were."""
        mean = self.off / (self.steps + FORETRUST)
        return model.with_trust(1.0 / (1.0 + (mean / (OFF_SHARE * model.size_m)) ** 2))


TROUBLE = 0.05
"""Of the observed surface: where so much is not explained, another start is tried."""


@dataclass(frozen=True, eq=False)
class Link:
    """One step of a chain.

    step:    None where the surface of the step could not be used; the pose is then the one before.
    problem: why, in a sentence.
    reliability: of the model's points when the chain goes on from here; only its last link needs
             to keep it.
    """

    frame: int
    pose: Pose
    step: StepFit | None
    problem: str = ""
    reliability: PointReliability | None = None


def keyframe_link(
    model: SurfaceModel, steps: Steps, frame: int, pose: Pose, options: Options
) -> Link:
    """A keyframe as it was posed, measured but not moved: where a chain begins."""
    still = replace(options, solves=0, trust=False)
    return next(follow(model, steps, [Link(frame, pose, None)], [frame], still))


def follow(
    model: SurfaceModel,
    steps: Steps,
    before: Sequence[Link],
    frames: Sequence[int],
    options: Options,
) -> Iterator[Link]:
    """Fit the steps of these frames in their order, going on from the links before them.

    before: a chain as far as it is known, its keyframe first. Wherever it was stopped, what follows
        is the same.
    """
    usable = [link.pose for k, link in enumerate(before) if k == 0 or link.step is not None]
    pose = usable[-1]
    ahead = _extrapolate(*usable[-2:]) if len(usable) > 1 else None
    reliability = before[-1].reliability or PointReliability.of(model)
    for frame in frames:
        try:
            observed = TargetSurface.of(steps.mesh(frame), options)
        except SurfaceError as error:
            yield Link(frame, pose, None, str(error), reliability)
            continue
        weighted = reliability.apply_to(model)
        fit, step = _fit_step(weighted, observed, pose, ahead, options)
        pose, ahead = fit.pose, _extrapolate(pose, fit.pose)
        reliability = reliability.after(weighted, fit) if options.trust else reliability
        yield Link(frame, pose, step, "", reliability)


def _fit_step(
    model: SurfaceModel, observed: TargetSurface, pose: Pose, ahead: Pose | None, options: Options
) -> tuple[SurfaceRegistration, StepFit]:
    """The step fitted from the pose before; where that leaves much unexplained, also from where
    the body would be if its motion went on, and the better of the two."""
    fit = fit_pose(model, observed, pose, options)
    step = measure(model, observed, fit)
    if ahead is None or options.solves == 0 or step.unexplained < TROUBLE:
        return fit, step
    surface_registration = fit_pose(model, observed, ahead, options)
    if misfit(model, observed, surface_registration.pairs) >= misfit(model, observed, fit.pairs):
        return fit, step
    return surface_registration, measure(model, observed, surface_registration)


def _extrapolate(before: Pose, now: Pose) -> Pose:
    """The pose after as much motion again."""
    turn = transpose(before.Rs_parent_part) @ now.Rs_parent_part
    return Pose(now.Rs_parent_part @ turn, 2 * now.p_camera_root - before.p_camera_root)
