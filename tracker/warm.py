"""Getting the compiled loops ready before they are needed.

The first run on a machine compiles them, which takes about a minute; later runs load them from
disk. `warm` does either by tracking a tiny grey box, so that it can be done while a
person's video is still being read.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

import numba
import numpy as np

from keypose.tracker import kernels
from keypose.tracker.body.body import ALL_DOFS, Body, Part
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.raster import BodyMesh, raster
from keypose.tracker.body.shapes import Box
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.fitting.pose.texture import TextureMatch, texture_of
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import transform
from keypose.tracker.geometry.view import ViewCamera
from keypose.tracker.reduction.reduce import reduce_motion
from keypose.tracker.reduction.result import Tolerance
from keypose.tracker.solver.posed import Posed
from keypose.tracker.tracking.cycle import track_segment
from keypose.tracker.tracking.diagnostics.observability import observe
from keypose.tracker.tracking.initial.templates.patch import Patch
from keypose.tracker.tracking.initial.templates.search import GreyPicture, cut, find_match
from keypose.tracker.tracking.method import FULL, PREVIEW
from keypose.tracker.tracking.scene import Scene
from keypose.tracker.tracking.segment import Segment
from keypose.tracker.video.pyramid import LEVELS, Clip, Picture, prepare

_DONE, _HULLS_DONE = "warm", "warm-hulls"


def is_warm() -> bool:
    """Return whether the loops, as their files lie here, were compiled on this machine before."""
    return _is_marked(_DONE)


def preparing_words() -> str:
    """Return what is said before `warm` compiles the loops."""
    problem = kernels.FOLDER.problem
    if problem:
        return (
            f"Preparing the tracker: about a minute, and again at the next start, for {problem}. "
            "Make room there, or set XDG_CACHE_HOME to another folder of yours."
        )
    return "Preparing the tracker for this computer, once: about a minute."


def warm() -> None:
    """Compile the loops, or load them."""
    shape = Box(low_m=(-0.2, -0.2, -0.2), high_m=(0.2, 0.2, 0.2))
    body = Body(name="box", parts=(Part(name="box", shape=shape, tracked=ALL_DOFS),))
    skeleton = Skeleton.of(body)
    camera = Camera(width=48, height=48, fx=48.0, fy=48.0, cx=23.5, cy=23.5)
    poses = [Pose.rest(skeleton, (x, 0.0, 1.5)) for x in (0.0, 0.03)]
    scene = Scene.of(skeleton, camera, poses, density=0.05)
    rows, columns = np.mgrid[:48, :48]
    grey = (120 + 60 * np.sin(rows / 3) * np.sin(columns / 4)).astype(np.uint8)
    pyramid = prepare(grey, None, LEVELS)
    clip = Clip(0, tuple(np.stack([level] * 4) for level in pyramid))
    segment = Segment(0, 3, poses[0], poses[1], clip)
    for method in (PREVIEW, FULL):
        for step in track_segment(scene, segment, method):
            last = step.trajectory
    observe(scene, clip, last)
    _compare(scene, [level[0] for level in clip.levels], poses[0])
    _match(clip.levels[0][0])
    reduce_motion(skeleton, camera, segment.interpolated(), Tolerance())
    raster(BodyMesh.of(skeleton), pose_transforms(skeleton, poses[0]), ViewCamera.of(camera))
    if not is_warm():  # compiled, they load in no time, should there be surfaces at all
        _surface(body, poses[0], camera)
    _put_mark(_DONE)


def are_hulls_warm() -> bool:
    """Return whether the loops of visual hulls were compiled on this machine before."""
    return _is_marked(_HULLS_DONE)


def warm_hulls() -> None:
    """Compile these, or load them: on a ball that four cameras see as a disc."""
    from keypose.tracker.surface.cameras.footage import consistency
    from keypose.tracker.surface.cameras.hull import Silhouette, hull_field, hull_mesh
    from keypose.tracker.surface.cameras.rig import View

    camera = Camera(width=48, height=48, fx=48.0, fy=48.0, cx=23.5, cy=23.5)
    rows, columns = np.mgrid[:48, :48]
    disc = Silhouette(np.hypot(rows - 23.5, columns - 23.5) < 12)
    grey = (120 + 60 * np.sin(rows / 3) * np.sin(columns / 4)).astype(np.uint8)
    views = []
    for turn in np.arange(4) * np.pi / 2:
        R = np.array([[np.cos(turn), 0, np.sin(turn)], [0, 1, 0], [-np.sin(turn), 0, np.cos(turn)]])
        views.append(View(f"{turn:.0f}", camera, transform(R, np.array([0.0, 0.0, 2.0]))))
    mesh = hull_mesh(hull_field(views, [disc] * len(views), 0.08))
    consistency(mesh, views, [grey] * len(views))
    _put_mark(_HULLS_DONE)


def _surface(body: Body, pose: Pose, camera: Camera) -> None:
    """A surface compared with itself, and drawn."""
    from keypose.tracker.surface.fit.model import SurfaceModel
    from keypose.tracker.surface.fit.options import Options
    from keypose.tracker.surface.fit.pairing import TargetSurface, vertex_scalars
    from keypose.tracker.surface.fit.solving import fit_pose
    from keypose.tracker.surface.mesh import SurfaceMesh
    from keypose.tracker.surface.painting import paint

    solid = body.parts[0].shape.mesh()
    mesh = SurfaceMesh(solid.vertices + pose.p_camera_root, solid.faces)
    options = Options(points=50)
    model = SurfaceModel.of(mesh, body, pose, options.points)
    fit_pose(model, TargetSurface.of(mesh, options), pose, options)
    vertex_scalars(model, mesh, pose, "distance")
    paint(mesh, camera)


def _compare(scene: Scene, pictures: Sequence[Picture], pose: Pose) -> None:
    """A frame beside its own texture."""
    match = TextureMatch(scene, pictures, [texture_of(scene, pictures, pose, 1.0)])
    match.update_visibility(pose)
    posed = Posed.of(scene.skeleton, pose)
    for level in range(len(pictures)):
        for fine in (False, True):
            match.term(posed, level, fine).equations(posed)
    match.score(pose)


def _match(picture: Picture) -> None:
    """Find a piece of a picture in itself."""
    template = cut(picture, np.array([24.0, 24.0]), 6)
    patch = Patch.cut(picture, (24.0, 24.0, 0.0, 0.0), 6, picture[..., 3] > 0)
    assert template is not None
    assert patch is not None
    find_match(template, GreyPicture.of(picture), np.array([25.0, 23.0]), 3)
    patch.refine(picture, (25.0, 23.0, 0.0, 0.0))


def _is_marked(name: str) -> bool:
    return kernels.FOLDER.path is not None and _mark(name).exists()


def _put_mark(name: str) -> None:
    if kernels.FOLDER.path is not None:
        with suppress(OSError):  # the disk is full by now: they are compiled once more
            _mark(name).touch()


def _mark(name: str) -> Path:
    """A mark in the cache, valid for the loops' present files: numba compiles them again where
    their files are elsewhere or were rewritten, even with the same text."""
    files = sorted(Path(kernels.__file__).absolute().parent.glob("*.py"))
    stamps = [(str(file), (facts := file.stat()).st_mtime_ns, facts.st_size) for file in files]
    stamp = hashlib.sha256(repr(stamps).encode()).hexdigest()[:12]
    return Path(numba.config.CACHE_DIR) / f"{name}-{stamp}"  # type: ignore[attr-defined]
