"""Keypoints get the depth that is lifted from them, in metres of the body, with its deviation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from keypose.tracker.body.body import preset
from keypose.tracker.body.modify import with_height
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.keypoints import JOINTS, Keypoints
from keypose.tracker.keypoints.lifted_depth import (
    DepthLifter,
    body_size_m,
    depth_along_view,
)
from keypose.tracker.session.annotations import KeypointCorrection
from tests.tracker.fitting.draft.clips import BODY, CAMERA, joints_of, place, walk

CLIP = walk(40, facing_deg=60)
LIFTER = DepthLifter(CAMERA, np.arange(40) / 30)
AT = [CLIP.keypoints.names.index(name) for name in JOINTS]


def depth_m(keypoints: Keypoints) -> Array:
    """(N, 12) of the joints, from the middle of the hips."""
    assert keypoints.p_hips is not None
    return np.asarray(keypoints.p_hips[:, AT, 2])


def truth_m() -> Array:
    z = joints_of(CLIP.body, CLIP.poses)[..., 2]
    hips = [JOINTS.index("left_hip"), JOINTS.index("right_hip")]
    return np.asarray(z - z[:, hips].mean(axis=1, keepdims=True))


def test_keypoints_of_a_picture_get_the_depth_of_a_walking_person_and_how_far_it_may_be_off() -> (
    None
):
    flat = replace(CLIP.keypoints, p_hips=None)
    found = LIFTER.of(flat, BODY)
    off = depth_m(found) - truth_m()
    assert np.sqrt((off**2).mean()) < 0.09 < np.sqrt((truth_m() ** 2).mean())
    assert found.depth_sigma_m is not None
    sigma = found.depth_sigma_m[:, AT]
    assert ((sigma > 0.005) & (sigma < 0.3)).all()
    assert (np.abs(off) < 2 * sigma).mean() > 0.9
    others = np.delete(found.depth_sigma_m, AT, axis=1)
    assert np.isnan(others).all()


def test_lengths_are_those_of_the_body() -> None:
    small = with_height(BODY, 1.2)
    sizes = [body_size_m(body) for body in (BODY, small)]
    assert sizes[0] is not None
    assert sizes[1] is not None
    ratio = depth_m(LIFTER.of(CLIP.keypoints, small)) / depth_m(LIFTER.of(CLIP.keypoints, BODY))
    np.testing.assert_allclose(ratio, sizes[1] / sizes[0], rtol=1e-6)


def test_a_foot_goes_with_its_ankle() -> None:
    before, after = CLIP.keypoints, LIFTER.of(CLIP.keypoints, BODY)
    assert before.p_hips is not None
    assert after.p_hips is not None
    for side in ("left", "right"):
        heel, ankle = place(f"{side}_heel"), place(f"{side}_ankle")
        np.testing.assert_allclose(
            after.p_hips[:, heel] - after.p_hips[:, ankle],
            before.p_hips[:, heel] - before.p_hips[:, ankle],
            atol=1e-9,
        )


def test_a_joint_that_a_person_set_gets_the_depth_that_belongs_there() -> None:
    wrist = place("left_wrist")
    at = tuple((CLIP.keypoints.uv[20, wrist] + (30.0, 0.0)).tolist())
    corrected = CLIP.keypoints.corrected([KeypointCorrection(frame=20, joint="left_wrist", uv=at)])
    assert corrected.p_hips is not None
    assert np.isnan(corrected.p_hips[20, wrist]).all()
    found = LIFTER.of(corrected, BODY)
    assert found.p_hips is not None
    assert np.isfinite(found.p_hips[20, wrist]).all()


def test_what_hangs_on_a_joint_that_a_person_set_has_no_depth_of_another_network() -> None:
    ankle, heel = place("left_ankle"), place("left_heel")
    at = tuple(CLIP.keypoints.uv[20, ankle].tolist())
    set_by_hand = KeypointCorrection(frame=20, joint="left_ankle", uv=at)
    found = LIFTER.of(CLIP.keypoints.corrected([set_by_hand]), BODY)
    assert found.p_hips is not None
    assert np.isnan(found.p_hips[20, heel]).all()
    assert np.isfinite(found.p_hips[19, heel]).all()


def test_hips_that_are_hidden_for_a_moment_leave_the_others_their_depth() -> None:
    uv, visibility = CLIP.keypoints.uv.copy(), CLIP.keypoints.visibility.copy()
    uv[20:23, place("left_hip")], visibility[20:23, place("left_hip")] = np.nan, 0.0
    found = LIFTER.of(replace(CLIP.keypoints, uv=uv, visibility=visibility, p_hips=None), BODY)
    off = depth_m(found)[20:23] - truth_m()[20:23]
    assert np.sqrt((off**2).mean()) < 0.12


def test_along_the_view_depth_is_that_of_the_camera_wherever_the_person_is() -> None:
    aside = walk(40, facing_deg=60, place=(2.6, 0.1, 4.5))
    z = joints_of(aside.body, aside.poses)[..., 2]
    hips = [JOINTS.index("left_hip"), JOINTS.index("right_hip")]
    known = z - z[:, hips].mean(axis=1, keepdims=True)
    found = LIFTER.of(aside.keypoints, BODY)
    turned = depth_along_view(found, CAMERA)[:, AT]
    assert found.p_hips is not None
    as_landmarks = found.p_hips[:, AT, 2]
    assert np.abs(turned - known).mean() < 0.7 * np.abs(as_landmarks - known).mean()


@pytest.mark.parametrize(
    ("names", "body"),
    [(("nose", *CLIP.keypoints.names[1:]), BODY), (CLIP.keypoints.names, preset("dog"))],
    ids=["a shoulder is missing", "a dog"],
)
def test_what_is_no_person_stays_as_it_is(names: tuple[str, ...], body: object) -> None:
    given = replace(CLIP.keypoints, names=names)
    assert LIFTER.of(given, body) is given  # type: ignore[arg-type]


def test_the_deviation_stays_with_its_frames_and_sides() -> None:
    found = LIFTER.of(CLIP.keypoints, BODY)
    assert found.depth_sigma_m is not None
    cut = found.over(5, 50)
    assert cut.depth_sigma_m is not None
    np.testing.assert_array_equal(cut.depth_sigma_m[:35], found.depth_sigma_m[5:])
    assert np.isnan(cut.depth_sigma_m[35:]).all()
    other = found.exchanged()
    assert other.depth_sigma_m is not None
    np.testing.assert_array_equal(
        other.depth_sigma_m[:, place("left_knee")], found.depth_sigma_m[:, place("right_knee")]
    )
