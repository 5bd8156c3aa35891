"""Limbs are drafted toward the camera or away from it as the whole stretch says."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from keypose.tracker.fitting.draft import clip as clip_module
from keypose.tracker.fitting.draft import draft_from_keypoints
from keypose.tracker.fitting.draft.depth_signs import Pointing, most_probable_signs, pointing
from keypose.tracker.fitting.draft.observed import Joints
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.keypoints import JOINTS
from tests.tracker.fitting.draft.clips import CAMERA, Clip, drafted_joints_m, place, walk

TILT = 0.35 + 0.25 * np.sin(np.arange(90) / 9)[:, None]
"""Of a bone that swings and never passes through the picture's plane."""
NOTHING = np.zeros((90, 1, 2))
RIGHT_FOREARM = 3
LEFT_SHIN = 5
"""Of `Joints.bones`."""


def _noise(sigma: float) -> Array:
    return np.random.default_rng(4).normal(0, sigma, TILT.shape)


@pytest.mark.parametrize("sign", [-1.0, 1.0])
@pytest.mark.parametrize("bias", [-0.4, 0.0, 0.4])
def test_a_constant_error_of_the_network_turns_no_bone(sign: float, bias: float) -> None:
    reported = 0.8 * sign * TILT + bias + _noise(0.1)
    signs, surer = most_probable_signs(TILT, reported, NOTHING)
    assert (signs == sign).all()
    assert (surer > 0).all()


def test_a_bone_changes_its_side_only_through_the_pictures_plane() -> None:
    true = np.linspace(-0.6, 0.6, 90)[:, None]
    wrong = true + _noise(0.15)
    wrong[10:14] *= -1
    signs, _ = most_probable_signs(np.abs(true), wrong, NOTHING)
    steep = np.abs(true) > 0.1
    assert (signs[steep] == np.sign(true[steep])).all()


def test_where_the_network_shows_nothing_the_likelier_pose_counts() -> None:
    unlikely = np.broadcast_to([2.0, 0.0], (90, 1, 2))
    signs, _ = most_probable_signs(TILT, _noise(0.05), unlikely)
    assert (signs == 1.0).all()


def _biased(clip: Clip, name: str, metres: float) -> Clip:
    """The clip with one joint told too far from the camera in every frame."""
    assert clip.keypoints.p_hips is not None
    p_hips = clip.keypoints.p_hips.copy()
    p_hips[:, place(name), 2] += metres
    return replace(clip, keypoints=replace(clip.keypoints, p_hips=p_hips))


@pytest.mark.parametrize(("facing_deg", "metres"), [(0, 0.15), (180, -0.15)])
def test_a_wrist_that_the_network_sees_at_a_wrong_depth_stays_on_its_side(
    facing_deg: float, metres: float
) -> None:
    clip = _biased(walk(60, facing_deg), "right_wrist", metres)
    draft = draft_from_keypoints(clip.keypoints, CAMERA, clip.body, proportions=False)
    near, far = (JOINTS.index(f"right_{joint}") for joint in ("elbow", "wrist"))
    ours, theirs = (p[:, far, 2] - p[:, near, 2] for p in (drafted_joints_m(draft), clip.joints_m))
    assert np.abs(theirs).min() > 0.08
    assert (np.sign(ours) == np.sign(theirs)).all()


def test_a_limb_that_cannot_be_turned_holds_no_other_back(monkeypatch: pytest.MonkeyPatch) -> None:
    clip = walk(30, 0)
    p_hips = clip.keypoints.p_hips
    assert p_hips is not None
    elbow, wrist = (place(f"right_{joint}") for joint in ("elbow", "wrist"))
    mirrored = p_hips.copy()
    mirrored[:, wrist, 2] = 2 * p_hips[:, elbow, 2] - p_hips[:, wrist, 2]

    def told(joints: Joints, *given: Any) -> Pointing:
        """The forearm is mirrored, which is so, and the knee bends forward, which it cannot."""
        drafted = pointing(joints, *given).drafted
        against = np.zeros(drafted.shape)
        against[:, [RIGHT_FOREARM, LEFT_SHIN]] = 100.0
        return Pointing(drafted, -np.sign(drafted), against)

    monkeypatch.setattr(clip_module, "pointing", told)
    keypoints = replace(clip.keypoints, p_hips=mirrored)
    draft = draft_from_keypoints(keypoints, CAMERA, clip.body, proportions=False)
    p = drafted_joints_m(draft)
    for side, near, far in (("right", "elbow", "wrist"), ("left", "knee", "ankle")):
        at = [JOINTS.index(f"{side}_{joint}") for joint in (near, far)]
        ours, theirs = (q[:, at[1], 2] - q[:, at[0], 2] for q in (p, clip.joints_m))
        steep = np.abs(theirs) > 0.08
        assert steep.any()
        assert (np.sign(ours) == np.sign(theirs))[steep].all()
