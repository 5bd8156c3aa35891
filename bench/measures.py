"""What is measured of a motion on a real clip, and its spread over disturbed keyframes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from bench.clips import Clip, Stance, place
from keypose.tracker.body.body import Body
from keypose.tracker.body.modify import height
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.posed import BodyPoints

TALL_PX = 400.0
FAR_PX = 10.0
"""A joint is wrong when it is further off than `FAR_PX` on a person who is `TALL_PX` tall."""


@dataclass(frozen=True)
class Over:
    """One figure over all disturbances of the keyframes."""

    values: tuple[float, ...]

    @property
    def median(self) -> float:
        return float(np.median(self.values))

    @property
    def low(self) -> float:
        return min(self.values)

    @property
    def high(self) -> float:
        return max(self.values)

    def __str__(self) -> str:
        return f"{self.median:.1f} ({self.low:.1f}–{self.high:.1f})"


@dataclass(frozen=True)
class Mark:
    """How far a marked joint is off: pixels, and pixels on a person 400 px tall."""

    frame: int
    joint: str
    px: float
    scaled_px: float


def marks_between(
    clip: Clip, skeleton: Skeleton, motion: Trajectory, keyframes: Iterable[int]
) -> list[Mark]:
    """The marks at frames of the motion strictly between keyframes."""
    reference, tall = clip.reference(skeleton.body), height(skeleton.body)
    points, posed = BodyPoints(skeleton, reference.places), set(keyframes)
    found = []
    for frame, known in zip(reference.frames.tolist(), reference.positions, strict=True):
        if frame in posed or not motion.first_frame < frame < motion.last_frame:
            continue
        row = frame - motion.first_frame
        p = points.at(motion.transforms(skeleton)[row])
        scale = TALL_PX / (tall * clip.camera.fy / motion.ps_camera_root[row, 2])
        off = np.linalg.norm(clip.camera.project(p) - known, axis=-1)
        named = zip(reference.names, off.tolist(), strict=True)
        found += [Mark(frame, name, px, px * scale) for name, px in named if np.isfinite(px)]
    return found


def figures(
    clip: Clip, skeleton: Skeleton, motion: Trajectory, keyframes: Sequence[int]
) -> dict[str, float]:
    """All figures of one motion by name, those that cannot be had left out.

    mean, median, p90, worst: pixels at marks.  over_10: percent of marks that are wrong.
    root_mm, depth_mm: distance of joints seen from the middle of the hips, and of the joints'
        depth, at all frames strictly between keyframes.
    jitter_px: see `jitter_px`, of all stances together.
    """
    marks = marks_between(clip, skeleton, motion, keyframes)
    px, scaled = np.array([m.px for m in marks]), np.array([m.scaled_px for m in marks])
    found = {
        "mean": float(px.mean()),
        "median": float(np.median(px)),
        "p90": float(np.percentile(px, 90)),
        "worst": float(px.max()),
        "over_10": 100 * float((scaled > FAR_PX).mean()),
    }
    if clip.space is not None:
        names, joints = clip.space
        ours = _places(skeleton, names, motion)
        theirs = joints[motion.first_frame : motion.last_frame + 1]
        posed = np.isin(np.arange(motion.first_frame, motion.last_frame + 1), keyframes)
        found["root_mm"] = 1000 * root_relative(names, ours[~posed], theirs[~posed])
        found["keys_mm"] = 1000 * root_relative(names, ours[posed], theirs[posed])
        depth = np.abs(ours[~posed, :, 2] - theirs[~posed, :, 2])
        found["depth_mm"] = 1000 * float(np.nanmean(depth))
    stood = [j for stance in clip.stances if (j := _standing(clip, skeleton, motion, stance)).size]
    if stood:
        found["jitter_px"] = jitter_px(stood)
    return found


def root_relative(names: Sequence[str], ours: Array, theirs: Array) -> float:
    """Mean distance of joints (F, J, 3) seen from the middle of the hips."""
    hips = [names.index("LHip"), names.index("RHip")]
    away = (ours - ours[:, hips].mean(1, keepdims=True)) - (
        theirs - theirs[:, hips].mean(1, keepdims=True)
    )
    return float(np.nanmean(np.linalg.norm(away, axis=-1)))


def jitter_px(paths: Sequence[Array]) -> float:
    """Root mean square of the second differences of joints' paths (N, 2) in the picture."""
    return float(
        np.sqrt(np.mean(np.concatenate([(np.diff(p, 2, axis=0) ** 2).sum(1) for p in paths])))
    )


def _standing(clip: Clip, skeleton: Skeleton, motion: Trajectory, stance: Stance) -> Array:
    """(N, 2) where a standing joint is seen; nothing where the motion has under three frames."""
    first, last = max(stance.first, motion.first_frame), min(stance.last, motion.last_frame)
    if last - first < 2:
        return np.zeros((0, 2))
    path = _places(skeleton, (stance.joint,), motion)[:, 0]
    return clip.camera.project(path[first - motion.first_frame : last + 1 - motion.first_frame])


def _places(skeleton: Skeleton, names: Sequence[str], motion: Trajectory) -> Array:
    body: Body = skeleton.body
    points = BodyPoints(skeleton, tuple(place(body, name) for name in names))
    return points.at(motion.transforms(skeleton))
