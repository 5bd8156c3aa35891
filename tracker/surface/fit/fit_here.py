"""One pose laid onto the surface of its step, and what that changed, in words."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tracker.body.pose import Pose, pose_transforms
from tracker.body.skeleton import Skeleton
from tracker.errors import spoken
from tracker.geometry.rotations import Array, apply_transform
from tracker.surface.fit.fitter import SurfaceFitter
from tracker.surface.fit.measuring import measure
from tracker.surface.fit.model import SurfaceModel
from tracker.surface.fit.options import Options
from tracker.surface.fit.pairing import Observed
from tracker.surface.fit.solving import fit_pose
from tracker.surface.mesh import SurfaceMesh

WORTH_A_WORD_M = 0.005
MOST = 3

MUCH = 0.25
"""Of the observed surface: so much far from the body's is worth a word."""
_NOT_YET = (
    " Much of the surface is still far from the body: set height and sizes in Body, pull the limbs "
    "nearer, and fit again."
)
OPTIONS = Options(contact=False, swell=False, solves=60)
"""Solids overlap where a surface is in one piece: what is near another part tells as much. Since
nothing is left out so, a difference in thickness pushes evenly."""


@dataclass(frozen=True, eq=False)
class Found:
    """The pose, and what moved to it in a sentence."""

    pose: Pose
    words: str


def fit_here(fitter: SurfaceFitter, frame: int, pose: Pose) -> Found:
    """Lay a pose onto the surface of a frame; SurfaceError where that cannot be used."""
    fitted = fitter.fit_frame(frame, pose)
    return Found(fitted, _describe_moves(fitter.skeleton, pose, fitted))


def lay_body(mesh: SurfaceMesh, skeleton: Skeleton, pose: Pose) -> Found:
    """Lay the body's own solids into a surface, where none moves with the body yet.

    As good as the body's sizes: joints come to a centimetre or two. mesh: camera frame, metres.
    """
    size = float(np.linalg.norm(mesh.extent))
    model = SurfaceModel.of_solids(skeleton.body, pose, OPTIONS.points, size)
    observed = Observed.of(mesh, OPTIONS)
    fit = fit_pose(model, observed, pose, OPTIONS)
    left = measure(model, observed, fit).unexplained
    return Found(
        fit.pose, _describe_moves(skeleton, pose, fit.pose) + (_NOT_YET if left > MUCH else "")
    )


def _describe_moves(skeleton: Skeleton, before: Pose, after: Pose) -> str:
    """Such as "Right forearm moved 6 cm, head 2 cm."."""
    moved = np.linalg.norm(_middles(skeleton, after) - _middles(skeleton, before), axis=1)
    most = [i for i in np.argsort(-moved, kind="stable")[:MOST] if moved[i] >= WORTH_A_WORD_M]
    if not most:
        return "No part moved by more than half a centimetre."
    names = [spoken(skeleton.body.names[i]) for i in most]
    first, *rest = (f"{100 * moved[i]:.0f} cm" for i in most)
    words = [f"{names[0]} moved {first}", *map(" ".join, zip(names[1:], rest, strict=True))]
    told = ", ".join(words)
    return f"{told[:1].upper()}{told[1:]}."


def _middles(skeleton: Skeleton, pose: Pose) -> Array:
    """(P, 3) the middle of every part, camera frame, metres."""
    Ts, parts = pose_transforms(skeleton, pose), skeleton.body.parts
    middles = [
        apply_transform(T, part.shape.mesh().vertices).mean(axis=0)
        for T, part in zip(Ts, parts, strict=True)
    ]
    return np.array(middles)
