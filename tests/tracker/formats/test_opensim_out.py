"""For OpenSim: markers of a named set, joint coordinates, a model scaled to the body."""

from __future__ import annotations

import io
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import ezc3d
import numpy as np
import pandas as pd
import pytest

from keypose.tracker.body.body import preset
from keypose.tracker.body.modify import with_clavicles
from keypose.tracker.body.preset_names import PEOPLE
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.errors import FormatError
from keypose.tracker.formats.marker_files import c3d, trc
from keypose.tracker.formats.marker_sets import marked, markers_of
from keypose.tracker.formats.opensim.model import model_of, read_model, scaled
from keypose.tracker.formats.opensim.mot import coordinates, mot, mot_files
from keypose.tracker.formats.opensim.setups import ik_xml, markers_xml, scale_xml
from keypose.tracker.formats.recording import MARKER_SETS, Recording
from keypose.tracker.geometry.rotations import Array, exp_rotation
from tests.tracker.formats import recordings
from tests.tracker.formats.opensim_model import both_sides, osim
from tests.tracker.formats.test_markers_out import read_trc

HALPE = replace(recordings.recording("person"), marker_set="halpe26")
MODEL = model_of("small.osim", osim())
TORSO_ELSEWHERE = b"femur_r</socket_parent><translation>-0.1 "


def posed(body: str = "adult_female", **turns: tuple[float, float, float]) -> Recording:
    """Two frames of one pose, seen from front; parts turn by degrees about their x, y, z."""
    skeleton = Skeleton.of(preset(body))
    Rs = np.tile(np.eye(3), (2, skeleton.part_count, 1, 1))
    for part, degrees in turns.items():
        Rs[:, skeleton.body.index(part)] = exp_rotation(np.radians(degrees))
    return recordings.recorded(skeleton, Trajectory(0, Rs, np.tile([0.2, 0.1, 4.0], (2, 1))), 30.0)


def of_frame(found: dict[str, Array]) -> dict[str, float]:
    return {name: float(values[0]) for name, values in found.items()}


def read_mot(text: str) -> pd.DataFrame:
    """The table as a reader of .sto and .mot takes it: a header up to endheader, then tabs."""
    head, _, rows = text.partition("endheader\n")
    facts = dict(line.split("=") for line in head.splitlines() if "=" in line)
    table = pd.read_csv(io.StringIO(rows), sep="\t")
    assert int(facts["nRows"]) == len(table)
    assert int(facts["nColumns"]) == len(table.columns)
    assert facts["inDegrees"] == "yes"
    return table


def test_halpe26_is_written_by_the_names_of_pose2sim_on_the_ground() -> None:
    table = read_trc(trc(HALPE))
    assert table.names[:6] == ["Nose", "Head", "Neck", "LShoulder", "RShoulder", "LElbow"]
    assert len(table.names) == 22
    places = dict(zip(table.names, np.moveaxis(table.positions, 1, 0), strict=True))
    assert (places["Head"][:, 1] > places["RHip"][:, 1]).all()
    assert -0.05 < min(places[f"{side}Heel"][:, 1].min() for side in "LR") < 0.15
    ahead = (places["Nose"] - places["Head"]).mean(axis=0)
    across = (places["RHip"] - places["LHip"]).mean(axis=0)
    assert ahead[0] > 0.05
    assert across[2] > 0.1
    assert abs(across[0]) < 0.05


def test_c3d_has_the_same_markers(tmp_path: Path) -> None:
    (tmp_path / "motion.c3d").write_bytes(c3d(HALPE))
    file = ezc3d.c3d(str(tmp_path / "motion.c3d"))
    names, ps = marked(HALPE)
    assert tuple(file["parameters"]["POINT"]["LABELS"]["value"]) == names
    found = np.moveaxis(file["data"]["points"][:3], 0, -1).swapaxes(0, 1) / 1e3
    np.testing.assert_allclose(found, ps, atol=1e-5)


@pytest.mark.parametrize("body", PEOPLE)
def test_big_toes_are_inside_of_small_ones_and_hips_beside_their_middle(body: str) -> None:
    made = replace(posed(body), marker_set="halpe26")
    names, ps = marked(made)
    at = dict(zip(names, ps[0], strict=True))
    for side, sign in (("L", -1.0), ("R", 1.0)):
        assert sign * at[f"{side}SmallToe"][2] > sign * at[f"{side}BigToe"][2] > 0
        assert at[f"{side}BigToe"][0] > at[f"{side}SmallToe"][0] > at[f"{side}Heel"][0]
        assert at[f"{side}Heel"][1] == pytest.approx(0.0, abs=1e-6)
    np.testing.assert_allclose((at["LHip"] + at["RHip"]) / 2, at["Hip"], atol=1e-9)
    assert at["Hip"][2] == pytest.approx(0.0, abs=1e-9)


def test_the_body_at_rest_has_coordinates_of_zero_but_for_its_place_and_its_thumbs() -> None:
    found = of_frame(coordinates(posed()))
    turned = {name: value for name, value in found.items() if abs(value) > 1e-9}
    assert turned == pytest.approx(
        {"pro_sup_r": 90.0, "pro_sup_l": 90.0,
         "pelvis_tx": found["pelvis_tx"], "pelvis_ty": found["pelvis_ty"]}
    )  # fmt: skip
    assert 0.85 < found["pelvis_ty"] < 1.0


@pytest.mark.parametrize(
    ("turns", "expected"),
    [
        ({"right_thigh": (-50, 0, 0)}, {"hip_flexion_r": 50}),
        ({"left_thigh": (0, 0, -20)}, {"hip_adduction_l": -20}),
        ({"right_shin": (70, 0, 0)}, {"knee_angle_r": 70}),
        ({"left_forearm": (-90, 0, 0)}, {"elbow_flex_l": 90}),
        ({"left_forearm": (0, 30, 0)}, {"pro_sup_l": 120}),
        ({"right_upper_arm": (0, 0, 60)}, {"arm_add_r": -60}),
        ({"chest": (25, 0, 0)}, {"L5_S1_Flex_Ext": -25}),
        ({"chest": (0, -25, 0)}, {"L5_S1_axial_rotation": 25}),
        ({"head": (0, 0, -12)}, {"neck_bending": 12}),
        ({"waist": (15, 0, 0)}, {"pelvis_tilt": -15}),
        ({"waist": (0, 0, 6)}, {"pelvis_list": -6}),
    ],
)
def test_coordinates_have_the_signs_of_the_models(
    turns: dict[str, tuple[float, float, float]], expected: dict[str, float]
) -> None:
    found, rest = of_frame(coordinates(posed(**turns))), of_frame(coordinates(posed()))
    moved = {
        name: found[name]
        for name in found
        if abs(found[name] - rest[name]) > 1e-6 and not name.startswith("pelvis_t")
    }
    moved |= {name: found[name] for name in expected}
    assert moved == pytest.approx(expected)


@pytest.mark.parametrize("side", ["left", "right"])
def test_a_foot_turned_about_the_models_axes_has_their_angles(side: str) -> None:
    up, inward = np.array([-0.10501355, -0.17402245, 0.97912632]), np.array(
        [0.78717961, 0.60474746, -0.12094949]
    )  # fmt: skip
    R = exp_rotation(np.radians(-20) * up) @ exp_rotation(np.radians(10) * inward)
    ours = np.array([[0.0, 0.0, -1.0], [0.0, -1.0, 0.0], [-1.0, 0.0, 0.0]])
    if side == "left":
        ours = np.diag([1.0, 1.0, -1.0]) @ ours
    made = posed()
    Rs = made.tracks.Rs_parent_part.copy()
    Rs[:, made.skeleton.body.index(f"{side}_foot")] = ours.T @ R @ ours
    found = of_frame(coordinates(replace(made, tracks=replace(made.tracks, Rs_parent_part=Rs))))
    assert found[f"ankle_angle_{side[0]}"] == pytest.approx(-20, abs=1e-6)
    assert found[f"subtalar_angle_{side[0]}"] == pytest.approx(10, abs=1e-6)


def test_mot_is_the_coordinates_over_time() -> None:
    made = recordings.recording("person")
    table = read_mot(mot(made))
    found = coordinates(made)
    assert list(table.columns) == ["time", *found]
    np.testing.assert_allclose(table["time"], made.times_s, atol=1e-6)
    for name, values in found.items():
        np.testing.assert_allclose(table[name], values, atol=1e-6)
    angles = {one.joint.name: one for one in made.joint_angles}
    np.testing.assert_allclose(table["knee_angle_l"], angles["left_knee"]["flexion"], atol=1e-6)


def test_where_depth_was_lifted_a_second_file_says_how_far_off_angles_may_be() -> None:
    made = recordings.with_depth(recordings.recording("person"))
    motion, errors = (read_mot(text) for text in mot_files(made))
    assert list(motion.columns) == list(read_mot(mot(made)).columns)
    assert set(errors.columns) < set(motion.columns)
    angles = {one.joint.name: one for one in made.joint_angles}
    knee = angles["left_knee"].error_deg("flexion")
    np.testing.assert_allclose(errors["knee_angle_l"], knee, atol=1e-6)
    assert (errors.drop(columns="time") > 2).all(axis=None)
    model = set(read_mot(mot_files(made, MODEL)[1]).columns)
    assert model <= set(read_mot(mot(made, MODEL)).columns)
    assert len(mot_files(recordings.recording("person"))) == 1
    known = made.tracks.diagnostics
    assert known.expected_depth is not None
    half = known.expected_depth.copy()
    half[: len(half) // 2] = np.nan
    tracks = replace(made.tracks, diagnostics=replace(known, expected_depth=half))
    assert len(mot_files(replace(made, tracks=tracks))) == 1  # OpenSim reads no gaps


def test_the_pelvis_errors_are_those_of_the_world_that_its_angles_are_in() -> None:
    made = recordings.with_depth(posed(waist=(0, 0, 0)))
    by_body, by_camera = (
        next(each for each in made.joint_angles_in(world) if each.joint.name == "pelvis")
        for world in (made.ground, replace(made, origin="camera", kept_ground=None).world)
    )
    assert by_body.errors_deg is not None
    assert by_camera.errors_deg is not None
    assert by_body.errors_deg[0, 0] == pytest.approx(by_camera.errors_deg[0, 1], rel=0.02)
    assert by_body.errors_deg[0, 0] != pytest.approx(by_camera.errors_deg[0, 0], rel=0.02)


def test_mot_holds_no_gaps() -> None:
    with pytest.raises(FormatError, match="not tracked, and MOT holds no gaps"):
        mot(recordings.recording("person", without=(1,)))


def test_a_model_is_given_what_it_has_under_its_own_names() -> None:
    found = coordinates(posed(chest=(25, 0, 0)), MODEL)
    assert set(found) == set(MODEL.coordinates)
    assert found["lumbar_extension"][0] == pytest.approx(-25)


@pytest.mark.parametrize("body", PEOPLE)
def test_a_model_is_scaled_to_the_distances_of_our_joints(body: str) -> None:
    made = preset(body)
    factors = scaled(MODEL, made, ()).factors
    assert set(factors) == set(MODEL.bodies)
    places = both_sides()

    def length(part: str) -> float:
        return float(np.linalg.norm(made.parts[made.index(part)].joint_m))

    for limb, joint, part in (
        ("femur_r", "tibia_r", "right_shin"),
        ("tibia_l", "talus_l", "left_foot"),
        ("humerus_l", "ulna_l", "left_forearm"),
    ):
        assert np.linalg.norm(factors[limb] * places[joint][1]) == pytest.approx(length(part))
    hips = [factors["pelvis"] * places[f"femur_{s}"][1] for s in "rl"]
    wide = made.parts[made.index("left_thigh")].joint_m[0]
    assert (hips[0] - hips[1])[2] == pytest.approx(2 * wide)
    arms = factors["torso"] * places["humerus_r"][1]
    assert arms[2] == pytest.approx(made.parts[made.index("left_upper_arm")].joint_m[0])


@pytest.mark.parametrize("marker_set", MARKER_SETS)
def test_markers_are_on_the_scaled_model_where_they_are_on_the_body_at_rest(
    marker_set: str,
) -> None:
    body = preset("adult_male")
    made = replace(posed("adult_male"), marker_set=marker_set)
    names, ps = marked(made)
    sizes = scaled(MODEL, body, markers_of(body, made.marker_set))
    at, places = {"/ground": np.zeros(3)}, both_sides()
    for name, (carrier, place) in places.items():
        at[name] = at[carrier] + np.array(place) * sizes.factors.get(carrier, 1.0)
    found = {name: at[on] + place for name, (on, place) in sizes.placed.items()}
    ours, pelvis = dict(zip(names, ps[0], strict=True)), names[0 if "waist" in names else 9]
    shift = ours[pelvis] - found[pelvis]
    off = {name: float(np.linalg.norm(found[name] + shift - ours[name])) for name in names}
    arms = ("arm", "hand", "elbow", "wrist")  # the model's are bent a little in its zero pose
    for name in names:
        assert off[name] < (0.06 if any(word in name.lower() for word in arms) else 0.02), name


def test_a_part_that_models_have_not_is_left_out_and_moving_shoulders_change_nothing() -> None:
    body = with_clavicles(preset("adult_male"))
    hat = body.parts[body.index("head")].model_copy(
        update={"name": "hat", "parent": "head", "landmarks": {"brim": (0.0, 0.0, -0.1)}}
    )
    dressed = body.replaced((*body.parts, hat))
    placed = scaled(MODEL, dressed, markers_of(dressed, "keypose")).placed
    assert "brim" not in placed
    plain = preset("adult_male")
    bare = scaled(MODEL, plain, markers_of(plain, "keypose")).placed
    for name, (on, place) in bare.items():
        assert placed[name][0] == on
        np.testing.assert_allclose(placed[name][1], place, atol=1e-9)


def test_setups_name_every_body_and_marker_once() -> None:
    body = preset("adult_female")
    markers = markers_of(body, "halpe26")
    sizes = scaled(MODEL, body, markers)
    scale = ElementTree.fromstring(scale_xml(sizes, "../small.osim", "small-scaled.osim"))
    assert [e.text for e in scale.iter("segment")] == list(sizes.factors)
    assert scale.findtext("ScaleTool/GenericModelMaker/model_file") == "../small.osim"
    made = ElementTree.fromstring(markers_xml(sizes))
    assert [e.get("name") for e in made.iter("Marker")] == [m.name for m in markers]
    for marker in made.iter("Marker"):
        on, place = sizes.placed[marker.get("name", "")]
        assert marker.findtext("socket_parent_frame") == f"/bodyset/{on}"
        given = [float(word) for word in marker.findtext("location", "").split()]
        np.testing.assert_allclose(given * sizes.factors[on], place, atol=2e-6)
    ik = ElementTree.fromstring(ik_xml(["Nose"], "small-scaled.osim", (0.0, 1.5)))
    assert ik.findtext("InverseKinematicsTool/time_range") == "0.000000 1.500000"
    assert [e.get("name") for e in ik.iter("IKMarkerTask")] == ["Nose"]


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"no xml", "small.osim is not XML"),
        (b"<a/>", "is no document of OpenSim"),
        (osim(version="9" * 5000), "is no document of OpenSim"),
        (osim(version="4²000"), "is no document of OpenSim"),
        (osim(version="30000"), "is of OpenSim 3 or older: open it in OpenSim 4 and save it"),
        (osim(without="ulna_l"), "has no ulna_l: a full-body model with arms is needed"),
        (b"<!DOCTYPE a><a/>", "declares a document type"),
        (osim().replace(b"-0.1 0.08 0.0", b"-0.1 nan 0.0"), "where three numbers are due"),
        (osim().replace(b"pelvis</socket_parent><translation>-0.1 ", TORSO_ELSEWHERE), "vertebrae"),
    ],
)
def test_a_file_that_is_no_full_body_model_is_refused_in_one_sentence(
    content: bytes, words: str, tmp_path: Path
) -> None:
    (tmp_path / "small.osim").write_bytes(content)
    with pytest.raises(FormatError) as reported:
        scaled(read_model(tmp_path / "small.osim"), preset("adult_male"), ())
    assert words in str(reported.value)
    assert "\n" not in str(reported.value)
