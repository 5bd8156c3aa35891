"""Find what of a motion is implausible in space: sliding feet, depth, balance, shaking."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from keypose.tracker.body.joint_limits import Limits
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory, runs
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.pins import Pin
from keypose.tracker.session.results import SpaceFinding
from keypose.tracker.solver.posed import BodyPoints
from keypose.tracker.space.mirrored import mirrored_limbs

SLIDES_M = 0.05
FLOOR_M = 0.04
DEPTH_M = 0.04
TWISTED_RAD = np.radians(20.0)
LEANS_RAD = np.radians(20.0)
SLOW_M_S = 0.25
"""Balance is asked of a body whose root moves slower."""
SHAKES_M_S2 = 8.0
"""Root mean square acceleration of a waist that only shaking brings about at slow speeds."""


NEAR_END = 3
"""Frames on either side of a pin's end that count for it."""
STILL_M_S2 = 5.0
"""An acceleration that is as good as none."""
MOST_PUSH = 1.3
"""How many times what was tracked there, or that, a pin may accelerate a foot."""


@dataclass(frozen=True, eq=False)
class MotionInSpace:
    """What is looked at.

    camera: without distortion.  motion: in the world.  tracked: the same before the last solve,
        which meets all keyframes.  path: of the camera over these frames; None where it is the
        world.
    stances: ranges over which a foot stands still, pinned or not.  pinned: which of them are.
    keyframes: frames whose pose is met exactly; soft: those met nearly.
    up_world: unit vector; None where up is not known.  floor_m: the floor's height along it.
    """

    skeleton: Skeleton
    camera: Camera
    motion: Trajectory
    tracked: Trajectory
    frames_per_second: float
    stances: Sequence[Pin]
    pinned: Sequence[bool]
    keyframes: Collection[int]
    up_world: Array | None
    floor_m: float | None
    soft: Collection[int] = ()
    path: CameraPath | None = None

    @property
    def eyes(self) -> Array | None:
        """(N, 3) where the camera was; None where it stands still, in the world's origin."""
        return None if self.path is None else self.path.Ts_world_camera[:, :3, 3]

    def places(self, stance: Pin, motion: Trajectory) -> Array:
        """(n, K, 3) of a stance's points over its frames."""
        body = self.skeleton.body
        part = body.index(stance.part)
        points = BodyPoints(self.skeleton, tuple(((part, p),) for p in stance.points(body)))
        first = motion.first_frame
        rows = slice(stance.first_frame - first, stance.last_frame + 1 - first)
        return points.at(motion.transforms(self.skeleton)[rows])


def space_findings(judged: MotionInSpace) -> tuple[SpaceFinding, ...]:
    """Everything that is found, the order that of the kinds."""
    return (
        *_slides(judged),
        *_floats(judged),
        *_keyframe_depths(judged),
        *_mirrored(judged),
        *_twisted(judged),
        *_leans(judged),
        *_shakes(judged),
        *_jumps(judged),
    )


def _slides(judged: MotionInSpace) -> Iterator[SpaceFinding]:
    """Feet that stand still and are not pinned."""
    for stance, pinned in zip(judged.stances, judged.pinned, strict=True):
        if pinned:
            continue
        p = judged.places(stance, judged.motion).mean(axis=1)
        away = np.linalg.norm(p - np.median(p, axis=0), axis=-1)
        if away.max() > SLIDES_M:
            yield _of_stance("slides", stance, int(np.argmax(away)), float(away.max()))


def _floats(judged: MotionInSpace) -> Iterator[SpaceFinding]:
    """Standing feet that are not on the floor, where it is known."""
    if judged.up_world is None or judged.floor_m is None:
        return
    for stance in judged.stances:
        high = (judged.places(stance, judged.motion) @ judged.up_world).min(axis=1)
        off = high - judged.floor_m
        row = int(np.argmax(np.abs(off)))
        usual = float(np.median(off))
        if abs(usual) > FLOOR_M:
            kind = "off_floor" if usual > 0 else "below_floor"
            yield _of_stance(kind, stance, row, abs(usual))


def _keyframe_depths(judged: MotionInSpace) -> Iterator[SpaceFinding]:
    """Keyframes at which a planted foot stands nearer or farther than at the others."""
    for stance in judged.stances:
        z = _depths(judged, stance)
        rows = [
            frame - stance.first_frame
            for frame in judged.keyframes
            if stance.first_frame <= frame <= stance.last_frame
        ]
        if not rows or len(z) < 3:
            continue
        usual = float(np.median(z[rows] if len(rows) > 2 else z))
        row = max(rows, key=lambda row: abs(z[row] - usual))
        if abs(z[row] - usual) > DEPTH_M:
            yield _of_stance("keyframe_depth", stance, row, float(z[row] - usual))


def _depths(judged: MotionInSpace, stance: Pin) -> Array:
    """(n,) metres along the view at which a stance's points were tracked, over its frames."""
    p = judged.places(stance, judged.tracked).mean(axis=1)
    if judged.path is None:
        return np.asarray(p[:, 2])
    first = stance.first_frame - judged.motion.first_frame
    Ts = judged.path.Ts_camera_world[first : first + len(p)]
    usual = np.median(p, axis=0)
    return np.asarray(((p - usual) * Ts[:, 2, :3]).sum(axis=1))


def _mirrored(judged: MotionInSpace) -> Iterator[SpaceFinding]:
    """Limbs that a keyframe may have the wrong way round in depth."""
    path, tracked = judged.path, judged.tracked
    in_camera = tracked if path is None else tracked.carried(path.Ts_camera_world)
    poses = {frame: in_camera.pose(frame) for frame in judged.keyframes}
    rate = judged.frames_per_second
    for limb in mirrored_limbs(judged.skeleton, judged.camera, poses, rate):
        yield SpaceFinding(
            kind="mirrored",
            part=limb.part,
            first_frame=limb.frame,
            last_frame=limb.frame,
            go=limb.frame,
            amount=limb.nearer_m,
        )


def _twisted(judged: MotionInSpace) -> Iterator[SpaceFinding]:
    """Arms and legs that a keyframe turns about their own length farther than a body can."""
    limits = Limits.of(judged.skeleton.body)
    for frame in sorted((*judged.keyframes, *judged.soft)):
        excess, _ = limits.excess(judged.tracked.pose(frame).Rs_parent_part)
        for part in np.flatnonzero(np.abs(excess[:, 3]) > TWISTED_RAD).tolist():
            yield SpaceFinding(
                kind="twisted",
                part=judged.skeleton.body.names[part],
                first_frame=frame,
                last_frame=frame,
                go=frame,
                amount=float(excess[part, 3]),
            )


def _leans(judged: MotionInSpace) -> Iterator[SpaceFinding]:
    """A slow body whose trunk is not over its feet."""
    up, motion = judged.up_world, judged.motion
    if up is None or not judged.stances:
        return
    root = motion.ps_camera_root
    speed = np.linalg.norm(np.gradient(root, axis=0), axis=-1) * judged.frames_per_second
    joints = motion.transforms(judged.skeleton)[..., :3, 3]
    middle = joints.mean(axis=1)
    lean = np.full(len(motion), np.nan)
    standing = [(stance, judged.places(stance, motion)) for stance in judged.stances]
    for row in range(len(motion)):
        feet = _standing(standing, motion.first_frame + row)
        if len(feet) and speed[row] < SLOW_M_S:
            lean[row] = _out_of_balance(middle[row], feet, up)
    leaning = np.nan_to_num(lean) > LEANS_RAD
    for first, last in runs(leaning):
        if last - first >= 0.1 * judged.frames_per_second:
            row = first + int(np.argmax(lean[first : last + 1]))
            start = motion.first_frame
            yield SpaceFinding(
                kind="leans",
                part=judged.skeleton.body.names[0],
                first_frame=start + first,
                last_frame=start + last,
                go=start + row,
                amount=float(lean[row]),
            )


def _standing(stances: Sequence[tuple[Pin, Array]], frame: int) -> Array:
    """(K, 3) the points of the feet that stand at a frame."""
    points = [
        places[frame - stance.first_frame]
        for stance, places in stances
        if stance.first_frame <= frame <= stance.last_frame
    ]
    return np.concatenate(points) if points else np.zeros((0, 3))


def _out_of_balance(middle: Array, feet: Array, up: Array) -> float:
    """Radians by which the body's middle is out of the upright over the nearest of its feet."""
    away = middle - feet
    height = away @ up
    aside = np.linalg.norm(away - height[:, None] * up, axis=-1)
    toward = middle - feet.mean(axis=0)
    level = float(toward @ up)
    between = float(np.linalg.norm(toward - level * up))
    nearest = min(float(aside.min()), between)
    return float(np.arctan2(nearest, max(float(height.max()), 1e-6)))


def _shakes(judged: MotionInSpace) -> Iterator[SpaceFinding]:
    """A waist that is accelerated back and forth."""
    motion = judged.motion
    if len(motion) < 10:
        return
    a = np.diff(motion.ps_camera_root, 2, axis=0) * judged.frames_per_second**2
    usual = float(np.sqrt((a**2).sum(axis=-1).mean()))
    if usual > SHAKES_M_S2:
        row = int(np.argmax((a**2).sum(axis=-1))) + 1
        yield SpaceFinding(
            kind="shakes",
            part=judged.skeleton.body.names[0],
            first_frame=motion.first_frame,
            last_frame=motion.last_frame,
            go=motion.first_frame + row,
            amount=usual,
        )


def _jumps(judged: MotionInSpace) -> Iterator[SpaceFinding]:
    """Parts that are accelerated where a pin begins or ends, far beyond what was tracked there."""
    first, last = judged.motion.first_frame, judged.motion.last_frame
    pins = [pin for pin, is_pin in zip(judged.stances, judged.pinned, strict=True) if is_pin]
    for pin in pins:
        part = judged.skeleton.body.index(pin.part)
        for end in (frame for frame in pin.span if first < frame < last):
            (frame, after), (_, before) = (
                near_end(judged.skeleton, motion, part, end, judged.frames_per_second)
                for motion in (judged.motion, judged.tracked)
            )
            pushed = float(after.max(initial=0.0))
            if pushed > MOST_PUSH * max(float(before.max(initial=0.0)), STILL_M_S2):
                row = frame + int(after.argmax()) - pin.first_frame
                yield _of_stance("jumps", pin, row, pushed)


def near_end(
    skeleton: Skeleton, motion: Trajectory, part: int, end: int, rate: float
) -> tuple[int, Array]:
    """A part's accelerations (n,), m/s², near the frame at which a pin begins or ends; and the
    frame of the first."""
    count = len(motion) - 2
    if count < 1:
        return end, np.zeros(0)
    at = min(max(end - motion.first_frame - 1, 0), count - 1)
    start, stop = max(at - NEAR_END, 0), min(at + NEAR_END + 1, count)
    rows, frame = slice(start, stop + 2), motion.first_frame + start
    trajectory = Trajectory(frame, motion.Rs_parent_part[rows], motion.ps_camera_root[rows])
    p = trajectory.transforms(skeleton)[:, part, :3, 3]
    return frame + 1, np.asarray(np.linalg.norm(np.diff(p, 2, axis=0), axis=-1) * rate**2)


def _of_stance(kind: str, stance: Pin, row: int, amount: float) -> SpaceFinding:
    return SpaceFinding.model_validate(
        {
            "kind": kind,
            "part": stance.part,
            "first_frame": stance.first_frame,
            "last_frame": stance.last_frame,
            "go": stance.first_frame + row,
            "amount": amount,
        }
    )
