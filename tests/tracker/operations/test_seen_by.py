"""Which film sees a joint, where films disagree of it, and in which a place is looked at."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.body.pose import pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.film_clock import FilmClock
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.keypoints import JOINTS, Keypoints
from keypose.tracker.operations.seen_by import SeenBy, seen_by
from keypose.tracker.session import Session
from keypose.tracker.session.views import Clock
from tests.app.editor.desk import desk
from tests.app.film_beside_cases import ID, seen_of, with_film

BEGINS = 4.0
COUNT = 20
FRAMES = np.arange(COUNT)
DOC = with_film(desk().doc, Clock(begins=BEGINS))
BODY = DOC.subject.body
FIRST = DOC.view.id
FOREARM = BODY.index("left_forearm")


def still_motion() -> Array:
    """The first keyframe's pose at every frame."""
    skeleton = Skeleton.of(BODY)
    pose = DOC.subject.keyframes[0].pose(skeleton)
    return np.broadcast_to(pose_transforms(skeleton, pose), (COUNT, len(BODY.parts), 4, 4)).copy()


def shown(doc: Session) -> dict[str, Keypoints]:
    return seen_of(doc, DOC.subject.keyframes[0].pose(Skeleton.of(BODY)))


def hidden(keypoints: Keypoints, joint: str, frames: slice) -> Keypoints:
    visibility = keypoints.visibility.copy()
    visibility[frames, JOINTS.index(joint)] = 0.05
    return Keypoints(0, JOINTS, keypoints.uv, visibility)


def moved(keypoints: Keypoints, joint: str, px: float) -> Keypoints:
    uv = keypoints.uv.copy()
    uv[:, JOINTS.index(joint), 0] += px
    return Keypoints(0, JOINTS, uv, keypoints.visibility)


def told(keypoints: dict[str, Keypoints]) -> SeenBy:
    return seen_by(DOC, keypoints, FRAMES, still_motion())


def test_what_both_films_show_where_the_body_is_is_agreed_upon() -> None:
    seen = told(shown(DOC))
    whole = seen.of_part(None)
    assert seen.sees(whole)[0].all()
    assert not seen.disagree(whole).any()
    assert np.nanmax(seen.off) < 1e-6


def test_a_film_sees_nothing_before_it_begins_nor_where_nobody_looked_in_it() -> None:
    seen = told(shown(DOC))
    np.testing.assert_array_equal(seen.sees(seen.of_part(None))[1], FRAMES >= BEGINS)
    alone = told({FIRST: shown(DOC)[FIRST]})
    assert not alone.sees(alone.of_part(None))[1].any()


def test_a_limb_that_one_film_hides_is_seen_by_the_other() -> None:
    both = shown(DOC)
    both[FIRST] = hidden(both[FIRST], "left_wrist", slice(8, 12))
    both[FIRST] = hidden(both[FIRST], "left_elbow", slice(8, 12))
    seen = told(both)
    forearm = seen.sees(seen.of_part(FOREARM))
    np.testing.assert_array_equal(~forearm[0], (FRAMES >= 8) & (FRAMES < 12))
    assert forearm[1][8:12].all()
    assert seen.best_at(9, FOREARM) == ID


@pytest.mark.parametrize("film", [FIRST, ID])
def test_films_disagree_where_one_shows_a_joint_elsewhere_and_that_one_is_looked_at(
    film: str,
) -> None:
    both = shown(DOC)
    both[film] = moved(both[film], "left_wrist", 40.0)
    seen = told(both)
    joints = seen.of_part(FOREARM)
    np.testing.assert_array_equal(seen.disagree(joints), FRAMES >= BEGINS)
    assert not seen.disagree(seen.of_part(BODY.index("right_shin"))).any()
    assert seen.best_at(12, FOREARM) == film


def test_what_one_film_alone_sees_is_disagreed_upon_by_nobody() -> None:
    both = shown(DOC)
    both[ID] = hidden(both[ID], "left_wrist", slice(None))
    both[FIRST] = moved(both[FIRST], "left_wrist", 40.0)
    seen = told(both)
    assert not seen.disagree(seen.of_part(BODY.index("left_hand"))).any()


def test_no_film_is_named_where_none_sees_the_place() -> None:
    seen = told(
        {name: hidden(each, "left_wrist", slice(None)) for name, each in shown(DOC).items()}
    )
    assert seen.best_at(10, BODY.index("left_hand")) is None


def test_a_clock_of_twice_the_rate_is_followed() -> None:
    view = DOC.views[1]
    fast = with_film(desk().doc, Clock(begins=2.0, rate=2.0))
    assert fast.views[1].film_clock == FilmClock(2.0, 2.0)
    both = shown(fast)
    both[ID] = hidden(both[ID], "left_wrist", slice(8, 12))
    seen = seen_by(fast, both, FRAMES, still_motion())
    hand = seen.sees(seen.of_part(BODY.index("left_hand")))[1]
    assert view.id == ID
    np.testing.assert_array_equal(~hand[2:], np.isin(FRAMES[2:], (6, 7)))
