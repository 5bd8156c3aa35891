"""One segment tracked by brightness and keypoints together: the cycle of DRIFT §2.2 with drift
correction over soft anchors, see `cues/soft_correction.py`, in place of closing.

Brightness follows a limb closely while it is seen, and loses it behind the trunk; keypoints jitter,
but lose nothing. From two starts, the body followed from both keyframes and the keypoints alone,
the same cycle leads to two motions, as a rule to nearly the same. Of these the one counts that all
evidence together contradicts least; how far they lie apart shows how sure it is. Where both explain
the pictures worse than the body as it was followed to begin with, keypoints have misled them, and
the motion that brightness alone leads to is tried as well.
"""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from keypose.tracker.body.trajectory import Pass, Trajectory
from keypose.tracker.solver.projection import image_points
from keypose.tracker.solver.robust import Cauchy
from keypose.tracker.solver.sigmas import BEND_IN_PICTURE, SCORE_GREY2
from keypose.tracker.tracking.bundle import Textures, refine
from keypose.tracker.tracking.cues.joint_evidence import JointEvidence
from keypose.tracker.tracking.cues.keypoint_start import from_keypoints
from keypose.tracker.tracking.cues.reweighting import increment_scale, smoothed_keypoints
from keypose.tracker.tracking.cues.soft_correction import (
    Correction,
    even_increments,
    measured_increments,
)
from keypose.tracker.tracking.cycle import Outcome, Work, drift_px, track_from
from keypose.tracker.tracking.frame_pair import robust_pass
from keypose.tracker.tracking.initial.choose import Starts
from keypose.tracker.tracking.segment import distance_px, extent_px, is_sound

if TYPE_CHECKING:
    from keypose.tracker.geometry.rotations import Array
    from keypose.tracker.solver.smoothness import Increments
    from keypose.tracker.tracking.cues.anchors import Anchors
    from keypose.tracker.tracking.cues.other_film import OtherFilm
    from keypose.tracker.tracking.method import Keypose
    from keypose.tracker.tracking.scene import Scene
    from keypose.tracker.tracking.segment import Segment

IN_PASSES = 0.5
IN_REFINEMENT = 1.5
"""By how much steadied keypoints are surer than single ones. Passes come after one that single
keypoints have led, and leave the more to brightness."""

MEETS = 0.004
"""Share of the body's extent, in the mean over its marks: from two starts the cycle has led to one
motion where they lie no farther apart."""


@dataclass(frozen=True, eq=False)
class Measured:
    """What the pictures say of a trajectory: of every step, in the first film and in each other,
    how far the first film's lead from it, (N - 1, M) pixels, and its score, grey levels².

    unexplained: the cost of what the pictures of all films show besides.
    """

    steps: tuple[Increments, ...]
    drift_px: Array
    score: float
    unexplained: float


@dataclass(frozen=True, eq=False)
class Meeting:
    """Where the cycle from one start met that from another: both trajectories after a pass."""

    here: Trajectory
    there: Trajectory


@dataclass(frozen=True, eq=False)
class Candidate:
    """Where the cycle led from one start. index: of its last trajectory among all passes.

    cost: of all evidence together.  score: grey levels², None where brightness does not count.
    drift_px (N - 1, M): what was left to correct.
    after_passes: the trajectory after each pass.  met: where cycles from other starts met these.
    """

    index: int
    trajectory: Trajectory
    cost: float
    score: float | None
    drift_px: Array
    anchors: Anchors
    after_passes: tuple[Trajectory, ...] = ()
    met: tuple[Meeting, ...] = ()


def track_anchored(
    scene: Scene,
    free: Scene,
    segment: Segment,
    method: Keypose,
    candidates: Sequence[Anchors],
    begun: Starts | None,
    *,
    films: Sequence[OtherFilm] = (),
    reach_far: bool = True,
) -> Work:
    """Track one segment; yields every trajectory as it is found and returns the outcome.

    free: the scene with all parts that carry keypoints free to turn.  candidates: the anchors,
    several where left and right are in doubt.  begun: starts from brightness; None where it does
        not count.
    films: others that show the segment.
    reach_far: unless the starts are about right already, and keypoints need not reach far; nor
        need they where the body was followed from both keyframes.
    """
    brightness = begun is not None
    begun = begun or Starts(())
    reach_far = reach_far and begun.chains is None
    tried: list[Pass] = []
    ends: list[Candidate] = []
    scale, followed = 1.0, None
    if begun.chains is not None:
        followed = _measure(free, segment, method, begun.ways[0].trajectory, films)
        scale = increment_scale(segment, begun.chains, followed.steps[0])
    for anchors in candidates:
        correction = Correction(free, segment, anchors, films=tuple(films))
        alone = Pass("keypoints", from_keypoints(correction, reach_far), None)
        if not brightness:
            tried.append(alone)
            yield alone
            ends.append(measured_by_keypoints(correction, alone.trajectory, len(tried) - 1))
            continue
        of_anchors: list[Candidate] = []
        for start, first_measured in (
            (alone, None),
            *((start_way, followed) for start_way in begun.ways[:1]),
        ):
            if is_sound(scene, segment, start.trajectory):
                drifting = replace(correction, drift_scale=scale)
                before = of_anchors[0] if of_anchors else None
                ended = yield from cycle(drifting, method, start, tried, first_measured, before)
                of_anchors = [ended] if ended.met else [*of_anchors, ended]
        ends += of_anchors
    if followed is not None and _is_misled(followed, ends):
        motion, index = yield from _by_brightness(scene, segment, method, begun, tried)
        measured = _measure(free, segment, method, motion, films)
        for anchors in candidates:
            correction = Correction(free, segment, anchors, drift_scale=scale, films=tuple(films))
            ends.append(_ended(correction, motion, measured, index))
    best = min(ends, key=lambda ended: ended.cost)
    return _outcome(scene, free, begun, tried, ends, best, films)


def _is_misled(followed: Measured, ends: Sequence[Candidate]) -> bool:
    """Whether all that was found with keypoints explains the pictures worse than the body as
    it was followed to begin with. What a person set right misleads nobody.
    """
    if any((ended.anchors.by_hand > 0).any() for ended in ends):
        return False
    return all(ended.score is not None and ended.score > followed.score for ended in ends)


def _by_brightness(
    scene: Scene, segment: Segment, method: Keypose, begun: Starts, tried: list[Pass]
) -> Generator[Pass, None, tuple[Trajectory, int]]:
    """Tracked as if there were no keypoints: the motion, and its index among all passes."""
    before, work = len(tried), track_from(scene, segment, method, begun)
    while True:
        try:
            tried.append(next(work))
        except StopIteration as done:
            outcome: Outcome = done.value
            return outcome.trajectory, before + outcome.best
        yield tried[-1]


def expected_anchored_steps(passes: int) -> int:
    """Trajectories a segment is expected to yield: from two starts passes, the last, refinement."""
    return 2 * (passes + 2)


def measured_by_keypoints(correction: Correction, trajectory: Trajectory, index: int) -> Candidate:
    """What keypoints alone led to."""
    held = even_increments(correction.scene, correction.segment.interpolated())
    nothing = np.zeros((len(trajectory) - 1, len(correction.scene.marks[1])))
    return Candidate(
        index, trajectory, correction.cost(trajectory, (held,)), None, nothing, correction.anchors
    )


def cycle(
    correction: Correction,
    method: Keypose,
    start: Pass,
    tried: list[Pass],
    first_measured: Measured | None = None,
    before: Candidate | None = None,
) -> Generator[Pass, None, Candidate]:
    """All passes from one start, which are put into `tried` one by one. The first one is led by the
    keypoints of each frame, which reach far; the others by steadied ones.

    first_measured: what the pictures say of the start, where that was asked.
    before: where the cycle led from another start. Where this one meets it, it would go the same
        way, and that one comes back.

    Refined are motions between two keyframes: a last pose that nobody set is no texture to
    compare with.
    """
    free, segment = correction.scene, correction.segment
    led, met = yield from _passes(correction, method, start, tried, first_measured, before)
    present, pass_name = (led[-1], "pass") if led else (start.trajectory, start.what)
    if before is not None and met is not None:
        tried.append(Pass(pass_name, present, None))
        yield tried[-1]
        return replace(before, met=(*before.met, met))
    measured = _measure(free, segment, method, present, correction.films)
    tried.append(Pass(pass_name, present, measured.score))
    yield tried[-1]
    refined = present
    if not correction.open_end:
        stride = method.refinement.stride
        steady = _steadied(correction, present, IN_REFINEMENT * correction.drift_scale)
        others = steady.problem(measured.steps, Cauchy(), BEND_IN_PICTURE)
        beside = tuple(
            film.inner(Textures.of(film.scene, film.clip, film.seen(present), stride))
            for film in correction.films
        )
        others = replace(others, links=(*others.links, *beside))
        refined = refine(free, segment.clip, present, method.refinement, others)
    if refined is not present and is_sound(free, segment, refined):
        present = refined
        measured = _measure(free, segment, method, present, correction.films)
        tried.append(Pass("refinement", present, measured.score))
        yield tried[-1]
    ended = _ended(correction, present, measured, len(tried) - 1)
    return replace(ended, after_passes=led)


def _passes(
    correction: Correction,
    method: Keypose,
    start: Pass,
    tried: list[Pass],
    first_measured: Measured | None,
    before: Candidate | None,
) -> Generator[Pass, None, tuple[tuple[Trajectory, ...], Meeting | None]]:
    """Where the passes lead one after another, the start not counted, until they meet another
    start's or lead out of sight; and where they meet."""
    free, segment = correction.scene, correction.segment
    present, pass_name, led = start.trajectory, start.what, list[Trajectory]()
    for turn in range(method.passes):
        first = first_measured if turn == 0 else None
        measured = first or _measure(free, segment, method, present, correction.films)
        tried.append(Pass(pass_name, present, measured.score))
        yield tried[-1]
        steady = _steadied(correction, present, IN_PASSES) if turn else correction
        following = steady.solve(present, measured.steps, Cauchy())
        if not is_sound(free, segment, following):
            break
        present, pass_name = following, "pass"
        led.append(present)
        if before is not None and (met := _meeting(free, present, before)) is not None:
            return tuple(led), met
    return tuple(led), None


def _meeting(free: Scene, present: Trajectory, before: Candidate) -> Meeting | None:
    """Where a trajectory meets one of those from another start; None where it meets none."""
    away = [distance_px(free, present, there).mean() for there in before.after_passes]
    nearest = int(np.argmin(away)) if away else 0
    if not away or not away[nearest] < MEETS * extent_px(free, present):
        return None
    return Meeting(present, before.after_passes[nearest])


def _ended(correction: Correction, motion: Trajectory, measured: Measured, index: int) -> Candidate:
    """Rate a motion: what anchors, limits and steps say, and how well pictures are explained."""
    cost = correction.cost(motion, measured.steps) + measured.unexplained
    return Candidate(index, motion, cost, measured.score, measured.drift_px, correction.anchors)


def _steadied(correction: Correction, present: Trajectory, weight: float) -> Correction:
    """Smooth keypoints, their standard deviations divided by the weight. At an open end nothing
    tells what lasts from what shakes.
    """
    if correction.open_end:
        return correction
    anchors = smoothed_keypoints(correction.anchors, correction.scene, present).weighted(weight)
    films = tuple(film.steadied(present, weight) for film in correction.films)
    return replace(correction, anchors=anchors, films=films)


def _measure(
    scene: Scene,
    segment: Segment,
    method: Keypose,
    present: Trajectory,
    films: Sequence[OtherFilm] = (),
) -> Measured:
    """What the pictures say of a trajectory.

    Differences of brightness have a width that nobody knows, so they count by the logarithm of
    their mean square, as often in each frame as the body has degrees of freedom to explain them.
    """
    steps: list[Increments] = []
    drift, unexplained, first_score = np.empty(0), 0.0, 0.0
    shown = [(scene, segment.clip, present)]
    shown += [(film.scene, film.clip, film.seen(present)) for film in films]
    for number, (shown_scene, clip, motion) in enumerate(shown):
        motions, score = robust_pass(
            shown_scene, clip, motion, method.stride, method.inner, method.stop
        )
        steps.append(measured_increments(shown_scene, motion, motions))
        dofs = shown_scene.skeleton.dof_count
        unexplained += float(0.5 * (len(motion) - 1) * dofs * np.log(score + SCORE_GREY2))
        if number == 0:
            drift, first_score = drift_px(shown_scene, motion, motions), score
    return Measured(tuple(steps), drift, first_score, unexplained)


def _outcome(
    scene: Scene,
    free: Scene,
    begun: Starts,
    tried: list[Pass],
    ends: list[Candidate],
    best: Candidate,
    films: Sequence[OtherFilm],
) -> Outcome:
    chains = begun.chains
    joints = joint_evidence(free, ends, best)
    for film in films:
        sight = film.sight(best.trajectory)
        joints = joints if sight is None else joints.with_sight(sight)
    zeros = np.zeros((len(best.trajectory), len(scene.marks[1])))
    return Outcome(
        passes=tuple(tried),
        best=best.index,
        apart_px=zeros if chains is None else distance_px(scene, *chains),
        drift_px=best.drift_px,
        followed=True,
        diverged=False,
        gap=0.0,
        notes=begun.notes,
        joints=joints,
    )


def joint_evidence(
    free: Scene, ends: Sequence[Candidate], best: Candidate, keyed: tuple[int, ...] = (0, -1)
) -> JointEvidence:
    """What tracking saw of the best motion: its keypoints, how far from it brightness leads,
    and how far the others lie that took left and right alike. keyed: its rows that are keyframes.
    """
    anchors, height = best.anchors, best.anchors.height_px
    here = _joint_pixels(free, anchors, best.trajectory)
    away = np.linalg.norm(here - anchors.uv, axis=-1) / height
    others = [end for end in ends if end is not best and end.anchors is anchors]
    ways = [(end.trajectory, best.trajectory) for end in others]
    ways += [(met.here, met.there) for met in best.met]
    apart = [
        np.linalg.norm(_joint_pixels(free, anchors, a) - _joint_pixels(free, anchors, b), axis=-1)
        for a, b in ways
    ]
    return JointEvidence(
        anchors.parts,
        np.where(anchors.known, away, np.nan),
        anchors.visibility,
        np.max(apart, axis=0) / height if apart else np.full(away.shape, np.nan),
        _drift_by_part(free, best)[:, anchors.parts] / height,
        height,
        keyed,
        anchors.depth_sigma_m,
        _foot_distance(free, best) / height,
        np.array([part for ((part, _),) in anchors.feet.points], dtype=np.int64),
    )


def _foot_distance(free: Scene, end: Candidate) -> Array:
    """(N, F) pixels of heels and toes from where they are seen; NaN where they are not."""
    feet = end.anchors.feet
    here = image_points(free.camera, feet.at(end.trajectory.transforms(free.skeleton)))
    return np.asarray(np.linalg.norm(here - end.anchors.feet_uv, axis=-1))


def _drift_by_part(free: Scene, end: Candidate) -> Array:
    """(N, P) pixels by which a part's worst mark drifts in the steps to and from a frame, in the
    mean of both."""
    by_step = np.zeros((len(end.drift_px), free.skeleton.part_count))
    np.maximum.at(by_step.T, free.marks[1], end.drift_px.T)
    around = np.concatenate([by_step[:1], by_step, by_step[-1:]])
    return np.asarray(0.5 * (around[:-1] + around[1:]))


def _joint_pixels(free: Scene, anchors: Anchors, motion: Trajectory) -> Array:
    """(N, K, 2) where the joints are that have keypoints."""
    return image_points(free.camera, anchors.where(free.transforms(motion)))
