"""Where the background is: nowhere that the body is seen."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.camera_motion.background import FARTHEST_FRAMES, BodyBackground
from keypose.tracker.geometry.rotations import apply_transform
from keypose.tracker.session.settings import IgnoreMask
from tests.tracker import panned_cases as panned
from tests.tracker import session_cases as cases


def background(zoom: np.ndarray | None = None, masks: tuple[IgnoreMask, ...] = ()) -> np.ndarray:
    poses = {5: cases.pose(0.4)}
    found = BodyBackground(cases.SKELETON, panned.CAMERA, poses, masks, zoom)(5)
    assert found is not None
    return found


@pytest.mark.parametrize("zoom", [0.5, 2.0])
def test_a_body_covers_what_the_camera_shows_of_it_with_the_zoom_of_the_frame(zoom: float) -> None:
    zooms = np.ones(panned.FRAMES)
    zooms[5] = zoom
    poses, camera = {5: cases.pose(0.4)}, panned.CAMERA.zoomed(zoom)
    seen = BodyBackground(cases.SKELETON, camera, poses)(5)
    assert seen is not None
    np.testing.assert_array_equal(background(zooms), seen)
    assert ((~background(zooms)).sum() > (~background()).sum()) == (zoom > 1)


def test_what_is_masked_is_no_background_in_its_frames() -> None:
    corners = ((0, 0), (40, 0), (40, 30), (0, 30))
    now, later = (
        IgnoreMask(polygon=corners, first_frame=first, last_frame=first + 2) for first in (4, 9)
    )
    assert not background(masks=(now,))[:30, :40].any()
    assert background(masks=(later,))[:20, :30].all()


def covered_columns(frame: int, poses: dict[int, Pose]) -> np.ndarray:
    """The first and the last column that a body covers."""
    found = BodyBackground(cases.SKELETON, panned.CAMERA, poses)(frame)
    assert found is not None
    columns = np.flatnonzero((~found).any(axis=0))
    return np.array([columns[0], columns[-1]])


def aside(metres: float) -> Pose:
    pose = cases.pose(0.4)
    return Pose(pose.Rs_parent_part, pose.p_camera_root + np.array([metres, 0.0, 0.0]))


def test_between_two_poses_the_body_is_on_the_way() -> None:
    poses = {10: aside(-0.3), 20: aside(0.3)}
    start, middle, end = (covered_columns(frame, poses) for frame in (10, 15, 20))
    np.testing.assert_allclose(middle, (start + end) / 2, atol=3)
    assert (start < middle).all()
    assert (middle < end).all()
    np.testing.assert_array_equal(covered_columns(4, poses), start)  # before the first one


def test_far_from_every_pose_nobody_knows_where_the_body_is() -> None:
    body = BodyBackground(cases.SKELETON, panned.CAMERA, {5: cases.pose(0.4)})
    assert body(5 + FARTHEST_FRAMES) is not None
    assert body(5 + FARTHEST_FRAMES + 1) is None
    assert BodyBackground(cases.SKELETON, panned.CAMERA, {})(5) is None


def test_there_is_a_margin_around_the_body() -> None:
    pose = cases.pose(0.4)
    Ts = pose_transforms(cases.SKELETON, pose)
    covered = ~background()
    for T, part in zip(Ts, cases.SKELETON.body.parts, strict=True):
        corners = apply_transform(T, part.shape.mesh().vertices)
        for u, v in np.rint(panned.CAMERA.project(corners)).astype(int):
            for du, dv in ((-2, 0), (2, 0), (0, -2), (0, 2)):
                inside = 0 <= u + du < panned.CAMERA.width and 0 <= v + dv < panned.CAMERA.height
                assert not inside or covered[v + dv, u + du]


def test_a_part_that_is_too_near_or_behind_the_camera_covers_nothing() -> None:
    behind = cases.pose(0.4)
    behind = Pose(behind.Rs_parent_part, behind.p_camera_root * np.array([1.0, 1.0, -1.0]))
    found = BodyBackground(cases.SKELETON, panned.CAMERA, {5: behind})(5)
    assert found is not None
    assert found.all()
