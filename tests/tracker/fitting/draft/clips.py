"""Clips of a person whose every joint is known, as a network would tell it that is always right
about where it is used to put joints."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.body import Body, preset
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.fitting.draft import ClipDraft
from keypose.tracker.fitting.draft.observed import ENDS, POINTS, SIDES, Joints, place_of
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import exp_rotation, rotation_from_euler
from keypose.tracker.keypoints.keypoints import JOINTS, Keypoints

CAMERA = Camera(width=1280, height=720, fx=1100, fy=1100, cx=639.5, cy=359.5)
BODY = preset("adult_female")


@dataclass(frozen=True, eq=False)
class Clip:
    """A motion, and what is seen of it."""

    body: Body
    poses: list[Pose]
    keypoints: Keypoints

    @property
    def joints_m(self) -> NDArray[np.float64]:
        """(N, 12, 3)"""
        return joints_of(self.body, self.poses)


def joints_of(body: Body, poses: list[Pose]) -> NDArray[np.float64]:
    """(N, 12, 3) where the joints of posed bodies are."""
    joints = Joints.of(Skeleton.of(body))
    return np.stack([joints.points.at(pose_transforms(joints.skeleton, pose)) for pose in poses])


def walk(
    count: int,
    facing_deg: float = 0.0,
    turning_deg: float = 0.0,
    body: Body = BODY,
    camera: Camera = CAMERA,
    place: tuple[float, float, float] = (0.3, 0.1, 4.5),
) -> Clip:
    """A person who strides and swings bent arms, facing a direction (0: the camera) and turning by
    so much a frame."""
    skeleton = Skeleton.of(body)
    poses = []
    for n in range(count):
        s = np.sin(2 * np.pi * n / 40)
        Rs = np.tile(np.eye(3), (skeleton.part_count, 1, 1))
        Rs[0] = rotation_from_euler(0, np.radians(facing_deg + n * turning_deg), 0)
        bends = {
            "chest": (10, 0, 0),
            "left_thigh": (-10 + 30 * s, 0, -4), "right_thigh": (-10 - 30 * s, 0, 4),
            "left_shin": (30 - 20 * s, 0, 0), "right_shin": (30 + 20 * s, 0, 0),
            "left_upper_arm": (-30 * s - 5, 0, -15), "right_upper_arm": (30 * s - 5, 0, 15),
            "left_forearm": (-50 + 20 * s, 0, 0), "right_forearm": (-50 - 20 * s, 0, 0),
        }  # fmt: skip
        for name, (x, y, z) in bends.items():
            Rs[body.index(name)] = rotation_from_euler(*np.radians((z, y, x)))
        x, y, z = place
        poses.append(Pose(Rs, np.array([x + 0.004 * n, y, z])))
    return seen(body, poses, camera)


def standing(count: int, body: Body = BODY) -> Clip:
    """A person in the rest pose."""
    pose = Pose.rest(Skeleton.of(body), (0.0, 0.0, 4.0))
    return seen(body, [pose] * count, CAMERA)


def seen(body: Body, poses: list[Pose], camera: Camera, scale: float = 0.9) -> Clip:
    """What a perfect network tells: pixels, and points as if the person were in the picture's
    middle, all by one factor too small."""
    joints = Joints.of(Skeleton.of(body))
    columns, ends = joints.ends
    assert len(columns) == len(ENDS)
    p = []
    for pose in poses:
        T = pose_transforms(joints.skeleton, pose)
        p.append(np.concatenate([joints.seen.at(T), ends.at(T)]))
    places = np.stack(p)
    middle = places[:, [place_of(side, "hip") for side in SIDES]].mean(1, keepdims=True)
    p_hips = scale * np.stack(
        [q @ _onto_ray(m[0]) for q, m in zip(places - middle, middle, strict=True)]
    )
    rows = np.ones(places.shape[:2])
    return Clip(body, poses, Keypoints(0, POINTS, camera.project(places), rows, p_hips))


def _onto_ray(p: NDArray[np.float64]) -> NDArray[np.float64]:
    """From the camera's axis to a direction, by the least turn."""
    ray = p / np.linalg.norm(p)
    axis = np.cross((0.0, 0.0, 1.0), ray)
    sine = np.linalg.norm(axis)
    if sine < 1e-9:
        return np.eye(3)
    return np.asarray(exp_rotation(axis / sine * np.arcsin(sine)))


def drafted_joints_m(draft: ClipDraft) -> NDArray[np.float64]:
    """(F, 12, 3) of the drafts, in their order."""
    return joints_of(draft.body, [draft.poses[frame] for frame in sorted(draft.poses)])


def place(name: str) -> int:
    """Of a keypoint among `POINTS`."""
    return POINTS.index(name)


LIMB_BONES = [
    (JOINTS.index(f"{side}_{near}"), JOINTS.index(f"{side}_{far}"))
    for side in SIDES
    for near, far in (
        *(("shoulder", "elbow"), ("elbow", "wrist")),
        *(("hip", "knee"), ("knee", "ankle")),
    )
]
