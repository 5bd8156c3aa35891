"""One segment between two keyframes: the cycle of passes, and what comes of it (DRIFT §2.2)."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tracker.drift import Closed, Motions, correct_drift
from tracker.geometry import Array
from tracker.images import Clip
from tracker.initial import blended, follow
from tracker.kernels.pairs import CAP, mean_capped_square
from tracker.methods import Keypose, Method, Paper
from tracker.motion import least_squares_pass, printed_score, robust_pass
from tracker.refine import refine
from tracker.scene import Scene
from tracker.stretch import Segment, distance_px, is_sound
from tracker.trajectory import Trajectory, interpolate

EXACT_KEYFRAMES = 100.0
"""Mean capped square, grey levels², below which two keyframes show the same texture."""
EXACT_ALLOWANCE, PLAIN_ALLOWANCE, NOISE = 1.15, 1.05, 2.0
"""How much worse than the passes the refinement may score: a share, and the noise of the pictures,
grey levels², near which shares say nothing."""
NOWHERE_PX = 1e6
"""Stands for the distance to a place that is behind the camera or no place at all."""
DOUBT = 0.5
"""Distance between the two chains, as a share of that between them and plain interpolation, above
which interpolation may still be the better one and is scored as well."""


@dataclass(frozen=True, eq=False)
class Pass:
    """A trajectory on the way, and its score (the lower the better within one segment).

    what: "interpolation", "both ways", "import", "pass" or "refinement".
    score: None where not judged.
    """

    what: str
    trajectory: Trajectory
    score: float | None


@dataclass(frozen=True, eq=False)
class Outcome:
    """All trajectories tried, the best of them, and how the evidence agrees.

    apart_px: (N, M) how far the chains from the two keyframes lie apart at every mark of the
        scene; zero for a method that does not follow from both.
    drift_px: (N - 1, M) how far each frame's own motion, in the last pass, led from the pose that
        the trajectory has next: what drift correction had to take away.
    followed: neither chain left the space before the camera.
    diverged: a pass left it; the pass was dropped.
    gap: how far the last correction missed the keyframe before it was set exactly: radians.
    """

    passes: tuple[Pass, ...]
    best: int
    apart_px: Array
    drift_px: Array
    followed: bool
    diverged: bool
    gap: float

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
    present, start = _paper_start(scene, segment, method)
    tried: list[Pass] = []
    diverged, drift, gap = False, _nothing_px(scene, present)[1:], 0.0
    for number in range(method.passes + 1):
        what = "pass" if number else start
        if number == method.passes:
            tried.append(Pass(what, present, printed_score(scene, segment.clip, present)))
            yield tried[-1]
            break
        motions, score = least_squares_pass(scene, segment.clip, present, method.inner)
        drift = _drift_px(scene, present, motions)
        tried.append(Pass(what, present, score))
        yield tried[-1]
        if number - _best(tried) >= method.patience:
            break
        following = _closed(scene, segment, present, motions)
        if following is None:
            diverged = True
            break
        present, gap = following.trajectory, following.gap
    apart = _nothing_px(scene, present)
    return Outcome(tuple(tried), _best(tried), apart, drift, True, diverged, gap)


def _paper_start(scene: Scene, segment: Segment, method: Paper) -> tuple[Trajectory, str]:
    """Interpolation, or the imported motion where it is wanted or scores better as printed."""
    plain = interpolate(segment.start, segment.end, segment.first_frame, segment.last_frame)
    imported = _imported(scene, segment, method)
    if imported is None:
        return plain, "interpolation"
    if method.initial == "auto":
        scores = [printed_score(scene, segment.clip, path) for path in (imported, plain)]
        if not scores[0] < scores[1]:
            return plain, "interpolation"
    return imported, "import"


def _imported(scene: Scene, segment: Segment, method: Method) -> Trajectory | None:
    """The imported motion, where it may be started from and lies before the camera."""
    imported = segment.imported
    if imported is None or method.initial == "linear" or not is_sound(scene, segment, imported):
        return None
    return imported


def _keypose(scene: Scene, segment: Segment, method: Keypose) -> Work:
    tried: list[Pass] = []
    plain = interpolate(segment.start, segment.end, segment.first_frame, segment.last_frame)
    chains = _from_both_ends(scene, segment, method)
    present, what = plain, "interpolation"
    if chains is not None and method.initial != "linear":
        present, what = _met_halfway(scene, segment, method, *chains), "both ways"
    apart = _nothing_px(scene, plain) if chains is None else distance_px(scene, *chains)
    drift, gap = _nothing_px(scene, plain)[1:], 0.0
    if method.judged and _in_doubt(scene, apart, plain, present):
        tried.append(Pass("interpolation", plain, _score(scene, segment.clip, plain, method)))
        yield tried[-1]
    imported = _imported(scene, segment, method)
    if imported is not None:
        ours = Pass(what, present, _score(scene, segment.clip, present, method))
        theirs = Pass("import", imported, _score(scene, segment.clip, imported, method))
        better, worse = (theirs, ours) if _is_preferred(theirs, ours, method) else (ours, theirs)
        if method.judged:  # the other one stays a choice, so that the result is worse than neither
            tried.append(worse)
            yield worse
        present, what = better.trajectory, better.what
    diverged = False
    for _ in range(method.passes):
        motions, score = robust_pass(
            scene, segment.clip, present, method.of, method.inner, method.stop
        )
        drift = _drift_px(scene, present, motions)
        tried.append(Pass(what, present, score))
        yield tried[-1]
        following = _closed(scene, segment, present, motions)
        if following is None:
            diverged = True
            break
        present, what, gap = following.trajectory, "pass", following.gap
    if present is not tried[-1].trajectory:
        last_score = _score(scene, segment.clip, present, method) if method.judged else None
        tried.append(Pass(what, present, last_score))
        yield tried[-1]
    best = _best(tried)
    refined = _refined(scene, segment, method, tried[best])
    if refined is not None:
        tried.append(refined)
        yield refined
        best = len(tried) - 1 if _is_better(scene, segment, method, refined, tried[best]) else best
    return Outcome(tuple(tried), best, apart, drift, chains is not None, diverged, gap)


def _from_both_ends(
    scene: Scene, segment: Segment, method: Keypose
) -> tuple[Trajectory, Trajectory] | None:
    """The chains from both keyframes, or None where one of them leaves the scene."""
    how = (method.of, method.chain_inner, method.stop, method.finest)
    first, last = segment.first_frame, segment.last_frame
    forward = follow(scene, segment.clip, segment.start, first, last, *how)
    backward = follow(scene, segment.clip, segment.end, last, first, *how)
    if is_sound(scene, segment, forward) and is_sound(scene, segment, backward):
        return forward, backward
    return None


def _met_halfway(
    scene: Scene, segment: Segment, method: Keypose, forward: Trajectory, backward: Trajectory
) -> Trajectory:
    """The blend of two chains by trust, unless the even one scores clearly better."""
    return blended(scene, forward, backward)


def _is_preferred(imported: Pass, own: Pass, method: Keypose) -> bool:
    """Whether to start from the imported motion."""
    assert imported.score is not None
    assert own.score is not None
    return method.initial == "import" or imported.score < own.score


def _in_doubt(scene: Scene, apart_px: Array, plain: Trajectory, blend: Trajectory) -> bool:
    return bool(apart_px.mean() > DOUBT * distance_px(scene, plain, blend).mean())


def _refined(scene: Scene, segment: Segment, method: Keypose, start: Pass) -> Pass | None:
    trajectory = refine(scene, segment.clip, start.trajectory, method.refinement)
    if trajectory is start.trajectory or not is_sound(scene, segment, trajectory):
        return None
    score = _score(scene, segment.clip, trajectory, method) if method.judged else None
    return Pass("refinement", trajectory, score)


def _is_better(
    scene: Scene, segment: Segment, method: Keypose, refined: Pass, unrefined: Pass
) -> bool:
    """Whether the refinement is to be kept.

    The score compares neighbouring frames and so prefers the passes, which do just that; the
    refinement compares with the keyframes and is nearer to the truth if those are posed exactly.
    Unjudged, that alone decides.
    """
    exact = 0.0 < _keyframe_difference(scene, segment, method) < EXACT_KEYFRAMES
    if refined.score is None or unrefined.score is None:
        return exact
    allowance = EXACT_ALLOWANCE if exact else PLAIN_ALLOWANCE
    return refined.score < allowance * unrefined.score + NOISE


def _keyframe_difference(scene: Scene, segment: Segment, method: Keypose) -> float:
    """How unlike the textures of the two keyframes are, each laid straight onto the other one.

    Mean capped square: small where both are posed exactly, 0 where nothing can be compared.
    """
    frames, ends = (segment.first_frame, segment.last_frame), (segment.start, segment.end)
    total = 0.0
    for a, b in ((0, 1), (1, 0)):
        slots = np.concatenate([segment.clip.slots(frames[k], frames[k]) for k in (a, b)])
        jump = Trajectory(
            0,
            np.stack([ends[a].Rs_parent_part, ends[b].Rs_parent_part]),
            np.stack([ends[a].p_camera_root, ends[b].p_camera_root]),
        )
        total += 0.5 * _capped(scene, segment.clip, slots, jump, method)
    return total


def _best(tried: list[Pass]) -> int:
    """The lowest score; the last trajectory where it was not judged."""
    if tried[-1].score is None:
        return len(tried) - 1
    return int(np.argmin([np.inf if p.score is None else p.score for p in tried]))


def _score(
    scene: Scene, clip: Clip, trajectory: Trajectory, method: Keypose, step: int = 1
) -> float:
    slots = clip.slots(trajectory.first_frame, trajectory.last_frame)
    return _capped(scene, clip, slots, trajectory, method, step)


def _capped(
    scene: Scene,
    clip: Clip,
    slots: NDArray[np.int64],
    trajectory: Trajectory,
    method: Keypose,
    step: int = 1,
) -> float:
    return float(
        mean_capped_square(
            scene.arrays, scene.lens, scene.sight, clip.levels[0], slots,
            *trajectory.loose(), method.of, step, CAP,
        )
    )  # fmt: skip


def _closed(scene: Scene, segment: Segment, present: Trajectory, motions: Motions) -> Closed | None:
    """The drift-corrected trajectory, or None where the motions led out of sight."""
    if not np.isfinite(motions.ps_camera_root).all():
        return None
    closed = correct_drift(present, motions, segment.end)
    return closed if is_sound(scene, segment, closed.trajectory) else None


def _drift_px(scene: Scene, present: Trajectory, motions: Motions) -> Array:
    """(N - 1, M) distance in the picture of where motions lead and where the trajectory goes."""
    led = Trajectory(present.first_frame + 1, motions.Rs_parent_part, motions.ps_camera_root)
    rest = Trajectory(led.first_frame, present.Rs_parent_part[1:], present.ps_camera_root[1:])
    return np.nan_to_num(distance_px(scene, led, rest), nan=NOWHERE_PX, posinf=NOWHERE_PX)


def _nothing_px(scene: Scene, trajectory: Trajectory) -> Array:
    """(N, M) zeros."""
    return np.zeros((len(trajectory), len(scene.marks[1])))
