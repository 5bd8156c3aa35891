"""Poses of SMPL-H, played with SciPy on the published tree, and read in again."""

from __future__ import annotations

import io
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from keypose.app.export.import_motion import fit_to_session
from keypose.tracker.body.body import Body, preset
from keypose.tracker.body.modify import height, with_clavicles
from keypose.tracker.body.preset_names import PEOPLE
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import FormatError
from keypose.tracker.formats.joint_names import matched
from keypose.tracker.formats.reading import load_motion
from keypose.tracker.formats.recording import Recording
from keypose.tracker.formats.smpl import JOINTS, PARENTS, amass, rest_joints, smpl_of
from keypose.tracker.geometry.rotations import Array
from tests.tracker.formats import recordings

SAMPLES = ("person", "balance", "twirl")
OURS = {
    "pelvis": "waist", "neck": "neck", "head": "head", "spine1": "chest",
    **{f"{side}_{theirs}": f"{side}_{ours}" for side in ("left", "right") for theirs, ours in (
        ("hip", "thigh"), ("knee", "shin"), ("ankle", "foot"), ("shoulder", "upper_arm"),
        ("elbow", "forearm"), ("wrist", "hand"),
    )},
}  # fmt: skip
"""What their joints are called here."""


def loaded(made: Recording) -> dict[str, Any]:
    with np.load(io.BytesIO(amass(made)), allow_pickle=False) as archive:
        return dict(archive)


def played(file: dict[str, Any]) -> Array:
    """(N, 22, 3): the tree turned joint by joint, as any player of SMPL does."""
    N, rest = len(file["poses"]), file["rest_joints"]
    local = [Rotation.from_rotvec(file["poses"][:, 3 * j : 3 * j + 3]) for j in range(len(JOINTS))]
    turned, places = [local[0]], [file["trans"]]
    for joint, parent in list(enumerate(PARENTS))[1:]:
        bone = np.tile(rest[joint] - rest[parent], (N, 1))
        places.append(places[parent] + turned[parent].apply(bone))
        turned.append(turned[parent] * local[joint])
    return np.stack(places, axis=1)


def distances(ps: Array) -> Array:
    """(N, J, J), which no choice of a world changes."""
    return np.asarray(np.linalg.norm(ps[:, :, None] - ps[:, None], axis=-1))


@pytest.mark.parametrize("name", SAMPLES)
def test_the_tree_puts_every_joint_where_the_body_has_it(name: str) -> None:
    made = recordings.recording(name)
    ps = played(loaded(made))[:, [JOINTS.index(theirs) for theirs in OURS]]
    names = made.skeleton.body.names
    ours = made.trajectory.joints(made.skeleton)[:, [names.index(o) for o in OURS.values()]]
    np.testing.assert_allclose(distances(ps), distances(ours), atol=1e-9)
    # and it is no mirror image: left, up and forward of the pelvis make a right hand
    assert np.linalg.det(_onto(ps[0], ours[0])) == pytest.approx(1.0)


def _onto(theirs: Array, ours: Array) -> Array:
    """The orthogonal matrix (3, 3) that turns one set of points into the other; det −1 mirrors."""
    u, _, vt = np.linalg.svd((theirs - theirs.mean(0)).T @ (ours - ours.mean(0)))
    return np.asarray(u @ vt)


def test_the_archive_has_the_fields_of_amass() -> None:
    made = recordings.recording("person")
    file = loaded(made)
    assert file["poses"].shape == (len(made), 156)
    assert file["trans"].shape == (len(made), 3)
    assert float(file["mocap_framerate"]) == pytest.approx(made.frames_per_second)
    assert str(file["gender"]) == "neutral"
    assert not file["betas"].any()
    assert not file["poses"][:, 66:].any()


def test_the_world_is_z_up_and_the_body_stands_on_its_floor() -> None:
    file = loaded(recordings.recording("person"))
    ps = played(file)
    head, feet = ps[:, JOINTS.index("head"), 2], ps[:, [10, 11], 2]
    assert (head > 1.3).all()
    assert -0.02 < feet.min() < 0.1
    assert (feet < 0.5).all()


def test_a_floor_that_is_set_is_where_z_is_zero() -> None:
    made = recordings.recording("person")
    at_floor = replace(made, floor_m=-1.0)
    lower = replace(made, floor_m=-2.0)
    apart = loaded(lower)["trans"] - loaded(at_floor)["trans"]
    np.testing.assert_allclose(apart, np.tile([0, 0, 1.0], (len(made), 1)), atol=1e-12)


@pytest.mark.parametrize(
    "up", [(0.0, -1.0, 0.0), (0.3, -0.9, 0.2), (1.0, 0.0, 0.0), (0.0, 0.0, -1.0)]
)
def test_whatever_is_up_the_world_is_level_and_right_handed(up: tuple[float, ...]) -> None:
    up_camera = np.array(up) / np.linalg.norm(up)
    made = replace(recordings.recording("person"), up_camera=up_camera, floor_m=0.0)
    ps = played(loaded(made))
    ours = made.ps_camera_joint[:, made.skeleton.body.names.index("head")]
    np.testing.assert_allclose(ps[:, JOINTS.index("head"), 2], ours @ up_camera, atol=1e-9)


def test_at_rest_no_joint_turns_but_the_arms() -> None:
    made = recordings.at_rest(recordings.recording("person"))
    poses = loaded(made)["poses"].reshape(len(made), -1, 3)
    turned = {JOINTS[j] for j in np.flatnonzero(np.abs(poses[0]).max(axis=1) > 1e-9)}
    assert turned == {"pelvis", "left_shoulder", "right_shoulder"}
    down = poses[0, [JOINTS.index("left_shoulder"), JOINTS.index("right_shoulder")]]
    np.testing.assert_allclose(down, np.array([[0, 0, -1], [0, 0, 1]]) * np.pi / 2, atol=1e-9)


@pytest.mark.parametrize("name", PEOPLE)
def test_every_preset_rests_as_a_t_that_looks_along_z(name: str) -> None:
    rest = dict(zip(JOINTS, rest_joints(smpl_of(Skeleton.of(preset(name)))), strict=True))
    size = height(preset(name)) / height(preset("adult_male"))
    for side, sign in (("left", 1.0), ("right", -1.0)):
        arm = [rest[f"{side}_{joint}"] for joint in ("shoulder", "elbow", "wrist")]
        leg = [rest[f"{side}_{joint}"] for joint in ("hip", "knee", "ankle")]
        np.testing.assert_allclose(np.ptp(arm, axis=0)[1:], 0.0, atol=1e-9)
        np.testing.assert_allclose(np.ptp(leg, axis=0)[[0, 2]], 0.0, atol=1e-9)
        assert (np.diff([sign * p[0] for p in arm]) > 0.2 * size).all()
        assert (np.diff([p[1] for p in leg]) < -0.3 * size).all()
        assert rest[f"{side}_foot"][2] > rest[f"{side}_ankle"][2] + 0.1 * size
    heights = [rest[joint][1] for joint in ("pelvis", "spine1", "spine2", "spine3", "neck", "head")]
    assert (np.diff(heights) > 0.05 * size).all()


def test_clavicles_are_its_collars() -> None:
    body = with_clavicles(preset("adult_female"))
    rig, without = smpl_of(Skeleton.of(body)), smpl_of(Skeleton.of(preset("adult_female")))
    assert rig.parts[JOINTS.index("left_collar")] == body.index("left_clavicle")
    shoulder = JOINTS.index("left_shoulder")
    np.testing.assert_allclose(
        rest_joints(rig)[shoulder], rest_joints(without)[shoulder], atol=1e-9
    )


def test_a_body_that_is_no_person_is_refused() -> None:
    with pytest.raises(FormatError, match="those of a whole person"):
        amass(recordings.recording("box"))


def _hung(body: Body, part: str, parent: str) -> Body:
    parts = [p.model_copy(update={"parent": parent}) if p.name == part else p for p in body.parts]
    return body.model_copy(update={"parts": tuple(parts)})


def test_a_body_of_another_tree_is_refused() -> None:
    odd = _hung(preset("adult_male"), "left_thigh", "chest")
    words = "the left thigh hangs on the waist, and in this body it does not"
    with pytest.raises(FormatError, match=words):
        smpl_of(Skeleton.of(odd))


def test_a_body_without_hands_is_refused() -> None:
    whole = preset("adult_male")
    parts = tuple(part for part in whole.parts if not part.name.endswith("hand"))
    pairs = tuple(pair for pair in whole.mirror_pairs if "left_hand" not in pair)
    less = whole.model_copy(update={"parts": parts, "mirror_pairs": pairs})
    with pytest.raises(FormatError, match="this one has no left wrist and right wrist"):
        smpl_of(Skeleton.of(less))


@pytest.mark.parametrize("name", ["person", "twirl"])
def test_what_is_written_is_read_in_again(name: str, tmp_path: Path) -> None:
    made = recordings.recording(name)
    path = tmp_path / "walk_poses.npz"
    path.write_bytes(amass(made))
    motion = load_motion(path)
    assert (motion.world, motion.unit, motion.names) == ("z up", "m", JOINTS)
    np.testing.assert_allclose(motion.ps_world_joint, played(loaded(made)), atol=1e-9)
    known = matched(made.skeleton, motion.names, path.name)
    assert known.convention.startswith("SMPL")
    assert {made.skeleton.body.names[place[0][0]] for place in known.places} == set(OURS.values())


def test_it_comes_back_onto_the_keyframes_to_a_millimetre(tmp_path: Path) -> None:
    made, session = recordings.recording("person"), recordings.session("person")
    path = tmp_path / "walk_poses.npz"
    path.write_bytes(amass(made))
    times_s = np.arange(len(made)) / made.frames_per_second
    back = fit_to_session(session, load_motion(path), path.name, times_s).fit.trajectory
    limbs = [made.skeleton.body.names.index(ours) for ours in OURS.values()]
    off = back.joints(made.skeleton)[:, limbs] - made.ps_camera_joint[:, limbs]
    assert np.linalg.norm(off, axis=-1).max() < 1e-3


def _file(tmp_path: Path, **changes: Any) -> Path:
    """As AMASS has it, without our rest joints."""
    arrays: dict[str, Any] = {
        "poses": np.zeros((4, 156)), "trans": np.zeros((4, 3)),
        "mocap_framerate": np.array(120.0), "gender": np.array("female"),
    }  # fmt: skip
    path = tmp_path / "other_poses.npz"
    made = {name: value for name, value in (arrays | changes).items() if value is not None}
    np.savez_compressed(path, **made)
    return path


def test_a_file_of_somebody_elses_is_played_on_a_body_of_ours(tmp_path: Path) -> None:
    motion = load_motion(_file(tmp_path))
    rest = rest_joints(smpl_of(Skeleton.of(preset("adult_male"))))
    np.testing.assert_allclose(motion.ps_world_joint[0], rest, atol=1e-12)
    assert motion.unit is None  # so it is scaled to the session's body
    np.testing.assert_allclose(np.diff(motion.times_s), 1 / 120)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"poses": None}, "is no AMASS file"),
        ({"mocap_framerate": None}, "is no AMASS file"),
        ({"poses": np.zeros((4, 60))}, "three numbers for each of 22 joints or more"),
        ({"poses": np.full((4, 156), np.nan)}, "something else than finite numbers in its poses"),
        ({"poses": np.full((4, 156), "a")}, "something else than finite numbers in its poses"),
        ({"trans": np.zeros((3, 3))}, "a place for each pose"),
        ({"mocap_framerate": np.array(0.0)}, "its mocap_framerate should be frames a second"),
        ({"rest_joints": np.zeros((5, 3))}, "the places of 22 joints"),
        ({"poses": np.zeros((0, 156)), "trans": np.zeros((0, 3))}, "holds no frame"),
    ],
)
def test_what_is_wrong_with_a_file_is_said(
    changes: dict[str, Any], words: str, tmp_path: Path
) -> None:
    with pytest.raises(FormatError, match=words):
        load_motion(_file(tmp_path, **changes))


def test_what_is_no_archive_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "broken.npz"
    path.write_bytes(b"PK nothing of the kind")
    with pytest.raises(FormatError, match="is no NumPy archive of plain arrays"):
        load_motion(path)
