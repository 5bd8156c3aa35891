"""Poses and body sizes fitted to joints marked on pictures: the patient hand of a benchmark.

One body is sized for all marked frames together; every frame is posed so that its joints lie on
the marks, its angles stay human, and neighbouring keyframes do not differ without need. Where rough
3D joints are known they give the depth that a person would set in the side views.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from keypose.tracker.body.body import Body
from keypose.tracker.body.modify import joint_moved, resized, scaled
from keypose.tracker.body.pose import Pose, joint_positions, part_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array

MARKS = {
    **{f"{s}Shoulder": f"{side}_upper_arm" for s, side in (("L", "left"), ("R", "right"))},
    **{f"{s}Elbow": f"{side}_forearm" for s, side in (("L", "left"), ("R", "right"))},
    **{f"{s}Wrist": f"{side}_hand" for s, side in (("L", "left"), ("R", "right"))},
    **{f"{s}Hip": f"{side}_thigh" for s, side in (("L", "left"), ("R", "right"))},
    **{f"{s}Knee": f"{side}_shin" for s, side in (("L", "left"), ("R", "right"))},
    **{f"{s}Ankle": f"{side}_foot" for s, side in (("L", "left"), ("R", "right"))},
}
SIZES = ("whole", "upper_arm", "forearm", "thigh", "shin", "trunk", "shoulders", "hips")
SIZE_SIGMA = 0.08
PIXEL_SIGMA, METRE_SIGMA = 2.0, 0.06

Habit: TypeAlias = tuple[tuple[float, float, float], tuple[float, float, float]]
"""Angles (z, y, x) in degrees about which a part's pose is expected, and how far it strays."""

HUMAN: Mapping[str, Habit] = {
    "chest": ((0, 0, 0), (15, 20, 20)),
    "neck": ((0, 0, 0), (8, 12, 12)),
    "head": ((0, 0, 0), (10, 20, 15)),
    "clavicle": ((0, 0, 0), (8, 8, 2)),
    "upper_arm": ((0, 0, -10), (50, 40, 60)),
    "forearm": ((0, 0, -35), (6, 25, 40)),
    "hand": ((0, 0, 0), (5, 5, 5)),
    "thigh": ((0, 0, -10), (20, 20, 40)),
    "shin": ((0, 0, 20), (4, 5, 40)),
    "foot": ((0, 0, 0), (5, 5, 10)),
}
_HINGES = {"forearm": (-150.0, 0.0), "shin": (0.0, 150.0)}
"""Range of rx, degrees, that a hinge may not leave."""


@dataclass(frozen=True)
class Marked:
    """Marked joints of one frame: pixels (u, v) by name, and 3D joints (camera frame) if known."""

    frame: int
    uv: Mapping[str, tuple[float, float]]
    xyz: Mapping[str, tuple[float, float, float]]


@dataclass(frozen=True, eq=False)
class Posed:
    """The sized body and a pose for every marked frame."""

    skeleton: Skeleton
    poses: dict[int, Pose]
    miss_px: float


def sized(body: Body, factors: tuple[float, ...]) -> Skeleton:
    """The body with its lengths times these factors, in the order of SIZES."""
    size = dict(zip(SIZES, factors, strict=True))
    body = scaled(body, size["whole"])
    for name in ("upper_arm", "forearm", "thigh", "shin"):
        body = resized(body, f"left_{name}", length_factor=size[name])
    body = resized(body, "chest", length_factor=size["trunk"])
    for part, width in (("left_upper_arm", "shoulders"), ("left_thigh", "hips")):
        x, y, z = body.parts[body.index(part)].joint_m
        body = joint_moved(body, part, (x * size[width], y, z))
    return Skeleton.of(body)


class _Problem:
    """The residuals of all marked frames; a vector of sizes, then 6 + 3 (P − 1) numbers a frame."""

    def __init__(
        self,
        body: Body,
        camera: Camera,
        marked: Sequence[Marked],
        fit_sizes: bool,
        habits: Mapping[str, Habit],
    ) -> None:
        self.body, self.camera, self.marked, self.fit_sizes = body, camera, marked, fit_sizes
        self.parts = len(body.parts)
        self.sized: dict[tuple[float, ...], Skeleton] = {}
        self.per_frame = 6 + 3 * (self.parts - 1)
        kinds = [name.removeprefix("left_").removeprefix("right_") for name in body.names[1:]]
        sides = [(-1 if name.startswith("right_") else 1) for name in body.names[1:]]
        mean = np.array([habits[k][0] for k in kinds], float)
        mean[:, :2] *= np.array(sides)[:, None]  # turns about z and y are mirrored
        self.mean, self.sigma = np.radians(mean), np.radians([habits[k][1] for k in kinds])
        hinges = [_HINGES.get(k, (-180.0, 180.0)) for k in kinds]
        self.low, self.high = np.radians(hinges).T
        self.Rs_camera_root = np.tile(np.eye(3), (len(marked), 1, 1))

    def unpack(self, x: Array) -> tuple[Skeleton, Array, Array, Array]:
        sizes, rest = x[: len(SIZES)], x[len(SIZES) :].reshape(-1, self.per_frame)
        factors = tuple(np.exp(sizes) if self.fit_sizes else np.ones(len(SIZES)))
        if factors not in self.sized:  # most steps change a pose only
            self.sized[factors] = sized(self.body, factors)
        skeleton = self.sized[factors]
        angles = rest[:, 6:].reshape(len(rest), self.parts - 1, 3)
        limbs = Rotation.from_euler("ZYX", angles.reshape(-1, 3)).as_matrix()
        roots = self.Rs_camera_root @ Rotation.from_rotvec(rest[:, 3:6]).as_matrix()
        Rs = np.concatenate([roots[:, None], limbs.reshape(*angles.shape[:2], 3, 3)], axis=1)
        return skeleton, Rs, rest[:, :3], angles

    def residuals(self, x: Array) -> Array:
        skeleton, Rs, ps, angles = self.unpack(x)
        joints = joint_positions(skeleton, part_transforms(skeleton, Rs, ps))
        uv = self.camera.project(joints)
        out = [x[: len(SIZES)] / SIZE_SIGMA]
        for k, frame in enumerate(self.marked):
            for name, mark in frame.uv.items():
                out.append((_joint(uv[k], skeleton.body, name) - mark) / PIXEL_SIGMA)
            for name, place in frame.xyz.items():
                out.append((_joint(joints[k], skeleton.body, name) - place) / METRE_SIGMA)
        out.append(((angles - self.mean) / self.sigma).ravel())
        rx = angles[..., 2]
        out.append((np.maximum(rx - self.high, 0) + np.minimum(rx - self.low, 0)).ravel() / 0.02)
        turn = np.swapaxes(Rs[:-1], -1, -2) @ Rs[1:]
        out.append(Rotation.from_matrix(turn.reshape(-1, 3, 3)).as_rotvec().ravel() / 1.0)
        out.append(np.diff(ps[:, 2]) / 0.3)
        return np.nan_to_num(np.concatenate(out), nan=1e3)


def _joint(places: Array, body: Body, name: str) -> Array:
    """The place (2,) or (3,) that a mark of this name stands for."""
    if name == "hip":
        return (places[body.index("left_thigh")] + places[body.index("right_thigh")]) / 2
    if name == "Head":
        return places[len(body.parts)]  # the first landmark, the top of the head
    name = MARKS.get(name, name)
    if name in body.names:
        return places[body.index(name)]
    landmarks = [landmark for part in body.parts for landmark in part.landmarks]
    return places[len(body.parts) + landmarks.index(name)]


def fit(
    body: Body,
    camera: Camera,
    marked: Sequence[Marked],
    depth_m: float,
    habits: Mapping[str, Habit] = HUMAN,
) -> Posed:
    """Size the body and pose every marked frame; the body starts `depth_m` from the camera.

    Every frame is tried facing eight ways by itself, and from the best of these all are solved
    together. Marks are named as in MARKS, or "Head", "hip", or by a part (its joint) or a landmark
    of the body.
    """
    alone = [_alone(body, camera, mark, depth_m, habits) for mark in marked]
    problem = _Problem(body, camera, marked, fit_sizes=True, habits=habits)
    problem.Rs_camera_root = np.stack([R for _, R in alone])
    x = np.concatenate([np.zeros(len(SIZES)), *(pose for pose, _ in alone)])
    skeleton, Rs, ps, _ = problem.unpack(_solved(problem, x))
    poses = {m.frame: Pose(R, p) for m, R, p in zip(marked, Rs, ps, strict=True)}
    return Posed(skeleton, poses, _miss(skeleton, camera, marked, poses))


def _solved(problem: _Problem, x: Array) -> Array:
    """The best sizes and poses from a start."""
    try:
        return np.asarray(least_squares(problem.residuals, x, max_nfev=40, x_scale="jac").x)
    except np.linalg.LinAlgError:
        # LAPACK's divide and conquer gives up on a few sound Jacobians, which ones goes by the
        # number of its threads; the iterative solver has no such case and takes longer.
        how: dict[str, Any] = {"max_nfev": 40, "x_scale": "jac", "tr_solver": "lsmr"}
        return np.asarray(least_squares(problem.residuals, x, **how).x)


def _alone(
    body: Body, camera: Camera, mark: Marked, depth_m: float, habits: Mapping[str, Habit]
) -> tuple[Array, Array]:
    """The best pose of one frame, and the camera's view of the body that it starts from."""
    problem = _Problem(body, camera, [mark], fit_sizes=False, habits=habits)
    starts = [_try(problem, _start(problem, depth_m), 0.25 * k * np.pi) for k in range(8)]
    _, x, R = min(starts, key=lambda start: start[0])
    return x[len(SIZES) :], R


def _start(problem: _Problem, depth_m: float) -> Array:
    x = np.zeros(len(SIZES) + problem.per_frame)
    middle = np.mean(list(problem.marked[0].uv.values()), axis=0)
    x[len(SIZES) : len(SIZES) + 3] = problem.camera.back_project(middle, depth_m)
    x[len(SIZES) + 6 :] = problem.mean.ravel()
    return x


def _try(problem: _Problem, x: Array, yaw: float) -> tuple[float, Array, Array]:
    problem.Rs_camera_root = Rotation.from_euler("y", yaw).as_matrix()[None]
    solved = least_squares(problem.residuals, x, max_nfev=60)
    return float(solved.cost), solved.x, problem.Rs_camera_root[0].copy()


def _miss(
    skeleton: Skeleton, camera: Camera, marked: Sequence[Marked], poses: Mapping[int, Pose]
) -> float:
    """Mean distance in pixels between marks and posed joints."""
    return float(np.mean(np.concatenate([miss_px(skeleton, camera, m, poses) for m in marked])))


def miss_px(skeleton: Skeleton, camera: Camera, marked: Marked, poses: Mapping[int, Pose]) -> Array:
    """Distances in pixels between one frame's marks and the posed joints, in the marks' order."""
    pose = poses[marked.frame]
    Ts = part_transforms(skeleton, pose.Rs_parent_part, pose.p_camera_root)
    uv = camera.project(joint_positions(skeleton, Ts))
    return np.array(
        [np.linalg.norm(_joint(uv, skeleton.body, n) - mark) for n, mark in marked.uv.items()]
    )
