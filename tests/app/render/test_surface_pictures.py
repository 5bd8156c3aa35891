"""Pictures of surfaces without a window: the surface around the body in every view, and where it
is seen."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.request import Request, urlopen

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.app.cli.main import main
from keypose.app.orders.drawing import PictureOrder, Viewpoint
from keypose.app.render.films import Film, film_pictures
from keypose.app.render.painting import form_of
from keypose.app.render.palette import Picture
from keypose.app.render.pictures import FourViewLayout, Framing, middle, parallel_view, posed_points
from keypose.app.render.poses import KnownPoses
from keypose.app.render.stills import still
from keypose.app.render.studio import Studio, ViewStyle, snapshot
from keypose.app.render.surfaces import SurfaceLayer, draw_surface
from keypose.app.render.viewpoints import least_distance, view_from
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.raster import raster
from keypose.tracker.geometry.rotations import Array, apply_transform
from keypose.tracker.geometry.view import ViewCamera, ViewName
from keypose.tracker.session import Session
from keypose.tracker.storage.evidence import surfaces_of
from keypose.tracker.storage.files import load_session, open_video_of
from keypose.tracker.surface.mesh import SurfaceMesh
from keypose.tracker.surface.painting import CLAY
from keypose.tracker.video import Video
from tests.app import surface_cases as cases
from tests.app.cli_cases import refused
from tests.app.serving import Keypose, Visitor
from tests.tracker import session_cases

Mask = NDArray[np.bool_]
SMALL: tuple[ViewName, ...] = ("top", "side", "front")
FRAME = 2
CORNER = Viewpoint(50.0, 20.0)


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three steps of the arms, the first of them posed as it is, the last a little beside it."""
    place = cases.write_session(tmp_path_factory.mktemp("arms"), 3, (0, FRAME))
    data = json.loads(place.read_bytes())
    data["bodies"][0]["keyframes"][1]["root_m"][0] += 0.06
    place.write_text(json.dumps(data))
    return place


@pytest.fixture(scope="module")
def session(path: Path) -> Session:
    return load_session(path)


@pytest.fixture(scope="module")
def video(path: Path, session: Session) -> Iterator[Video]:
    with open_video_of(session, path) as opened:
        yield opened


@pytest.fixture(scope="module")
def poses(path: Path, session: Session) -> KnownPoses:
    return KnownPoses.of(session, path)


def posed(poses: KnownPoses, frame: int = FRAME) -> Pose:
    pose = poses.pose(frame)
    assert pose is not None
    return pose


def covered(mesh: SurfaceMesh, view: ViewCamera) -> Mask:
    """The pixels of a picture in which any face lies, projected and filled one by one."""
    uv = view.project(apply_transform(view.T_view_camera, mesh.vertices))
    mask = np.zeros((view.height, view.width), np.uint8)
    for face in np.rint(uv[mesh.faces]).astype(np.int32):
        cv2.fillConvexPoly(mask, face, 1)
    return mask > 0


def grown(mask: Mask, pixels: int) -> Mask:
    """So many pixels larger, or smaller."""
    kernel = np.ones((2 * abs(pixels) + 1,) * 2, np.uint8)
    change = cv2.dilate if pixels > 0 else cv2.erode
    return np.asarray(change(mask.astype(np.uint8), kernel) > 0)


def body_in(poses: KnownPoses, view: ViewCamera) -> Mask:
    form = form_of(poses.skeleton)
    return raster(form.mesh, pose_transforms(poses.skeleton, posed(poses)), view).part >= 0


def require_surface_at(changed: Mask, there: Mask, body: Mask) -> None:
    """Nothing changes away from the surface, and all of it shows where no body is before it."""
    assert not (changed & ~grown(there, 2)).any()
    bare = grown(there, -2) & ~grown(body, 2)
    assert bare.sum() > 100
    assert changed[bare].all()
    assert (changed & grown(body, -2)).sum() > 100  # the body is seen through it


def eye_of(view: ViewName, session: Session, poses: KnownPoses) -> ViewCamera:
    studio = Studio.of(session, poses.skeleton)
    size = (session.view.camera.width, session.view.camera.height)
    return parallel_view(
        posed_points(poses.skeleton, posed(poses)), view, size, Framing(Rs=studio.Rs)
    )


@pytest.mark.parametrize("view", SMALL)
def test_the_surface_is_seen_from_the_side_where_its_vertices_project(
    session: Session, video: Video, poses: KnownPoses, view: ViewName
) -> None:
    alone = snapshot(session, None, FRAME, posed(poses), ViewStyle(view))
    both = snapshot(session, video, FRAME, posed(poses), ViewStyle(view))
    eye, mesh = eye_of(view, session, poses), surfaces_of(video).steps.shape(FRAME)
    changed = (alone != both).any(axis=2)
    require_surface_at(changed, covered(mesh, eye), body_in(poses, eye))


def test_the_surface_is_seen_from_any_viewpoint_where_its_vertices_project(
    session: Session, video: Video, poses: KnownPoses
) -> None:
    wanted = PictureOrder(view=CORNER)
    alone = still(session, None, FRAME, poses, wanted)
    both = still(session, video, FRAME, poses, wanted)
    studio, size = (
        Studio.of(session, poses.skeleton),
        (session.view.camera.width, session.view.camera.height),
    )
    level, points = studio.Rs["front"], posed_points(poses.skeleton, posed(poses))
    centre = middle(points @ level.T) @ level
    view = view_from(
        CORNER, least_distance(CORNER, level, centre, points, size), level, centre, size
    )
    changed = (alone != both).any(axis=2)
    require_surface_at(
        changed, covered(surfaces_of(video).steps.shape(FRAME), view), body_in(poses, view)
    )


def test_what_lies_behind_the_body_stays_hidden() -> None:
    skeleton = session_cases.SKELETON
    pose, form = session_cases.pose(0.0), form_of(skeleton)
    Ts, points = pose_transforms(skeleton, pose), posed_points(skeleton, pose)
    view = ViewCamera.orthographic("front", middle(points), 150.0, (240, 240))
    body = raster(form.mesh, Ts, view).part >= 0
    paper = np.full((240, 240, 3), 250, np.uint8)
    for z, hidden in ((-2.0, False), (2.0, True)):
        wall = plane(middle(points) + np.array([0.0, 0.0, z]))
        changed = (draw_surface(paper, view, wall, form, Ts) != paper).any(axis=2)
        assert changed[~grown(body, 2)].all()
        assert changed[grown(body, -2)].any() != hidden


def plane(p_camera: Array) -> SurfaceLayer:
    """A wide wall of clay that faces the camera."""
    corners = np.array([[-3.0, -3, 0], [3, -3, 0], [3, 3, 0], [-3, 3, 0]]) + p_camera
    mesh = SurfaceMesh(corners, np.array([[0, 2, 1], [0, 3, 2]]))
    return SurfaceLayer(mesh, np.tile(np.array(CLAY, np.uint8), (4, 1)))


def test_all_four_views_show_the_surface_and_the_cameras_own_is_as_it_was(
    session: Session, video: Video, poses: KnownPoses
) -> None:
    look = ViewStyle("all")
    both = snapshot(session, video, FRAME, posed(poses), look)
    places = FourViewLayout.of(session.view.camera, session.view.camera.height)
    main_alone = snapshot(session, video, FRAME, posed(poses), ViewStyle("main"))
    plate = 60  # where the frame's number is written
    width = places.main[0]
    np.testing.assert_array_equal(both[plate:, :width], main_alone[plate:])
    alone = snapshot(session, None, FRAME, posed(poses), look)
    top = 0
    for _, height in places.small:
        rows = slice(top, top + height)
        assert (both[rows, width:] != alone[rows, width:]).any(axis=2).sum() > 300
        top += height + places.gap


@pytest.mark.parametrize("view", ["top", "orbit", CORNER, "all"])
def test_a_film_shows_the_surface_of_every_step(
    session: Session, video: Video, poses: KnownPoses, view: Any
) -> None:
    film = Film(view, 0, 2, size=(480, 360))
    alone = [p.copy() for p in film_pictures(session, None, poses, film, 25.0)]
    both = list(film_pictures(session, video, poses, film, 25.0))
    right = slice(-100, None) if view == "all" else slice(None)  # away from the camera's view
    for one, other in zip(alone, both, strict=True):
        assert (one[:, right] != other[:, right]).any(axis=2).sum() > 100


def test_a_film_of_the_camera_is_its_shots_in_colours_too(
    session: Session, video: Video, poses: KnownPoses
) -> None:
    for tint in ("clay", "distance"):
        film = Film("main", FRAME, FRAME, tint=tint)
        (picture,) = film_pictures(session, video, poses, film, 25.0)
        look = ViewStyle("main", tint=tint)
        expected = snapshot(session, video, FRAME, posed(poses), look)
        np.testing.assert_array_equal(picture, expected)


def test_of_a_session_about_a_film_other_views_show_the_body_alone_as_ever(
    tracked_path: Path,
) -> None:
    of = load_session(tracked_path)
    known = KnownPoses.of(of, tracked_path)
    with open_video_of(of, tracked_path) as film:
        for view in SMALL:
            seen = snapshot(of, film, 3, posed(known, 3), ViewStyle(view))
            alone = snapshot(of, None, 3, posed(known, 3), ViewStyle(view))
            np.testing.assert_array_equal(seen, alone)


def plum(picture: Picture) -> int:
    """How many pixels are clearly redder and bluer than green."""
    red, green, blue = (picture[..., k].astype(int) for k in range(3))
    return int((np.minimum(red, blue) - green > 20).sum())


@pytest.mark.parametrize("view", ["main", "top", "all"])
def test_the_tint_that_is_chosen_colours_every_view(
    session: Session, video: Video, poses: KnownPoses, view: Any
) -> None:
    """The body stands 6 cm beside the surface: by distance most of that is plum."""
    clay, distance = (
        snapshot(session, video, FRAME, posed(poses), ViewStyle(view, opacity=0.2, tint=tint))
        for tint in ("clay", "distance")
    )
    assert plum(distance) > plum(clay) + 1000


def shot(path: Path, out: Path, *more: str) -> bytes:
    command = ["shot", str(path), "--frame", str(FRAME), "--out", str(out), "--overwrite"]
    assert main([*command, *more]) == 0
    return out.read_bytes()


def test_a_shot_of_its_own_size_is_the_plain_one(path: Path, tmp_path: Path) -> None:
    for view in ("top", "all"):
        plain = shot(path, tmp_path / "a.png", "--view", view)
        picture = cv2.imdecode(np.frombuffer(plain, np.uint8), cv2.IMREAD_COLOR)
        height, width = picture.shape[:2]
        sized = shot(path, tmp_path / "b.png", "--view", view, "--size", f"{width}x{height}")
        assert plain == sized


def test_the_body_alone_is_drawn_without_its_surface(path: Path, tmp_path: Path) -> None:
    content = shot(path, tmp_path / "a.png", "--view", "top", "--background", "none")
    alpha = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_UNCHANGED)[..., 3] > 0
    session = load_session(path)
    poses = KnownPoses.of(session, path)
    body = body_in(poses, eye_of("top", session, poses))
    assert not (alpha & ~grown(body, 2)).any()


def test_where_the_meshes_are_gone_the_body_is_drawn_alone_with_a_note(
    path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    there = shot(path, tmp_path / "a.png", "--view", "side")
    lonely = tmp_path / "elsewhere" / "session.json"
    lonely.parent.mkdir()
    shutil.copy(path, lonely)
    assert shot(lonely, tmp_path / "b.png", "--view", "side") != there
    assert "the meshes are missing" in capsys.readouterr().err


def test_where_the_meshes_are_gone_the_body_is_filmed_alone_with_a_note(
    path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lonely = tmp_path / "session.json"
    shutil.copy(path, lonely)
    out = ["--out", str(tmp_path / "a.mp4"), "--size", "64x48"]
    assert main(["film", str(lonely), "--view", "side", *out]) == 0
    reported = capsys.readouterr().err
    assert "the meshes are missing; the body is filmed without its surface" in reported


def test_of_a_step_that_cannot_be_used_the_body_is_drawn_alone_and_it_is_reported(
    path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    whole = shot(path, tmp_path / "a.png", "--view", "side")
    damaged = tmp_path / "damaged"
    shutil.copytree(path.parent, damaged)
    sorted((damaged / "meshes").iterdir())[FRAME].write_bytes(b"")
    assert shot(damaged / "session.json", tmp_path / "b.png", "--view", "side") != whole
    assert f"Step {FRAME}" in capsys.readouterr().err


def test_a_video_has_no_surface_to_colour(
    tracked_path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["shot", tracked_path, "--frame", "3", "--tint", "contact"]
    words = refused(capsys, tmp_path, [*command, "--out", tmp_path / "a.png"])
    assert "no surface to colour" in words


def asked(keypose: Keypose, query: str) -> bytes:
    request = Request(f"{keypose.origin}/picture.png?{query}", headers=keypose.entered.headers)
    with urlopen(request, timeout=120) as answer:
        content: bytes = answer.read()
    return content


def test_what_the_page_exports_is_what_the_command_draws(path: Path, tmp_path: Path) -> None:
    place = tmp_path / "arms"
    shutil.copytree(path.parent, place)
    keypose = Keypose(str(place / "session.json"), "--workspace", str(tmp_path / "workspace"))
    try:
        visitor = Visitor(keypose)
        for view, tint in (("top", "clay"), ("all", "clay"), ("all", "contact"), ("main", "photo")):
            page = asked(keypose, f"view={view}&frames={FRAME}&tint={tint}")
            drawn = shot(place / "session.json", tmp_path / "a.png", "--view", view, "--tint", tint)
            assert page == drawn, (view, tint)
        visitor.leave()
    finally:
        keypose.end()
