"""One segment between two keyframes: the cycle of passes and its outcome (DRIFT §2.2)."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass

import numpy as np

from keypose.tracker.body.trajectory import Pass, Trajectory
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.motion_problem import MotionProblem
from keypose.tracker.solver.sigmas import SCORE_GREY2
from keypose.tracker.tracking.bundle import refine
from keypose.tracker.tracking.cues.joint_evidence import JointEvidence
from keypose.tracker.tracking.cues.silhouette import SilhouetteMismatch
from keypose.tracker.tracking.drift import Corrected, Motions, correct_drift
from keypose.tracker.tracking.frame_pair import (
    best_of,
    capped_score,
    keyframe_difference,
    least_squares_pass,
    printed_score,
    robust_pass,
)
from keypose.tracker.tracking.initial.choose import Starts, printed_start, starts
from keypose.tracker.tracking.method import Keypose, Method, Paper
from keypose.tracker.tracking.prior_motion import prior_motion_links
from keypose.tracker.tracking.scene import Scene
from keypose.tracker.tracking.segment import Segment, distance_px, is_sound

EXACT_KEYFRAMES = 100.0
"""Mean capped square, grey levels², below which two keyframes show the same texture."""
EXACT_ALLOWANCE = 1.15
PLAIN_ALLOWANCE = 1.05
"""Share of the passes' score that the refinement may have; near the noise shares say nothing."""
NOWHERE_PX = 1e6
"""Distance to a point that is behind the camera or undefined."""


@dataclass(frozen=True, eq=False)
class Outcome:
    """All trajectories tried, the best of them, and how well the evidence agrees.

    apart_px: (N, M) how far the chains from the two keyframes lie apart at every mark of the
        scene; zero for a method that does not follow from both.
    drift_px: (N - 1, M) how far each frame's own motion, in the last pass, led from the
        trajectory's next pose: the drift that was corrected.
    followed: neither chain left the space before the camera.
    diverged: a pass left it; the pass was dropped.
    gap: how far the last correction missed the keyframe before it was set exactly: radians.
    notes: sentences for a person about what could not be done as asked.
    joints: what keypoints show of the motion, where there are any.
    silhouette: how its poses disagree with what moves, where that was asked.
    off_person: the keyframe whose body is not where keypoints show the person, who is where the
        other one is.
    """

    passes: tuple[Pass, ...]
    best: int
    apart_px: Array
    drift_px: Array
    followed: bool
    diverged: bool
    gap: float
    notes: tuple[str, ...] = ()
    joints: JointEvidence | None = None
    silhouette: SilhouetteMismatch | None = None
    off_person: int | None = None

    @property
    def trajectory(self) -> Trajectory:
        return self.passes[self.best].trajectory


Work = Generator[Pass, None, Outcome]


def track_segment(scene: Scene, segment: Segment, method: Method) -> Work:
    """Track one segment; yields every trajectory as it is found and returns the outcome."""
    if isinstance(method, Paper):
        return _paper(scene, segment, method)
    return track_from(scene, segment, method, starts(scene, segment, method))


def _paper(scene: Scene, segment: Segment, method: Paper) -> Work:
    begun = printed_start(scene, segment, method)
    present, start = begun.ways[0].trajectory, begun.ways[0].what
    tried: list[Pass] = []
    diverged, drift, gap = False, _zeros_px(scene, present)[1:], 0.0
    for number in range(method.passes + 1):
        pass_name = "pass" if number else start
        if number == method.passes:
            tried.append(Pass(pass_name, present, printed_score(scene, segment.clip, present)))
            yield tried[-1]
            break
        motions, score = least_squares_pass(scene, segment.clip, present, method.inner)
        drift = drift_px(scene, present, motions)
        tried.append(Pass(pass_name, present, score))
        yield tried[-1]
        if number - best_of(tried) >= method.patience:
            break
        following = _correct(scene, segment, present, motions)
        if following is None:
            diverged = True
            break
        present, gap = following.trajectory, following.gap
    apart = _zeros_px(scene, present)
    return Outcome(tuple(tried), best_of(tried), apart, drift, True, diverged, gap, begun.notes)


def track_from(scene: Scene, segment: Segment, method: Keypose, begun: Starts) -> Work:
    """The same from these starts."""
    (first, *others), clip = begun.ways, segment.clip
    # the better, the later; what is known of the motion excludes those that lead elsewhere
    tried = others[::-1] if segment.own is None else []
    yield from tried
    present, pass_name = first.trajectory, first.what
    drift, gap, diverged = _zeros_px(scene, present)[1:], 0.0, False
    for _ in range(method.passes):
        motions, score = robust_pass(scene, clip, present, method.stride, method.inner, method.stop)
        drift = drift_px(scene, present, motions)
        tried.append(Pass(pass_name, present, score))
        yield tried[-1]
        following = _correct(scene, segment, present, motions)
        if following is None:
            diverged = True
            break
        present, pass_name, gap = following.trajectory, "pass", following.gap
    if present is not tried[-1].trajectory:
        last_score = capped_score(scene, clip, present, method.stride) if method.judged else None
        tried.append(Pass(pass_name, present, last_score))
        yield tried[-1]
    best = best_of(tried)
    refined = _refine(scene, segment, method, tried[best])
    if refined is not None:
        unrefined = tried[best]
        tried.append(refined)
        yield refined
        taken = segment.own is not None  # it keeps to that one, which no score knows
        if taken or _is_better(scene, segment, method, refined, unrefined):
            best = len(tried) - 1
    chains = begun.chains
    apart = _zeros_px(scene, present) if chains is None else distance_px(scene, *chains)
    return Outcome(tuple(tried), best, apart, drift, chains is not None, diverged, gap, begun.notes)


def _refine(scene: Scene, segment: Segment, method: Keypose, start: Pass) -> Pass | None:
    own = segment.own
    links = () if own is None else prior_motion_links(scene, own)
    others = MotionProblem(scene.skeleton, links=links) if links else None
    trajectory = refine(scene, segment.clip, start.trajectory, method.refinement, others)
    if trajectory is start.trajectory or not is_sound(scene, segment, trajectory):
        return None
    judged = method.judged
    score = capped_score(scene, segment.clip, trajectory, method.stride) if judged else None
    return Pass("refinement", trajectory, score)


def _is_better(
    scene: Scene, segment: Segment, method: Keypose, refined: Pass, unrefined: Pass
) -> bool:
    """Whether the refinement is better.

    The score compares neighbouring frames and so prefers the passes, which do just that; the
    refinement compares with the keyframes and is nearer to the truth if those are posed exactly.
    Unjudged, that alone decides.
    """
    exact = 0.0 < keyframe_difference(scene, segment, method.stride) < EXACT_KEYFRAMES
    if refined.score is None or unrefined.score is None:
        return exact
    allowance = EXACT_ALLOWANCE if exact else PLAIN_ALLOWANCE
    return refined.score < allowance * unrefined.score + SCORE_GREY2


def _correct(
    scene: Scene, segment: Segment, present: Trajectory, motions: Motions
) -> Corrected | None:
    """The drift-corrected trajectory, or None where the motions led out of sight."""
    if not np.isfinite(motions.ps_camera_root).all():
        return None
    corrected = correct_drift(present, motions, segment.end)
    return corrected if is_sound(scene, segment, corrected.trajectory) else None


def drift_px(scene: Scene, present: Trajectory, motions: Motions) -> Array:
    """(N - 1, M) distance in the picture of where motions lead and where the trajectory goes."""
    led = Trajectory(present.first_frame + 1, motions.Rs_parent_part, motions.ps_camera_root)
    rest = Trajectory(led.first_frame, present.Rs_parent_part[1:], present.ps_camera_root[1:])
    return np.nan_to_num(distance_px(scene, led, rest), nan=NOWHERE_PX, posinf=NOWHERE_PX)


def _zeros_px(scene: Scene, trajectory: Trajectory) -> Array:
    """(N, M) zeros."""
    return np.zeros((len(trajectory), len(scene.marks[1])))
