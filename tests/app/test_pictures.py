"""Pictures of posed bodies: where they land, what they leave alone, how large they are."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from app.palette import PAPER, side_of
from app.pictures import Style, contact_sheet, four_views, orthographic, overlay
from tracker.body import Body, Part
from tracker.camera import Camera
from tracker.geometry import rotation_from_euler
from tracker.pose import Pose, pose_transforms
from tracker.raster import BodyMesh
from tracker.shapes import Box, Cylinder
from tracker.skeleton import Skeleton

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
    for z in (0.0, 0.05, 0.2):
        picture = overlay(GREY, CAMERA, SKELETON, posed((0.05, 0.1, z), 1.2), style)
        assert picture.shape == GREY.shape
        assert four_views(GREY, CAMERA, SKELETON, posed((0.05, 0.1, z)), style).ndim == 3


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


def test_a_contact_sheet_fills_its_last_row_with_blanks() -> None:
    sheet = contact_sheet([GREY, GREY, GREY], 2, ["0", "12", "24"])
    assert sheet.shape[0] > 2 * 180
    assert sheet.shape[1] > 2 * 320
    assert sheet[-90, -160].max() < 40
    with pytest.raises(ValueError, match="at least one"):
        contact_sheet([], 2)


def test_a_frame_of_another_size_than_the_cameras_is_refused() -> None:
    with pytest.raises(ValueError, match="100×50"):
        overlay(np.zeros((50, 100, 3), np.uint8), CAMERA, SKELETON, posed())
