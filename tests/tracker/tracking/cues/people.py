"""A person who moves between two keyframes, and what a detector would say of it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.body import preset
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import exp_rotation
from keypose.tracker.keypoints.keypoints import JOINTS, Keypoints
from keypose.tracker.keypoints.on_body import points_on_body
from keypose.tracker.solver.posed import BodyPoints
from keypose.tracker.tracking.cues.anchors import Anchors, anchors_of, with_free_joints
from keypose.tracker.tracking.scene import Scene
from keypose.tracker.tracking.segment import Segment
from keypose.tracker.video.pyramid import LEVELS, Clip, prepare

Floats = NDArray[np.float64]

SKELETON = Skeleton.of(preset("adult_male"))
CAMERA = Camera(width=320, height=240, fx=330.0, fy=335.0, cx=160.0, cy=118.0)
BENT = CAMERA.model_copy(update={"distortion": (-0.12, 0.03, 0.001, -0.001, 0.0)})
OFFSET_M = (0.012, -0.01, 0.008)
"""Where on its part the detector puts every joint."""
TOO_FAR_M = 0.11
"""By how much it has all depths too far."""


def moving(count: int = 13, size: float = 0.9) -> Trajectory:
    """A man who swings his arms and legs out and back again while he goes to the right.

    Interpolation of its ends sees nothing of the swing.
    """
    s = np.linspace(0.0, 1.0, count)
    swing = np.sin(np.pi * s)
    turns = np.zeros((count, SKELETON.part_count, 3))
    for name, axis, share in (
        ("left_upper_arm", 2, -0.9), ("right_upper_arm", 2, 0.7), ("left_forearm", 0, -1.0),
        ("right_forearm", 0, -0.8), ("left_thigh", 0, -0.7), ("right_shin", 0, 0.8),
        ("chest", 1, 0.3), ("left_upper_arm", 1, 0.4),
    ):  # fmt: skip
        turns[:, SKELETON.body.index(name), axis] = size * share * swing
    turns[:, 0, 1] = 0.3 * s
    root = np.stack([0.4 * s - 0.2, 0.02 * swing, 4.0 + 0.2 * s], axis=1)
    return Trajectory(3, exp_rotation(turns), root)


def still_clip(count: int, first_frame: int) -> Clip:
    """Grey pictures: brightness tells nothing."""
    grey = np.full((CAMERA.height, CAMERA.width), 90, np.uint8)
    pictures = [prepare(grey, None, LEVELS) for _ in range(count)]
    return Clip(first_frame, tuple(np.stack(level) for level in zip(*pictures, strict=True)))


@dataclass(frozen=True, eq=False)
class Filmed:
    """The truth, and a detector of known faults."""

    truth: Trajectory
    camera: Camera = CAMERA
    offset_m: tuple[float, float, float] = OFFSET_M

    @cached_property
    def keypoints(self) -> Keypoints:
        index, parts, points = points_on_body(SKELETON.body, JOINTS)
        where = BodyPoints.single(SKELETON, parts, points + self.offset_m)
        p = where.at(self.truth.transforms(SKELETON))
        uv = self.camera.project(p)
        hips = [JOINTS.index("left_hip"), JOINTS.index("right_hip")]
        from_hips = p - p[:, hips].mean(axis=1, keepdims=True) + (0.0, 0.0, TOO_FAR_M)
        assert index.tolist() == list(range(len(JOINTS)))
        return Keypoints(self.truth.first_frame, JOINTS, uv, np.ones(uv.shape[:2]), from_hips)

    @cached_property
    def segment(self) -> Segment:
        first, last = self.truth.first_frame, self.truth.last_frame
        ends = self.truth.pose(first), self.truth.pose(last)
        return Segment(first, last, *ends, still_clip(len(self.truth), first))

    @cached_property
    def free(self) -> Scene:
        """The scene that keypoints are solved in."""
        ideal = self.camera.without_distortion()
        return Scene.of(
            with_free_joints(SKELETON), ideal, [self.segment.start, self.segment.end], 0.2
        )

    def wrist_px(self, motion: Trajectory) -> Floats:
        """(N, 2) where the left wrist of a motion is seen."""
        _, parts, points = points_on_body(SKELETON.body, ["left_wrist"])
        p = BodyPoints.single(SKELETON, parts, points).at(motion.transforms(SKELETON))
        return np.asarray(self.camera.project(p)[:, 0])

    def anchors(
        self, keypoints: Keypoints | None = None, followed: Trajectory | None = None
    ) -> tuple[Anchors, ...]:
        found = self.keypoints if keypoints is None else keypoints
        return anchors_of(self.free, self.segment, self.camera, found, followed=followed)

    def keyed(self, start: Pose, end: Pose) -> Filmed:
        """With other keyframes before the same film."""
        other = Filmed(self.truth, self.camera, self.offset_m)
        other.__dict__["segment"] = replace(self.segment, start=start, end=end)
        return other


def joints_apart_m(a: Trajectory, b: Trajectory) -> Floats:
    """(N, K) metres between the twelve joints of two motions."""
    _, parts, points = points_on_body(SKELETON.body, JOINTS)
    where = BodyPoints.single(SKELETON, parts, points)
    return np.asarray(
        np.linalg.norm(where.at(a.transforms(SKELETON)) - where.at(b.transforms(SKELETON)), axis=-1)
    )
