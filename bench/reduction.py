"""Recorded motions reduced to keyframes: how many frames one keyframe stands for, by interpolation
alone, and with the film tracked between keyframes; what a corrected keyframe moves; and what
tracking makes of a motion that is a little wrong."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from bench.keeping import Absent
from bench.sequences import Sequence, sequence
from bench.table import Expected, Pair, Report, Table
from bench.tracking import linear, track
from keypose.tracker.body.body import preset
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory, displaced, joined
from keypose.tracker.geometry.rotations import Array, exp_rotation
from keypose.tracker.reduction.reduce import reduce_motion
from keypose.tracker.reduction.result import Every, Tolerance
from keypose.tracker.tracking.tracker import Tracker
from tests.rendering import mocap
from tests.rendering.scenes import RECORDED, camera

FEWEST_PER_KEYFRAME, WITHIN_CM = 20.0, 2.0
"""Asked for with the film tracked between keyframes. By interpolation alone nothing comes near:
cubic curves, with velocities from neighbouring keyframes, reach 3.0 to 6.7, and with the motion's
own velocities 4.6 to 10.9."""
MOTIONS: dict[str, tuple[Callable[[Skeleton], Trajectory], str]] = {
    "walk": (mocap.walk, "adult_female"),
    "jump": (mocap.jump, "adult_male"),
    "wash": (mocap.wash, "elderly_male"),
    "pirouette": (mocap.pirouette, "adult_female"),
    "jumping jacks": (mocap.jumping_jacks, "adult_male"),
}
SPARSER = (20, 30, 40)
MOVED_M = 0.05
SEEDS = range(1, 4)
WRONG_RAD, WRONG_M, WRONG_FRAMES = np.radians(4.0), 0.03, 12
"""Standard deviations of a motion's errors, and over how many frames they are alike."""


def reduction(report: Report) -> None:
    """The whole group."""
    try:
        _interpolated(report)
    except FileNotFoundError:
        raise Absent("the recorded motions beside the checkout") from None
    _tracked(report)
    _corrected(report)
    _wrong(report)


def _interpolated(report: Report) -> None:
    """Each to a tolerance that other programs need, by interpolation alone."""
    table = report.table("interpolated, to 2 cm", "frames", "keyframes", "frames a keyframe")
    for name, (made, body) in MOTIONS.items():
        skeleton = Skeleton.of(preset(body))
        motion = made(skeleton)
        found = reduce_motion(skeleton, camera(), motion, Tolerance())
        table.row(name, len(motion), len(found.frames), found.frames_per_keyframe)


def _tracked(report: Report) -> None:
    """The film tracked between few keyframes, from the motion that was reduced."""
    report.note("joints, cm, mean/largest: with what lay between kept, and tracked from it;")
    columns = ("every", "keyframes", "frames a keyframe", "interpolated", "kept", "tracked")
    table = report.table("tracked", *columns)
    for name in RECORDED:
        shown = sequence(name)
        for every in SPARSER:
            _tracked_row(table, name, shown, every)


def _tracked_row(table: Table, name: str, shown: Sequence, every: int) -> None:
    frames = _keyframes(shown, every)
    tracker = _tracker(shown, frames, shown.truth)
    found = joined(track(tracker).trajectories)
    plain, kept = joined(linear(tracker)), _kept(tracker, shown.truth)
    errors = [_error(shown, each) for each in (plain, kept, found)]
    each = (len(shown.truth) - 1) / (len(frames) - 1)
    expected = [
        Expected("keyframes, of those allowed", FEWEST_PER_KEYFRAME / each, 1.0, "×"),
        Expected("largest", errors[-1].second, WITHIN_CM, "cm"),
    ]
    asked = expected if every == FEWEST_PER_KEYFRAME else []
    table.row(f"{name} {every}", every, len(frames), each, *errors, expected=asked)


def _corrected(report: Report) -> None:
    """The root of the middle keyframe moved across the picture: what else moves, and how evenly."""
    report.note("cm: what moves beyond the two segments, as kept and as tracked, and within them;")
    report.note("kink: by how much the velocity changes at most from frame to frame, cm a frame")
    columns = ("elsewhere", "tracked", "there", "kink")
    table = report.table("one keyframe moved by 5 cm", *columns)
    for name in RECORDED:
        shown = sequence(name)
        frames = _keyframes(shown, int(FEWEST_PER_KEYFRAME))
        at = len(frames) // 2
        before, after = (_tracker(shown, frames, shown.truth) for _ in range(2))
        pose = after.keyposes[frames[at]]
        moved = pose.p_camera_root + np.array([MOVED_M, 0.0, 0.0])
        after.move_keyframe(frames[at], replace(pose, p_camera_root=moved))
        kept = _apart(shown, *(_kept(each, shown.truth) for each in (before, after)))
        tracked = _apart(shown, *(joined(track(each).trajectories) for each in (before, after)))
        inside = np.arange(frames[at - 1] + 1, frames[at + 1])
        elsewhere, also = (float(np.delete(e, inside, 0).max()) for e in (kept, tracked))
        kink = float(np.abs(np.diff(kept, n=2, axis=0)).max())
        expected = [Expected("elsewhere", max(elsewhere, also), 0.0, "cm")]
        table.row(name, elsewhere, also, float(kept.max()), kink, expected=expected)


def _wrong(report: Report) -> None:
    """A motion that is wrong by some centimetres between right keyframes."""
    report.note(f"joints, cm, mean/largest over {len(SEEDS)} motions wrong by 4° and 3 cm")
    table = report.table("a motion that is wrong", "kept", "tracked from it", "from nothing")
    for name in RECORDED:
        shown = sequence(name)
        frames = _keyframes(shown, int(FEWEST_PER_KEYFRAME))
        nothing = _error(shown, joined(track(_tracker(shown, frames, None)).trajectories))
        kept, tracked = [], []
        for seed in SEEDS:
            wrong = _wronged(shown, seed)
            tracker = _tracker(shown, frames, wrong)
            kept.append(_error(shown, _kept(tracker, wrong)))
            tracked.append(_error(shown, joined(track(tracker).trajectories)))
        expected = [Expected("", _over(tracked).first, _over(kept).first, "cm")]
        table.row(name, _over(kept), _over(tracked), nothing, expected=expected)


def _over(errors: list[Pair]) -> Pair:
    mean, most = np.mean([e.first for e in errors]), max(e.second for e in errors)
    return Pair(float(mean), most, errors[0].names)


def _keyframes(shown: Sequence, every: int) -> list[int]:
    found = reduce_motion(shown.skeleton, shown.camera, shown.truth, Every(every))
    return list(found.frames)


def _tracker(shown: Sequence, frames: list[int], own: Trajectory | None) -> Tracker:
    """From a motion of before, or from nothing; the keyframes are the truth."""
    runs = [] if own is None else [(own.first_frame, own.last_frame)]
    poses = shown.keyposes(frames)
    given = (shown.video(), shown.camera, shown.skeleton, poses)
    return Tracker(*given, first_motion=own, own=runs)


def _kept(tracker: Tracker, own: Trajectory) -> Trajectory:
    """What is shown before anything is tracked."""
    poses = tracker.keyposes
    return joined([displaced(own, poses[a], poses[b], a, b) for a, b in tracker.spans])


def _apart(shown: Sequence, one: Trajectory, other: Trajectory) -> Array:
    away = one.joints(shown.skeleton) - other.joints(shown.skeleton)
    return np.asarray(100 * np.linalg.norm(away, axis=-1))


def _error(shown: Sequence, found: Trajectory) -> Pair:
    away = _apart(shown, found, shown.truth)
    return Pair(float(away.mean()), float(away.max()), ("mean cm", "largest cm"))


def _wronged(shown: Sequence, seed: int) -> Trajectory:
    """The truth with errors that come and go."""
    rng, skeleton = np.random.default_rng(seed), shown.skeleton
    R, t = shown.truth.writable()
    turns = np.zeros((len(t), skeleton.part_count, 3))
    for part, axis, is_turn in zip(
        skeleton.dof_part, skeleton.dof_axis, skeleton.dof_turns, strict=True
    ):
        if is_turn:
            turns[:, part, axis] = WRONG_RAD * _smooth_noise(rng, len(t))
    shift = np.stack([WRONG_M * _smooth_noise(rng, len(t)) for _ in range(3)], axis=-1)
    return Trajectory(0, R @ exp_rotation(turns), t + shift)


def _smooth_noise(rng: np.random.Generator, count: int) -> Array:
    """(count,) of unit variance."""
    reach = np.arange(-3 * WRONG_FRAMES, 3 * WRONG_FRAMES + 1)
    bell = np.exp(-0.5 * (reach / WRONG_FRAMES) ** 2)
    noise = rng.standard_normal(count + len(reach) - 1)
    return np.asarray(np.convolve(noise, bell, "valid") / np.linalg.norm(bell))
