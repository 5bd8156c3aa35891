"""What is said of drafts: which agree with their keypoints, and which limbs may be mirrored."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.fitting.draft.flips import LimbRun
from keypose.tracker.fitting.draft.judged import (
    JudgedDrafts,
    Piece,
    flip_doubts,
    judged,
)
from keypose.tracker.fitting.draft.observed import Joints, Observed, place_of
from keypose.tracker.fitting.draft.proposals import FrameRange
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.on_body import height_px
from tests.tracker.fitting.draft.clips import BODY, CAMERA, Clip, walk

SKELETON = Skeleton.of(BODY)
JOINTS_OF = Joints.of(SKELETON)
PARTS = ("left_upper_arm", "right_upper_arm", "left_thigh", "right_thigh")
COUNT = 20


def motion_of(clip: Clip) -> Trajectory:
    return Trajectory(
        0,
        np.stack([pose.Rs_parent_part for pose in clip.poses]),
        np.stack([pose.p_camera_root for pose in clip.poses]),
    )


def depths(clip: Clip) -> Array:
    """(N, 12) by which every joint is farther than the root."""
    return np.asarray(clip.joints_m[..., 2] - motion_of(clip).ps_camera_root[:, 2:])


def piece(clip: Clip, seen: Observed | None = None, flipped: tuple[LimbRun, ...] = ()) -> Piece:
    """The true poses, beside what is seen."""
    observed = Observed.of(clip.keypoints, CAMERA) if seen is None else seen
    return Piece(observed, motion_of(clip), depths(clip), flipped)


def of(*pieces: Piece) -> JudgedDrafts:
    return judged(SKELETON, CAMERA, pieces)


# --- which frames are drafts


def test_the_truth_misses_nothing_and_hides_nothing() -> None:
    found = of(piece(walk(COUNT)))
    assert found.frames == tuple(range(COUNT))
    assert found.parts == PARTS
    assert found.stretches == (FrameRange(0, COUNT - 1, "start"),)
    np.testing.assert_allclose(found.residual, 0.0, atol=1e-9)
    np.testing.assert_allclose(found.hidden, 0.0)
    assert not found.flipped.any()


@pytest.mark.parametrize("limb", range(4))
def test_what_a_limb_misses_is_a_share_of_the_bodys_height(limb: int) -> None:
    clip, miss_px = walk(COUNT), 12.0
    seen = Observed.of(clip.keypoints, CAMERA)
    uv = seen.uv.copy()
    uv[7, JOINTS_OF.limbs[limb].lower.far, 0] += miss_px
    found = of(piece(clip, replace(seen, uv=uv)))
    expected = np.zeros((COUNT, 4))
    expected[7, limb] = miss_px / 3 / height_px(SKELETON, CAMERA, clip.poses[7])
    np.testing.assert_allclose(found.residual, expected, atol=1e-9)


def test_a_limb_is_as_hidden_as_its_worst_joint() -> None:
    clip = walk(COUNT)
    seen = Observed.of(clip.keypoints, CAMERA)
    visibility = seen.visibility.copy()
    visibility[4, place_of("right", "wrist")] = 0.35
    found = of(piece(clip, replace(seen, visibility=visibility)))
    assert found.hidden[4].tolist() == pytest.approx([0.0, 0.65, 0.0, 0.0])


def test_a_pose_that_misses_most_keypoints_is_no_draft() -> None:
    clip = walk(COUNT)
    seen = Observed.of(clip.keypoints, CAMERA)
    uv = seen.uv.copy()
    uv[9] += 0.2 * height_px(SKELETON, CAMERA, clip.poses[9])
    found = of(piece(clip, replace(seen, uv=uv)))
    assert set(range(COUNT)) - set(found.frames) == {9}
    assert len(found.residual) == len(found.joints) == COUNT - 1


def test_joints_are_said_from_the_hips_as_shares_of_the_height() -> None:
    near, far = (of(piece(walk(2, place=place))) for place in ((0, 0, 3.0), (1.0, 0.2, 6.0)))
    np.testing.assert_allclose(near.joints, far.joints, atol=1e-9)
    hips = near.joints[:, [place_of(side, "hip") for side in ("left", "right")]]
    np.testing.assert_allclose(hips.mean(axis=1), 0.0, atol=1e-12)


def test_pieces_follow_one_another_and_one_that_shows_another_person_begins_so() -> None:
    clip = walk(COUNT)
    seen = Observed.of(clip.keypoints, CAMERA, changes=(12,))
    whole = motion_of(clip)
    pieces = [
        Piece(
            seen.rows(rows),
            Trajectory(rows.start, whole.Rs_parent_part[rows], whole.ps_camera_root[rows]),
            depths(clip)[rows],
        )
        for rows in (slice(0, 12), slice(12, COUNT))
    ]
    found = of(*pieces)
    assert found.frames == tuple(range(COUNT))
    assert found.stretches == (FrameRange(0, 11, "start"), FrameRange(12, COUNT - 1, "person"))


def test_of_nothing_nothing_is_said() -> None:
    found = of()
    assert (found.frames, found.stretches, found.proposals()) == ((), (), ())
    assert found.joints.shape == (0, 12, 3)


def test_where_a_limb_is_wrong_throughout_there_is_one_draft_to_correct_and_none_to_confirm() -> (
    None
):
    found = of(piece(walk(COUNT), flipped=(LimbRun(2, 0, COUNT - 1),)))
    (proposal,) = found.proposals()
    assert (proposal.reason, proposal.parts) == ("wrong", PARTS[2:3])


# --- limbs that may point the other way


@pytest.mark.parametrize("facing_deg", [20.0, 160.0])
def test_a_limb_that_the_network_sees_point_the_other_way_is_doubted_and_no_other(
    facing_deg: float,
) -> None:
    clip = walk(COUNT, facing_deg)
    network = depths(clip)
    agreed = flip_doubts(JOINTS_OF, CAMERA, network, motion_of(clip))
    for k, limb in enumerate(JOINTS_OF.limbs):
        mirrored = network.copy()
        ends = [limb.upper.far, limb.lower.far]
        mirrored[:, ends] = 2 * network[:, [limb.upper.near]] - network[:, ends]
        doubts = flip_doubts(JOINTS_OF, CAMERA, mirrored, motion_of(clip))
        assert doubts[:, k].max() > 0.7
        assert (doubts[:, k] > agreed[:, k] - 1e-9).all()
        others = np.arange(4) != k
        np.testing.assert_allclose(doubts[:, others], agreed[:, others])


# --- runs that are known to be wrong


RUNS = [
    ((), ()),
    (((0, 3, 5),), ((3, 5, PARTS[:1]),)),
    (((0, 3, 5), (0, 6, 8)), ((3, 8, PARTS[:1]),)),
    (((0, 3, 5), (0, 7, 8)), ((3, 5, PARTS[:1]), (7, 8, PARTS[:1]))),
    (((1, 3, 8), (2, 5, 6)), ((3, 4, PARTS[1:2]), (5, 6, PARTS[1:3]), (7, 8, PARTS[1:2]))),
]


@pytest.mark.parametrize(("limbs", "expected"), RUNS)
def test_frames_in_which_the_same_limbs_are_wrong_are_one_run(
    limbs: tuple[tuple[int, int, int], ...],
    expected: tuple[tuple[int, int, tuple[str, ...]], ...],
) -> None:
    runs = tuple(LimbRun(*limb) for limb in limbs)
    found = of(piece(walk(COUNT), flipped=runs)).flipped_drafts()
    assert [(run.first_frame, run.last_frame, run.parts) for run in found] == list(expected)


def test_a_wrong_draft_is_proposed_to_be_corrected_and_never_to_be_confirmed() -> None:
    found = of(piece(walk(COUNT), flipped=(LimbRun(0, 0, 4), LimbRun(3, 12, 16))))
    proposals = {proposal.frame: proposal for proposal in found.proposals()}
    assert {f: p.parts for f, p in proposals.items() if p.reason == "wrong"} == {
        2: PARTS[:1],
        14: PARTS[3:],
    }
    confirmed = {f for f, p in proposals.items() if p.reason != "wrong"}
    assert not confirmed & {*range(5), *range(12, 17)}
    assert proposals[5].reason == "start", "the first that is sound"
    assert list(proposals) == sorted(proposals)
