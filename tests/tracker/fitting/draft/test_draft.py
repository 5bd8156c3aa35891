"""A whole clip is drafted from keypoints: where the joints are, in depth too, and where not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from keypose.tracker.body.body import Body, Part
from keypose.tracker.body.modify import (
    has_clavicles,
    height,
    joint_moved,
    resized,
    with_clavicles,
    with_height,
)
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.shapes.box import Box as BoxShape
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import KeypointError
from keypose.tracker.fitting.draft import ClipDraft, DraftProgress, draft_from_keypoints
from keypose.tracker.fitting.draft.depth_signs import consistent_sides
from keypose.tracker.fitting.draft.observed import Joints, Observed
from keypose.tracker.geometry.rotations import Array, exp_rotation, log_rotation
from keypose.tracker.keypoints.keypoints import Keypoints
from tests.tracker.fitting.draft.clips import (
    BODY,
    CAMERA,
    LIMB_BONES,
    Clip,
    drafted_joints_m,
    joints_of,
    place,
    seen,
    standing,
    walk,
)

OUTER_LEG = ("knee", "ankle", "heel", "foot_index")


def drafted(clip: Clip, keypoints: Keypoints | None = None) -> ClipDraft:
    """With the clip's own body."""
    given = clip.keypoints if keypoints is None else keypoints
    return draft_from_keypoints(given, CAMERA, clip.body, proportions=False)


def without(keypoints: Keypoints, frames: slice, *names: str) -> Keypoints:
    """With these unseen in some frames; all of them where none is named."""
    columns = [place(name) for name in names] if names else list(range(len(keypoints.names)))
    uv, visibility = keypoints.uv.copy(), keypoints.visibility.copy()
    assert keypoints.p_hips is not None
    p_hips = keypoints.p_hips.copy()
    uv[frames, columns], p_hips[frames, columns] = np.nan, np.nan
    visibility[frames, columns] = 0.0
    return replace(keypoints, uv=uv, visibility=visibility, p_hips=p_hips)


def exchanged(keypoints: Keypoints, frames: list[int], *joints: str) -> Keypoints:
    """With left and right of some joints exchanged in some frames."""
    other = keypoints.exchanged()
    uv, visibility = keypoints.uv.copy(), keypoints.visibility.copy()
    assert keypoints.p_hips is not None
    assert other.p_hips is not None
    p_hips = keypoints.p_hips.copy()
    columns = [k for k, name in enumerate(keypoints.names) if name.split("_", 1)[-1] in joints]
    here = np.ix_(frames, columns)
    uv[here], p_hips[here] = other.uv[here], other.p_hips[here]
    return replace(keypoints, uv=uv, visibility=visibility, p_hips=p_hips)


@pytest.mark.parametrize("facing_deg", [0, 60, 90, 180, 250])
def test_a_person_is_drafted_where_they_are_with_limbs_pointing_the_right_way_in_depth(
    facing_deg: float,
) -> None:
    clip = walk(24, facing_deg)
    found, known = drafted_joints_m(drafted(clip)), clip.joints_m
    assert np.linalg.norm(found - known, axis=-1).mean() < 0.03
    for near, far in LIMB_BONES:
        theirs = known[:, far, 2] - known[:, near, 2]
        ours = found[:, far, 2] - found[:, near, 2]
        reported = np.abs(theirs) > 0.05
        assert (np.sign(theirs[reported]) == np.sign(ours[reported])).all()


def test_a_person_at_rest_is_drafted_at_rest() -> None:
    draft = drafted(standing(6))
    for pose in draft.poses.values():
        assert np.abs(log_rotation(pose.Rs_parent_part)).max() < np.radians(8)


def test_a_person_who_turns_about_completely_is_followed_all_the_way() -> None:
    clip = walk(72, turning_deg=5)
    draft = drafted(clip)
    assert np.linalg.norm(drafted_joints_m(draft) - clip.joints_m, axis=-1).mean() < 0.03


def test_head_and_feet_turn_as_their_keypoints_say_and_the_limbs_do_not() -> None:
    clip = walk(12)
    seen = drafted(clip)
    blind = drafted(clip, without(clip.keypoints, slice(None), "nose", "left_ear", "right_ear"))
    nodded = clip.keypoints.uv.copy()
    nodded[:, place("nose")] += (0, 8)
    moved = drafted(clip, replace(clip.keypoints, uv=nodded))
    for other in (blind, moved):
        np.testing.assert_array_equal(drafted_joints_m(seen), drafted_joints_m(other))
    head = BODY.index("head")
    turns = [draft.poses[6].Rs_parent_part[head] for draft in (seen, moved)]
    assert np.abs(log_rotation(turns[0].T @ turns[1])).max() > np.radians(3)


def test_the_lens_is_taken_out_of_keypoints() -> None:
    lens = CAMERA.model_copy(update={"distortion": (-0.12, 0.02, 0.001, 0.0, 0.0)})
    clip = walk(12, camera=lens)
    draft = draft_from_keypoints(clip.keypoints, lens, clip.body, proportions=False)
    assert np.linalg.norm(drafted_joints_m(draft) - clip.joints_m, axis=-1).mean() < 0.03


def test_joints_that_nobody_sees_are_bridged_by_the_frames_around() -> None:
    clip = walk(40)
    few = without(clip.keypoints, slice(12, 18), "left_wrist", "left_elbow", "right_ankle")
    away = np.linalg.norm(drafted_joints_m(drafted(clip, few)) - clip.joints_m, axis=-1)
    assert away.mean() < 0.03
    assert away.max() < 0.25


def test_frames_that_show_nobody_get_no_draft() -> None:
    clip = walk(40)
    gone = without(without(clip.keypoints, slice(4)), slice(20, 23))
    assert sorted(drafted(clip, gone).poses) == [*range(4, 20), *range(23, 40)]
    apart = without(clip.keypoints, slice(10, 30))
    draft = drafted(clip, apart)
    assert sorted(draft.poses) == [*range(10), *range(30, 40)]
    assert {p.frame for p in draft.proposals} >= {0, 9, 30, 39}


def test_a_single_frame_is_drafted() -> None:
    clip = walk(1, facing_deg=30)
    assert np.linalg.norm(drafted_joints_m(drafted(clip)) - clip.joints_m, axis=-1).max() < 0.1


def test_a_long_clip_has_no_seams() -> None:
    clip = walk(260, facing_deg=-40)
    found, known = drafted_joints_m(drafted(clip)), clip.joints_m
    assert np.linalg.norm(found - known, axis=-1).mean() < 0.03
    jumps, usual = (np.linalg.norm(np.diff(p, axis=0), axis=-1).max() for p in (found, known))
    assert jumps < 2 * usual


def test_sides_that_are_reported_wrong_for_a_while_are_set_right() -> None:
    clip = walk(60, facing_deg=70)
    legs = ("hip", "knee", "ankle", "heel", "foot_index")
    wrong = exchanged(clip.keypoints, [10, 11, 12, 30, 45, 46], *legs)
    found = drafted_joints_m(drafted(clip, wrong))
    assert np.linalg.norm(found - clip.joints_m, axis=-1).mean() < 0.03


def test_knees_and_feet_that_are_seen_on_the_other_leg_are_set_right() -> None:
    clip = walk(60, facing_deg=80)
    uv, frames = clip.keypoints.uv.copy(), [8, 9, 10, 28, 50, 51]
    outer = [place(f"{side}_{joint}") for side in ("left", "right") for joint in OUTER_LEG]
    uv[np.ix_(frames, outer)] = clip.keypoints.exchanged().uv[np.ix_(frames, outer)]
    seen = Observed.of(replace(clip.keypoints, uv=uv), CAMERA)
    reported = Observed.of(clip.keypoints, CAMERA)
    found = consistent_sides(seen, 440.0, height(clip.body))
    assert found is not None
    for name in ("uv", "known", "visibility", "p_hips"):
        np.testing.assert_array_equal(getattr(found, name), getattr(reported, name))


def test_a_hidden_foot_that_is_seen_on_something_else_for_a_while_stays_on_its_way() -> None:
    clip = walk(40, facing_deg=30)
    uv, leg = clip.keypoints.uv.copy(), [place("right_knee"), place("right_ankle")]
    uv[18:22, leg] += (-120.0, -40.0)
    found = drafted_joints_m(drafted(clip, replace(clip.keypoints, uv=uv)))
    away = np.linalg.norm(found - clip.joints_m, axis=-1)
    assert away.mean() < 0.03
    assert away[18:22].max() < 0.1


@pytest.mark.parametrize("facing_deg", [0, 90, 180])
def test_right_sides_stay_as_reported_where_legs_pass_each_other(facing_deg: float) -> None:
    clip = walk(80, facing_deg)
    draft = drafted(clip)
    assert np.linalg.norm(drafted_joints_m(draft) - clip.joints_m, axis=-1).max() < 0.15


def test_limbs_take_the_persons_proportions_and_the_body_keeps_its_height() -> None:
    person = with_height(
        resized(resized(BODY, "left_thigh", length_factor=1.1), "left_forearm", length_factor=0.9),
        height(BODY),
    )
    clip = walk(40, body=person)
    draft = draft_from_keypoints(clip.keypoints, CAMERA, BODY)
    assert height(draft.body) == pytest.approx(height(BODY))
    for left, right in draft.body.mirror_pairs:
        one, other = (draft.body.parts[draft.body.index(name)] for name in (left, right))
        x, y, z = one.joint_m
        assert other.joint_m == pytest.approx((-x, y, z))
    before, after, truth = (Joints.of(Skeleton.of(b)) for b in (BODY, draft.body, person))
    for limb in (0, 2):
        for bone in (before.limbs[limb].upper, before.limbs[limb].lower):
            off = abs(after.length_m(bone) - truth.length_m(bone))
            assert off <= 0.5 * abs(before.length_m(bone) - truth.length_m(bone)) + 0.005


def test_shoulders_seen_farther_inside_than_people_have_them_narrow_the_body_by_little() -> None:
    person = BODY
    for name in ("left_upper_arm", "right_upper_arm"):
        x, y, z = BODY.parts[BODY.index(name)].joint_m
        person = joint_moved(person, name, (0.8 * x, y, z), linked=False)
    draft = draft_from_keypoints(walk(40, body=person).keypoints, CAMERA, BODY)
    arm = BODY.index("left_upper_arm")
    assert 0.92 < draft.body.parts[arm].joint_m[0] / BODY.parts[arm].joint_m[0] < 1.0


def test_drafts_are_the_same_every_time() -> None:
    clip = walk(30)
    one, other = (draft_from_keypoints(clip.keypoints, CAMERA, BODY) for _ in range(2))
    assert one.body == other.body
    assert one.proposals == other.proposals
    for frame, pose in one.poses.items():
        np.testing.assert_array_equal(pose.Rs_parent_part, other.poses[frame].Rs_parent_part)
        np.testing.assert_array_equal(pose.p_camera_root, other.poses[frame].p_camera_root)


def test_progress_rises_and_what_the_report_raises_ends_the_work_at_once() -> None:
    class Left(Exception):
        pass

    reported: list[DraftProgress] = []

    def report(progress: DraftProgress) -> None:
        reported.append(progress)

    clip = walk(150)
    wrong = exchanged(clip.keypoints, [70, 71], "hip", "knee", "ankle", "heel", "foot_index")
    draft_from_keypoints(wrong, CAMERA, BODY, report=report)
    done = [progress.done for progress in reported]
    assert done == sorted(done)
    assert all(progress.expected == 150 for progress in reported)

    def leave(progress: DraftProgress) -> None:
        reported.append(progress)
        if len(reported) == 5:
            raise Left

    reported.clear()
    with pytest.raises(Left):
        draft_from_keypoints(clip.keypoints, CAMERA, BODY, report=leave)
    assert len(reported) == 5


def test_keypoints_that_no_body_can_have_are_no_draft() -> None:
    clip = walk(3)
    rng = np.random.default_rng(2)
    nowhere = rng.uniform(0, 700, clip.keypoints.uv.shape)
    with pytest.raises(KeypointError, match="nowhere seen well enough"):
        drafted(clip, replace(clip.keypoints, uv=nowhere))


def test_keypoints_that_are_no_persons_with_depth_are_refused_in_one_sentence() -> None:
    clip = walk(5)
    flat = replace(clip.keypoints, p_hips=None)
    names = tuple("thing" if name == "left_knee" else name for name in clip.keypoints.names)
    box = Body(
        name="box", parts=(Part(name="box", shape=BoxShape(low_m=(0, 0, 0), high_m=(1, 1, 1))),)
    )
    for keypoints, body, words in (
        (flat, BODY, "have no depth"),
        (replace(clip.keypoints, names=names), BODY, "have no left knee"),
        (without(clip.keypoints, slice(None)), BODY, "nowhere seen well enough"),
        (clip.keypoints, box, "no joints of a person"),
    ):
        with pytest.raises(KeypointError, match=words):
            draft_from_keypoints(keypoints, CAMERA, body)


def test_every_draft_lies_before_the_camera() -> None:
    near = walk(10, place=(0.0, 0.0, 0.9))
    for pose in drafted(near).poses.values():
        T = pose_transforms(Skeleton.of(BODY), pose)
        assert T[:, 2, 3].min() > 0.05


@pytest.mark.parametrize("proportions", [False, True])
def test_a_body_with_clavicles_gets_the_drafts_of_the_body_without(proportions: bool) -> None:
    clip = walk(12)
    plain = draft_from_keypoints(clip.keypoints, CAMERA, BODY, proportions=proportions)
    body = with_clavicles(BODY)
    draft = draft_from_keypoints(clip.keypoints, CAMERA, body, proportions=proportions)
    assert has_clavicles(draft.body)
    assert draft.body.names == body.names
    assert proportions or draft.body == body
    for frame, pose in plain.poses.items():
        given = joints_of(plain.body, [pose])
        np.testing.assert_allclose(joints_of(draft.body, [draft.poses[frame]]), given, atol=1e-9)


@pytest.mark.parametrize(("x_m", "facing_deg"), [(2.2, 90.0), (-2.2, 60.0)])
def test_feet_point_ahead_at_the_edge_of_the_picture_too(x_m: float, facing_deg: float) -> None:
    clip = walk(12, facing_deg, place=(x_m, 0.1, 4.5))
    draft = draft_from_keypoints(clip.keypoints, CAMERA, clip.body, proportions=False)
    off = [
        np.einsum("ki,ki->k", _soles(clip.body, clip.poses[n]), _soles(draft.body, draft.poses[n]))
        for n in range(12)
    ]
    assert np.degrees(np.arccos(np.min(off))) < 4.0


def _soles(body: Body, pose: Pose) -> Array:
    """(2, 3) unit vectors from heels to toes."""
    Ts, found = pose_transforms(Skeleton.of(body), pose), []
    for side in ("left", "right"):
        foot = body.index(f"{side}_foot")
        ends = body.parts[foot].landmarks
        along = np.subtract(ends[f"{side}_toe"], ends[f"{side}_heel"])
        found.append(Ts[foot, :3, :3] @ along / np.linalg.norm(along))
    return np.array(found)


# --- where up is known


@pytest.mark.parametrize("tilt_deg", [8.0, 15.0])
def test_a_person_whom_the_network_has_lean_toward_the_camera_is_put_upright(
    tilt_deg: float,
) -> None:
    """The camera looks down, and the network takes it for level: bodies lean by as much."""
    c, s = np.cos(np.radians(tilt_deg)), np.sin(np.radians(tilt_deg))
    up = np.array([0.0, -c, -s])
    clip = standing(20)
    leaning = seen(clip.body, [_tipped(pose, up) for pose in clip.poses], CAMERA)
    told = clip.keypoints.p_hips
    assert told is not None
    keypoints = replace(leaning.keypoints, p_hips=told)
    leans = [
        _lean_deg(draft_from_keypoints(keypoints, CAMERA, clip.body, up_world=known), up)
        for known in (None, up)
    ]
    assert leans[0] > tilt_deg / 2
    assert leans[1] < 2.0


def _tipped(pose: Pose, up: Array) -> Pose:
    """A pose turned about its root so that it stands along another up."""
    Rs = pose.Rs_parent_part.copy()
    Rs[0] = _turn_to(up) @ Rs[0]
    return Pose(Rs, pose.p_camera_root)


def _turn_to(up: Array) -> Array:
    axis = np.cross([0.0, -1.0, 0.0], up)
    return np.asarray(exp_rotation(axis / np.linalg.norm(axis) * np.arccos(-up[1])))


def _lean_deg(draft: ClipDraft, up: Array) -> float:
    """Of the line from feet to shoulders, in the median."""
    p = drafted_joints_m(draft)
    ends = [[place(f"{side}_{joint}") for side in ("left", "right")]
            for joint in ("shoulder", "ankle")]  # fmt: skip
    along = p[:, ends[0]].mean(axis=1) - p[:, ends[1]].mean(axis=1)
    along /= np.linalg.norm(along, axis=-1, keepdims=True)
    return float(np.degrees(np.median(np.arccos(np.clip(along @ up, -1, 1)))))
