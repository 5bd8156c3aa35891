"""Bodies, pictures and videos on which the tracker's numerics are tried."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.body import ALL_DOFS, ROTATIONS, Body, Part
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.shapes import Box, Cylinder, Frustum, Shape
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Pass, Trajectory, interpolate
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import exp_rotation
from keypose.tracker.kernels.layout import STEPS
from keypose.tracker.session.settings import TrackSettings
from keypose.tracker.tracking.cycle import Outcome, track_segment
from keypose.tracker.tracking.method import Method
from keypose.tracker.tracking.pool import TrackFinished, run
from keypose.tracker.tracking.result import SegmentResult
from keypose.tracker.tracking.scene import Scene
from keypose.tracker.tracking.segment import Segment
from keypose.tracker.tracking.tracker import Tracker
from keypose.tracker.video.pyramid import LEVELS, Clip, prepare
from tests.rendering import scenes
from tests.rendering.settings import RenderSettings

Floats = NDArray[np.float64]

WIDTH = 160
HEIGHT = 120
CAMERA = Camera(width=WIDTH, height=HEIGHT, fx=170.0, fy=176.0, cx=78.3, cy=61.2)
TELEPHOTO = CAMERA.model_copy(update={"projection": "telephoto", "telephoto_distance_m": 3.0})
CAMERAS = {"perspective": CAMERA, "telephoto": TELEPHOTO}
SMALL = (320, 180)


def random_shape(rng: np.random.Generator) -> Shape:
    """A box, a cylinder or a frustum of 10 to 60 cm."""
    a, b, c, d = rng.uniform(0.06, 0.2, 4)
    length = rng.uniform(0.2, 0.6)
    shapes: list[Shape] = [
        Box(low_m=(-a, -b, -c), high_m=(b, length, d)),
        Cylinder(start_m=-0.05, end_m=length, radius_m=a),
        Frustum(end_m=-length, start_radii_m=(a, b), end_radii_m=(c, d)),
    ]
    return shapes[rng.integers(3)]


def random_body(seed: int, parts: int = 5, root_dofs: Sequence[str] = ALL_DOFS) -> Skeleton:
    """A random tree; the root tracks `root_dofs`, every other part a random set of rotations."""
    rng = np.random.default_rng(seed)
    made = [Part(name="part0", shape=random_shape(rng), tracked=tuple(root_dofs))]
    for i in range(1, parts):
        made.append(
            Part(
                name=f"part{i}",
                parent=f"part{rng.integers(i)}",
                joint_m=tuple(rng.uniform(-0.3, 0.3, 3)),
                shape=random_shape(rng),
                tracked=tuple(dof for dof in ROTATIONS if rng.random() < 0.6),
            )
        )
    return Skeleton.of(Body(name="random", parts=tuple(made)))


def deep_chain(parts: int = 8) -> Skeleton:
    """One limb of many short bones, all of whose rotations are tracked."""
    bone = Cylinder(end_m=0.12, radius_m=0.05)
    made = [Part(name="bone0", shape=bone, tracked=ALL_DOFS)]
    made += [
        Part(name=f"bone{i}", parent=f"bone{i - 1}", joint_m=(0.0, 0.12, 0.01), shape=bone,
             tracked=ROTATIONS)
        for i in range(1, parts)
    ]  # fmt: skip
    return Skeleton.of(Body(name="chain", parts=tuple(made)))


def random_pose(skeleton: Skeleton, seed: int, size: float = 0.6, depth_m: float = 2.8) -> Pose:
    """Rotations of about `size` radians, the root near the optical axis."""
    rng = np.random.default_rng(seed)
    place = rng.normal((0, 0, depth_m), 0.05)
    return Pose(exp_rotation(rng.normal(0, size, (skeleton.part_count, 3))), place)


def random_trajectory(skeleton: Skeleton, seed: int, count: int, size: float = 0.03) -> Trajectory:
    """A random pose that wanders by about `size` (radians, metres) a frame."""
    rng = np.random.default_rng([seed, 1])
    start = random_pose(skeleton, seed)
    Rs, ps = [start.Rs_parent_part], [start.p_camera_root]
    for _ in range(count - 1):
        Rs.append(Rs[-1] @ exp_rotation(rng.normal(0, size, (skeleton.part_count, 3))))
        ps.append(ps[-1] + rng.normal(0, size, 3))
    return Trajectory(0, np.stack(Rs), np.stack(ps))


def scene_of(skeleton: Skeleton, camera: Camera = CAMERA, poses: Sequence[Pose] = ()) -> Scene:
    """The body before the camera."""
    return Scene.of(skeleton, camera, poses or [random_pose(skeleton, 0)])


def waves_at(seed: int, uv: Floats) -> Floats:
    """(..., 3) brightness and its gradient at pixels (..., 2): a sum of long waves."""
    rng = np.random.default_rng([seed, 2])
    u, v = uv[..., 0], uv[..., 1]
    total = np.zeros((*u.shape, 3))
    total[..., 0] = 120.0
    for _ in range(6):
        ku, kv, phase, high = *rng.uniform(-0.12, 0.12, 2), rng.uniform(0, 6.3), rng.uniform(4, 20)
        wave = ku * u + kv * v + phase
        parts = (np.sin(wave), ku * np.cos(wave), kv * np.cos(wave))
        total += high * np.stack(parts, axis=-1)
    return total


def smooth_picture(seed: int, width: int = WIDTH, height: int = HEIGHT) -> NDArray[np.int16]:
    """(height, width, 4) the waves as a prepared picture, all of it usable."""
    uv = np.stack(np.meshgrid(np.arange(width), np.arange(height)), axis=-1).astype(float)
    shown = np.concatenate([waves_at(seed, uv), np.ones((height, width, 1))], -1)
    return np.rint(STEPS * shown).astype(np.int16)


@dataclass
class MemoryVideo:
    """What a loader asks of a video, from an array (N, H, W, 3); some frames cannot be decoded."""

    pictures: NDArray[np.uint8]
    missing: Sequence[int] = ()

    @property
    def info(self) -> Any:
        return SimpleNamespace(frame_count=len(self.pictures))

    def frames(self, first: int, stop: int) -> Iterator[tuple[int, NDArray[np.uint8] | None]]:
        for i in range(first, stop):
            yield i, None if i in self.missing else self.pictures[i]

    def sound_frames(self, first: int, stop: int) -> Iterator[tuple[int, NDArray[np.uint8] | None]]:
        return self.frames(first, stop)


@dataclass(frozen=True, eq=False)
class Case:
    """A rendered sequence with its exact truth."""

    skeleton: Skeleton
    camera: Camera
    truth: Trajectory
    pictures: NDArray[np.uint8]

    def tracker(self, *keyframes: int, missing: Sequence[int] = (), **more: Any) -> Tracker:
        """A tracker whose keyframes are the truth; `more` goes to Tracker."""
        poses = {k: self.truth.pose(k) for k in keyframes}
        video: Any = MemoryVideo(self.pictures, missing)
        return Tracker(video, self.camera, self.skeleton, poses, **more)

    def error_cm(self, found: Trajectory) -> float:
        """Mean distance of the joints from the truth between the found trajectory's ends."""
        frames = slice(found.first_frame, found.last_frame + 1)
        miss = found.joints(self.skeleton) - self.truth.joints(self.skeleton)[frames]
        return float(100 * np.linalg.norm(miss, axis=-1)[1:-1].mean())

    def clip(self) -> Clip:
        """All frames, prepared."""
        return clip_of(self.pictures)

    def scene(self) -> Scene:
        """The body before the camera, laid out for the first pose."""
        return Scene.of(self.skeleton, self.camera, [self.truth.pose(0)])


def case(
    name: str,
    first: int,
    last: int,
    settings: RenderSettings | None = None,
    telephoto: bool = False,
) -> Case:
    """Frames first … last of a written motion, rendered small."""
    made = scenes.scene(name, settings, size=SMALL).cut(first, last)
    if telephoto:
        distance = float(made.truth.ps_camera_root[:, 2].mean())
        changes = {"projection": "telephoto", "telephoto_distance_m": distance}
        made = replace(made, camera=made.camera.model_copy(update=changes))
    return Case(made.skeleton, made.camera, made.truth, made.frames())


def clip_of(pictures: NDArray[np.uint8], usable: Any = None) -> Clip:
    """RGB pictures (N, H, W, 3), prepared as a loader does; `usable` (H, W) of every frame."""
    greys: Any = [cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY) for picture in pictures]
    ready = [prepare(grey, usable, LEVELS) for grey in greys]
    return Clip(0, tuple(np.stack([r[k] for r in ready]) for k in range(LEVELS)))


def tracked(tracker: Tracker, **settings: Any) -> tuple[SegmentResult, ...]:
    """The segments of a whole run."""
    *_, last = run(tracker, TrackSettings(**settings))
    assert isinstance(last, TrackFinished)
    return last.result.segments


def segment_of(shown: Case, clip: Clip | None = None) -> Segment:
    """From the first to the last frame of a case."""
    last = len(shown.truth) - 1
    return Segment(0, last, shown.truth.pose(0), shown.truth.pose(last), clip or shown.clip())


def worked(shown: Case, segment: Segment, method: Method) -> tuple[list[Pass], Outcome]:
    """All that tracking yields, and its outcome."""
    scene = Scene.of(shown.skeleton, shown.camera, [segment.start, segment.end], method.density)
    work, steps = track_segment(scene, segment, method), []
    while True:
        try:
            steps.append(next(work))
        except StopIteration as done:
            return steps, done.value


def plain(shown: Case) -> Trajectory:
    """Interpolation from the first to the last frame of a case."""
    last = len(shown.truth) - 1
    return interpolate(shown.truth.pose(0), shown.truth.pose(last), 0, last)
