"""Pictures of posed bodies: where they land, what they leave alone, how large they are."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.app.orders.drawing import Style
from keypose.app.render import pictures
from keypose.app.render.lettering import axes, length_name, round_length, scale_bar, write_name
from keypose.app.render.palette import GRID, GRID_MIDDLE, PAPER, Picture, side_of
from keypose.app.render.pictures import four_views, orthographic, overlay
from keypose.tracker.body.body import Body, Part, load_body
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.raster import BodyMesh
from keypose.tracker.body.shapes import Box, Cylinder
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import rotation_from_euler
from keypose.tracker.geometry.view import ViewName

CAMERA = Camera(width=320, height=180, fx=300.0, fy=300.0, cx=163.2, cy=88.7)
GREY = np.full((180, 320, 3), 90, dtype=np.uint8)
STYLES: tuple[Style, ...] = ("wire", "solid", "both")


def figure() -> Skeleton:
    trunk = Part(name="trunk", shape=Box(low_m=(-0.2, -0.3, -0.1), high_m=(0.2, 0.3, 0.1)))
    arms = [
        Part(
            name=f"{side}_arm",
            parent="trunk",
            joint_m=(x, -0.25, 0.0),
            shape=Cylinder(end_m=0.5, radius_m=0.06),
        )
        for side, x in (("left", 0.28), ("right", -0.28))
    ]
    return Skeleton.of(
        Body(name="figure", parts=(trunk, *arms), mirror_pairs=(("left_arm", "right_arm"),))
    )


SKELETON = figure()


def posed(p: tuple[float, float, float] = (0.1, 0.0, 3.0), turn: float = 0.5) -> Pose:
    R = np.tile(np.eye(3), (3, 1, 1))
    R[0], R[1] = rotation_from_euler(0.1, turn, 0.2), rotation_from_euler(-0.9, 0.0, -0.4)
    return Pose(R, np.array(p))


def changed_box(picture: NDArray[np.uint8], ground: NDArray[np.uint8]) -> NDArray[np.int64]:
    """First and last changed column and row: [[u0, v0], [u1, v1]]."""
    rows, columns = np.nonzero((picture != ground).any(axis=2))
    return np.array([[columns.min(), rows.min()], [columns.max(), rows.max()]])


def test_a_solid_overlay_ends_where_the_camera_projects_the_body() -> None:
    pose = posed()
    picture = overlay(GREY, CAMERA, SKELETON, pose, "solid", 1.0)
    p_camera = BodyMesh.of(SKELETON).posed(pose_transforms(SKELETON, pose))
    uv = CAMERA.project(p_camera)
    # a pixel is touched when its area, half a pixel to each side, is
    expected = np.array([uv.min(axis=0) - 0.5, uv.max(axis=0) + 0.5])
    inner = changed_box(picture, GREY) + np.array([[-0.5, -0.5], [0.5, 0.5]])
    assert np.abs(inner - expected).max() <= 1.0


def test_the_overlays_edge_is_placed_to_a_fraction_of_a_pixel() -> None:
    box = Part(name="block", shape=Box(low_m=(-0.2, -0.2, 0.0), high_m=(0.2, 0.2, 0.01)))
    skeleton = Skeleton.of(Body(name="plate", parts=(box,)))
    white = np.full((180, 320, 3), 255, dtype=np.uint8)
    for shift in np.linspace(0.0, 0.01, 7):
        pose = Pose.rest(skeleton, (float(shift), 0.0, 3.0))
        row = overlay(white, CAMERA, skeleton, pose, "solid", 1.0)[88].astype(float).sum(axis=1)
        covered = np.nonzero(row < 765)[0]
        left, right = CAMERA.project(np.array([[shift - 0.2, 0.0, 3.0], [shift + 0.2, 0.0, 3.0]]))
        assert abs(covered.mean() - (left[0] + right[0]) / 2) <= 0.5


@pytest.mark.parametrize("style", STYLES)
def test_pixels_away_from_the_body_stay_as_they_are(style: Style) -> None:
    noise = np.random.default_rng(1).integers(0, 255, GREY.shape, dtype=np.uint8)
    picture = overlay(noise, CAMERA, SKELETON, posed(), style)
    (left, top), (right, bottom) = changed_box(picture, noise)
    uv = CAMERA.project(BodyMesh.of(SKELETON).posed(pose_transforms(SKELETON, posed())))
    assert (np.array([left, top]) > uv.min(axis=0) - 5).all()
    assert (np.array([right, bottom]) < uv.max(axis=0) + 5).all()
    assert picture.shape == noise.shape
    assert picture.dtype == np.uint8


@pytest.mark.parametrize("style", STYLES)
@pytest.mark.parametrize("p", [(30.0, 0.0, 3.0), (0.0, 0.0, -3.0)])
def test_a_body_out_of_sight_leaves_the_frame_alone(
    style: Style, p: tuple[float, float, float]
) -> None:
    np.testing.assert_array_equal(overlay(GREY, CAMERA, SKELETON, posed(p), style), GREY)


@pytest.mark.parametrize("style", STYLES)
def test_a_body_partly_behind_the_camera_is_drawn_without_harm(style: Style) -> None:
    small = CAMERA.model_copy(update={"width": 80, "height": 45, "fx": 75.0, "fy": 75.0})
    small = small.model_copy(update={"cx": 40.8, "cy": 22.2})
    grey = GREY[::4, ::4].copy()
    for z in (0.0, 0.05, 0.2):
        picture = overlay(grey, small, SKELETON, posed((0.05, 0.1, z), 1.2), style)
        assert picture.shape == grey.shape
        four = four_views(grey, small, SKELETON, posed((0.05, 0.1, z)), style, height=240)
        assert four.shape[0] == 240


def test_left_right_and_middle_are_told_apart_by_colour() -> None:
    picture = orthographic(SKELETON, Pose.rest(SKELETON, (0.0, 0.0, 3.0)), "front", (300, 300))
    row = picture[150].astype(int)
    blue, orange = row[:, 2] - row[:, 0], row[:, 0] - row[:, 2]
    assert np.argmax(blue) > 180  # the body faces the camera: its left is on the right
    assert np.argmax(orange) < 120
    assert [side_of(SKELETON.body, name) for name in SKELETON.body.names] == [
        "middle",
        "left",
        "right",
    ]


def test_an_orthographic_view_shows_the_same_picture_at_any_distance() -> None:
    near = orthographic(SKELETON, posed((0.0, 0.0, 3.0)), "front", (200, 160), None, 2.0)
    far = orthographic(SKELETON, posed((0.0, 0.0, 30.0)), "front", (200, 160), None, 2.0)
    np.testing.assert_array_equal(near, far)


def test_metres_across_sets_the_scale_of_an_orthographic_view() -> None:
    plate = Part(name="block", shape=Box(low_m=(-0.5, -0.1, -0.1), high_m=(0.5, 0.1, 0.1)))
    skeleton = Skeleton.of(Body(name="plate", parts=(plate,)))
    pose = Pose.rest(skeleton, (0.0, 0.0, 3.0))
    picture = orthographic(skeleton, pose, "front", (401, 201), np.array([0.0, 0.0, 3.0]), 4.0)
    dark = np.abs(picture[104].astype(int) - PAPER).max(axis=1) > 30
    assert dark.sum() == pytest.approx(100 + 1, abs=2)


@pytest.mark.parametrize("view", ["top", "side", "front"])
def test_the_whole_body_fits_into_a_view_that_is_left_to_itself(view: str) -> None:
    picture = orthographic(SKELETON, posed((3.0, 1.0, 9.0)), view, (240, 320))  # type: ignore[arg-type]
    assert picture.shape == (320, 240, 3)
    assert picture.dtype == np.uint8
    edge = np.concatenate([picture[0], picture[-1], picture[:, 0], picture[:, -1]])
    assert edge.min() > 190


def test_four_views_are_one_picture_of_the_height_asked_for() -> None:
    picture = four_views(GREY, CAMERA, SKELETON, posed(), height=480)
    assert picture.shape[0] == 480
    assert picture.shape[1] > 480 * 320 / 180 + 150
    assert picture.dtype == np.uint8


def cube(side_m: float) -> Skeleton:
    half = side_m / 2
    shape = Box(low_m=(-half, -half, -half), high_m=(half, half, half))
    return Skeleton.of(Body(name="cube", parts=(Part(name="cube", shape=shape),)))


def drawn_bar(
    skeleton: Skeleton, size: tuple[int, int], monkeypatch: pytest.MonkeyPatch
) -> tuple[str, float]:
    """The scale bar's name, and its length as a share of the width, in a front view."""
    seen: list[tuple[str, float]] = []

    def watched(picture: Picture, metres: float, pixels_per_metre: float, letter_px: float) -> int:
        seen.append((length_name(metres), metres * pixels_per_metre / picture.shape[1]))
        end = scale_bar(picture, metres, pixels_per_metre, letter_px)
        assert 0 < end <= picture.shape[1]
        return end

    monkeypatch.setattr(pictures, "scale_bar", watched)
    orthographic(skeleton, Pose.rest(skeleton, (0.0, 0.0, 3.0)), "front", size)
    return seen[0]


@pytest.mark.parametrize(("side_m", "name"), [(0.084, "2 cm"), (200.0, "50 m"), (0.02, "5 mm")])
def test_the_scale_bar_of_a_cube_suits_its_size(
    side_m: float, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    words, share = drawn_bar(cube(side_m), (480, 480), monkeypatch)
    assert words == name
    assert 0.15 < share < 0.35


@pytest.mark.parametrize("size", [(480, 480), (312, 238), (1920, 1080)])
@pytest.mark.parametrize("preset", ["adult_male", "elderly_female"])
def test_a_person_is_drawn_with_a_scale_bar_of_half_a_metre(
    preset: str, size: tuple[int, int], monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = Path(__file__).parents[3] / "tracker" / "body" / "presets"
    person = Skeleton.of(load_body(folder / f"{preset}.json"))
    assert drawn_bar(person, size, monkeypatch)[0] == "0.5 m"


def test_a_scale_bar_is_a_round_length_that_takes_a_fair_share_of_any_width() -> None:
    for across in np.geomspace(1e-4, 1e6, 3001):
        length = round_length(float(across))
        assert 0.12 <= length / across <= 0.35
        assert f"{length:e}"[0] in "125"
        assert f"{length:.15e}"[1:17].strip(".0") == ""


@pytest.mark.parametrize(
    ("metres", "name"),
    [
        (0.0005, "0.5 mm"),
        (0.005, "5 mm"),
        (0.01, "1 cm"),
        (0.05, "5 cm"),
        (0.1, "0.1 m"),
        (0.5, "0.5 m"),
        (50.0, "50 m"),
        (500.0, "500 m"),
        (2000.0, "2 km"),
    ],
)
def test_a_length_is_named_in_the_unit_people_would_use(metres: float, name: str) -> None:
    assert length_name(metres) == name


def grid_lines(picture: Picture) -> tuple[list[int], list[int]]:
    """Columns and rows of the grid lines that reach the picture's upper left borders."""
    line = [np.array(GRID), np.array(GRID_MIDDLE)]
    top, left = picture[0], picture[:, 0]
    columns, rows = (
        [k for k, pixel in enumerate(border) if any((pixel == colour).all() for colour in line)]
        for border in (top, left)
    )
    return columns, rows


@pytest.mark.parametrize("side_m", [0.084, 1.7, 200.0])
def test_grid_lines_lie_at_multiples_of_the_scale_bars_length(side_m: float) -> None:
    across = 1.22 * side_m
    skeleton = cube(side_m)
    centre = np.array([0.0, 0.0, 0.0])
    pose = Pose.rest(skeleton, (0.0, 0.0, 0.0))
    picture = orthographic(skeleton, pose, "front", (481, 481), centre, across)
    columns, rows = grid_lines(picture)
    step_px = round_length(across) * 481 / across
    count = int(240 / step_px)
    expected = [round(240 + k * step_px) for k in range(-count, count + 1)]
    assert columns == expected
    assert rows == expected


@pytest.mark.parametrize("size", [(60, 2000), (2000, 60), (100, 900)])
def test_even_a_very_long_picture_has_at_most_forty_grid_lines(size: tuple[int, int]) -> None:
    centre = np.zeros(3)
    pose = Pose.rest(SKELETON, (500.0, 500.0, 500.0))
    columns, rows = grid_lines(orthographic(SKELETON, pose, "front", size, centre, 2.0))
    assert 3 <= len(columns) + len(rows) <= 40


@pytest.mark.parametrize("size", [(1, 1), (2, 2), (1, 300), (300, 1), (20, 20), (64, 24)])
@pytest.mark.parametrize("view", ["top", "side", "front"])
def test_pictures_of_any_size_can_be_drawn(size: tuple[int, int], view: ViewName) -> None:
    picture = orthographic(SKELETON, posed(), view, size)
    assert picture.shape == (size[1], size[0], 3)


@pytest.mark.parametrize("style", STYLES)
def test_a_video_of_two_by_two_pixels_gets_the_overlay_alone(style: Style) -> None:
    camera = Camera(width=2, height=2, fx=2.0, fy=2.0, cx=0.5, cy=0.5)
    grey = np.full((2, 2, 3), 90, dtype=np.uint8)
    picture = four_views(grey, camera, SKELETON, posed(), style, height=2)
    np.testing.assert_array_equal(picture, overlay(grey, camera, SKELETON, posed(), style))


@pytest.mark.parametrize("height", [1, 2, 3, 5, 7, 23, 24, 25, 40, 100])
@pytest.mark.parametrize(("width", "rows"), [(320, 180), (2, 400), (400, 2), (2, 2)])
def test_four_views_are_drawn_at_any_height(height: int, width: int, rows: int) -> None:
    camera = Camera(width=width, height=rows, fx=300.0, fy=300.0, cx=width / 2, cy=rows / 2)
    grey = np.full((rows, width, 3), 90, dtype=np.uint8)
    picture = four_views(grey, camera, SKELETON, posed(), height=height)
    assert picture.shape[0] == height


@pytest.mark.parametrize("size", [(104, 79), (104, 40), (104, 100), (150, 100), (312, 238)])
@pytest.mark.parametrize("up", ["z", "-y"])
def test_axes_scale_bar_and_name_never_cover_each_other(size: tuple[int, int], up: str) -> None:
    def sheet() -> Picture:
        return np.full((size[1], size[0], 3), PAPER, dtype=np.uint8)

    named, barred, crossed = sheet(), sheet(), sheet()
    letter_px = 8.0 if size[1] < 200 else 10.8
    write_name(named, "Front", letter_px)
    bar_end = scale_bar(barred, 0.5, 0.33 * size[0] / 0.5, letter_px)
    axes(crossed, "x", up, letter_px, bar_end)
    masks = [(picture != PAPER).any(axis=2) for picture in (named, barred, crossed)]
    assert sum(mask.astype(int) for mask in masks).max() == 1
    assert masks[0].any()
    assert masks[1].any()
    assert masks[2].any() == (size in ((150, 100), (312, 238)))


def test_a_frame_of_another_size_than_the_cameras_is_refused() -> None:
    with pytest.raises(ValueError, match="100×50"):
        overlay(np.zeros((50, 100, 3), np.uint8), CAMERA, SKELETON, posed())
