"""Where the background is: nowhere that the body is seen."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.camera_motion.background import BodyBackground
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
