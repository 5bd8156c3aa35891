"""Regions: which square of the picture is looked at, and the way back from it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from keypose.tracker.body.body import preset
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import KeypointError
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import rotation_from_euler
from keypose.tracker.keypoints.region import MARGIN, Region

CAMERA = Camera(width=640, height=360, fx=500.0, fy=500.0, cx=320.0, cy=180.0)
SKELETON = Skeleton.of(preset("adult_male"))
PIXELS = 256


def mapped(region: Region, *uv: float) -> np.ndarray:
    A = region.to_picture(PIXELS)
    return A[:, :2] @ uv + A[:, 2]


@given(
    st.floats(-50, 700), st.floats(-50, 400), st.floats(10, 900), st.floats(-np.pi, np.pi)
)  # fmt: skip
def test_the_circle_a_region_was_made_of_gives_that_region_again(
    x: float, y: float, side: float, turn: float
) -> None:
    rim = np.array([x, y]) + side / (2 * MARGIN) * np.array([np.sin(turn), -np.cos(turn)])
    again = Region.of_circle(np.array([x, y]), rim)
    assert (again.x, again.y, again.side) == pytest.approx((x, y, side))
    assert np.exp(1j * again.turn_rad) == pytest.approx(np.exp(1j * turn))


@pytest.mark.parametrize("turn", [0.0, 1e-9, np.pi, -np.pi, np.pi / 2])
def test_the_middle_stays_and_up_in_the_square_is_along_the_body(turn: float) -> None:
    region = Region(200.0, 100.0, 128.0, turn)
    middle = (PIXELS - 1) / 2
    assert mapped(region, middle, middle) == pytest.approx([200.0, 100.0])
    above = mapped(region, middle, middle - 100)
    assert above == pytest.approx([200 + 50 * np.sin(turn), 100 - 50 * np.cos(turn)])


def test_an_unturned_square_as_large_as_its_pixels_is_the_picture_itself() -> None:
    assert Region(127.5, 127.5, 256.0).to_picture(256) == pytest.approx(np.eye(2, 3))


def test_a_box_may_be_drawn_from_any_corner_and_reach_out_of_the_picture() -> None:
    region = Region.of_box((-20, 10, 60, 200), 640, 360)
    assert region == Region.of_box((60, 200, -20, 10), 640, 360)
    assert (region.x, region.y) == (20, 105)


@pytest.mark.parametrize("box", [(5, 5, 5, 90), (5, 5, 90, 5), (7, 7, 7, 7)])
def test_a_box_without_size_is_refused(box: tuple[float, float, float, float]) -> None:
    with pytest.raises(KeypointError, match="has no size"):
        Region.of_box(box, 640, 360)


@pytest.mark.parametrize("box", [(700, 5, 800, 90), (5, -90, 90, -5), (-50, 5, -5, 90)])
def test_a_box_outside_the_picture_is_refused(box: tuple[float, float, float, float]) -> None:
    with pytest.raises(KeypointError, match="outside the picture of 640 × 360"):
        Region.of_box(box, 640, 360)


def test_a_box_that_is_no_number_is_refused() -> None:
    with pytest.raises(KeypointError, match="no number"):
        Region.of_box((np.nan, 5, 8, 90), 640, 360)


@pytest.mark.parametrize("angle", [0.0, 0.3, np.pi / 2, np.pi, -2.0])
def test_a_posed_bodys_region_turns_with_the_body(angle: float) -> None:
    rest = Pose.rest(SKELETON, (0.0, 0.0, 4.0))
    Rs = np.array(rest.Rs_parent_part)
    Rs[0] = rotation_from_euler(angle, 0.0, 0.0) @ Rs[0]
    region = Region.of_pose(SKELETON, Pose(Rs, rest.p_camera_root), CAMERA)
    upright = Region.of_pose(SKELETON, rest, CAMERA)
    assert np.exp(1j * region.turn_rad) == pytest.approx(np.exp(1j * angle), abs=1e-6)
    assert region.side == pytest.approx(upright.side)
    from_middle = np.array([region.x - 320, region.y - 180])
    c, s = np.cos(angle), np.sin(angle)
    offset = np.array([upright.x - 320, upright.y - 180])
    assert from_middle == pytest.approx(np.array([[c, -s], [s, c]]) @ offset, abs=1e-6)


def test_a_body_behind_the_camera_has_no_region() -> None:
    with pytest.raises(KeypointError, match="behind the camera"):
        Region.of_pose(SKELETON, Pose.rest(SKELETON, (0.0, 0.0, -4.0)), CAMERA)


def test_regions_that_are_nearly_the_same_are_rounded_to_the_same_one() -> None:
    rng = np.random.default_rng(2)
    for x, y, log_side, turn in rng.uniform((0, 0, 3, -3), (2000, 1000, 7, 3), (200, 4)):
        region = Region(x, y, float(np.exp(log_side)), turn)
        rounded = region.rounded(16)
        assert rounded.rounded(16) == rounded
        assert rounded.rounded(32) == rounded
        assert region.distance(rounded) < 0.05
        assert abs(region.turn_rad - rounded.turn_rad) < 0.05
    one, other = Region(100.2, 50.1, 96.5, 0.01), Region(99.8, 49.9, 95.5, -0.01)
    assert one.rounded(16) == other.rounded(16)
