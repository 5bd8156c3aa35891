"""Motions that are known exactly, and what tracking may make of them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.solver.posed import BodyPoint, BodyPoints
from keypose.tracker.solver.projection import image_points
from keypose.tracker.space.pinned import PinnedPoint
from keypose.tracker.space.solve import SpaceProblem
from tests.rendering.scenes import Scene, scene

Floats = NDArray[np.float64]

FPS = {"jump": 60.0, "pirouette": 60.0}
"""Frames a second of the scenes that have not 30."""
STILL = (
    "waist", "left_thigh", "left_shin", "left_foot", "right_thigh", "right_shin", "right_foot"
)  # fmt: skip
UP = np.array([0.0, -1.0, 0.0])


def fps_of(shown: Scene) -> float:
    return FPS.get(shown.name, 30.0)


def problem(shown: Scene, motion: Trajectory | None = None, **changes: Any) -> SpaceProblem:
    """The solve of a scene's truth, or of what was tracked of it; its ends are keyframes."""
    tracked = shown.truth if motion is None else motion
    given: dict[str, Any] = {
        "skeleton": shown.skeleton,
        "camera": shown.camera,
        "motion": tracked,
        "observability": np.full((len(tracked) - 1, shown.skeleton.part_count), 0.9),
        "keyframes": (tracked.first_frame, tracked.last_frame),
        "frames_per_second": fps_of(shown),
    }
    return SpaceProblem(**{**given, **changes})


def foot_points(shown: Scene, name: str = "left_foot") -> tuple[int, list[tuple[float, ...]]]:
    """A foot's part, and its heel and toe."""
    part = shown.skeleton.body.index(name)
    return part, list(shown.skeleton.body.parts[part].landmarks.values())


def pinned_foot(
    shown: Scene, first: int, last: int, name: str = "left_foot", floor: bool = False
) -> list[PinnedPoint]:
    part, points = foot_points(shown, name)
    above = 0.0 if floor else None
    return [PinnedPoint(part, (x, y, z), first, last, above) for x, y, z in points]


def places(shown: Scene, motion: Trajectory, name: str = "left_foot") -> Floats:
    """(N, 2, 3) where heel and toe of a foot are."""
    part, points = foot_points(shown, name)
    some: tuple[BodyPoint, ...] = tuple(((part, (x, y, z)),) for x, y, z in points)
    return BodyPoints(shown.skeleton, some).at(motion.transforms(shown.skeleton))


def pixels(shown: Scene, motion: Trajectory) -> Floats:
    """(N, J, 2) of joints and landmarks."""
    return image_points(shown.camera, motion.joints(shown.skeleton))


def speeds(shown: Scene, motion: Trajectory) -> Floats:
    """(N − 1, J) m/s of joints and landmarks."""
    steps = np.diff(motion.joints(shown.skeleton), axis=0)
    return np.asarray(np.linalg.norm(steps, axis=-1) * fps_of(shown))


def acceleration(shown: Scene, motion: Trajectory) -> float:
    """Root mean square over joints and landmarks, m/s²."""
    bends = np.diff(motion.joints(shown.skeleton), 2, axis=0)
    return float(np.sqrt((bends**2).sum(axis=-1).mean())) * fps_of(shown) ** 2


def errors_m(shown: Scene, motion: Trajectory) -> Floats:
    """(N, J) metres between joints and landmarks and where they truly are."""
    away = motion.joints(shown.skeleton) - shown.truth.joints(shown.skeleton)
    return np.asarray(np.linalg.norm(away, axis=-1))


def shaken(shown: Scene, across_m: float = 0.002, along_m: float = 0.02) -> Trajectory:
    """The truth with noise on the root's place, but for its ends."""
    rng = np.random.default_rng(0)
    ps = shown.truth.ps_camera_root.copy()
    noise = rng.normal(0, 1, ps.shape) * (across_m, across_m, along_m)
    ps[1:-1] += noise[1:-1]
    return Trajectory(shown.truth.first_frame, shown.truth.Rs_parent_part, ps)


def standing(frames: int = 61) -> Scene:
    """Somebody who explains with arms and head; waist and legs stand still."""
    shown = scene("speech").cut(0, frames - 1)
    R, p = shown.truth.writable()
    below = [i for i, name in enumerate(shown.skeleton.body.names) if name in STILL]
    R[:, below], p[:] = R[0, below], p[0]
    return replace(shown, truth=Trajectory(0, R, p))


def reach_far(shown: Scene) -> Scene:
    """Filmed from three times as far with three times the focal length: a body that is a little
    nearer or farther is seen nearly as large, so that the picture does not contradict it."""
    camera = shown.camera.model_copy(update={"fx": 3 * shown.camera.fx, "fy": 3 * shown.camera.fy})
    away = np.array([0.0, 0.0, 2 * shown.truth.ps_camera_root[0, 2]])
    R, p = shown.truth.writable()
    return replace(shown, camera=camera, truth=Trajectory(0, R, p + away))


def farther(motion: Trajectory, away_m: Floats) -> Trajectory:
    """A motion moved by away_m (N,) along the rays to its root."""
    p = motion.ps_camera_root
    far = np.linalg.norm(p, axis=-1)
    return Trajectory(motion.first_frame, motion.Rs_parent_part, p * (1 + away_m / far)[:, None])
