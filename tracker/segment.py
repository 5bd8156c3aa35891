"""One segment between two keyframes: the cycle of passes, and what comes of it (DRIFT §2.2)."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass

import numpy as np

from tracker.drift import Motions, correct_drift
from tracker.geometry import Array
from tracker.images import Clip
from tracker.initial import blended, follow
from tracker.kernels.pairs import CAP, mean_capped_square
from tracker.methods import Keypose, Method, Paper
from tracker.motion import least_squares_pass, printed_score, robust_pass
from tracker.pose import Pose
from tracker.refine import refine
from tracker.scene import Scene
from tracker.trajectory import Trajectory, interpolate

NEAREST_M, FURTHEST = 0.05, 50.0
"""A body nearer than this, or this many times further than it was keyed, has been lost."""


@dataclass(frozen=True, eq=False)
class Segment:
    """A stretch between two keyframes, with its pictures."""

    first_frame: int
    last_frame: int
    start: Pose
    end: Pose
    clip: Clip


@dataclass(frozen=True, eq=False)
class Pass:
    """A trajectory on the way, and its score (the lower the better within one segment).

    what: "interpolation", "both ways", "pass" or "refinement".
    """

    what: str
    trajectory: Trajectory
    score: float


@dataclass(frozen=True, eq=False)
class Outcome:
    """All trajectories tried, the best of them, and how the evidence agrees.

    disagreement_px: (N, J) how far the chains from the two keyframes lie apart at every joint,
        or None for a method that does not follow from both.
    diverged: a pass left the space before the camera; it was dropped.
    """

    passes: tuple[Pass, ...]
    best: int
    disagreement_px: Array | None
    diverged: bool

    @property
    def trajectory(self) -> Trajectory:
        return self.passes[self.best].trajectory


Work = Generator[Pass, None, Outcome]


def track_segment(scene: Scene, segment: Segment, method: Method) -> Work:
    """Track one segment; yields every trajectory as it is found and returns the outcome."""
    if isinstance(method, Paper):
        return _paper(scene, segment, method)
    return _keypose(scene, segment, method)


def _paper(scene: Scene, segment: Segment, method: Paper) -> Work:
    present = interpolate(segment.start, segment.end, segment.first_frame, segment.last_frame)
    tried: list[Pass] = []
    diverged = False
    for number in range(method.passes + 1):
        what = "pass" if number else "interpolation"
        if number == method.passes:
            tried.append(Pass(what, present, printed_score(scene, segment.clip, present)))
            yield tried[-1]
            break
        motions, score = least_squares_pass(scene, segment.clip, present, method.inner)
        tried.append(Pass(what, present, score))
        yield tried[-1]
        if number - _best(tried) >= method.patience:
            break
        following = _closed(scene, segment, present, motions)
        if following is None:
            diverged = True
            break
        present = following
    return Outcome(tuple(tried), _best(tried), None, diverged)


def _keypose(scene: Scene, segment: Segment, method: Keypose) -> Work:
    first, last, clip = segment.first_frame, segment.last_frame, segment.clip
    plain = interpolate(segment.start, segment.end, first, last)
    tried = [Pass("interpolation", plain, _score(scene, clip, plain, method))]
    yield tried[0]
    how = (method.of, method.chain_inner, method.stop)
    forward = follow(scene, clip, segment.start, first, last, *how)
    backward = follow(scene, clip, segment.end, last, first, *how)
    present, diverged, disagreement = plain, True, None
    if _is_sound(scene, segment, forward) and _is_sound(scene, segment, backward):
        present, diverged = blended(forward, backward), False
        disagreement = _distance_px(scene, forward, backward)
    what = "interpolation" if diverged else "both ways"
    for _ in range(method.passes):
        motions, score = robust_pass(scene, clip, present, method.of, method.inner, method.stop)
        if present is not plain:
            tried.append(Pass(what, present, score))
            yield tried[-1]
        following = _closed(scene, segment, present, motions)
        if following is None:
            diverged = True
            break
        present, what = following, "pass"
    else:
        tried.append(Pass(what, present, _score(scene, clip, present, method)))
        yield tried[-1]
    refined = refine(scene, clip, tried[_best(tried)].trajectory, method.refinement)
    if _is_sound(scene, segment, refined):
        tried.append(Pass("refinement", refined, _score(scene, clip, refined, method)))
        yield tried[-1]
    return Outcome(tuple(tried), _best(tried), disagreement, diverged)


def _best(tried: list[Pass]) -> int:
    return int(np.argmin([p.score for p in tried]))


def _score(scene: Scene, clip: Clip, trajectory: Trajectory, method: Keypose) -> float:
    slots = clip.slots(trajectory.first_frame, trajectory.last_frame)
    return float(
        mean_capped_square(
            scene.arrays, scene.lens, scene.sight, clip.levels[0], slots,
            trajectory.Rs_parent_part, trajectory.ps_camera_root, method.of, 1, CAP,
        )
    )  # fmt: skip


def _closed(
    scene: Scene, segment: Segment, present: Trajectory, motions: Motions
) -> Trajectory | None:
    """The drift-corrected trajectory, or None where the motions led out of sight."""
    if not np.isfinite(motions.ps_camera_root).all():
        return None
    closed = correct_drift(present, motions, segment.end).trajectory
    return closed if _is_sound(scene, segment, closed) else None


def _is_sound(scene: Scene, segment: Segment, trajectory: Trajectory) -> bool:
    """Whether every joint of a trajectory lies before the camera, and not absurdly far away."""
    z = trajectory.transforms(scene.skeleton)[..., 2, 3]
    far = FURTHEST * max(segment.start.p_camera_root[2], segment.end.p_camera_root[2])
    return bool(np.isfinite(z).all() and z.min() > NEAREST_M and z.max() < far)


def _distance_px(scene: Scene, a: Trajectory, b: Trajectory) -> Array:
    """(N, J) distance of two trajectories' joints in the picture."""
    uv_a, uv_b = (scene.camera.project(x.joints(scene.skeleton)) for x in (a, b))
    return np.asarray(np.linalg.norm(uv_a - uv_b, axis=-1))
