"""A dog or a horse that walks: its motion, its pictures, and its keypoints as they are."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.body import Body, preset
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.raster import BodyMesh, raster
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.fitting.draft.animals import animal_points
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import exp_rotation
from keypose.tracker.geometry.view import ViewCamera
from keypose.tracker.keypoints.keypoints import Keypoints, other_side
from keypose.tracker.keypoints.on_animal import ANIMAL_POINTS
from tests.animals.dot_network import COLOURS

Array = NDArray[np.float64]

CAMERA = Camera(width=640, height=360, fx=550.0, fy=550.0, cx=319.5, cy=179.5)
FPS = 30.0
SIZE = {"dog": 1.0, "horse": 2.6}
SPEED_M_S = {"dog": 1.2, "horse": 1.6}
STRIDES_PER_S = {"dog": 1.6, "horse": 0.95}
LEGS = {"left_hind": 0.0, "left_front": 0.25, "right_hind": 0.5, "right_front": 0.75}
"""Of a walk, by leg the share of a stride by which it comes before the first."""
DOT_PX = 4


@dataclass(frozen=True)
class Walk:
    """An animal that walks past a camera that is held level.

    heading_deg: 0 toward the camera, 90 to the picture's left, turning by `turn_deg` on the way.
    """

    name: str
    heading_deg: float = 90.0
    turn_deg: float = 0.0
    frames: int = 48
    sized: Body | None = None
    """The animal, where it is not as large as the shelf's."""

    @property
    def body(self) -> Body:
        return preset(self.name) if self.sized is None else self.sized

    @property
    def skeleton(self) -> Skeleton:
        return Skeleton.of(self.body)

    def motion(self) -> Trajectory:
        n = np.arange(self.frames)
        share = n / max(self.frames - 1, 1) - 0.5
        heading = np.radians(self.heading_deg + self.turn_deg * share)
        ahead = np.stack([-np.sin(heading), 0 * heading, -np.cos(heading)], axis=1)
        at = np.cumsum(ahead * SPEED_M_S[self.name] / FPS, axis=0)
        size, phase = SIZE[self.name], 2 * np.pi * STRIDES_PER_S[self.name] * n / FPS
        at += np.array([0.0, 0.05, 3.2 * size]) - at.mean(axis=0)
        at[:, 1] += 0.015 * size * np.sin(2 * phase)
        rotations = [
            self._rotations(float(a), float(p)) for a, p in zip(heading, phase, strict=True)
        ]
        return Trajectory(0, np.stack(rotations), at)

    def _rotations(self, heading: float, phase: float) -> Array:
        turns: dict[str, tuple[float, float, float]] = {
            "neck": (0.35 + 0.1 * np.sin(2 * phase), 0.1 * np.sin(phase / 2), 0.0),
            "head": (-0.2 + 0.08 * np.sin(2 * phase), 0.15 * np.sin(0.7 * phase), 0.0),
            "tail": (0.6, 0.0, 0.3 * np.sin(2 * phase)),
        }
        for leg, before in LEGS.items():
            own = phase + 2 * np.pi * before
            lifted = max(0.0, float(np.cos(own)))
            hind = leg.endswith("hind")
            upper = -0.42 * np.sin(own) + (-0.12 if hind else 0.08) - 0.3 * lifted
            lower = 0.2 + 0.75 * lifted if hind else -0.1 + 0.6 * lifted
            turns[f"{leg}_upper_leg"] = (upper, 0.0, 0.05 * np.sin(own))
            turns[f"{leg}_lower_leg"] = (lower, 0.0, 0.0)
        names = self.body.names
        Rs = np.stack([exp_rotation(np.array(turns.get(name, (0.0, 0.0, 0.0)))) for name in names])
        leans = exp_rotation(np.array([0.03 * np.sin(2 * phase), 0.0, 0.04 * np.sin(phase)]))
        Rs[0] = exp_rotation(np.array([0.0, heading, 0.0])) @ leans
        return Rs

    def points(self, motion: Trajectory, body: Body | None = None) -> Array:
        """(N, 17, 3) the keypoints in the camera's frame, metres, of it or of another body."""
        skeleton = self.skeleton if body is None else Skeleton.of(body)
        return animal_points(skeleton).at(motion.transforms(skeleton))

    def keypoints(self, share: float = 0.0, seed: int = 0) -> Keypoints:
        """As a network might see them.

        share: of how far each is off, one half always alike and one half by chance, of the animal's
        length.
        """
        uv = np.asarray(CAMERA.project(self.points(self.motion())))
        extent = np.ptp(uv, axis=1).max()
        rng = np.random.default_rng(seed)
        uv += rng.normal(0.0, share * extent, uv.shape[1:]) + rng.normal(
            0.0, share * extent, uv.shape
        )
        return Keypoints(0, ANIMAL_POINTS, uv, np.full(uv.shape[:2], 0.9))

    def pictures(self) -> list[NDArray[np.uint8]]:
        """Grey bodies before grey, with a dot of its colour at each keypoint."""
        motion, mesh = self.motion(), BodyMesh.of(self.skeleton)
        uv = np.rint(np.asarray(CAMERA.project(self.points(motion)))).astype(int)
        Ts = motion.transforms(self.skeleton)
        view = ViewCamera.of(CAMERA)
        return [_dotted(raster(mesh, T, view).part, dots) for T, dots in zip(Ts, uv, strict=True)]

    def film(self, folder: Path) -> Path:
        """A folder of its pictures."""
        folder.mkdir()
        for number, picture in enumerate(self.pictures()):
            cv2.imwrite(str(folder / f"{number:04}.png"), picture[..., ::-1])
        return folder

    def box(self, frame: int = 0) -> tuple[float, float, float, float]:
        """Around the animal in a frame."""
        uv = np.asarray(CAMERA.project(self.points(self.motion())[frame]))
        (left, top), (right, bottom) = uv.min(axis=0) - 10, uv.max(axis=0) + 10
        return float(left), float(top), float(right), float(bottom)


def _dotted(part: NDArray[np.int64], dots: NDArray[np.int64]) -> NDArray[np.uint8]:
    picture = np.full((*part.shape, 3), 90, np.uint8)
    shade = 110 + 7 * (part % 12)
    picture[part >= 0] = shade[part >= 0, None]
    for (x, y), colour in zip(dots.tolist(), COLOURS, strict=True):
        cv2.circle(picture, (x, y), DOT_PX, tuple(int(level) for level in colour), -1)
    return picture


def with_sides_swapped(keypoints: Keypoints, frames: range, words: tuple[str, ...]) -> Keypoints:
    """Left and right exchanged, in some frames, of the keypoints that have one of these words."""
    order = list(range(len(ANIMAL_POINTS)))
    for k, name in enumerate(ANIMAL_POINTS):
        if any(word in name for word in words):
            order[k] = ANIMAL_POINTS.index(other_side(name, ANIMAL_POINTS))
    uv = keypoints.uv.copy()
    uv[frames.start : frames.stop] = uv[frames.start : frames.stop][:, order]
    return replace(keypoints, uv=uv)


def error_share(walk: Walk, poses: dict[int, Pose], body: Body | None = None) -> float:
    """By how much keypoints of drafts are off in space beside their middle: a mean, as a share of
    the trunk's length. Of a body of its own it is as large as fits best, which nothing tells."""
    motion, frames = walk.motion(), sorted(poses)
    expected = walk.points(motion)[frames]
    R = np.stack([poses[frame].Rs_parent_part for frame in frames])
    t = np.stack([poses[frame].p_camera_root for frame in frames])
    drafted = walk.points(Trajectory(frames[0], R, t), body)
    drafted -= drafted.mean(axis=1, keepdims=True)
    about = expected - expected.mean(axis=1, keepdims=True)
    if body is not None:
        drafted *= (drafted * about).sum() / (drafted**2).sum()
    away = drafted - about
    trunk = np.linalg.norm(expected[0, 3] - expected[0, 4])
    return float(np.linalg.norm(away, axis=-1).mean() / trunk)
