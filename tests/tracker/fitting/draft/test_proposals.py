"""Which drafts a person should confirm, and why."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from keypose.tracker.fitting.draft import draft_from_keypoints
from keypose.tracker.fitting.draft.proposals import APART, FrameRange, proposed
from keypose.tracker.keypoints.keypoints import Keypoints
from tests.tracker.fitting.draft.clips import CAMERA, place, standing, walk

PARTS = ("left_upper_arm", "right_upper_arm", "left_thigh", "right_thigh")


def of(keypoints: Keypoints) -> dict[str, list[int]]:
    """Frames by reason."""
    draft = draft_from_keypoints(keypoints, CAMERA, walk(1).body, proportions=False)
    by_reason: dict[str, list[int]] = {}
    for proposal in draft.proposals:
        by_reason.setdefault(proposal.reason, []).append(proposal.frame)
    return by_reason


def test_of_a_person_who_stands_still_the_ends_alone_are_proposed() -> None:
    assert of(standing(60).keypoints) == {"start": [0], "end": [59]}


def test_poses_that_differ_most_are_proposed_and_not_a_stand_before_and_after_them() -> None:
    """120 frames still, an arm up and down again, an arm to the side, 120 frames still."""
    frames, joints = list(range(400)), np.zeros((400, 12, 3))
    swing = np.sin(np.pi * np.arange(60) / 59)
    joints[120:180, :6, 1] = -0.3 * swing[:, None]
    joints[200:260, :6, 0] = 0.25 * swing[:, None]
    found = proposed(frames, [FrameRange(0, 399, "start")], {}, PARTS, joints)
    assert [(p.frame, p.reason) for p in found if abs(p.frame - 149) < 3] == [(149, "pose")]
    assert [(p.frame, p.reason) for p in found if abs(p.frame - 229) < 3] == [(229, "pose")]
    between = [p.frame for p in found[1:-1]]
    assert (found[0].frame, found[-1].frame) == (0, 399), "all between them is tracked"
    assert min(between) > 110, "not while the body stands, but as it begins to move"
    assert max(between) < 270
    assert len(found) <= 400 // 60 + 2


def test_both_ends_are_proposed_and_nothing_near_them() -> None:
    frames, joints = list(range(100)), np.zeros((100, 12, 3))
    joints[:, :6, 0] = 0.3 * np.sin(2 * np.pi * np.arange(100) / 50)[:, None]
    found = proposed(frames, [FrameRange(0, 99, "start")], {}, PARTS, joints)
    assert [found[0].reason, found[-1].reason] == ["start", "end"]
    assert np.diff([p.frame for p in found]).min() >= APART


def test_a_hidden_joint_is_proposed_by_its_limb() -> None:
    keypoints = walk(60, facing_deg=40).keypoints
    visibility = keypoints.visibility.copy()
    visibility[25:35, place("right_wrist")] = 0.05
    draft = draft_from_keypoints(
        replace(keypoints, visibility=visibility), CAMERA, walk(1).body, proportions=False
    )
    (hidden,) = (p for p in draft.proposals if p.reason == "hidden")
    assert 25 <= hidden.frame < 35
    assert hidden.parts == ("right_upper_arm",)


def test_a_joint_far_from_its_keypoint_is_proposed() -> None:
    keypoints = walk(60, facing_deg=40).keypoints
    uv = keypoints.uv.copy()
    uv[30, place("left_ankle")] += 150
    assert of(replace(keypoints, uv=uv))["residual"] == [30]


def test_a_possible_change_of_person_is_proposed() -> None:
    keypoints = walk(60, facing_deg=40).keypoints
    uv = keypoints.uv.copy()
    uv[30:, :, 0] += 260
    found = of(replace(keypoints, uv=uv))
    assert found["person"] == [30]
    first, last = min(min(found.values())), max(max(found.values()))
    assert (first, 29 in found["end"]) == (0, True)
    assert last >= 49, "the other person's frames lie between two as well"


def test_a_limb_whose_depth_nobody_gives_is_marked_as_maybe_flipped() -> None:
    clip = walk(30, facing_deg=150)
    assert clip.keypoints.p_hips is not None
    p_hips = clip.keypoints.p_hips.copy()
    arm = [place(f"left_{joint}") for joint in ("shoulder", "elbow", "wrist")]
    p_hips[:, arm, 2] = p_hips[:, arm[:1], 2]
    flat, reported = (
        draft_from_keypoints(keypoints, CAMERA, clip.body, proportions=False).judged.flips
        for keypoints in (replace(clip.keypoints, p_hips=p_hips), clip.keypoints)
    )
    assert flat[:, 0].mean() > reported[:, 0].mean()
    assert reported.mean() < 0.3


def test_legs_are_believed_sooner_than_arms() -> None:
    found = draft_from_keypoints(walk(30).keypoints, CAMERA, walk(1).body, proportions=False)
    arms, legs = found.judged.flips[:, :2], found.judged.flips[:, 2:]
    assert legs.max() < 0.5 < arms.max()


def test_a_limb_in_the_plane_of_the_picture_is_no_matter_whichever_way_it_points() -> None:
    clip = standing(5)
    assert clip.keypoints.p_hips is not None
    p_hips = clip.keypoints.p_hips.copy()
    p_hips[..., 2] = 0.0
    keypoints = replace(clip.keypoints, p_hips=p_hips)
    found = draft_from_keypoints(keypoints, CAMERA, clip.body, proportions=False)
    assert not found.judged.flips.any()


def test_proposals_are_apart_few_and_begin_with_the_worst() -> None:
    frames = list(range(240))
    rng = np.random.default_rng(0)
    doubts = {"residual": rng.uniform(0.0, 0.02, (240, 4))}
    doubts["residual"][100:104, 2] = (0.1, 0.2, 0.3, 0.1)
    doubts["residual"][50, 0] = 0.04
    still = np.zeros((240, 12, 3))
    whole = [FrameRange(0, 239, "start")]
    found = proposed(frames, whole, doubts, PARTS, still)  # type: ignore[arg-type]
    assert [(p.frame, p.reason, p.parts) for p in found[1:-1]] == [
        (50, "residual", ("left_upper_arm",)),
        (102, "residual", ("left_thigh",)),
    ]
    doubts["residual"][:] = 1.0
    every = proposed(frames, whole, doubts, PARTS, still)  # type: ignore[arg-type]
    assert len(every) < 10
    assert np.diff([p.frame for p in every]).min() >= APART
