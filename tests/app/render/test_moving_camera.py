"""Films of a body that stands still before a camera that pans: nothing moves but the picture."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from keypose.app.orders.drawing import FilmView, PictureOrder, Viewpoint
from keypose.app.render.films import Film, film_pictures
from keypose.app.render.poses import KnownPoses
from keypose.app.render.stills import still
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.session.camera_motion import CameraMotion
from tests.tracker import panned_cases as panned
from tests.tracker import session_cases as cases

KEYS = (2, 12, 22)


def known() -> KnownPoses:
    session = panned.panned()
    keys = {k.frame: k.pose(cases.SKELETON) for k in session.subject.keyframes}
    return KnownPoses(cases.SKELETON, keys, None)


@pytest.mark.parametrize("view", ["side", "top", "front", Viewpoint(40.0, 15.0)], ids=str)
def test_a_body_that_stands_still_does_in_every_view_of_the_world(view: FilmView) -> None:
    film = Film(view, 0, panned.FRAMES - 1, size=(160, 120))
    pictures = list(film_pictures(panned.panned(), None, known(), film, 25.0))
    first = pictures[KEYS[0]].astype(int)
    for frame in KEYS[1:]:
        assert np.abs(pictures[frame] - first).max() <= 40  # lines fall between other pixels
        assert np.abs(pictures[frame] - first).mean() < 0.1
    turned = film_pictures(panned.session(), None, known(), film, 25.0)
    assert np.abs(list(turned)[KEYS[2]] - first).mean() > 0.5


def test_the_camera_itself_shows_the_body_as_large_as_its_zoom() -> None:
    session = panned.panned()
    zoom = np.ones(panned.FRAMES)
    zoom[12] = 1.3
    path = CameraPath(panned.path().Ts_camera_world, zoom)
    zoomed = session.changed({"camera_motion": CameraMotion.of("turns", path)})
    order = replace(PictureOrder(), view="main", style="solid", background="none")
    covered = [
        (np.asarray(still(of, None, 12, known(), order))[..., 3] > 128).sum()
        for of in (session, zoomed)
    ]
    assert covered[1] > 1.25 * covered[0]  # part of it is beside the picture


def test_a_still_of_any_frame_is_the_same_from_beside() -> None:
    order = replace(PictureOrder(), view=Viewpoint(70.0, 10.0), size=(160, 120))
    pictures = [np.asarray(still(panned.panned(), None, frame, known(), order)).astype(int)
                for frame in KEYS]  # fmt: skip
    for picture in pictures[1:]:
        assert np.abs(picture - pictures[0]).mean() < 0.2
