"""Surfaces as pictures: where they are seen, how they are lit, what is read on the way."""

from __future__ import annotations

import threading
from pathlib import Path

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray

from keypose.tracker.errors import SurfaceError, VideoError
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.kernels.painting import colour
from keypose.tracker.kernels.raster import PERSPECTIVE, fill
from keypose.tracker.session.references import Surface
from keypose.tracker.surface.mesh import SurfaceMesh
from keypose.tracker.surface.painting import CLAY, GROUND, paint
from keypose.tracker.surface.picture import SurfaceVideo, surface_video
from keypose.tracker.surface.source import MOST_KEPT, SurfaceSteps
from keypose.tracker.video import MissingFrame

CAMERA = Camera(width=160, height=120, fx=200.0, fy=200.0, cx=79.5, cy=59.5)
AWAY = np.array([0.0, 0.0, 3.0])


def box(extents: tuple[float, float, float] = (0.4, 0.6, 0.4)) -> SurfaceMesh:
    """A box 3 m before the camera."""
    made = trimesh.creation.box(extents)
    return SurfaceMesh(np.array(made.vertices) + AWAY, np.array(made.faces))


def is_ground(picture: NDArray[np.uint8]) -> NDArray[np.bool_]:
    return (picture == np.array(GROUND, np.uint8)).all(axis=2)


class Meshes:
    """Boxes of growing size, as a sequence of files would give them; step 3 is damaged."""

    path = Path("scan")
    fps = None

    def __init__(self, count: int = 20) -> None:
        self.frame_count = count
        self.missing: dict[int, str] = {}
        self.read: list[int] = []
        self.closed = False

    def mesh(self, frame: int) -> SurfaceMesh:
        self.read.append(frame)
        if frame == 3:
            raise SurfaceError('Step 3 ("box_3.ply") is damaged: export it again.')
        made = trimesh.creation.box((100 + frame, 200, 50))
        return SurfaceMesh(np.array(made.vertices), np.array(made.faces))

    def fingerprint(self) -> str:
        return "sha256:0"

    def close(self) -> None:
        self.closed = True


SURFACE = Surface(units="cm", up="+z", p_camera_surface=(0.0, 0.0, 8.0), fps=50.0)


def video(meshes: Meshes) -> SurfaceVideo:
    steps = SurfaceSteps(meshes, SURFACE)  # type: ignore[arg-type]
    return surface_video(steps, SURFACE, CAMERA)


def test_a_surface_is_seen_where_the_camera_projects_it() -> None:
    mesh = box()
    seen = ~is_ground(paint(mesh, CAMERA))
    rows, columns = np.nonzero(seen)
    uv = CAMERA.project(mesh.vertices)
    np.testing.assert_allclose(
        (columns.min(), columns.max(), rows.min(), rows.max()),
        (uv[:, 0].min(), uv[:, 0].max(), uv[:, 1].min(), uv[:, 1].max()),
        atol=1.0,
    )


def test_nothing_before_the_camera_is_an_empty_picture() -> None:
    mesh = box()
    behind = SurfaceMesh(mesh.vertices - 3 * AWAY, mesh.faces)
    assert is_ground(paint(behind, CAMERA)).all()


def test_the_light_comes_from_above_and_a_hole_shows_the_darker_inside() -> None:
    ball = trimesh.creation.icosphere(3, 0.5)
    vertices, faces = np.array(ball.vertices) + AWAY, np.array(ball.faces)
    whole = paint(SurfaceMesh(vertices, faces), CAMERA).mean(axis=2)
    assert whole[45, 80] > whole[75, 80] + 10
    middles = vertices[faces].mean(axis=1)
    front = (np.abs(middles[:, :2]).max(axis=1) < 0.15) & (middles[:, 2] < 3)
    open_ = paint(SurfaceMesh(vertices, faces[~front]), CAMERA).mean(axis=2)
    assert 10 < open_[60, 80] < 0.7 * whole[60, 80]


def test_colours_are_those_of_the_vertices() -> None:
    mesh = box()
    red = np.tile(np.array([255, 0, 0], np.uint8), (len(mesh.vertices), 1))
    middle = paint(mesh, CAMERA, red)[60, 80]
    assert middle[0] > 100
    assert middle[1] == middle[2] == 0
    clay = paint(mesh, CAMERA)[60, 80] / np.array(CLAY)
    assert np.ptp(clay) < 0.02


def test_the_loop_colours_as_plain_numpy_does() -> None:
    rng = np.random.default_rng(3)
    corners = rng.uniform((-1, -1, 2), (1, 1, 4), (30, 3))
    faces = rng.permuted(np.tile(np.arange(30), (25, 1)), axis=1)[:, :3].astype(np.int64)
    rgb = rng.uniform(0, 255, (30, 3)).astype(np.float32)
    lens = np.array([60.0, 60.0, 31.5, 23.5])
    nearness = np.full((48, 64), -np.inf, np.float32)
    shown = np.full((48, 64), -1, np.int32)
    fill(corners, faces, np.array([PERSPECTIVE, *lens, 1.0]), 0.05, nearness, shown)
    assert (shown >= 0).mean() > 0.2
    picture = np.full((48, 64, 3), 7, np.uint8)
    colour(corners, faces, rgb, lens, 0.5, shown, picture)
    for row, column in np.argwhere(shown >= 0)[::7]:
        abc = corners[faces[shown[row, column]]]
        ray = np.array([(column - lens[2]) / lens[0], (row - lens[3]) / lens[1], 1.0])
        shares = np.linalg.solve(abc.T, ray)
        value = (shares / shares.sum()) @ rgb[faces[shown[row, column]]]
        value *= 0.5 if np.linalg.det(abc) > 0 else 1.0
        inside = shares.min() > 0  # the rim's pixels may lie a rounding outside
        if inside:
            np.testing.assert_allclose(picture[row, column], value, atol=1.01)
    assert (picture[shown < 0] == 7).all()


def test_the_meshes_lie_in_the_camera_frame_in_metres() -> None:
    with SurfaceSteps(Meshes(), SURFACE) as steps:  # type: ignore[arg-type]
        p = steps.shape(0).vertices
    np.testing.assert_allclose(p.max(axis=0) - p.min(axis=0), (1.0, 0.5, 2.0))
    np.testing.assert_allclose((p.max(axis=0) + p.min(axis=0)) / 2, (0, 0, 8), atol=1e-9)


def test_frames_are_timed_by_the_session() -> None:
    info = video(Meshes(5)).info
    assert (info.width, info.height, info.frame_count) == (160, 120, 5)
    np.testing.assert_allclose(info.times_s, np.arange(5) / 50)


def test_a_step_that_cannot_be_used_is_a_missing_frame_with_its_sentence() -> None:
    with video(Meshes()) as shown:
        for _ in range(2):
            with pytest.raises(MissingFrame, match=r'^Step 3 \("box_3.ply"\) is damaged'):
                shown.frame(3)
        assert shown.info.missing == (3,)
        numbers = [number for number, picture in shown.frames(2, 5) if picture is None]
        assert numbers == [3]
        with pytest.raises(VideoError, match="has no frame 20"):
            shown.frame(20)


def test_steps_asked_for_in_a_row_are_read_ahead_and_forgotten_again() -> None:
    meshes = Meshes(200)
    steps = SurfaceSteps(meshes, SURFACE)  # type: ignore[arg-type]
    for frame in range(10, 30):
        steps.shape(frame)
    steps.close()
    assert meshes.read == list(range(10, 10 + len(meshes.read)))
    assert 20 <= len(meshes.read) <= 21
    assert meshes.closed
    assert len(steps._shapes._kept) <= MOST_KEPT


def test_a_step_looked_at_again_is_not_read_again() -> None:
    meshes = Meshes()
    with SurfaceSteps(meshes, SURFACE) as steps:  # type: ignore[arg-type]
        one = steps.shape(7)
        assert steps.shape(7) is one
        assert steps.mesh(7) is one
    assert meshes.read == [7]


def test_threads_may_share_the_steps() -> None:
    meshes = Meshes(60)
    widths: dict[int, float] = {}
    with SurfaceSteps(meshes, SURFACE) as steps:  # type: ignore[arg-type]

        def walk(frames: range) -> None:
            for frame in frames:
                widths[frame] = float(steps.shape(frame).extent[0])

        walks = [
            threading.Thread(target=walk, args=(r,)) for r in (range(4, 30), range(59, 30, -1))
        ]
        for one in walks:
            one.start()
        for one in walks:
            one.join()
    assert len(widths) == 55
    np.testing.assert_allclose([100 * widths[f] - f for f in sorted(widths)], 100)


def test_closed_meshes_say_so() -> None:
    steps = SurfaceSteps(Meshes(), SURFACE)  # type: ignore[arg-type]
    steps.close()
    with pytest.raises(SurfaceError, match="have been closed"):
        steps.shape(0)
