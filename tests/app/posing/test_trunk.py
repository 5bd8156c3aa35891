"""A shoulder or a hip dragged: the trunk follows, and what hangs on it stays where it is seen."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.app.posing import Held, Posed, angles_deg, handle_named, handles
from keypose.app.posing.limits import box_of
from keypose.tracker.body.modify import with_clavicles
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from tests.app.posing.posing_cases import (
    DOG,
    PERSON,
    VIEWS,
    as_sent,
    bent,
    points,
    pull,
    sights,
    standing,
    tumbling,
    walking,
)
from tests.app.posing.test_holding import ALL, ENDS, off_m, off_px, pulled

CORNERS = ("left_shoulder", "right_shoulder", "left_hip", "right_hip")
POSES = {"standing": standing(PERSON), "walking": walking(), "tumbling": tumbling()}
every_pose = pytest.mark.parametrize("pose", POSES.values(), ids=POSES.keys())
every_corner = pytest.mark.parametrize("name", CORNERS)


def anchor_of(name: str) -> str:
    return handle_named(PERSON, name).anchor


def dragged(
    pose: Pose, name: str, way_m: tuple[float, float], view: str = "main", held: Held = ALL,
    **more: object,
) -> Posed:  # fmt: skip
    given = PERSON, pose, as_sent(handle_named(PERSON, name)), anchor_of(name), view, way_m
    return pulled(*given, held, **more)[0]


@every_pose
@every_corner
@pytest.mark.parametrize("view", VIEWS)
def test_it_lies_under_the_pointer_wherever_it_is_dragged(pose: Pose, name: str, view: str) -> None:
    handle = handle_named(PERSON, name)
    for way_m in ((0.03, 0.01), (-0.02, -0.05), (0.4, 0.3)):
        _, end, seen = pull(PERSON, pose, handle, view, way_m)
        np.testing.assert_allclose(seen, end, atol=1e-6)


@pytest.mark.parametrize("pose", [walking(), tumbling()], ids=["walking", "tumbling"])
@every_corner
def test_the_rest_of_the_trunk_stays_about_where_it_is_seen(pose: Pose, name: str) -> None:
    """A trunk is rigid but for its joints: the others go a quarter as far in the median."""
    off = []
    for way_m in ((0.06, 0.0), (-0.04, 0.05), (0.0, 0.05), (0.03, -0.04)):
        posed = dragged(pose, name, way_m)
        others = [anchor_of(other) for other in CORNERS if other != name] + ["head_top"]
        off += [off_px(pose, posed.pose, (other,)) for other in others]
    way_px = 0.06 / sights()["main"].metres_per_unit(pose.p_camera_root)
    assert np.median(off) < 0.25 * way_px
    assert max(off) < way_px


@every_corner
def test_hands_and_feet_stay_where_they_are_seen_unless_alt_is_held(name: str) -> None:
    pose = walking()
    way_m = (0.02, 0.02)
    off = [off_px(pose, dragged(pose, name, way_m).pose, (end,)) for end in ENDS]
    along = [off_px(pose, dragged(pose, name, way_m, carry=True).pose, (end,)) for end in ENDS]
    assert max(off) < 2.0
    assert max(along) > max(off)


def test_a_pinned_foot_stays_in_its_place_in_space_while_a_hip_is_dragged() -> None:
    pose = walking()
    held = Held(ALL.placed, frozenset({"left_foot"}))
    posed = dragged(pose, "right_hip", (0.02, 0.01), held=held)
    assert "left_foot" in posed.readout.unreached or off_m(pose, posed.pose, "left_foot") < 2e-3


def test_a_long_drag_carries_the_body_with_it() -> None:
    pose = standing(PERSON)
    posed = dragged(pose, "left_shoulder", (0.8, 0.0), held=Held())
    p, q = points(PERSON, pose), points(PERSON, posed.pose)
    assert q["waist"][0] - p["waist"][0] > 0.5
    turned = np.abs(angles_deg(Skeleton.of(PERSON), posed.pose)[PERSON.index("chest")]).max()
    assert turned < 40


def test_in_the_side_view_the_body_keeps_its_place_across_the_picture() -> None:
    """What a small view does not show stays about as it was."""
    pose = walking()
    posed = dragged(pose, "left_shoulder", (0.06, 0.0), view="side")
    p, q = points(PERSON, pose), points(PERSON, posed.pose)
    assert abs(q["left_upper_arm"][2] - p["left_upper_arm"][2]) == pytest.approx(0.06, abs=1e-6)
    assert abs(q["left_upper_arm"][0] - p["left_upper_arm"][0]) < 0.03


def test_depth_takes_a_shoulder_along_its_line_of_sight() -> None:
    pose = walking()
    posed = dragged(pose, "left_shoulder", (0.0, -0.05), depth=True)
    assert off_px(pose, posed.pose, ("left_upper_arm",)) < 1e-6
    moved = off_m(pose, posed.pose, "left_upper_arm")
    assert moved == pytest.approx(0.05, rel=0.1)


@every_corner
def test_the_chest_keeps_its_limits(name: str) -> None:
    chest = PERSON.index("chest")
    box = box_of(PERSON.parts[chest])
    assert box is not None
    for way_m in ((0.15, 0.1), (-0.15, -0.1), (0.0, 0.2)):
        posed = dragged(walking(), name, way_m)
        angles = np.radians(angles_deg(Skeleton.of(PERSON), posed.pose)[chest])
        assert (angles > box[:, 0] - np.radians(3)).all()
        assert (angles < box[:, 1] + np.radians(3)).all()


def test_a_dog_has_corners_too_and_shoulders_with_clavicles_turn_those_instead() -> None:
    of_dog = [handle for handle in handles(DOG) if handle.kind == "corner"]
    assert len(of_dog) == 4
    pose = bent(DOG, 1, 0.3)
    for handle in of_dog:
        _, end, seen = pull(DOG, pose, handle, "main", (0.02, 0.02))
        np.testing.assert_allclose(seen, end, atol=1e-6)
    moving = {handle.name: handle.kind for handle in handles(with_clavicles(PERSON))}
    assert (moving["left_shoulder"], moving["left_hip"]) == ("middle", "corner")
