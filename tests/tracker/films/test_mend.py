"""A keyframe that was posed in one film is mended by both, and stays as it is where one sees it."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.films.cameras import joints_of_pose
from keypose.tracker.films.mend import SeenInFilm, mended
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import exp_rotation, rotation_from_euler, transform
from tests.rendering.motions import throw
from tests.tracker.films.film_cases import BODY, SKELETON

CAMERA = Camera.from_focal_length(1280, 720, 30.0)
TRUE = throw(SKELETON).pose(40)
R = rotation_from_euler(0.0, np.radians(70.0), 0.0)
T_SIDE = transform(R, TRUE.p_camera_root - R @ TRUE.p_camera_root)


def seen(T: np.ndarray, visibility: float = 1.0) -> SeenInFilm:
    """What a film shows of the true pose, exactly."""
    joints = joints_of_pose(SKELETON, TRUE.carried(T))
    return SeenInFilm(CAMERA, T, CAMERA.project(joints), np.full(len(joints), visibility))


def posed_in_one_film() -> Pose:
    """As somebody poses it who sees the front alone: limbs nearer or farther than they are."""
    R, p = TRUE.Rs_parent_part.copy(), TRUE.p_camera_root * 1.02
    for name, rad in (("left_upper_arm", 0.3), ("right_thigh", -0.25), ("left_forearm", 0.25)):
        part = BODY.index(name)
        R[part] = R[part] @ exp_rotation(np.array([rad, 0.0, 0.0]))
    return Pose(R, p)


def off_m(pose: Pose) -> float:
    """How far joints are from the truth, in the mean."""
    joints = [pose_transforms(SKELETON, each)[:, :3, 3] for each in (pose, TRUE)]
    return float(np.linalg.norm(joints[0] - joints[1], axis=-1).mean())


def test_two_films_bring_a_keyframe_to_where_the_body_is() -> None:
    wrong = posed_in_one_film()
    found = mended(BODY, wrong, [seen(np.eye(4)), seen(T_SIDE)])
    assert found is not None
    assert off_m(found.pose) < 0.2 * off_m(wrong)
    assert found.moved_m > 0.02


@pytest.mark.parametrize(
    "films",
    [[seen(np.eye(4))], [seen(np.eye(4)), seen(T_SIDE, visibility=0.0)], []],
    ids=["one film", "nobody seen in the other", "none"],
)
def test_what_one_film_sees_alone_stays_as_it_was_posed(films: list[SeenInFilm]) -> None:
    assert mended(BODY, posed_in_one_film(), films) is None


def test_another_person_in_the_other_film_mends_nothing() -> None:
    aside = seen(T_SIDE)
    elsewhere = SeenInFilm(CAMERA, T_SIDE, aside.uv + np.array([400.0, 0.0]), aside.visibility)
    assert mended(BODY, posed_in_one_film(), [seen(np.eye(4)), elsewhere]) is None
