"""Pictures of any size, from anywhere, over the video or on nothing."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.app.cli.main import main
from keypose.app.orders.drawing import Paint, PictureOrder, Size, Viewpoint
from keypose.app.render.poses import KnownPoses
from keypose.app.render.stills import still
from keypose.app.render.studio import Studio, ViewStyle, snapshot
from keypose.app.render.viewpoints import Ground, least_distance, smoothed, view_from
from keypose.tracker.body.pose import pose_transforms
from keypose.tracker.body.raster import BodyMesh, raster
from keypose.tracker.geometry.rotations import apply_transform
from keypose.tracker.geometry.view import ViewCamera
from keypose.tracker.storage.files import load_session, open_video_of
from tests.app.cli_cases import refused
from tests.tracker import session_cases as cases

FRAME = 3
POSES = KnownPoses(cases.SKELETON, {FRAME: cases.pose(FRAME / cases.FRAMES)}, None)
SESSION = cases.session()
STUDIO = Studio.of(SESSION, cases.SKELETON)
POSE = POSES.keys[FRAME]
POINTS = BodyMesh.of(cases.SKELETON).posed(pose_transforms(cases.SKELETON, POSE))
LEVEL = STUDIO.Rs["front"]


def drawn(**wanted: object) -> NDArray[np.uint8]:
    """Without the video."""
    return still(SESSION, None, FRAME, POSES, PictureOrder(**wanted))  # type: ignore[arg-type]


def shot(session: Path, out: Path, *more: str) -> NDArray[np.uint8]:
    """What the command writes, with its alpha."""
    command = ["shot", str(session), "--frame", str(FRAME), "--out", str(out), "--overwrite"]
    assert main([*command, *more]) == 0
    picture = cv2.imread(str(out), cv2.IMREAD_UNCHANGED)
    assert picture is not None
    return np.asarray(picture, np.uint8)


def test_the_videos_own_size_asked_for_is_the_same_file(tracked_path: Path, tmp_path: Path) -> None:
    plain, sized = tmp_path / "plain.png", tmp_path / "sized.png"
    shot(tracked_path, plain)
    shot(tracked_path, sized, "--size", f"{cases.WIDTH}x{cases.HEIGHT}")
    assert plain.read_bytes() == sized.read_bytes()


def test_a_plain_shot_is_the_picture_that_the_page_draws(
    tracked_path: Path, tmp_path: Path
) -> None:
    session = load_session(tracked_path)
    poses = KnownPoses.of(session, tracked_path)
    pose = poses.pose(FRAME)
    assert pose is not None
    found = shot(tracked_path, tmp_path / "a.png", "--style", "wire")
    with open_video_of(session, tracked_path) as video:
        expected = snapshot(session, video, FRAME, pose, ViewStyle("main", "wire", 0.5))
    np.testing.assert_array_equal(cv2.cvtColor(found, cv2.COLOR_BGR2RGB), expected)


@pytest.mark.parametrize("view", ["main", "top", "side", "front", "all", "orbit:70,20"])
@pytest.mark.parametrize("background", ["video", "none"])
@pytest.mark.parametrize("size", ["640x200", "100x300"])
def test_every_view_has_the_size_asked_for(
    tracked_path: Path, tmp_path: Path, view: str, background: str, size: str
) -> None:
    more = ("--view", view, "--background", background, "--size", size)
    picture = shot(tracked_path, tmp_path / "a.png", *more)
    width, height = (int(side) for side in size.split("x"))
    assert picture.shape == (height, width, 4 if background == "none" else 3)


def test_a_scale_enlarges_the_videos_size(tracked_path: Path, tmp_path: Path) -> None:
    picture = shot(tracked_path, tmp_path / "a.png", "--scale", "2.5")
    assert picture.shape[:2] == (round(2.5 * cases.HEIGHT), round(2.5 * cases.WIDTH))


def test_another_shape_than_the_videos_leaves_dark_bars_and_distorts_nothing() -> None:
    wide = drawn(size=(4 * cases.WIDTH, cases.HEIGHT), view="main")
    inner = wide[:, round(1.5 * cases.WIDTH) : round(2.5 * cases.WIDTH)]
    assert wide[:, : round(1.5 * cases.WIDTH)].max() < 30
    np.testing.assert_array_equal(inner, drawn(size=(cases.WIDTH, cases.HEIGHT)))


@pytest.mark.parametrize("paint", [Paint("solid", 1.0), Paint("solid", 0.5), Paint("both", 0.3)])
@pytest.mark.parametrize("ground", [0, 90, 255])
def test_the_body_on_nothing_laid_over_a_picture_is_the_body_painted_over_it(
    paint: Paint, ground: int
) -> None:
    size = (8 * cases.WIDTH, 8 * cases.HEIGHT)
    picture = np.full((cases.HEIGHT, cases.WIDTH, 3), ground, np.uint8)
    painted = STUDIO.main(picture, FRAME, POSE, size, paint).astype(float)
    rgba = STUDIO.main_cut_out(POSE, size, paint).astype(float)
    alpha = rgba[..., 3:] / 255
    laid = alpha * rgba[..., :3] + (1 - alpha) * ground
    assert np.abs(laid - painted).max() <= 2.0
    assert rgba[..., 3].max() > 200 * paint.opacity


def test_alpha_is_nothing_away_from_the_body_all_inside_and_between_on_its_edge() -> None:
    size = (8 * cases.WIDTH, 8 * cases.HEIGHT)
    alpha = STUDIO.main_cut_out(POSE, size, Paint("solid", 1.0))[..., 3]
    view = ViewCamera.of(STUDIO.camera).resized(*size)
    mask = (
        raster(BodyMesh.of(cases.SKELETON), pose_transforms(cases.SKELETON, POSE), view).part >= 0
    )
    kernel = np.ones((5, 5), np.uint8)
    inside = cv2.erode(mask.astype(np.uint8), kernel) > 0
    outside = cv2.dilate(mask.astype(np.uint8), kernel) == 0
    assert inside.sum() > 1000
    assert (alpha[inside] == 255).all()
    assert (alpha[outside] == 0).all()
    assert ((alpha > 0) & (alpha < 255)).sum() > 50


def test_half_opacity_is_half_alpha() -> None:
    size = (8 * cases.WIDTH, 8 * cases.HEIGHT)
    alpha = STUDIO.main_cut_out(POSE, size, Paint("solid", 0.5))[..., 3]
    assert np.median(alpha[alpha > 0]) == pytest.approx(127.5, abs=1)


def test_wire_on_nothing_has_lines_with_soft_edges_and_no_solid() -> None:
    size = (8 * cases.WIDTH, 8 * cases.HEIGHT)
    wire = STUDIO.main_cut_out(POSE, size, Paint("wire", 0.5))[..., 3]
    solid = STUDIO.main_cut_out(POSE, size, Paint("solid", 1.0))[..., 3]
    assert 0 < (wire > 0).sum() < 0.6 * (solid > 0).sum()
    assert len(np.unique(wire)) > 50


def test_all_four_bodies_on_nothing_stand_where_the_four_views_show_them() -> None:
    size = (1000, 480)
    paint = Paint("solid", 1.0)
    alpha = STUDIO.four_cut_out(POSE, size, paint)[..., 3] > 200
    shown = STUDIO.four(None, FRAME, POSE, size, paint).astype(int)
    coloured = np.ptp(shown, axis=2) > 40  # the blue and the orange arm
    coloured &= shown.max(axis=2) > 120
    arms = coloured & alpha
    assert arms.sum() > 500
    assert arms.sum() > 0.7 * coloured.sum()  # the rest is letters and little axes


@pytest.mark.parametrize(
    ("viewpoint", "view"),
    [(Viewpoint(0, 0), "front"), (Viewpoint(90, 0), "side"), (Viewpoint(0, 90), "top")],
)
def test_from_far_away_a_viewpoint_is_the_parallel_view_of_that_side(
    viewpoint: Viewpoint, view: str
) -> None:
    centre = np.array([0.02, -0.1, 3.1])
    eye = view_from(viewpoint, 1e5, LEVEL, centre, (400, 400))
    seen = eye.project(apply_transform(eye.T_view_camera, POINTS))
    flat = ViewCamera.orthographic(view, centre, eye.focal[0] / 1e5, (400, 400))  # type: ignore[arg-type]
    expected = flat.project(apply_transform(flat.T_view_camera, POINTS))
    np.testing.assert_allclose(seen, expected, atol=1e-4)


@pytest.mark.parametrize("size", [(640, 360), (360, 640)])
@pytest.mark.parametrize("azimuth", [0.0, 33.0, 90.0, 180.0, -77.0])
@pytest.mark.parametrize("elevation", [-60.0, 0.0, 12.0, 90.0])
def test_the_least_distance_shows_all_of_the_body_and_fills_the_picture(
    size: Size, azimuth: float, elevation: float
) -> None:
    viewpoint = Viewpoint(azimuth, elevation)
    centre = POINTS.mean(axis=0)
    distance = least_distance(viewpoint, LEVEL, centre, POINTS, size)
    view = view_from(viewpoint, distance, LEVEL, centre, size)
    uv = view.project(apply_transform(view.T_view_camera, POINTS))
    assert (uv > -0.5).all()
    assert (uv < np.array(size) - 0.5).all()
    margins = np.concatenate([uv.min(axis=0), np.array(size) - uv.max(axis=0)])
    assert (margins / np.array([*size, *size])).min() < 0.08


def test_a_stick_that_points_at_the_camera_keeps_its_distance() -> None:
    stick = np.array([[0.0, 0.0, 2.0], [0.0, 0.0, 4.0]])
    centre = np.array([0.0, 0.0, 3.0])
    assert least_distance(Viewpoint(0.0, 0.0), LEVEL, centre, stick, (64, 64)) == pytest.approx(1.5)


def test_a_new_viewpoint_shows_the_silhouette_that_its_eye_sees() -> None:
    size = (320, 240)
    viewpoint = Viewpoint(40.0, 25.0)
    picture = drawn(view=viewpoint, size=size, background="none")
    low, high = (POINTS @ LEVEL.T).min(axis=0), (POINTS @ LEVEL.T).max(axis=0)
    centre = (low + high) / 2 @ LEVEL
    distance = least_distance(viewpoint, LEVEL, centre, POINTS, size)
    view = view_from(viewpoint, distance, LEVEL, centre, size)
    seen = (
        raster(BodyMesh.of(cases.SKELETON), pose_transforms(cases.SKELETON, POSE), view).part >= 0
    )
    overlap = (seen & (picture[..., 3] > 127)).sum() / (seen | (picture[..., 3] > 127)).sum()
    assert overlap > 0.97


def test_the_worlds_up_stands_upright_from_every_side() -> None:
    up = np.array([0.3, -0.9, 0.2])
    tilted = SESSION.changed({"up_world": tuple(up)})
    level = Studio.of(tilted, cases.SKELETON).Rs["front"]
    for azimuth in range(0, 360, 30):
        view = view_from(
            Viewpoint(azimuth, 10.0), 4.0, level, np.array([0.0, 0.0, 3.0]), (400, 300)
        )
        foot, head = np.array([0.0, 0.0, 3.0]), np.array([0.0, 0.0, 3.0]) + 0.5 * up
        uv = view.project(apply_transform(view.T_view_camera, np.array([foot, head])))
        assert uv[1, 0] == pytest.approx(uv[0, 0], abs=1e-6)
        assert uv[1, 1] < uv[0, 1] - 10


def test_the_floor_lies_under_the_lowest_of_all_poses() -> None:
    high, low = cases.pose(0.0), cases.pose(0.0)
    sunk = type(low)(low.Rs_parent_part, low.p_camera_root + np.array([0.0, 0.7, 0.0]))
    alone = Ground.under(cases.SKELETON, LEVEL, [high])
    both = Ground.under(cases.SKELETON, LEVEL, [high, sunk])
    assert both.floor_m == pytest.approx(alone.floor_m + 0.7)


def test_calm_places_follow_slow_ways_and_shrug_at_quick_ones() -> None:
    straight = np.linspace([0.0, 0.0, 0.0], [10.0, 0.0, 0.0], 200)
    assert np.abs(smoothed(straight, 10.0) - straight)[40:-40].max() < 1e-9
    shaken = straight + np.where(np.arange(200) % 2, 0.1, -0.1)[:, None]
    assert np.abs(smoothed(shaken, 10.0) - straight)[40:-40].max() < 0.005
    np.testing.assert_array_equal(smoothed(straight[:1], 10.0), straight[:1])


@pytest.mark.parametrize(
    ("more", "sentence"),
    [
        (["--view", "behind"], "is not a view; choose main, top"),
        (["--view", "orbit:"], "is not a view"),
        (["--view", "orbit:nan,3"], "is not a view"),
        (["--view", "orbit:1,2,3"], "is not a view"),
        (["--view", "orbit:10,91"], "from -90 to 90 degrees"),
        (["--view", "camera:10,20,0"], "from 0.1 to 10000 metres"),
        (["--size", "1920"], "is not a size such as 1920x1080"),
        (["--size", "4x4"], "is not a size"),
        (["--size", "99999x99999"], "is not a size"),
        (["--size", "8000x8000"], "more than 20 million pixels"),
        (["--scale", "inf"], "is not a number from 0.05 to 16"),
        (
            ["--scale", "2", "--size", "64x64"],
            "--size and --scale mean the same",
        ),
        (["--background", "white"], "invalid choice"),
    ],
)
def test_what_cannot_be_drawn_is_refused_in_one_sentence(
    tracked_path: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    more: list[str],
    sentence: str,
) -> None:
    command = ["shot", tracked_path, "--frame", "3", "--out", tmp_path / "a.png", *more]
    assert sentence in refused(capsys, tmp_path, command)  # type: ignore[arg-type]


def test_a_scale_that_makes_a_giant_is_refused(
    tracked_path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    giant = {"width": 4000, "height": 3000}
    cases.altered(
        tracked_path, lambda data: (data["video"].update(giant), data["camera"].update(giant))
    )
    command = ["shot", tracked_path, "--frame", "4", "--out", tmp_path / "a.png", "--scale", "3"]
    assert "108 million pixels" in refused(capsys, tmp_path, command)  # type: ignore[arg-type]
