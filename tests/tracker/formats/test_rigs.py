"""The body as the named bones of other programs' skeletons."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.body.body import Part, preset
from keypose.tracker.body.modify import with_clavicles
from keypose.tracker.body.preset_names import PEOPLE
from keypose.tracker.body.shapes import Cylinder
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import FormatError
from keypose.tracker.formats.conventions import parts_in_world
from keypose.tracker.formats.recording import Recording
from keypose.tracker.formats.rigs import OWN, RIGS
from keypose.tracker.formats.rigs.rig import Rig, rig_of
from keypose.tracker.formats.rigs.table import table_of
from keypose.tracker.geometry.rotations import transform
from tests.tracker.formats import recordings

NAMED = [name for name in RIGS if name != OWN]
FIRST_NAMES = {
    "mixamo": ("mixamorig:Hips", "mixamorig:LeftForeArm", "mixamorig:RightToeBase"),
    "ue5": ("root", "pelvis", "spine_05", "neck_02", "lowerarm_l", "ball_r"),
    "metahuman": ("root", "pelvis", "spine_05", "neck_02", "lowerarm_l", "ball_r"),
    "vrm": ("hips", "upperChest", "leftUpperArm", "rightToes"),
    "cmu": ("root", "lfemur", "thorax", "rhumerus", "ltoes"),
    "smpl": ("pelvis", "left_knee", "spine3", "right_collar", "left_wrist"),
}
ELBOWS = {
    "mixamo": "mixamorig:LeftForeArm",
    "ue5": "lowerarm_l",
    "metahuman": "lowerarm_l",
    "vrm": "leftLowerArm",
    "cmu": "lradius",
    "smpl": "left_elbow",
}


def posed(rig: Rig, Rs: np.ndarray, ps: np.ndarray) -> np.ndarray:  # type: ignore[type-arg]
    """Ts_world_bone (N, B, 4, 4) by forward kinematics of the curves alone."""
    offsets = np.tile(rig.Ts_parent_bone[:, :3, 3], (len(Rs), 1, 1))
    offsets[:, rig.mover] = ps
    local = transform(Rs, offsets)
    T = local.copy()
    for i, parent in enumerate(rig.parents):
        if parent >= 0:
            T[:, i] = T[:, parent] @ local[:, i]
    return T


def in_world(made: Recording) -> np.ndarray:  # type: ignore[type-arg]
    return parts_in_world(made, made.T_world_camera)


@pytest.mark.parametrize("clavicles", [False, True])
@pytest.mark.parametrize("rig_name", NAMED)
def test_bones_are_where_the_body_has_its_joints(rig_name: str, clavicles: bool) -> None:
    made = recordings.recording("twirl")
    skeleton = Skeleton.of(with_clavicles(made.skeleton.body)) if clavicles else made.skeleton
    Ts_world_part = in_world(made)
    if clavicles:
        own = made.skeleton.body.names
        order = [
            own.index(name) if name in own else own.index("chest") for name in skeleton.body.names
        ]
        Ts_world_part = Ts_world_part[:, order]
    rig = rig_of(skeleton, rig_name)
    T = posed(rig, *rig.motion(Ts_world_part))
    for part, name in enumerate(skeleton.body.names):
        if "clavicle" in name:
            continue
        first = int(np.flatnonzero(rig.parts == part)[0])
        if "hipjoint" in rig.names[first]:
            continue
        np.testing.assert_allclose(T[:, first, :3, 3], Ts_world_part[:, part, :3, 3], atol=1e-9)


@pytest.mark.parametrize("name", recordings.NAMES)
def test_a_body_s_own_rig_has_a_bone_for_every_joint_and_landmark(name: str) -> None:
    made = recordings.recording(name)
    rig, T_world = rig_of(made.skeleton), made.T_world_camera
    T = posed(rig, *rig.motion(parts_in_world(made, T_world)))
    joints = made.trajectory.joints(made.skeleton) @ T_world[:3, :3].T + T_world[:3, 3]
    np.testing.assert_allclose(T[:, :, :3, 3], joints, atol=1e-9)


@pytest.mark.parametrize("rig_name", NAMED)
def test_a_bone_stays_on_its_part_as_it_lies_on_it_at_rest(rig_name: str) -> None:
    made = recordings.recording("person")
    rig, Ts_world_part = rig_of(made.skeleton, rig_name), in_world(made)
    T = posed(rig, *rig.motion(Ts_world_part))
    for i, part in enumerate(rig.parts):
        on_part = rig.Ts_part_bone[i]
        expected = on_part[None] if part < 0 else Ts_world_part[:, part] @ on_part
        np.testing.assert_allclose(T[:, i], np.broadcast_to(expected, T[:, i].shape), atol=1e-9)


@pytest.mark.parametrize("body", PEOPLE)
@pytest.mark.parametrize("rig_name", list(RIGS))
def test_at_rest_the_body_stands_on_the_floor_and_faces_along_z(rig_name: str, body: str) -> None:
    rig = rig_of(Skeleton.of(preset(body)), rig_name)
    assert rig.parents[0] == -1
    assert (rig.parents[1:] < np.arange(1, len(rig))).all()
    assert len(set(rig.names)) == len(rig)
    Rs = rig.Ts_world_bone[:, :3, :3]
    np.testing.assert_allclose(np.linalg.det(Rs), 1, atol=1e-9)
    np.testing.assert_allclose(
        Rs @ Rs.swapaxes(1, 2), np.tile(np.eye(3), (len(rig), 1, 1)), atol=1e-9
    )
    places = rig.Ts_world_bone[:, :3, 3]
    assert -1e-9 <= places[:, 1].min() < 0.09  # ankles and balls of feet, or a root on the floor
    hands = [places[rig.parts == preset(body).index(f"{s}_hand")][0] for s in ("left", "right")]
    assert hands[0][0] > 0 > hands[1][0]
    foot = preset(body).index("left_foot")
    toe = places[rig.parts == foot][1]
    assert toe[2] > places[rig.parts == foot][0][2]


@pytest.mark.parametrize("rig_name", NAMED)
def test_arms_are_level_in_a_t_pose_and_half_way_down_in_an_a_pose(rig_name: str) -> None:
    rig = rig_of(Skeleton.of(preset("adult_male")), rig_name)
    elbow = rig.names.index(ELBOWS[rig_name])
    shoulder, hand = rig.parents[elbow], int(np.flatnonzero(rig.parents == elbow)[0])
    p = rig.Ts_world_bone[:, :3, 3]
    fall = 1.0 if rig_name in ("ue5", "metahuman") else 0.0
    for start, end in ((shoulder, elbow), (elbow, hand)):
        x, y, z = p[end] - p[start]
        assert x > 0.1
        assert y / x == pytest.approx(-fall, abs=1e-9)
        assert z == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("rig_name", NAMED)
def test_names_are_those_of_the_rig(rig_name: str) -> None:
    rig = rig_of(Skeleton.of(preset("adult_female")), rig_name)
    assert rig.names == tuple(row.name for row in table_of(rig_name).rows())
    assert set(FIRST_NAMES[rig_name]) <= set(rig.names)


@pytest.mark.parametrize("rig_name", list(RIGS))
def test_a_rig_can_have_all_its_bones_parallel_to_the_world_at_rest(rig_name: str) -> None:
    made = recordings.recording("person")
    plain, rig = (rig_of(made.skeleton, rig_name, parallel=p) for p in (True, False))
    np.testing.assert_array_equal(
        plain.Ts_world_bone[:, :3, :3], np.tile(np.eye(3), (len(rig), 1, 1))
    )
    motion = in_world(made)
    places = [posed(each, *each.motion(motion))[..., :3, 3] for each in (plain, rig)]
    np.testing.assert_allclose(*places, atol=1e-9)


def test_bones_of_mixamo_point_along_their_y_and_those_of_unreal_along_their_x() -> None:
    skeleton = Skeleton.of(preset("adult_male"))
    for rig_name, axis in (("mixamo", 1), ("ue5", 0), (OWN, 1)):
        rig = rig_of(skeleton, rig_name)
        along = np.abs(rig.ends_bone) / np.linalg.norm(rig.ends_bone, axis=1, keepdims=True)
        turning = rig.parts >= 0  # a root that stands still is as the world
        turning[skeleton.part_count :] &= rig_name != OWN
        np.testing.assert_allclose(along[turning, axis], 1, atol=1e-9)
    rig = rig_of(skeleton, "ue5")
    arm, thigh = (rig.Ts_world_bone[rig.names.index(n), :3, 0] for n in ("upperarm_r", "thigh_l"))
    assert arm[0] > 0  # the right side's x points back to the shoulder, the left thigh's up
    assert thigh[1] > 0


def test_lengths_are_the_bodys() -> None:
    small, tall = (rig_of(Skeleton.of(preset(n)), "vrm") for n in ("elderly_female", "adult_male"))
    head = small.names.index("head")
    heights = [rig.Ts_world_bone[head, 1, 3] for rig in (small, tall)]
    assert heights[0] < heights[1] - 0.1


@pytest.mark.parametrize("rig_name", NAMED)
def test_a_box_has_its_own_names_only(rig_name: str) -> None:
    box = recordings.recording("box").skeleton
    with pytest.raises(FormatError, match=f"The rig {rig_name} is for a person, and the body"):
        rig_of(box, rig_name)
    assert rig_of(box).names[0] == "box"


def test_a_person_without_hands_and_neck_has_the_bones_that_are_left() -> None:
    body = preset("adult_male")
    gone = ("left_hand", "right_hand", "neck")
    parts = [
        p.model_copy(update={"parent": "chest"}) if p.parent == "neck" else p
        for p in body.parts
        if p.name not in gone
    ]
    pairs = tuple(pair for pair in body.mirror_pairs if pair[0] not in gone)
    bare = body.model_copy(update={"parts": tuple(parts), "mirror_pairs": pairs})
    rig = rig_of(Skeleton.of(bare), "mixamo")
    assert "mixamorig:LeftHand" not in rig.names
    head = rig.names.index("mixamorig:Head")
    assert rig.names[rig.parents[head]] == "mixamorig:Spine"


def test_a_racket_keeps_its_name_in_the_hand() -> None:
    body = preset("adult_male")
    racket = Part(
        name="racket",
        parent="right_hand",
        joint_m=(0.0, 0.1, 0.0),
        shape=Cylinder(end_m=0.6, radius_m=0.02),
    )
    rig = rig_of(Skeleton.of(body.replaced((*body.parts, racket))), "ue5")
    assert rig.names[-1] == "racket"
    assert rig.names[rig.parents[-1]] == "hand_r"
    assert rig.names[rig.bone_of_part[-1]] == "racket"


def test_an_unknown_rig_is_answered_with_those_there_are() -> None:
    with pytest.raises(FormatError, match="There is no rig 'biped': the rigs are keypose, mixamo"):
        rig_of(Skeleton.of(preset("adult_male")), "biped")
