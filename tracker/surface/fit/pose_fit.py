"""One pose fitted to the surface of its step, and what that changed in a sentence."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import readable
from keypose.tracker.geometry.rotations import Array, apply_transform
from keypose.tracker.surface.fit.fitter import SurfaceFitter
from keypose.tracker.surface.fit.measuring import measure
from keypose.tracker.surface.fit.model import SurfaceModel
from keypose.tracker.surface.fit.options import Options
from keypose.tracker.surface.fit.pairing import Observed
from keypose.tracker.surface.fit.solving import fit_pose
from keypose.tracker.surface.mesh import SurfaceMesh

LEAST_REPORTED_M = 0.005
MOST = 3

MUCH = 0.25
"""Of the observed surface: from so much far from the body on, a hint is given."""
_NOT_YET = (
    " Much of the surface is still far from the body: set height and sizes in Body, pull the limbs "
    "nearer, and fit again."
)
OPTIONS = Options(contact=False, offset=False, solves=60)
"""Solids overlap where a surface is in one piece, so contact does not count; and with nothing left
out, a difference in thickness pushes evenly."""


@dataclass(frozen=True, eq=False)
class FittedPose:
    """The pose, and which parts moved in a sentence."""

    pose: Pose
    message: str


def fit_pose_to_surface(fitter: SurfaceFitter, frame: int, pose: Pose) -> FittedPose:
    """Fit a pose to the surface of a frame; SurfaceError where that cannot be used."""
    fitted = fitter.fit_frame(frame, pose)
    return FittedPose(fitted, _describe_moves(fitter.skeleton, pose, fitted))


def fit_solids_to_surface(mesh: SurfaceMesh, skeleton: Skeleton, pose: Pose) -> FittedPose:
    """Fit the body's own solids to a surface, where none moves with the body yet.

    As exact as the body's sizes: joints come to a centimetre or two. mesh: camera frame, metres.
    """
    size = float(np.linalg.norm(mesh.extent))
    model = SurfaceModel.of_solids(skeleton.body, pose, OPTIONS.points, size)
    observed = Observed.of(mesh, OPTIONS)
    fit = fit_pose(model, observed, pose, OPTIONS)
    left = measure(model, observed, fit).unexplained
    return FittedPose(
        fit.pose, _describe_moves(skeleton, pose, fit.pose) + (_NOT_YET if left > MUCH else "")
    )


def _describe_moves(skeleton: Skeleton, before: Pose, after: Pose) -> str:
    """Such as "Right forearm moved 6 cm, head 2 cm."."""
    moved = np.linalg.norm(_middles(skeleton, after) - _middles(skeleton, before), axis=1)
    most = [i for i in np.argsort(-moved, kind="stable")[:MOST] if moved[i] >= LEAST_REPORTED_M]
    if not most:
        return "No part moved by more than half a centimetre."
    names = [readable(skeleton.body.names[i]) for i in most]
    first, *rest = (f"{100 * moved[i]:.0f} cm" for i in most)
    words = [f"{names[0]} moved {first}", *map(" ".join, zip(names[1:], rest, strict=True))]
    text = ", ".join(words)
    return f"{text[:1].upper()}{text[1:]}."


def _middles(skeleton: Skeleton, pose: Pose) -> Array:
    """(P, 3) the middle of every part, camera frame, metres."""
    Ts, parts = pose_transforms(skeleton, pose), skeleton.body.parts
    middles = [
        apply_transform(T, part.shape.mesh().vertices).mean(axis=0)
        for T, part in zip(Ts, parts, strict=True)
    ]
    return np.array(middles)
