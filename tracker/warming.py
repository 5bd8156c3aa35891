"""Compile the loops in parts, on tiny made-up work, also in processes of their own.

numba's compiler holds one lock for all threads, so only processes compile side by side; what one
has compiled the others load from the cache. `python -m keypose.tracker.warming` reads names of
parts from stdin, a line each, and says each when it is done, until stdin ends.
"""

from __future__ import annotations

import gc
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import Final, Self

import numpy as np

from keypose.tracker.body.body import ALL_DOFS, Body, Part
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.raster import BodyMesh, raster
from keypose.tracker.body.shapes import Box
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.fitting.pose.texture import TextureMatch, texture_of
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.view import ViewCamera
from keypose.tracker.reduction.reduce import reduce_motion
from keypose.tracker.reduction.result import Tolerance
from keypose.tracker.solver.posed import BodyPoints, Posed
from keypose.tracker.tracking.bundle import refine
from keypose.tracker.tracking.cues.anchors import Anchors
from keypose.tracker.tracking.cues.keypoint_start import from_keypoints
from keypose.tracker.tracking.cues.soft_correction import Correction
from keypose.tracker.tracking.cycle import track_segment
from keypose.tracker.tracking.diagnostics.observability import observe
from keypose.tracker.tracking.drift import Motions, correct_drift
from keypose.tracker.tracking.frame_pair import capped_score, robust_pass
from keypose.tracker.tracking.initial.chains import blend_chains, follow_both
from keypose.tracker.tracking.initial.templates.patch import Patch
from keypose.tracker.tracking.initial.templates.search import GreyPicture, cut, find_match
from keypose.tracker.tracking.method import FULL, PREVIEW
from keypose.tracker.tracking.scene import Scene
from keypose.tracker.tracking.segment import Segment
from keypose.tracker.video.pyramid import LEVELS, Clip, in_grey_levels, prepare


@dataclass(frozen=True, eq=False)
class BoxScene:
    """A grey box that is moved a little over four small frames."""

    scene: Scene
    segment: Segment

    @classmethod
    def made(cls) -> Self:
        shape = Box(low_m=(-0.2, -0.2, -0.2), high_m=(0.2, 0.2, 0.2))
        body = Body(name="box", parts=(Part(name="box", shape=shape, tracked=ALL_DOFS),))
        skeleton = Skeleton.of(body)
        camera = Camera(width=48, height=48, fx=48.0, fy=48.0, cx=23.5, cy=23.5)
        poses = [Pose.rest(skeleton, (x, 0.0, 1.5)) for x in (0.0, 0.03)]
        scene = Scene.of(skeleton, camera, poses, density=0.05)
        rows, columns = np.mgrid[:48, :48]
        grey = (120 + 60 * np.sin(rows / 3) * np.sin(columns / 4)).astype(np.uint8)
        clip = Clip(0, tuple(np.stack([level] * 4) for level in prepare(grey, None, LEVELS)))
        return cls(scene, Segment(0, 3, poses[0], poses[1], clip))

    @property
    def motion(self) -> Trajectory:
        return self.segment.interpolated()


def _passes(box: BoxScene) -> None:
    given = (box.scene, box.segment.clip, box.motion, FULL.stride)
    robust_pass(*given, FULL.inner, FULL.stop)
    capped_score(*given)


def _drift(box: BoxScene) -> None:
    motion = box.motion
    led = Motions(motion.Rs_parent_part[1:].copy(), motion.ps_camera_root[1:].copy())
    correct_drift(motion, led, box.segment.end)


def _refinement(box: BoxScene) -> None:
    refine(box.scene, box.segment.clip, box.motion, FULL.refinement)


def _templates(box: BoxScene) -> None:
    """Find a piece of a picture in itself."""
    picture = in_grey_levels(box.segment.clip.levels[0][0])
    template = cut(picture, np.array([24.0, 24.0]), 6)
    patch = Patch.cut(picture, (24.0, 24.0, 0.0, 0.0), 6, picture[..., 3] > 0)
    assert template is not None
    assert patch is not None
    find_match(template, GreyPicture.of(picture), np.array([25.0, 23.0]), 3)
    patch.refine(picture, (25.0, 23.0, 0.0, 0.0))


def _keypoints(box: BoxScene) -> None:
    """Correct a motion by two points that are seen where they are."""
    skeleton, path = box.scene.skeleton, box.motion
    points = BodyPoints.single(skeleton, np.zeros(2, int), np.array([[0.1, 0.1, 0.0], [0.0] * 3]))
    p_camera = points.at(path.transforms(skeleton))
    known = np.ones(p_camera.shape[:2])
    depth = p_camera[..., 2] - path.ps_camera_root[:, None, 2]
    anchors = Anchors(
        points,
        np.zeros(2, int),
        box.scene.camera.project(p_camera),
        known,
        depth,
        known,
        known,
        height_px=40.0,
        joints=points,
        by_hand=0 * known,
        depth_sigma_m=known,
        feet=points,
        feet_uv=np.full((*known.shape, 2), np.nan),
    )
    from_keypoints(Correction(box.scene, box.segment, anchors))


def _chains(box: BoxScene) -> None:
    chains = follow_both(box.scene, box.segment, FULL)
    assert chains is not None
    blend_chains(box.scene, *chains)


def _observation(box: BoxScene) -> None:
    observe(box.scene, box.segment.clip, box.motion)


def _track(box: BoxScene) -> None:
    """Track, which finds all of the above compiled."""
    for method in (PREVIEW, FULL):
        for step in track_segment(box.scene, box.segment, method):
            last = step.trajectory
    observe(box.scene, box.segment.clip, last)


def _fit(box: BoxScene) -> None:
    """A frame beside its own texture."""
    scene, pose = box.scene, box.segment.start
    pictures = [level[0] for level in box.segment.clip.levels]
    match = TextureMatch(scene, pictures, [texture_of(scene, pictures, pose, 1.0)])
    match.update_visibility(pose)
    posed = Posed.of(scene.skeleton, pose)
    for level in range(len(pictures)):
        for fine in (False, True):
            match.term(posed, level, fine).equations(posed)
    match.score(pose)


def _reduction(box: BoxScene) -> None:
    reduce_motion(box.scene.skeleton, box.scene.camera, box.motion, Tolerance())


def _drawing(box: BoxScene) -> None:
    skeleton = box.scene.skeleton
    placed = pose_transforms(skeleton, box.segment.start)
    raster(BodyMesh.of(skeleton), placed, ViewCamera.of(box.scene.camera))


def _surface(box: BoxScene) -> None:
    """A surface compared with itself, and drawn."""
    from keypose.tracker.surface.fit.model import SurfaceModel
    from keypose.tracker.surface.fit.options import Options
    from keypose.tracker.surface.fit.pairing import TargetSurface, vertex_scalars
    from keypose.tracker.surface.fit.solving import fit_pose
    from keypose.tracker.surface.mesh import SurfaceMesh
    from keypose.tracker.surface.painting import paint

    body, pose = box.scene.skeleton.body, box.segment.start
    solid = body.parts[0].shape.mesh()
    mesh = SurfaceMesh(solid.vertices + pose.p_camera_root, solid.faces)
    options = Options(points=50)
    model = SurfaceModel.of(mesh, body, pose, options.points)
    fit_pose(model, TargetSurface.of(mesh, options), pose, options)
    vertex_scalars(model, mesh, pose, "distance")
    paint(mesh, box.scene.camera)


@dataclass(frozen=True)
class WarmPart:
    """Some loops: what compiles or loads them, and the share of the time of all, in hundredths."""

    do: Callable[[BoxScene], None]
    share: int


TRACKING: Final[Mapping[str, WarmPart]] = {
    "passes": WarmPart(_passes, 32),
    "keypoints": WarmPart(_keypoints, 16),
    "drift": WarmPart(_drift, 8),
    "refinement": WarmPart(_refinement, 12),
    "chains": WarmPart(_chains, 7),
    "templates": WarmPart(_templates, 4),
    "observation": WarmPart(_observation, 4),
    "track": WarmPart(_track, 1),
}
"""All that a segment needs. In this order two processes compile the least twice."""
OTHERS: Final[Mapping[str, WarmPart]] = {
    "fit": WarmPart(_fit, 8),
    "reduction": WarmPart(_reduction, 10),
    "drawing": WarmPart(_drawing, 2),
    "surface": WarmPart(_surface, 8),
}
PARTS: Final[Mapping[str, WarmPart]] = {**TRACKING, **OTHERS}


class Helper:
    """A process of its own that compiles parts, for one thread to wait for."""

    def __init__(self) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-m", "keypose.tracker.warming"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )

    def do(self, name: str) -> bool:
        """Compile a part; whether the process did, which may have died."""
        stdin, stdout = self._process.stdin, self._process.stdout
        assert stdin is not None
        assert stdout is not None
        try:
            stdin.write(f"{name}\n")
            stdin.flush()
            return stdout.readline() == f"{name}\n"
        except OSError:
            return False

    def close(self) -> None:
        """Let the process end."""
        with self._process, suppress(OSError):
            self._process.communicate()


OBJECTS: Final = 100_000
"""New ones after which the youngest are looked through for garbage, here."""


@contextmanager
def rarely_tidied() -> Iterator[None]:
    """Within, Python seldom looks for garbage, which takes a seventh of a compiler's time."""
    before = gc.get_threshold()
    gc.freeze()
    gc.set_threshold(OBJECTS, *before[1:])
    try:
        yield
    finally:
        gc.set_threshold(*before)
        gc.unfreeze()


def _main() -> None:
    box = BoxScene.made()
    with rarely_tidied():
        for line in sys.stdin:
            PARTS[line.strip()].do(box)
            print(line, end="", flush=True)


if __name__ == "__main__":
    with suppress(KeyboardInterrupt, BrokenPipeError):  # whoever asked is gone, or has enough
        _main()
