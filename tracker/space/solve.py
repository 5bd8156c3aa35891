"""Solve last for the motion of neighbouring segments in space.

What was tracked shows where the body is seen, and how it moves from frame to frame, each as far as
the picture decided it. Along the view the picture decides little; there pins, a floor and the
smoothness of bodies do. Unknown are all poses of the stretch, the places of its pins and the height
of the floor:

    E = Σ ρ(|π(T p) − uv| / 0.003 H) + Σ ρ(√w (inc − m)) + Σ (excess / 2°)² + Σ (Δinc)² / bend²
        + Σ ρ(|T_j p − c_i| / 1 mm) + Σ ((u · c_i − h − a_i) / 0.5 mm)²
        + Σ |Δ³x fps³ / σ|² + keyframes,

with uv, m those of the tracked motion, H the body's height in the picture, a_i how far a pinned
point is above the floor. Where several films show the motion, the first sum is over the pictures of
all of them. Keyframes are met exactly, but for those that are said to be soft: nearly,
or in the picture alone; of limbs keyed alone the last joints are exactly where they were seen,
those between nearly.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from keypose.tracker.body.body import Body
from keypose.tracker.body.joint_limits import Limits
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import Array, apply_transform
from keypose.tracker.keypoints.on_body import height_px, is_persons
from keypose.tracker.solver.frames import LinkIn, SharedTermIn, TermIn
from keypose.tracker.solver.least_squares import QUICK, least_squares
from keypose.tracker.solver.motion_problem import EVERY, MotionProblem, MotionState
from keypose.tracker.solver.pose_terms import (
    DepthFromRoot,
    JointLimits,
    PointsInPicture,
    PosePrior,
    RootPosition,
)
from keypose.tracker.solver.posed import BodyPoints, Posed, joints_and_landmarks, with_free_parts
from keypose.tracker.solver.projection import image_points
from keypose.tracker.solver.robust import Huber
from keypose.tracker.solver.sigmas import (
    BEND,
    BETWEEN_M,
    BETWEEN_SEEN_M,
    BOND_M,
    DOUBT_FLOOR,
    END_M,
    EXACT_SEEN_SHARE,
    FADE_S,
    FLOOR_M,
    JERK_M_S3,
    KEY_DEPTH_SHARE,
    KEY_RAD,
    KEY_SEEN_SHARE,
    LIMIT_RAD,
    OTHER_JERK_M_S3,
    PIN_CHANGE_M_S2,
    PIN_M,
    SEEN_ENDS_WIDER,
    SEEN_SHARE,
    STEP,
    UNDECIDED_PER_M,
)
from keypose.tracker.solver.smoothness import Increments, Smoothness, increments
from keypose.tracker.solver.space_terms import SECOND, AtOnePlace, Differences, Floor, Near, OnFloor
from keypose.tracker.solver.terms import Link, SharedTerm, Term
from keypose.tracker.space.contacts import speed_m_s
from keypose.tracker.space.pinned import (
    HeldPoint,
    PinnedPoint,
    at_places,
    knees_as_tracked,
    near_pins,
)
from keypose.tracker.tracking.cues.anchors import with_free_joints
from keypose.tracker.tracking.parts.limb_keyframes import (
    KeyedParts,
    with_exact_ends,
)
from keypose.tracker.tracking.segment import NEAREST_M

FOOT: Final = "foot"
FAST_M_S = 2.0
LEAST_SHARE = 0.2
NEAR_S = 0.1
"""A foot has its jerk at this speed and above, a slower one as much less as it is slower, but no
less than this share: what stands does not jerk, whatever the tracker's noise. Of the speeds within
so many seconds the highest counts, so that a landing is as sharp as the step before it."""


def parts_of_known_jerk(body: Body) -> set[str]:
    """Names of a person's own parts, not of what a hand holds. Without feet, whose turns shape the
    swing of a leg: were they free, a fast foot would lose some of its peak speed."""
    return {name for name in body.names if _bare(name) in JERK_M_S3 and _bare(name) != FOOT}


def jerk_points(
    skeleton: Skeleton, motion: Trajectory, frames_per_second: float
) -> tuple[BodyPoints, Array]:
    """The joints of a body and its landmarks, and their sigmas, m/s³: (K,), or (N − 3, K) of every
    third difference of the motion as tracked, N frames, where the body has feet."""
    points = joints_and_landmarks(skeleton)
    names = [_bare(skeleton.body.names[part]) for ((part, _),) in points.points]
    sigma = np.array([JERK_M_S3.get(name, OTHER_JERK_M_S3) for name in names])
    feet = np.array([name == FOOT for name in names])
    if not feet.any():
        return points, sigma
    share = np.ones((len(motion) - 3, len(names)))
    p_camera = points.at(motion.transforms(skeleton))
    for k in np.flatnonzero(feet):
        share[:, k] = _share(speed_m_s(p_camera[:, k], frames_per_second), frames_per_second)
    return points, sigma * share


def _bare(name: str) -> str:
    """Without its side."""
    return name.removeprefix("left_").removeprefix("right_")


def _share(speed: Array, frames_per_second: float) -> Array:
    """(N − 3,) of the jerk of a fast foot, by a foot's speed (N,) m/s; a difference is that of the
    four frames it is made of."""
    near = max(1, round(NEAR_S * frames_per_second))
    padded = np.pad(speed, near, mode="edge")
    highest = np.lib.stride_tricks.sliding_window_view(padded, 2 * near + 4).max(axis=1)
    return np.asarray(np.clip(highest / FAST_M_S, LEAST_SHARE, 1.0))


SEEN_KERNEL = Huber(2.0)
PIN_KERNEL = Huber(10.0)
LEAST_BEFORE_M: Final = 0.5
"""A body with a joint nearer to a camera, or behind it, is not seen by it."""
HARD = 1e9
"""1/σ² of a keyframe that is met exactly."""


@dataclass(frozen=True, eq=False)
class FilmInSpace:
    """Another film of a stretch.

    camera: without distortion.  Ts_film_first (N, 4, 4): from the first camera's frame to this
    one's, at each frame of the stretch.  shows (N,): whether it was running.
    """

    camera: Camera
    Ts_film_first: Array
    shows: NDArray[np.bool_]

    def shown(
        self, skeleton: Skeleton, motion: Trajectory, *others: Trajectory
    ) -> tuple[NDArray[np.bool_], Array, list[Trajectory]]:
        """Where it shows a motion of the stretch, (N,), Ts_film_first with the first camera's own
        frame in place of where it does not, and the motions there: whom a camera has behind it, it
        does not show."""
        joints = apply_transform(self.Ts_film_first, motion.transforms(skeleton)[..., :3, 3])
        shows = self.shows & (self.camera.depth(joints) > LEAST_BEFORE_M).all(axis=-1)
        Ts = np.where(shows[:, None, None], self.Ts_film_first, np.eye(4))
        return shows, Ts, [each.carried(Ts) for each in (motion, *others)]


@dataclass(frozen=True, eq=False)
class SpaceProblem:
    """What a stretch is solved with.

    camera: of the video, without distortion.  motion: as tracked, N frames.
    observability (N − 1, P): how far the picture decided each part's motion, NaN where unknown.
    keyframes: frames whose pose is met exactly; soft: those met nearly; seen: those of these that
        are met exactly in the picture.  keyed_parts: limbs that are exact at other frames.
    held: points at known places.  smooth: whether jerk counts.  up_world: unit vector.  floor_m:
        the floor's height along it, where it is known.  tilt_rad: σ of up, which is as known where
        that is 0.  path: of the
        camera over these frames; None where it is the world.  films: others of the same motion.
    """

    skeleton: Skeleton
    camera: Camera
    motion: Trajectory
    observability: Array
    keyframes: Collection[int]
    frames_per_second: float
    soft: Collection[int] = ()
    seen: Collection[int] = ()
    keyed_parts: Sequence[KeyedParts] = ()
    pins: Sequence[PinnedPoint] = ()
    held: Sequence[HeldPoint] = ()
    smooth: bool = True
    up_world: Array = field(default_factory=lambda: np.array([0.0, -1.0, 0.0]))
    floor_m: float | None = None
    tilt_rad: float = 0.0
    path: CameraPath | None = None
    films: Sequence[FilmInSpace] = ()

    @property
    def points(self) -> tuple[PinnedPoint | HeldPoint, ...]:
        """All points of the body whose place is given, or one."""
        return (*self.pins, *self.held)

    @cached_property
    def motion_in_world(self) -> Trajectory:
        """The motion as it was tracked, in the world."""
        return self.in_world(self.motion)

    def in_world(self, motion: Trajectory) -> Trajectory:
        """A motion of these frames in the world."""
        return motion if self.path is None else motion.carried(self.path.Ts_world_camera)


@dataclass(frozen=True, eq=False)
class SpaceSolution:
    """The motion in space.

    motion: in the camera frame.  places (Q, 3): where the pins are in the world.  off_m: of each
        pin how far its point is from there at every frame of its range.  floor_m: height of the
        floor along up; None without pins on it.  up_world: as it was known, or tilted.
    """

    motion: Trajectory
    places: Array
    off_m: tuple[Array, ...]
    floor_m: float | None
    up_world: Array


def solve_space(
    problem: SpaceProblem,
    cancelled: Callable[[], bool] | None = None,
    start: Trajectory | None = None,
) -> SpaceSolution:
    """Solve for the motion of a stretch. start: a motion near it, by default as tracked."""
    skeleton = _free(problem)
    start = problem.motion if start is None else start
    pins = [BodyPoints(skeleton, (((pin.part, pin.p_part),),)) for pin in problem.pins]
    frames = [pin.rows(start) for pin in problem.pins]
    there = problem.in_world(start).transforms(skeleton)
    places = [p.at(there[rows])[:, 0].mean(axis=0) for p, rows in zip(pins, frames, strict=True)]
    floor, shared = _shared(problem, np.array(places).reshape(-1, 3))
    poses = MotionProblem(
        skeleton,
        (
            *_seen(problem, skeleton),
            *_keyframes(problem, skeleton),
            *_limbs(problem, skeleton),
            *knees_as_tracked(skeleton, problem.motion, problem.pins),
            *at_places(skeleton, problem.motion, problem.held, BOND_M),
            _limits(problem, skeleton),
        ),
        _links(problem, skeleton),
        EVERY,
        _pinned(problem, pins, frames, floor, shared),
    )
    with threadpool_limits(1, "blas"):  # its matrices are small: threads would wait for each other
        motion_state = least_squares(poses, MotionState(start, shared), QUICK, cancelled).state
    return _solution(problem, skeleton, motion_state, pins, frames, floor)


def _solution(
    problem: SpaceProblem,
    skeleton: Skeleton,
    motion_state: MotionState,
    pins: list[BodyPoints],
    frames: list[slice],
    floor: Floor,
) -> SpaceSolution:
    """Put exact keyframes and limbs in: what they moved by is rounding."""
    R, t = motion_state.motion.writable()
    for frame in set(problem.keyframes) - set(problem.soft):
        row = frame - problem.motion.first_frame
        R[row], t[row] = problem.motion.Rs_parent_part[row], problem.motion.ps_camera_root[row]
    for keyed in problem.keyed_parts:
        row = keyed.frame - problem.motion.first_frame
        R[row] = with_exact_ends(skeleton, keyed, Pose(R[row], t[row])).Rs_parent_part
    motion = Trajectory(problem.motion.first_frame, R, t)
    places = motion_state.shared[: 3 * len(pins)].reshape(-1, 3)
    there = problem.in_world(motion).transforms(skeleton)
    off = [
        np.linalg.norm(p.at(there[rows])[:, 0] - place, axis=-1)
        for p, rows, place in zip(pins, frames, places, strict=True)
    ]
    on_floor = any(pin.floor for pin in problem.pins)
    height = floor.height(motion_state.shared) if on_floor else None
    return SpaceSolution(motion, places, tuple(off), height, floor.up(motion_state.shared))


def _free(problem: SpaceProblem) -> Skeleton:
    """Free the parts that pins or keypoints can turn, and those whose jerk is known.

    Hands, feet and neck, which nothing tracks as a rule, are interpolated between keyframes, with a
    corner at each of them.
    """
    skeleton = problem.skeleton
    names = {skeleton.body.names[pin.part] for pin in problem.points}
    if is_persons(skeleton.body):
        skeleton = with_free_joints(skeleton)
        names |= parts_of_known_jerk(skeleton.body)
    return with_free_parts(skeleton, names)


def _shared(problem: SpaceProblem, places: Array) -> tuple[Floor, Array]:
    """The floor, and places, its tilt and its height, to begin with."""
    on_floor = [pin.floor for pin in problem.pins]
    heights = [
        place @ problem.up_world - pin.above_floor_m
        for place, pin in zip(places, problem.pins, strict=True)
        if pin.above_floor_m is not None
    ]
    height = problem.floor_m
    if height is None:
        height = float(np.mean(heights)) if heights else 0.0
    ways = np.linalg.svd(problem.up_world[None])[2][1:] if problem.tilt_rad else np.zeros((0, 3))
    about = places[on_floor].mean(axis=0) if any(on_floor) else np.zeros(3)
    floor = Floor(problem.up_world, ways, about)
    return floor, np.concatenate([places.ravel(), np.zeros(len(ways)), [height]])


def heights_px(problem: SpaceProblem, skeleton: Skeleton) -> Array:
    """(N,) of the body, were it to stand where it is; of a thing its greatest extent."""
    return heights_before(skeleton, problem.camera, problem.motion)


def heights_before(skeleton: Skeleton, camera: Camera, motion: Trajectory) -> Array:
    """(N,) the same of a motion before a camera."""
    z = camera.depth(motion.ps_camera_root)
    if is_persons(skeleton.body):
        at_key = height_px(skeleton, camera, motion.pose(motion.first_frame))
        return np.asarray(at_key * z[0] / z)
    rest = _points_seen(skeleton).of(Posed.of(skeleton, Pose.rest(skeleton, (0.0, 0.0, 0.0))))
    return np.asarray(np.ptp(rest, axis=0).max() * camera.fy / z)


def _seen(problem: SpaceProblem, skeleton: Skeleton) -> tuple[Term, ...]:
    """Points of the body where the tracked motion has them in the picture."""
    points = _points_seen(skeleton)
    uv = image_points(problem.camera, points.at(problem.motion.transforms(skeleton)))
    scale = 1 / (SEEN_SHARE * heights_px(problem, skeleton))
    wider = _wider(problem, points)
    every = scale[:, None] / wider
    first = PointsInPicture(points, problem.camera, uv, every, NEAREST_M, SEEN_KERNEL)
    return (first, *(_seen_in(film, problem, points, wider) for film in problem.films))


def _seen_in(film: FilmInSpace, problem: SpaceProblem, points: BodyPoints, wider: Array) -> Term:
    """The same in another film's picture, as far as they lie in it."""
    skeleton, camera = points.skeleton, film.camera
    shows, Ts, (there,) = film.shown(skeleton, problem.motion)
    uv = image_points(camera, points.at(there.transforms(skeleton)))
    inside = ((uv > -0.5) & (uv < (camera.width - 0.5, camera.height - 0.5))).all(axis=-1)
    scale = 1 / (SEEN_SHARE * heights_before(skeleton, camera, there)[:, None] * wider)
    scale = np.where(inside & shows[:, None], scale, 0.0)
    return TermIn(PointsInPicture(points, camera, uv, scale, NEAREST_M, SEEN_KERNEL), Ts)


def _wider(problem: SpaceProblem, points: BodyPoints) -> Array:
    """(N, K) how many times less surely each point was seen: heel and toe of a foot on the floor,
    which say how it stands, follow from how the leg was tracked; less and less so before it stands
    and afterwards, as it turns there from how it was tracked to how it stands.
    """
    wider = np.ones((len(problem.motion), len(points.points)))
    fade = round(FADE_S * problem.frames_per_second)
    for pin in problem.pins:
        own = [k for k, ((part, p),) in enumerate(points.points) if part == pin.part and any(p)]
        if pin.floor:
            there = 1 + (SEEN_ENDS_WIDER - 1) * pin.nearness(problem.motion, fade)
            wider[:, own] = np.maximum(wider[:, own], there[:, None])
    return wider


def _points_seen(skeleton: Skeleton) -> BodyPoints:
    """Joints and landmarks, which say how a person is posed; of a thing, which may have one joint
    alone, also the corners of its shapes."""
    joints = joints_and_landmarks(skeleton)
    if is_persons(skeleton.body):
        return joints
    shapes = [(i, part.shape.marks()) for i, part in enumerate(skeleton.body.parts)]
    corners = tuple(((i, (x, y, z)),) for i, marks in shapes for x, y, z in marks)
    return BodyPoints(skeleton, (*joints.points, *corners))


def _keyframes(problem: SpaceProblem, skeleton: Skeleton) -> tuple[Term, ...]:
    motion, first = problem.motion, problem.motion.first_frame
    soft = np.array(sorted(set(problem.soft) & set(problem.keyframes)), dtype=np.int64) - first
    hard = np.array(sorted(set(problem.keyframes) - set(problem.soft)), dtype=np.int64) - first
    precision = np.zeros((len(motion), skeleton.dof_count))
    precision[hard] = HARD
    precision[soft] = np.where(skeleton.dof_turns == 1, KEY_RAD**-2.0, 0.0)
    held = PosePrior(motion.Rs_parent_part, motion.ps_camera_root, precision)
    if not len(soft):
        return (held,)
    points = _points_seen(skeleton)
    uv = image_points(problem.camera, points.at(motion.transforms(skeleton)))
    scale = np.zeros(uv.shape[:2])
    exact = np.isin(soft, np.array(sorted(problem.seen), dtype=np.int64) - first)
    wider = _wider(problem, points)[soft]
    share = np.where(exact[:, None] & (wider == 1), EXACT_SEEN_SHARE, KEY_SEEN_SHARE * wider)
    scale[soft] = 1 / (share * heights_px(problem, skeleton)[soft, None])
    directions = np.zeros((len(motion), 1, 3))
    directions[soft, 0, 2] = 1 / (KEY_DEPTH_SHARE * motion.ps_camera_root[soft, 2])
    return (
        held,
        PointsInPicture(points, problem.camera, uv, scale, NEAREST_M),
        RootPosition(motion.ps_camera_root, directions),
    )


def _limbs(problem: SpaceProblem, skeleton: Skeleton) -> tuple[Term, ...]:
    """The joints of limbs seen where they were keyed, and as far from the root as they were: the
    last ones exactly, those between about."""
    if not problem.keyed_parts:
        return ()
    motion, size = problem.motion, (len(problem.motion), skeleton.part_count)
    uv, depth, seen_scale, precision = np.zeros((*size, 2)), *np.zeros((3, *size))
    for keyed in problem.keyed_parts:
        row, parts = keyed.frame - motion.first_frame, keyed.hanging(skeleton)
        there = pose_transforms(skeleton, keyed.pose)[parts, :3, 3]
        uv[row, parts] = image_points(problem.camera, there)
        depth[row, parts] = there[:, 2] - keyed.pose.p_camera_root[2]
        between = np.isin(parts, skeleton.parents)
        seen_scale[row, parts] = 1 / np.where(between, BETWEEN_SEEN_M, END_M)
        precision[row, parts] = 1 / np.where(between, BETWEEN_M, END_M)
    known_parts = np.flatnonzero(precision.any(axis=0))
    points = BodyPoints(skeleton, tuple(((int(i), (0.0, 0.0, 0.0)),) for i in known_parts))
    pixel_m = problem.camera.depth(motion.ps_camera_root) / problem.camera.fy
    scale = seen_scale[:, known_parts] * pixel_m[:, None]
    return (
        PointsInPicture(points, problem.camera, uv[:, known_parts], scale, NEAREST_M),
        DepthFromRoot(points, depth[:, known_parts], precision[:, known_parts]),
    )


def _limits(problem: SpaceProblem, skeleton: Skeleton) -> Term:
    keyed = [*problem.keyframes, *(each.frame for each in problem.keyed_parts)]
    rows = [frame - problem.motion.first_frame for frame in keyed]
    posed = [problem.motion.Rs_parent_part[row] for row in rows]
    return JointLimits(Limits.of(skeleton.body).widened(posed), LIMIT_RAD)


def _links(problem: SpaceProblem, skeleton: Skeleton) -> tuple[Link, ...]:
    motion = problem.motion
    pixel_m = float(np.median(problem.camera.depth(motion.ps_camera_root))) / problem.camera.fy
    step, bend = (sigma.precision(skeleton, pixel_m) for sigma in (STEP, BEND))
    observability = np.nan_to_num(problem.observability)[:, skeleton.dof_part]
    measured = increments(skeleton, motion)
    followed = Increments(skeleton, measured, step / (DOUBT_FLOOR + 1 - observability), Huber())
    links: list[Link] = [Smoothness.even(skeleton, len(motion), bend)]
    if problem.smooth and len(motion) > 3:
        rate = problem.frames_per_second
        points, sigma = jerk_points(skeleton, problem.in_world(motion), rate)
        links.append(Differences(skeleton, points, sigma, rate))
    if problem.points:
        links.append(_evenly(problem, skeleton))
    if problem.path is not None:
        links = [LinkIn(link, problem.path.Ts_world_camera) for link in links]
    return (followed, *links)


def _evenly(problem: SpaceProblem, skeleton: Skeleton) -> Link:
    """What a pin changes of the motion comes evenly before it begins, and goes after it ends."""
    motion, rate = problem.motion_in_world, problem.frames_per_second
    places, near = near_pins(motion, problem.points, round(FADE_S * rate))
    sigma = np.where(near, PIN_CHANGE_M_S2, np.inf)
    points = BodyPoints(skeleton, tuple((place,) for place in places))
    change = Differences(skeleton, points, sigma, rate, SECOND)
    return replace(change, wanted=change.of(motion))


def _pinned(
    problem: SpaceProblem,
    points: list[BodyPoints],
    frames: list[slice],
    floor: Floor,
    shared: Array,
) -> tuple[SharedTerm, ...]:
    terms: list[SharedTerm] = []
    for i, (pin, point, rows) in enumerate(zip(problem.pins, points, frames, strict=True)):
        at_place: SharedTerm = AtOnePlace(point, rows, 3 * i, PIN_M, PIN_KERNEL)
        if problem.path is not None:
            at_place = SharedTermIn(at_place, problem.path.Ts_world_camera)
        terms.append(at_place)
        if pin.above_floor_m is not None:
            terms.append(OnFloor(3 * i, floor, pin.above_floor_m, FLOOR_M))
    scale = np.full(len(shared), UNDECIDED_PER_M)
    if problem.tilt_rad:
        scale[floor.unknown(shared)[:-1]] = 1 / problem.tilt_rad
    if problem.floor_m is not None:
        scale[-1] = 1e3 / FLOOR_M
    return (*terms, Near(shared, scale))
