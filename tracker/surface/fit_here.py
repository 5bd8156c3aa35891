"""One pose laid onto the surface of its step, and what that changed, in words."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tracker.geometry import Array, apply_transform
from tracker.pose import Pose, pose_transforms
from tracker.skeleton import Skeleton
from tracker.surface.fitter import SurfaceFitter
from tracker.verdict import spoken

WORTH_A_WORD_M = 0.005
MOST = 3

_NOTHING_TO_FIT = (
    "The surface of this frame is the one that moves with the body, as you posed it here: "
    "there is nothing to fit."
)


@dataclass(frozen=True, eq=False)
class Found:
    """The pose, whether it is another one now, and a sentence on it."""

    pose: Pose
    moved: bool
    words: str


def fit_here(fitter: SurfaceFitter, frame: int, pose: Pose) -> Found:
    """Lay a pose onto the surface of a frame; SurfaceError where that cannot be used."""
    if frame == fitter.model_frame:
        return Found(pose, False, _NOTHING_TO_FIT)
    fitted = fitter.fit_frame(frame, pose)
    return Found(fitted, True, _told(fitter.skeleton, pose, fitted))


def _told(skeleton: Skeleton, before: Pose, after: Pose) -> str:
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
