"""People who stand, with their truth: legs by inverse kinematics, feet exactly where they stand.

A keyframe is posed on the picture, as a person or a draft does, by a distance that is wrong: limbs
make up for it as well as they can. Tracked by brightness, before a camera that looks down by 10°.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial

import cv2
import numpy as np
from scipy.ndimage import gaussian_filter1d

from bench.camera_films import hand_held
from bench.keeping import ROOT, digest, place_for
from bench.keyed import jittered
from bench.sequences import FPS
from bench.sequences import Sequence as Shown
from bench.tracking import keyframes_every, track
from keypose.tracker.body.body import preset
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import Array, exp_rotation
from keypose.tracker.operations.solve_space import solved
from keypose.tracker.session import Session
from keypose.tracker.session.camera_motion import CameraMotion, CameraPiece
from keypose.tracker.session.keyframe import Keyframe
from keypose.tracker.session.settings import TrackSettings
from keypose.tracker.solver.fit_joints import NEAREST_M
from keypose.tracker.solver.least_squares import JOINTS, least_squares
from keypose.tracker.solver.one_pose import OnePose
from keypose.tracker.solver.pose_terms import PointsInPicture, PosePrior, RootPosition
from keypose.tracker.solver.posed import free_skeleton, joints_and_landmarks
from keypose.tracker.solver.projection import image_points
from keypose.tracker.storage.fingerprints import Span
from keypose.tracker.storage.results import Results, segment_key
from keypose.tracker.tracking.result import SegmentResult
from keypose.tracker.tracking.tracker import Tracker
from tests.rendering.render import rendered
from tests.rendering.scenes import camera as usual_camera
from tests.rendering.settings import RenderSettings
from tests.tracker import session_cases

FRAMES = 91
KEY_EVERY = 30
FLOOR_M = 0.86
AWAY_M = 5.8
TILT_RAD = np.radians(10.0)
HIP_HALF_M = 0.0847
STRAIGHT = 0.998
"""Half of the distance of the hips, and how straight a leg stands, of its length."""
POSED_RAD = np.radians(4.0)
POSED_PX = 1.0
"""Of a keyframe about the truth's pose, and of its joints in the picture."""


@dataclass(frozen=True, eq=False)
class Steps:
    """Where soles are: the ankle's ground places (N, 3) of left and right, y up from the floor,
    and by how much each foot is tipped onto its toe, radians (N,).  root (N, 2): x and z of the
    waist.  low (N,): metres that it is lower than legs reach, negative in the air; yaw (N,)."""

    feet: tuple[Array, Array]
    tipped: tuple[Array, Array]
    root: Array
    low: Array
    yaw: Array


def _eased(frames: int, at: float, over: float) -> Array:
    """From 0 to 1 at a frame, over so many frames, without a jerk."""
    s = np.clip((np.arange(frames) - at) / over, 0, 1)
    return np.asarray(s**3 * (10 - 15 * s + 6 * s**2))


def _bump(frames: int, at: float, over: float) -> Array:
    s = np.clip((np.arange(frames) - at) / over, 0, 1)
    return np.asarray(np.sin(np.pi * s) ** 2)


def _stands(frames: int = FRAMES, apart: float = 0.24, yaw: float = 0.5) -> Steps:
    """Somebody who stands and sways by some millimetres."""
    s = np.arange(frames) / FPS
    x = 0.5 * apart
    across = np.array([np.cos(yaw), 0.0, -np.sin(yaw)])
    feet = [np.tile(side * x * across, (frames, 1)) for side in (1, -1)]
    root = np.column_stack([0.012 * np.sin(1.6 * s), 0.010 * np.sin(1.1 * s + 1)])
    zero = np.zeros(frames)
    return Steps((feet[0], feet[1]), (zero, zero), root, zero, np.full(frames, yaw))


def standing_man() -> Steps:
    return _stands()


def shuffle(frames_each: int = 6) -> Steps:
    """Each foot moves by 15 cm in a fifth of a second, one after the other, twice."""
    steps = _stands()
    left, right = (foot.copy() for foot in steps.feet)
    root = steps.root.copy()
    for at in (22, 58):
        for foot, start in ((left, at), (right, at + frames_each + 2)):
            foot[:, 0] += 0.15 * _eased(FRAMES, start, frames_each)
            foot[:, 1] += 0.015 * _bump(FRAMES, start, frames_each)
        root[:, 0] += 0.15 * _eased(FRAMES, at, 2 * frames_each + 2)
    return replace(steps, feet=(left, right), root=root)


def jump() -> Steps:
    """Crouches, leaps 35 cm to the side and 30 nearer, lands, and stands."""
    steps = _stands()
    s = np.clip((np.arange(FRAMES) - 36) / 15, 0, 1)
    high = 0.5 * 9.81 * (15 / FPS) ** 2 * s * (1 - s)
    forward = np.clip(s, 0, 1)[:, None] * (0.35, 0.0, -0.3)
    feet = []
    for foot in steps.feet:
        foot = foot + forward
        foot[:, 1] += high
        feet.append(foot)
    root = steps.root + _eased(FRAMES, 34, 19)[:, None] * (0.35, -0.3)
    low = 0.16 * _bump(FRAMES, 16, 22) + 0.20 * _bump(FRAMES, 48, 26)
    low = gaussian_filter1d(low, 1.0) - 0.0
    air = (s > 0) & (s < 1)
    tipped = 0.5 * _bump(FRAMES, 33, 20) * air
    return Steps((feet[0], feet[1]), (tipped, tipped), root, low, steps.yaw)


def squat() -> Steps:
    """Twice down and up again."""
    steps = _stands(apart=0.36)
    low = 0.34 * (_bump(FRAMES, 6, 38) + _bump(FRAMES, 47, 38))
    return replace(steps, low=low)


def walk(frames: int = FRAMES, stride: float = 1.16, rise: float = 0.0) -> Steps:
    """Along a line that leads away from the camera and to the side; feet roll over their toes.

    stride: metres of two steps.  rise: of two steps on stairs.
    """
    heading, beat = 2.35, 32
    ahead = np.array([-np.sin(heading), 0.0, -np.cos(heading)])
    aside = np.array([np.cos(heading), 0.0, -np.sin(heading)])
    feet, tipped = [], []
    for side, start in ((1, 2), (-1, 2 - beat // 2)):
        along, high, tip = np.zeros(frames), np.zeros(frames), np.zeros(frames)
        for step in range(-1, frames // beat + 2):
            at = start + beat * step
            along += stride * _eased(frames, at, 13)
            high += 0.10 * _bump(frames, at, 13) + rise * _eased(frames, at, 9)
            tip += 0.55 * _bump(frames, at - 5, 13)
        along -= stride * (frames / beat / 2 + 0.75)
        foot = along[:, None] * ahead + side * 0.07 * aside
        foot[:, 1] = high
        feet.append(foot)
        tipped.append(tip)
    middle = 0.5 * (feet[0] + feet[1])
    path = gaussian_filter1d(middle, 6.0, axis=0, mode="nearest")
    line = np.polynomial.polynomial.polyfit(np.arange(frames), path[:, [0, 2]], 1)
    root = line[0] + np.arange(frames)[:, None] * line[1]
    return Steps(
        (feet[0], feet[1]),
        (tipped[0], tipped[1]),
        root,
        np.full(frames, 0.02),
        np.full(frames, heading),
    )


def stairs() -> Steps:
    """Up, by 17 cm a step; the feet do not roll."""
    steps = walk(stride=0.60, rise=0.34)
    flat = np.zeros_like(steps.low)
    return replace(steps, tipped=(flat, flat), low=flat + 0.05)


def treadmill() -> Steps:
    """The walk, on a belt that takes every stance back as fast."""
    steps = walk()
    back = steps.root - steps.root[FRAMES // 2]
    feet = [foot - np.insert(back, 1, 0.0, axis=1) for foot in steps.feet]
    return replace(steps, feet=(feet[0], feet[1]), root=steps.root - back)


def chair() -> Steps:
    """Sits for the whole time, the feet on the floor before the chair."""
    steps = _stands(apart=0.3)
    ahead = -0.42 * np.array([np.sin(0.5), 0.0, np.cos(0.5)])
    feet = [foot + ahead for foot in steps.feet]
    return replace(steps, feet=(feet[0], feet[1]), low=steps.low + 0.26)


def moved(skeleton: Skeleton, steps: Steps) -> Trajectory:
    """The motion in a level frame, y down, the floor at FLOOR_M, metres."""
    names, count = skeleton.body.index, len(steps.low)
    legs = [skeleton.joints[names(f"left_{part}")][1] for part in ("shin", "foot")]
    upper, lower = float(legs[0]), float(legs[1])
    R_root = exp_rotation(np.column_stack([np.zeros(count), steps.yaw, np.zeros(count)]))
    Rs = np.tile(np.eye(3), (count, skeleton.part_count, 1, 1))
    Rs[:, 0] = R_root
    each = zip(("left", "right"), steps.feet, steps.tipped, strict=True)
    ankles = [_ankle(skeleton, side, foot, tip, steps.yaw) for side, foot, tip in each]
    p = np.column_stack([steps.root[:, 0], np.zeros(count), steps.root[:, 1]])
    hips = [(R_root @ skeleton.joints[names(f"{side}_thigh")]) for side in ("left", "right")]
    reach = STRAIGHT * (upper + lower)
    highest = []
    for (A, _), hip in zip(ankles, hips, strict=True):
        flat = A - p - hip
        aside = flat[:, 0] ** 2 + flat[:, 2] ** 2
        highest.append(flat[:, 1] - np.sqrt(np.maximum(reach**2 - aside, 0.01)))
    p[:, 1] = gaussian_filter1d(np.max(highest, axis=0), 1.2, mode="nearest") + 0.002 + steps.low
    for side, (A, R_foot), hip in zip(("left", "right"), ankles, hips, strict=True):
        thigh, shin, foot = (names(f"{side}_{part}") for part in ("thigh", "shin", "foot"))
        to = A - p - hip
        far = np.minimum(np.linalg.norm(to, axis=1), 0.9999 * (upper + lower))
        to = to / np.linalg.norm(to, axis=1, keepdims=True)
        x = R_root[:, :, 0] - (R_root[:, :, 0] * to).sum(axis=1, keepdims=True) * to
        x = x / np.linalg.norm(x, axis=1, keepdims=True)
        cos = (upper**2 + far**2 - lower**2) / (2 * upper * far)
        a = np.arccos(np.clip(cos, -1, 1))[:, None]
        knee = upper * (np.cos(a) * to + np.sin(a) * np.cross(to, x))
        down = (far[:, None] * to - knee) / lower
        R_thigh, R_shin = (np.stack([x, y, np.cross(x, y)], axis=-1) for y in (knee / upper, down))
        Rs[:, thigh] = _seen_from(R_root, R_thigh)
        Rs[:, shin] = _seen_from(R_thigh, R_shin)
        Rs[:, foot] = _seen_from(R_shin, R_foot)
    swing = np.linspace(0, 4, count)
    for side, sign in (("left", 1.0), ("right", -1.0)):
        turn = np.zeros((count, 3))
        turn[:, 0], turn[:, 2] = 0.2 * sign * np.sin(swing), -0.15 * sign
        Rs[:, names(f"{side}_upper_arm")] = exp_rotation(turn)
        Rs[:, names(f"{side}_forearm")] = exp_rotation(np.tile([-0.35, 0, 0], (count, 1)))
    return Trajectory(0, Rs, p)


def _ankle(
    skeleton: Skeleton, side: str, foot: Array, tip: Array, yaw: Array
) -> tuple[Array, Array]:
    """Where an ankle is, and how its foot is turned, which is tipped about its toe."""
    part = skeleton.body.parts[skeleton.body.index(f"{side}_foot")]
    toe = np.array(part.landmarks[f"{side}_toe"])
    zero = np.zeros_like(yaw)
    R_flat = exp_rotation(np.column_stack([zero, yaw, zero]))
    R = R_flat @ exp_rotation(np.column_stack([tip, zero, zero]))
    below = np.column_stack([foot[:, 0], FLOOR_M - foot[:, 1], foot[:, 2]])
    p_toe = below + R_flat @ (toe * (1, 0, 1))
    return p_toe - R @ toe, R


def _seen_from(R_parent: Array, R_part: Array) -> Array:
    return np.asarray(np.swapaxes(R_parent, -1, -2) @ R_part)


@dataclass(frozen=True, eq=False)
class Case:
    """distances: of keyframes, by which the true one is multiplied, in turn.  path: where the
    camera goes in the level world, from a camera that looks down; None where it stands still.
    unit_m: of the path as it was found, None where it is known in metres.
    """

    steps: Callable[[], Steps]
    distances: tuple[float, ...] = (0.97, 1.03)
    path: Callable[[int], CameraPath] | None = None


def _walks_beside(frames: int) -> CameraPath:
    """A hand-held camera that goes along with the walker, and comes nearer."""
    s = np.linspace(0, 1, frames)[:, None]
    p = s * (-0.9, 0.0, 1.0)
    zero = np.zeros(frames)
    return hand_held(p, zero - 0.05 * s[:, 0], zero, 31)


CASES: Mapping[str, Case] = {
    "walk": Case(walk),
    "shuffle of 15 cm": Case(shuffle),
    "slow shuffle": Case(partial(shuffle, 14)),
    "jump": Case(jump),
    "jump, landing 10 % nearer": Case(jump, (1.0, 1.0, 0.9, 0.9)),
    "stands, 8 % too near": Case(standing_man, (0.92,)),
    "stands, 8 % too far": Case(standing_man, (1.08,)),
    "stands, ± 8 %": Case(standing_man, (0.92, 1.08)),
    "squat": Case(squat),
    "sits": Case(chair),
    "stairs": Case(stairs),
    "treadmill": Case(treadmill),
    "walk, walking camera": Case(walk, path=_walks_beside),
}


@dataclass(frozen=True, eq=False)
class Made:
    """A case as tracked.  truth: in the camera frame.  up: true, world.  path: true."""

    skeleton: Skeleton
    camera: Camera
    truth: Trajectory
    up: Array
    session: Session
    fitting: Mapping[Span, SegmentResult]
    path: CameraPath | None

    def in_world(self, motion: Trajectory) -> Trajectory:
        """A motion in the true world."""
        return motion if self.path is None else motion.carried(self.path.Ts_world_camera)


def made(name: str) -> Made:
    """The case of this name."""
    case, skeleton, camera = CASES[name], Skeleton.of(preset("adult_male")), usual_camera()
    level = moved(skeleton, case.steps())
    tilt = exp_rotation(np.array([TILT_RAD, 0.0, 0.0]))
    Rs, ps = level.writable()
    Rs[:, 0], ps = tilt @ Rs[:, 0], ps @ tilt.T + (0.0, 0.0, AWAY_M)
    truth, path = Trajectory(0, Rs, ps), None
    if case.path is not None:
        path = case.path(len(truth))
        first = path.Ts_world_camera[0]
        path = CameraPath(path.Ts_camera_world @ first, path.zoom)
        truth = truth.carried(path.Ts_camera_world)
    shown = Shown(skeleton, camera, truth, _pictures(name, skeleton, camera, truth))
    frames = keyframes_every(KEY_EVERY, 0, len(truth) - 1)
    true = shown.keyposes(frames)
    shares = dict(zip(frames, np.resize(case.distances, len(frames)), strict=True))
    wrong = {f: posed_at(skeleton, camera, true[f], float(shares[f])) for f in frames}
    wrong = jittered(skeleton, wrong, 1)
    tracker = Tracker(shown.video(), camera, skeleton, wrong)
    found = track(tracker)
    session = _session(skeleton, camera, wrong, len(truth))
    if path is not None:
        own = CameraPath(_scaled(path.Ts_camera_world, 0.4), path.zoom)
        motion = CameraMotion.of("moves", own, pieces=(CameraPiece(first_frame=0, metres=None),))
        session = session.changed({"camera_motion": motion})
    results = Results()
    for one in found.segments:
        key = segment_key(session, one.first, one.last)
        results = results.with_result(replace(one, key=key, quality="full"))
    for stretch in results.unsolved(session):
        results = results.with_space(solved(session, stretch))
    fitting = results.fitting(session)
    return Made(skeleton, camera, truth, tilt @ [0.0, -1.0, 0.0], session, fitting, path)


def _scaled(Ts: Array, share: float) -> Array:
    Ts = Ts.copy()
    Ts[:, :3, 3] *= share
    return Ts


def posed_at(skeleton: Skeleton, camera: Camera, true: Pose, share: float) -> Pose:
    """The pose that looks most as the true one does, from a distance that is wrong."""
    free = free_skeleton(skeleton.body)
    points = joints_and_landmarks(free)
    uv = image_points(camera, points.at(pose_transforms(free, true)))
    start = Pose(true.Rs_parent_part, share * true.p_camera_root)
    precision = np.where(free.dof_turns == 1, POSED_RAD**-2.0, 0.0)
    terms = [
        PointsInPicture(points, camera, uv, np.full(len(uv), 1 / POSED_PX), NEAREST_M),
        PosePrior.of(start, precision),
        RootPosition.depth(start.p_camera_root, 1e-3),
    ]
    return least_squares(OnePose(free, terms, floor=1.0), start, JOINTS).state


def _session(skeleton: Skeleton, camera: Camera, poses: Mapping[int, Pose], count: int) -> Session:
    given = session_cases.session()
    video = given.view.video.model_copy(
        update={"frame_count": count, "width": camera.width, "height": camera.height}
    )
    keyframes = tuple(Keyframe.of(skeleton, pose, f, f / FPS) for f, pose in poses.items())
    return given.changed(
        {
            "video": video,
            "camera": camera,
            "body": skeleton.body,
            "keyframes": keyframes,
            "settings": TrackSettings(smooth=True),
        }
    )


def _pictures(name: str, skeleton: Skeleton, camera: Camera, truth: Trajectory) -> Array:
    plain = f"{skeleton.body!r} {camera!r}".encode()
    motion = truth.Rs_parent_part.tobytes() + truth.ps_camera_root.tobytes()
    key = digest(ROOT / "tests" / "rendering", plain, motion)
    place = place_for("stands-" + "".join(c if c.isalnum() else "-" for c in name), key, ".npy")
    if not place.is_file():
        frames = rendered(skeleton, truth, camera, RenderSettings())
        np.save(place, np.stack([cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY) for rgb in frames]))
    return np.asarray(np.load(place, mmap_mode="r"))
