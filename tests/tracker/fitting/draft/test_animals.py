"""Drafts of a dog and a horse from keypoints in the picture alone: from all sides, with left and
right exchanged, and of animals with other proportions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from keypose.tracker.body.body import preset
from keypose.tracker.body.joint_limits import Limits
from keypose.tracker.body.modify import height
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import KeypointError
from keypose.tracker.fitting.draft.animal_clip import draft_from_animal_keypoints
from keypose.tracker.fitting.draft.animal_sizes import SIZED, resized_animal
from keypose.tracker.fitting.draft.animals import cheapest_way
from keypose.tracker.fitting.draft.clip import ClipDraft
from keypose.tracker.keypoints.keypoints import Keypoints
from tests.animals.walking import CAMERA, Walk, error_share, with_sides_swapped

NAMES = ("dog", "horse")
OFF = 0.008
"""What keypoints are off by, a share of the animal's length, twice."""
ALL = ("eye", "shoulder", "elbow", "paw", "hip", "knee")


def draft(walk: Walk, keypoints: Keypoints, *, proportions: bool = False) -> ClipDraft:
    return draft_from_animal_keypoints(
        keypoints, CAMERA, preset(walk.name), proportions=proportions
    )


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize(
    ("heading_deg", "most"),
    [(90, 0.07), (-90, 0.07), (60, 0.07), (120, 0.07), (30, 0.08), (150, 0.09)],
)
def test_a_walk_seen_from_the_side_or_obliquely_is_drafted(
    name: str, heading_deg: float, most: float
) -> None:
    walk = Walk(name, heading_deg)
    drafts = draft(walk, walk.keypoints(OFF))
    assert len(drafts.poses) == walk.frames
    assert error_share(walk, dict(drafts.poses)) < most


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("heading_deg", [0, 180])
def test_from_the_front_and_from_behind_depth_is_weak(name: str, heading_deg: float) -> None:
    """Legs swing along the view there, which hardly shows."""
    walk = Walk(name, heading_deg)
    assert 0.04 < error_share(walk, dict(draft(walk, walk.keypoints(OFF)).poses)) < 0.14


def test_an_animal_that_turns_round_is_followed() -> None:
    walk = Walk("dog", heading_deg=0, turn_deg=200, frames=72)
    drafts = draft(walk, walk.keypoints(OFF))
    motion = walk.motion()
    for frame, pose in drafts.poses.items():
        ahead = motion.Rs_parent_part[frame, 0, :, 2] @ pose.Rs_parent_part[0, :, 2]
        assert ahead > np.cos(np.radians(15))


@pytest.mark.parametrize("words", [ALL, ("hip", "knee", "back_paw")])
def test_left_and_right_that_a_network_exchanges_for_some_frames_are_exchanged_back(
    words: tuple[str, ...],
) -> None:
    walk = Walk("dog", 60)
    keypoints = walk.keypoints(OFF)
    right = error_share(walk, dict(draft(walk, keypoints).poses))
    swapped = with_sides_swapped(keypoints, range(12, 17), words)
    swapped = with_sides_swapped(swapped, range(30, 32), words)
    assert error_share(walk, dict(draft(walk, swapped).poses)) < right + 0.01


def test_keypoints_that_are_not_seen_are_done_without() -> None:
    walk = Walk("horse", 90)
    keypoints = walk.keypoints(OFF)
    hidden = np.random.default_rng(4).random(keypoints.visibility.shape) < 0.2
    uv = np.where(hidden[..., None], 5.0, keypoints.uv)  # anywhere
    visibility = np.where(hidden, 0.05, keypoints.visibility)
    drafts = draft(walk, replace(keypoints, uv=uv, visibility=visibility))
    assert error_share(walk, dict(drafts.poses)) < 0.08


def test_frames_without_an_animal_have_no_draft() -> None:
    walk = Walk("dog", 90)
    keypoints = walk.keypoints(OFF)
    visibility = keypoints.visibility.copy()
    visibility[10:30] = 0.0
    drafts = draft(walk, replace(keypoints, visibility=visibility))
    assert sorted(drafts.poses) == [*range(10), *range(30, walk.frames)]
    assert [place.frame for place in drafts.proposals if place.reason == "end"] == [9, 47]


def test_no_animal_anywhere_is_one_sentence() -> None:
    keypoints = Walk("dog").keypoints()
    unseen = replace(keypoints, visibility=0 * keypoints.visibility)
    with pytest.raises(KeypointError, match=r"^The animal is nowhere seen well enough .*\.$"):
        draft(Walk("dog"), unseen)


def test_poses_keep_to_the_limits_of_the_joints() -> None:
    walk = Walk("dog", 30)
    drafts = draft(walk, walk.keypoints(2 * OFF))
    limits = Limits.of(Skeleton.of(preset("dog")).body)
    Rs = np.stack([pose.Rs_parent_part for pose in drafts.poses.values()])
    excess, _ = limits.excess(Rs)
    assert np.degrees(np.abs(excess).max()) < 4


@pytest.mark.parametrize(("legs", "most"), [(-0.25, 0.6), (0.2, 0.6)])
def test_an_animal_with_other_legs_gets_them_and_the_height_stays(legs: float, most: float) -> None:
    sizes = np.array([legs if "leg" in name else 0.0 for name in SIZED])
    walk = Walk("dog", 90, sized=resized_animal(preset("dog"), sizes))
    keypoints = walk.keypoints(OFF)
    plain, sized = (draft(walk, keypoints, proportions=own) for own in (False, True))
    assert plain.body == preset("dog")
    assert height(sized.body) == pytest.approx(height(plain.body))
    assert [part.tracked for part in sized.body.parts] == [p.tracked for p in plain.body.parts]
    errors = [error_share(walk, dict(each.poses), each.body) for each in (plain, sized)]
    assert errors[1] < most * errors[0]


def test_the_way_that_costs_least_is_taken_and_not_the_least_of_each_frame() -> None:
    costs = np.array([[0.0, 1.0], [1.0, 0.9], [0.0, 1.0]])
    places = np.zeros((3, 2, 1, 3))
    places[:, 1] = 9.0
    assert cheapest_way(costs, places).tolist() == [0, 0, 0]
    costs[:, 0] = 50.0
    assert cheapest_way(costs, places).tolist() == [1, 1, 1]
