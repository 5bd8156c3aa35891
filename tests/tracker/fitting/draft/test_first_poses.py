"""One frame is posed in closed form; a body takes a person's proportions and no more."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from keypose.tracker.body.body import Body
from keypose.tracker.body.modify import height, resized, with_height
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.fitting.draft.first_poses import (
    FEWEST,
    LARGEST,
    NEAREST_M,
    STRAIGHT,
    SURE,
    _linear_place,
    first_pose,
    hinged,
    landmark_axes,
    placed,
    with_proportions,
)
from keypose.tracker.fitting.draft.observed import Joints, Limb, Observed, place_of
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, exp_rotation, log_rotation
from tests.tracker.fitting.draft.clips import BODY, CAMERA, Clip, joints_of, walk

TELEPHOTO = CAMERA.model_copy(update={"projection": "telephoto", "telephoto_distance_m": 4.5})
JOINTS_OF = Joints.of(Skeleton.of(BODY))
LIMB_NAMES = ("left arm", "right arm", "left leg", "right leg")


# --- where it is


@pytest.mark.parametrize("camera", [CAMERA, TELEPHOTO], ids=["perspective", "telephoto"])
def test_points_are_put_where_they_are_seen(camera: Camera) -> None:
    p, t = np.random.default_rng(4).normal(0, 0.4, (12, 3)), np.array([0.4, -0.2, 4.5])
    found = placed(camera, p, camera.project(p + t), np.ones(12))
    np.testing.assert_allclose(found, t, atol=1e-6)


@pytest.mark.parametrize("camera", [CAMERA, TELEPHOTO], ids=["perspective", "telephoto"])
@pytest.mark.parametrize("stray_px", [60.0, 120.0, 180.0])
def test_one_point_seen_elsewhere_pulls_less_than_its_share(
    camera: Camera, stray_px: float
) -> None:
    p, t = np.random.default_rng(4).normal(0, 0.4, (12, 3)), np.array([0.4, -0.2, 4.5])
    uv = camera.project(p + t)
    uv[5] += stray_px
    robust, even = placed(camera, p, uv, np.ones(12)), _linear_place(camera, p, uv, np.ones(12))
    assert np.linalg.norm(robust - t) < 0.5 * np.linalg.norm(even - t)


def test_a_point_of_no_weight_has_no_say() -> None:
    rng = np.random.default_rng(5)
    p, t, sure = rng.normal(0, 0.4, (12, 3)), np.array([0.1, 0.2, 3.0]), np.ones(12)
    uv = CAMERA.project(p + t)
    uv[7], sure[7] = (-4000.0, 9000.0), 0.0
    np.testing.assert_allclose(placed(CAMERA, p, uv, sure), t, atol=1e-6)


def test_nothing_is_put_nearer_than_a_person_can_be() -> None:
    p = np.random.default_rng(6).normal(0, 0.4, (12, 3))
    uv = CAMERA.project(p * 40 + (0, 0, 60))  # as large as only something at the lens would be
    uv = (uv - (CAMERA.cx, CAMERA.cy)) * 500 + (CAMERA.cx, CAMERA.cy)
    t = placed(CAMERA, p, uv, np.ones(12))
    assert (p + t)[:, 2].min() == pytest.approx(NEAREST_M)


def test_landmarks_are_seen_as_if_in_the_middle_of_the_picture() -> None:
    known = np.ones(12, np.bool_)
    middle, aside = (np.tile(uv, (12, 1)) for uv in ((CAMERA.cx, CAMERA.cy), (1200.0, 500.0)))
    np.testing.assert_allclose(landmark_axes(CAMERA, middle, known), np.eye(3), atol=1e-12)
    R = landmark_axes(CAMERA, aside, known)
    ray = CAMERA.back_project(np.array([1200.0, 500.0]), 1.0)
    np.testing.assert_allclose(R @ (0, 0, 1), ray / np.linalg.norm(ray))
    assert R[1, 0] == pytest.approx(0.0), "x stays level"
    np.testing.assert_allclose(landmark_axes(TELEPHOTO, aside, known), np.eye(3))


# --- how it is posed


def one_frame(clip: Clip, n: int = 0) -> tuple[Array, Array]:
    """(12, 2) pixels and (12, 3) exact landmarks in the axes of the view, of any length."""
    p = clip.joints_m[n]
    hips = p[[place_of("left", "hip"), place_of("right", "hip")]].mean(axis=0)
    uv = CAMERA.project(p)
    return uv, (p - hips) @ landmark_axes(CAMERA, uv, np.ones(12, np.bool_))


@pytest.mark.parametrize("facing_deg", [0, 70, 160, 250])
@pytest.mark.parametrize("scale", [0.7, 1.0, 1.3])
def test_exact_landmarks_of_any_length_give_the_pose(facing_deg: float, scale: float) -> None:
    clip = walk(12, facing_deg)
    for n in (0, 5, 11):
        uv, p_hips = one_frame(clip, n)
        pose = first_pose(JOINTS_OF, CAMERA, uv, np.ones(12), scale * p_hips)
        away = np.linalg.norm(joints_of(BODY, [pose])[0] - clip.joints_m[n], axis=-1)
        assert away.max() < 0.01, "the trunk bends, and its first pose does not"


@pytest.mark.parametrize("bend_deg", [20.0, 60.0, 120.0])
@pytest.mark.parametrize("limb", JOINTS_OF.limbs, ids=LIMB_NAMES)
def test_a_bent_limb_says_how_it_is_turned_about_itself(limb: Limb, bend_deg: float) -> None:
    rng = np.random.default_rng(8)
    upper = exp_rotation(rng.normal(0, 1, 3))
    bend = exp_rotation(np.array([limb.bends_to[2] * np.radians(bend_deg), 0.0, 0.0]))
    lower = upper @ bend
    p = np.zeros((12, 3))
    p[limb.upper.far] = 0.3 * upper[:, 1]
    p[limb.lower.far] = p[limb.upper.far] + 0.25 * lower[:, 1]
    found = hinged(limb, p, np.eye(3))
    most_rad = 2 * STRAIGHT / np.sin(np.radians(bend_deg))  # the least turn has a little say
    for ours, truth in zip(found, (upper, lower), strict=True):
        assert np.linalg.norm(log_rotation(ours.T @ truth)) < most_rad


def test_a_straight_limb_is_turned_about_itself_as_before() -> None:
    limb, H = JOINTS_OF.limbs[0], exp_rotation(np.array([0.0, 0.8, 0.0]))
    p = np.zeros((12, 3))
    p[limb.upper.far], p[limb.lower.far] = (0, 0.3, 0), (0, 0.55, 0)
    np.testing.assert_allclose(hinged(limb, p, H)[0], H, atol=1e-9)


def test_many_frames_give_what_each_gives() -> None:
    limb, rng = JOINTS_OF.limbs[2], np.random.default_rng(9)
    p, H = rng.normal(size=(5, 12, 3)), exp_rotation(rng.normal(size=(5, 3)))
    together = hinged(limb, p, H)
    for n in range(5):
        for all_frames, alone in zip(together, hinged(limb, p[n], H[n]), strict=True):
            np.testing.assert_allclose(all_frames[n], alone)


# --- proportions


def measured(body: Body, count: int = FEWEST, scale: float = 0.9) -> Observed:
    """What a perfect network sees of a person with these proportions."""
    clip = walk(count, facing_deg=40, body=body)
    seen = Observed.of(clip.keypoints, CAMERA)
    return replace(seen, p_hips=seen.p_hips * scale)


def lengths(body: Body) -> dict[str, float]:
    """Metres of arms, legs and trunk, by the part or the joints they lie between."""
    joints = Joints.of(Skeleton.of(body))
    out = {body.names[bone.part]: joints.length_m(bone) for bone in joints.bones}
    hips, shoulders = (
        [place_of(side, name) for side in ("left", "right")] for name in ("hip", "shoulder")
    )
    p = joints.rest
    out["trunk"] = float(np.linalg.norm(p[hips].mean(0) - p[shoulders].mean(0)))
    out["shoulders"] = float(np.linalg.norm(p[shoulders[0]] - p[shoulders[1]]))
    return out


@pytest.mark.parametrize("scale", [0.8, 1.0, 1.2])
def test_a_body_of_the_persons_proportions_stays_as_it_is_at_any_scale(scale: float) -> None:
    before, after = lengths(BODY), lengths(with_proportions(BODY, measured(BODY, scale=scale)))
    for name, length_m in before.items():
        assert after[name] == pytest.approx(length_m, rel=0.025), name


@pytest.mark.parametrize(("part", "factor"), [("left_thigh", 1.1), ("left_forearm", 0.88)])
def test_a_longer_or_shorter_limb_is_followed_on_both_sides_by_most_of_the_way(
    part: str, factor: float
) -> None:
    person = with_height(resized(BODY, part, length_factor=factor), height(BODY))
    found = with_proportions(BODY, measured(person))
    before, after, truth = lengths(BODY), lengths(found), lengths(person)
    gone = (after[part] - before[part]) / (truth[part] - before[part])
    assert 0.5 < gone < 1.1
    assert after[part] == pytest.approx(after[part.replace("left", "right")])
    assert height(found) == pytest.approx(height(BODY))


def test_no_length_is_changed_beyond_what_people_differ_by() -> None:
    stretched = measured(BODY)
    p_hips = stretched.p_hips.copy()
    for side in ("left", "right"):
        knee, ankle = (place_of(side, joint) for joint in ("knee", "ankle"))
        p_hips[:, ankle] = p_hips[:, knee] + 3 * (p_hips[:, ankle] - p_hips[:, knee])
    found = with_proportions(BODY, replace(stretched, p_hips=p_hips))
    before, after = lengths(BODY), lengths(found)
    beside_thigh = (after["left_shin"] / after["left_thigh"]) / (
        before["left_shin"] / before["left_thigh"]
    )
    assert 1.05 < beside_thigh <= 1.005 * np.exp(LARGEST)


@pytest.mark.parametrize("reason", ["few frames", "never sure"])
def test_what_too_few_frames_show_changes_nothing(reason: str) -> None:
    person = resized(BODY, "left_thigh", length_factor=1.1)
    both_sides = 2 * (FEWEST // 2 - 1)
    seen = measured(person, both_sides // 2 if reason == "few frames" else FEWEST)
    if reason == "never sure":
        seen = replace(seen, visibility=np.full_like(seen.visibility, SURE - 0.01))
    before, after = (lengths(each) for each in (BODY, with_proportions(BODY, seen)))
    assert after["left_thigh"] == pytest.approx(before["left_thigh"], rel=1e-6)
