"""The things of the shelf: their sizes, what turns, and where a hand holds them."""

from __future__ import annotations

import numpy as np
import pytest

from bench.presets.people import as_json
from bench.presets.things import make_objects
from keypose.tracker.body.body import Body, preset
from keypose.tracker.body.pose import Pose, joint_names, joint_positions, pose_transforms
from keypose.tracker.body.preset_names import OBJECTS
from keypose.tracker.body.skeleton import Skeleton
from tests.tracker.body.test_body import BODIES

EXTENT_M = {
    "box": (0.2, 0.3, 0.2),
    "cylinder": (0.1, 0.3, 0.1),
    "ball": (0.22, 0.22, 0.22),
    "stick": (0.03, 1.0, 0.03),
    "racket": (0.26, 0.685, 0.032),
    "club": (0.12, 1.1, 0.1),
    "bicycle": (0.6, 1.034, 1.718),
}
"""Across, up and along, as it stands at rest."""
HELD = {"racket": "grip", "club": "grip", "stick": "stick"}
"""By what a hand holds it."""


def vertices(body: Body) -> np.ndarray:
    skeleton = Skeleton.of(body)
    Ts = pose_transforms(skeleton, Pose.rest(skeleton, (0.0, 0.0, 0.0)))
    meshes = zip(body.parts, Ts, strict=True)
    return np.vstack([part.shape.mesh().vertices + T[:3, 3] for part, T in meshes])


def points(body: Body) -> dict[str, np.ndarray]:
    skeleton = Skeleton.of(body)
    Ts = pose_transforms(skeleton, Pose.rest(skeleton, (0.0, 0.0, 0.0)))
    return dict(zip(joint_names(skeleton), joint_positions(skeleton, Ts), strict=True))


def test_every_thing_has_a_size() -> None:
    assert set(EXTENT_M) == set(OBJECTS)


@pytest.mark.parametrize(("name", "extent"), EXTENT_M.items())
def test_a_thing_is_as_large_as_the_things_of_its_name(name: str, extent: tuple[float]) -> None:
    np.testing.assert_allclose(np.ptp(vertices(preset(name)), axis=0), extent, atol=2e-3)


@pytest.mark.parametrize("body", make_objects(), ids=lambda body: body.name)
def test_the_script_reproduces_the_files_of_things(body: Body) -> None:
    assert (BODIES / f"{body.name}.json").read_text("utf-8") == as_json(body)


@pytest.mark.parametrize(("name", "part"), HELD.items())
def test_what_is_held_hangs_from_the_hand(name: str, part: str) -> None:
    body = preset(name)
    assert body.parts[0].name == part
    assert part in points(body)
    low, high = np.sort(vertices(body)[:, 1])[[0, -1]]
    assert low < 0 < high
    assert abs(low) <= high


def test_the_wheels_of_a_bicycle_stand_on_the_ground_in_line() -> None:
    body = preset("bicycle")
    at = points(body)
    front, rear = at["front_wheel"], at["rear_wheel"]
    ground = vertices(body)[:, 1].max()
    for axle in (front, rear):
        assert axle[0] == 0
        assert ground - axle[1] == pytest.approx(0.339, abs=1e-3)
    assert 1.0 < rear[2] - front[2] < 1.1


def test_what_turns_on_a_bicycle_turns_about_its_own_axis_alone() -> None:
    tracked = {part.name: part.tracked for part in preset("bicycle").parts if part.tracked}
    turning = ("rear_wheel", "front_wheel", "cranks", "left_pedal", "right_pedal")
    assert {name: ("rx",) for name in turning}.items() <= tracked.items()
    assert tracked["handlebar"] == ("ry",)
    assert set(tracked) == {"frame", "handlebar", *turning}


def test_a_turned_handlebar_takes_the_front_wheel_along_and_no_other() -> None:
    skeleton = Skeleton.of(preset("bicycle"))
    rest = Pose.rest(skeleton, (0.0, 0.0, 0.0))
    Rs = rest.Rs_parent_part.copy()
    Rs[skeleton.body.index("handlebar")] = np.array([[0, 0, 1], [0, 1, 0], [-1, 0, 0.0]])
    before, after = (
        pose_transforms(skeleton, pose) for pose in (rest, Pose(Rs, rest.p_camera_root))
    )
    moved = {
        part.name
        for part, a, b in zip(skeleton.body.parts, before, after, strict=True)
        if not np.allclose(a, b)
    }
    assert moved == {"handlebar", "stem", "left_fork", "right_fork", "front_wheel"}
