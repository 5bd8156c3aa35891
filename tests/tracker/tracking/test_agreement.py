"""Films agree of a keyframe that is where the rays of all of them meet, and of no other one."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from keypose.tracker.body.pose import Pose
from keypose.tracker.geometry.film_clock import FilmClock
from keypose.tracker.geometry.rotations import rotation_from_euler, transform
from keypose.tracker.keypoints.keypoints import JOINTS
from keypose.tracker.tracking.agreement import films_agree
from keypose.tracker.tracking.film_beside import FilmBeside
from tests.tracker.tracking.cues.people import CAMERA, OFFSET_M, SKELETON, Filmed, moving

FILM = Filmed(moving())
FRAME = FILM.truth.first_frame + 6
TRUE = FILM.truth.pose(FRAME)
R = rotation_from_euler(0.0, np.radians(70.0), 0.0)
T_SIDE = transform(R, TRUE.p_camera_root - R @ TRUE.p_camera_root)


def beside(visibility: float = 1.0, begins: float = 0.0) -> FilmBeside:
    count = FILM.truth.last_frame + 1
    Ts = np.broadcast_to(T_SIDE, (count, 4, 4))
    shown = Filmed(FILM.truth.carried(Ts[FILM.truth.first_frame :])).keypoints
    shown = replace(shown, visibility=np.full(shown.visibility.shape, visibility))
    film: Any = SimpleNamespace(camera=CAMERA, frame_count=count)
    return FilmBeside(film, FilmClock(begins), Ts, Ts, shown)


def agree(pose: Pose, *films: FilmBeside) -> bool:
    return films_agree(FRAME, pose, SKELETON, CAMERA, FILM.keypoints, films)


def nearer(share: float) -> Pose:
    """As the first camera alone cannot tell it from the truth."""
    return Pose(TRUE.Rs_parent_part, (1 - share) * TRUE.p_camera_root)


def test_of_an_exact_keyframe_they_agree_though_a_detector_has_places_of_its_own() -> None:
    assert np.linalg.norm(OFFSET_M) > 0.01
    assert agree(TRUE, beside())


@pytest.mark.parametrize("share", [0.02, -0.02, 0.1])
def test_of_one_whose_depth_is_off_they_do_not(share: float) -> None:
    assert not agree(nearer(share), beside())


@pytest.mark.parametrize(
    "films",
    [(), (beside(visibility=0.1),), (beside(begins=40.0),)],
    ids=["no other film", "hidden there", "begins later"],
)
def test_where_one_film_alone_sees_it_nothing_contradicts_it(films: tuple[FilmBeside, ...]) -> None:
    assert agree(nearer(0.1), *films)


def test_a_film_without_keypoints_contradicts_nothing() -> None:
    assert agree(nearer(0.1), replace(beside(), keypoints=None))
    assert set(JOINTS) <= set(FILM.keypoints.names)
