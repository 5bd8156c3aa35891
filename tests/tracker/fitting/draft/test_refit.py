"""Drafts learn from posed frames where a network puts joints."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from keypose.tracker.body.pose import Pose
from keypose.tracker.fitting.draft import draft_from_keypoints, refit_drafts
from keypose.tracker.fitting.draft.refit import learned_depth, learned_place
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.keypoints import JOINTS, Keypoints
from tests.tracker.fitting.draft.clips import CAMERA, Clip, joints_of, walk

FRAMES = 40
POSED = 20
BESIDE_PX = (9.0, -6.0)
ELBOW = JOINTS.index("left_elbow")


@pytest.fixture(scope="module")
def clip() -> Clip:
    """A walk whose left elbow a network puts beside where it is, always the same way."""
    known = walk(FRAMES, 60)
    uv = known.keypoints.uv.copy()
    uv[:, ELBOW] += BESIDE_PX
    return replace(known, keypoints=replace(known.keypoints, uv=uv))


@pytest.fixture(scope="module")
def drafts(clip: Clip) -> dict[int, Pose]:
    return dict(draft_from_keypoints(clip.keypoints, CAMERA, clip.body, proportions=False).poses)


def refitted(clip: Clip, drafts: dict[int, Pose], *posed: int) -> dict[int, Pose]:
    poses = {frame: clip.poses[frame] for frame in posed}
    return refit_drafts(clip.keypoints, CAMERA, clip.body, drafts, poses, posed)


def off_px(clip: Clip, poses: dict[int, Pose], frames: range) -> Array:
    """(N, 12) how far joints are from where they are in the picture."""
    found = CAMERA.project(joints_of(clip.body, [poses[frame] for frame in frames]))
    truth = CAMERA.project(clip.joints_m[frames.start : frames.stop])
    return np.asarray(np.linalg.norm(found - truth, axis=-1))


def test_one_posed_frame_brings_the_frames_near_it_nearer_and_more_of_them_more(
    clip: Clip, drafts: dict[int, Pose]
) -> None:
    near = range(POSED + 1, POSED + 6)
    before = off_px(clip, drafts, near)[:, ELBOW].mean()
    one = off_px(clip, {**drafts, **refitted(clip, drafts, POSED)}, near)[:, ELBOW].mean()
    three = refitted(clip, drafts, POSED - 10, POSED, POSED + 10)
    more = off_px(clip, {**drafts, **three}, near)[:, ELBOW].mean()
    assert one < 0.75 * before
    assert more < 0.9 * one
    others = [k for k in range(len(JOINTS)) if k != ELBOW]
    after = off_px(clip, {**drafts, **three}, near)[:, others].mean()
    assert after < off_px(clip, drafts, near)[:, others].mean() + 0.5


def test_posed_frames_are_never_among_what_is_found(clip: Clip, drafts: dict[int, Pose]) -> None:
    found = refitted(clip, drafts, POSED)
    assert POSED not in found
    assert set(found) == set(range(FRAMES)) - {POSED}


def test_frames_beyond_reach_stay_and_the_seam_does_not_jump(
    clip: Clip, drafts: dict[int, Pose], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("keypose.tracker.fitting.draft.refit.LEARN_FRAMES", 8)
    found = refitted(clip, drafts, POSED)
    assert set(found) <= set(range(POSED - 8, POSED + 9)) - {POSED}
    edge = POSED + 8
    joints = joints_of(clip.body, [drafts[edge], found[edge]])
    assert np.linalg.norm(joints[1] - joints[0], axis=-1).max() < 0.01


def test_nothing_is_found_without_a_posed_frame_where_somebody_is_seen(
    clip: Clip, drafts: dict[int, Pose]
) -> None:
    assert refit_drafts(clip.keypoints, CAMERA, clip.body, drafts, {}, ()) == {}
    nobody = replace(clip.keypoints, visibility=np.zeros_like(clip.keypoints.visibility))
    unseen: Keypoints = nobody
    posed = {POSED: clip.poses[POSED]}
    assert refit_drafts(unseen, CAMERA, clip.body, drafts, posed, [POSED]) == {}


def test_what_is_learned_grows_with_agreement() -> None:
    slopes = np.tile([[200.0, 0.0, 0.0], [0.0, 200.0, 0.0]], (3, 1, 1))
    missed, pixel_m = np.tile([6.0, 0.0], (3, 1)), np.full(3, 1 / 200)
    one = learned_place(slopes[:1], missed[:1], pixel_m[:1])
    assert 0 < one[0] < learned_place(slopes, missed, pixel_m)[0] < 0.03
    assert np.allclose(one[1:], 0)
    assert 0 < learned_depth(np.array([0.2])) < learned_depth(np.full(3, 0.2)) < 0.2
