"""Several bodies in files: together in one, or a file each, in one world under their own names."""

from __future__ import annotations

import csv
import io
import shutil
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path

import ezc3d
import numpy as np
import pytest
from pxr import Usd, UsdSkel

from keypose.app.cli.main import main
from keypose.app.export.motion_files import file_of_body, files_of_bodies, unknown_errors_words
from keypose.app.export.motion_formats import FORMATS
from keypose.app.orders.motion import MotionOrder
from keypose.tracker.body.body import preset
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.errors import FormatError
from keypose.tracker.formats.conventions import column_names
from keypose.tracker.formats.reading import load_motion
from keypose.tracker.formats.recording import Recording, on_one_ground
from keypose.tracker.formats.rigs import OWN
from keypose.tracker.formats.rigs.rig import rig_of
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.storage.files import load_session, save_session
from tests.app.bodies_cases import two_tracked
from tests.tracker.formats import recordings
from tests.tracker.formats.glb_reading import Player

ASIDE_M = (0.7, 0.3, 0.4)
TOGETHER = MotionOrder(together=True)
WITHIN_M = 1e-4


@cache
def bodies() -> tuple[Recording, ...]:
    """Two people of the same parts, the second lower and tracked at frames 10 to 50 alone, and a
    box."""
    motion = recordings.trajectory("person")
    skeleton = Skeleton.of(recordings.session("person").subject.body)
    moved = motion.ps_camera_root + np.array(ASIDE_M)
    box = Skeleton.of(preset("box"))
    Rs = motion.Rs_parent_part[:, :1]
    made = {
        "ann": (skeleton, motion),
        "bob": (skeleton, Trajectory(0, motion.Rs_parent_part, moved)),
        "crate": (box, Trajectory(0, Rs, motion.ps_camera_root - np.array(ASIDE_M))),
    }
    each = [replace(recordings.recorded(*body, 30.0), body_id=name) for name, body in made.items()]
    each[1] = untracked_outside(each[1], 10, 50)
    return tuple(on_one_ground(each))


def untracked_outside(made: Recording, first: int, last: int) -> Recording:
    Rs, ps = made.tracks.Rs_parent_part.copy(), made.tracks.ps_camera_root.copy()
    for values in (Rs, ps):
        values[:first] = values[last + 1 :] = np.nan
    return replace(made, tracks=replace(made.tracks, Rs_parent_part=Rs, ps_camera_root=ps))


def joints(body: Recording) -> dict[str, Array]:
    """Where its joints are in the world by our own forward kinematics, (N, 3) by name."""
    places = body.world.points(body.ps_camera_joint)
    return dict(zip(column_names(body.skeleton), np.moveaxis(places, 1, 0), strict=True))


def files(name: str, order: MotionOrder = TOGETHER) -> dict[str, bytes]:
    return files_of_bodies(name, bodies(), order)[0]


def test_all_bodies_stand_in_one_world_whose_floor_is_under_the_lowest() -> None:
    ann, bob, crate = bodies()
    np.testing.assert_array_equal(ann.T_world_camera, bob.T_world_camera)
    np.testing.assert_array_equal(ann.T_world_camera, crate.T_world_camera)
    apart = joints(bob)["head"][20] - joints(ann)["head"][20]
    assert np.linalg.norm(apart) == pytest.approx(np.linalg.norm(ASIDE_M))
    lowest = {body.body_id: joints(body)["left_heel"][20, 1] for body in (ann, bob)}
    assert 0.2 < lowest["ann"] - lowest["bob"] < 0.4
    assert lowest["bob"] == pytest.approx(0.0, abs=0.1)


@pytest.mark.parametrize("order", [MotionOrder(), TOGETHER])
def test_a_glb_has_a_rig_for_each_body_and_no_two_nodes_of_one_name(order: MotionOrder) -> None:
    content = files("glb", order)
    assert list(content) == ["motion.glb"]
    gltf = Player.of(content["motion.glb"]).gltf
    names = [node.name for node in gltf.nodes]
    assert len(set(names)) == len(names)
    assert {"ann", "bob", "crate", "ann:left_hand", "bob:left_hand", "camera"} <= set(names)
    for skin, body in zip(gltf.skins, bodies(), strict=True):
        of_skin = [gltf.nodes[joint].name for joint in skin.joints]
        bones = rig_of(body.skeleton, OWN).names
        assert of_skin == [f"{body.body_id}:{name}" for name in bones]
        assert gltf.nodes[skin.skeleton].name == of_skin[0]
    assert [mesh.name for mesh in gltf.meshes] == ["ann", "bob", "crate"]


def test_every_body_of_a_glb_moves_at_its_own_frames() -> None:
    player = Player.of(files("glb")["motion.glb"])
    (animation,) = player.gltf.animations
    clocks = {
        player.gltf.nodes[channel.target.node].name: player.array(
            animation.samplers[channel.sampler].input
        )[:, 0]
        for channel in animation.channels
    }
    np.testing.assert_allclose(clocks["bob:left_hand"][[0, -1]] * 30, [10, 50], atol=1e-4)
    np.testing.assert_allclose(clocks["ann:left_hand"][[0, -1]] * 30, [0, 72], atol=1e-4)


def test_bodies_of_a_glb_are_where_they_are_here() -> None:
    ann, _, crate = bodies()
    pair, _ = files_of_bodies("glb", (ann, crate), MotionOrder())
    player = Player.of(pair["motion.glb"])
    at = player.places(player.times_s)
    for body in (ann, crate):
        for name in body.skeleton.body.names:
            np.testing.assert_allclose(
                at[f"{body.body_id}:{name}"], joints(body)[name], atol=WITHIN_M
            )


def test_each_body_of_a_usd_stage_is_a_skeleton_of_its_own_below_one_prim(tmp_path: Path) -> None:
    (tmp_path / "motion.usd").write_bytes(files("usd")["motion.usd"])
    stage = Usd.Stage.Open(str(tmp_path / "motion.usd"))
    prims = stage.GetDefaultPrim().GetChildren()
    assert [prim.GetName() for prim in prims] == ["ann", "bob", "crate"]
    for prim, body in zip(prims, bodies(), strict=True):
        kept, skeleton = UsdSkel.Cache(), UsdSkel.Skeleton(prim.GetChild("Skeleton"))
        kept.Populate(UsdSkel.Root(prim), Usd.PrimDefaultPredicate)
        Ts = kept.GetSkelQuery(skeleton).ComputeJointSkelTransforms(Usd.TimeCode(30))
        names = skeleton.GetJointNamesAttr().Get()
        assert set(body.skeleton.body.names) <= set(names)
        for name, T in zip(names, Ts, strict=True):
            np.testing.assert_allclose(np.array(T)[3, :3], joints(body)[name][30], atol=WITHIN_M)


@pytest.mark.parametrize(
    ("name", "file"), [("trc", "motion.trc"), ("c3d", "motion.c3d"), ("csv", "joints.csv")]
)
def test_each_body_is_read_back_from_a_file_of_all_by_its_name(
    name: str, file: str, tmp_path: Path
) -> None:
    (tmp_path / file).write_bytes(files(name)[file])
    motion = load_motion(tmp_path / file)
    for body in bodies()[:2]:
        own = motion.of_individual(file, body.body_id)
        places = dict(zip(own.names, np.moveaxis(own.ps_world_joint, 1, 0), strict=True))
        for joint in ("left_hand", "head", "right_foot"):
            place = column_names(body.skeleton).index(joint)
            expected = body.ps_camera_joint[:, place] if name == "csv" else joints(body)[joint]
            found = places[f"{body.body_id}:{joint}"]
            np.testing.assert_allclose(found, expected, atol=WITHIN_M)


def test_a_c3d_of_several_names_its_subjects_as_vicon_does(tmp_path: Path) -> None:
    (tmp_path / "motion.c3d").write_bytes(files("c3d")["motion.c3d"])
    parameters = ezc3d.c3d(str(tmp_path / "motion.c3d"))["parameters"]
    assert parameters["SUBJECTS"]["NAMES"]["value"] == ["ann", "bob", "crate"]
    assert parameters["SUBJECTS"]["LABEL_PREFIXES"]["value"] == ["ann:", "bob:", "crate:"]
    assert parameters["SUBJECTS"]["USES_PREFIXES"]["value"][0] == 1
    labels = parameters["POINT"]["LABELS"]["value"]
    assert len(set(labels)) == len(labels)


def test_an_archive_of_several_has_each_body_under_its_name() -> None:
    with np.load(io.BytesIO(files("npz")["motion.npz"])) as arrays:
        assert arrays["bodies"].tolist() == ["ann", "bob", "crate"]
        for body in bodies():
            np.testing.assert_array_equal(
                arrays[f"{body.body_id}/ps_camera_joint"], body.ps_camera_joint
            )


@pytest.mark.parametrize("name", ["joints.csv", "angles.csv", "frames.csv"])
def test_tables_of_several_have_no_two_columns_of_one_name(name: str) -> None:
    head, *rows = csv.reader(io.StringIO(files("csv")[name].decode(), newline=""))
    assert len(set(head)) == len(head)
    assert head[:2] == ["frame", "time_s"]
    assert len(rows) == len(bodies()[0])
    assert {column.partition(":")[0] for column in head[2:]} == {"ann", "bob", "crate"}


NAMES: Mapping[str, list[str]] = {
    "bvh": ["ann.bvh", "bob.bvh", "crate.bvh"],
    "trc": ["ann.trc", "bob.trc", "crate.trc"],
    "npz": ["ann.npz", "bob.npz", "crate.npz"],
    "fbx": ["motion.glb", "motion_to_fbx.py"],
    "usd": ["motion.usd"],
    "chan": ["motion_camera.chan"],
    "amass": ["ann_poses.npz", "bob_poses.npz"],
}


@pytest.mark.parametrize(("name", "written"), NAMES.items())
def test_other_formats_have_a_file_for_each_body(name: str, written: list[str]) -> None:
    assert list(files(name, MotionOrder())) == written


def test_no_two_files_of_two_bodies_have_one_name() -> None:
    names = [file for kind in FORMATS.values() for file in (*kind.names, *kind.also)]
    of_bodies = [file_of_body(name, body) for name in set(names) for body in ("ann", "bob")]
    assert len(set(of_bodies)) == len(of_bodies)


def test_a_file_of_one_body_has_the_places_of_the_file_of_all(tmp_path: Path) -> None:
    alone = files("trc", MotionOrder())
    for place, content in {**alone, **files("trc")}.items():
        (tmp_path / place).write_bytes(content)
    together = load_motion(tmp_path / "motion.trc").of_individual("", "bob")
    own = load_motion(tmp_path / "bob.trc")
    assert b"bob.trc" in alone["bob.trc"].splitlines()[0]
    np.testing.assert_array_equal(own.ps_world_joint, together.ps_world_joint)


def test_a_body_that_a_format_cannot_hold_is_said_and_the_rest_is_written() -> None:
    _, refused = files_of_bodies("amass", bodies(), MotionOrder())
    assert len(refused) == 1
    assert refused[0].startswith("AMASS of crate: ")
    with pytest.raises(FormatError, match="of crate"):
        files_of_bodies("amass", bodies()[2:] * 2, MotionOrder())


@pytest.mark.parametrize(
    ("with_errors", "words"),
    [
        (("ann", "bob"), None),
        (("ann",), "bob-errors.mot was not written: expected errors are not known there"),
        ((), None),
    ],
)
def test_expected_errors_that_one_body_lacks_and_another_has_are_said(
    with_errors: tuple[str, ...], words: str | None
) -> None:
    written = ["ann.mot", "bob.mot", *(f"{name}-errors.mot" for name in with_errors)]
    told = unknown_errors_words("mot", written, ("ann", "bob"))
    assert told is None if words is None else words in str(told)


def test_a_scene_has_all_bodies_but_one_with_a_gap_which_is_said() -> None:
    ann, bob, crate = bodies()
    gap = ann.tracks.ps_camera_root.copy()
    gap[20:25] = np.nan
    with_gap = replace(ann, tracks=replace(ann.tracks, ps_camera_root=gap))
    content, refused = files_of_bodies("glb", (with_gap, bob, crate), MotionOrder())
    assert refused[0].startswith("GLB of ann: Frames 20 to 24 are not tracked")
    meshes = Player.of(content["motion.glb"]).gltf.meshes
    assert [mesh.name for mesh in meshes] == ["bob", "crate"]


def test_a_vrm_animation_of_several_bodies_is_refused() -> None:
    with pytest.raises(FormatError, match="one body: choose it with --body"):
        files_of_bodies("glb", bodies()[:2], MotionOrder(rig="vrm"))


@pytest.mark.parametrize(
    "order", [MotionOrder(fps=24, together=True), MotionOrder(frames=(5, 40), together=True)]
)
def test_a_rate_and_a_range_of_frames_are_those_of_all_bodies(
    order: MotionOrder, tmp_path: Path
) -> None:
    (tmp_path / "motion.trc").write_bytes(files("trc", order)["motion.trc"])
    motion = load_motion(tmp_path / "motion.trc")
    both = [motion.of_individual("", name).ps_world_joint for name in ("ann", "bob")]
    known = np.isfinite(both[1]).all(axis=(1, 2))
    apart = np.linalg.norm(both[1][known] - both[0][known], axis=-1)
    np.testing.assert_allclose(apart, np.linalg.norm(ASIDE_M), atol=1e-3)


# --- the command line


@pytest.fixture(scope="module")
def tracked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return two_tracked(tmp_path_factory.mktemp("two"))


@pytest.fixture
def path(tracked: Path, tmp_path: Path) -> Path:
    shutil.copytree(tracked.parent, tmp_path / "box")
    return tmp_path / "box" / "session.json"


def exported(path: Path, *words: str) -> dict[str, bytes]:
    out = path.parent.parent / "out"
    shutil.rmtree(out, ignore_errors=True)
    assert main(["export", str(path), "--out", str(out), *words]) == 0
    return {file.name: file.read_bytes() for file in out.iterdir()}


def test_one_body_is_exported_under_its_name_in_the_world_of_all(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    every = exported(path, "--format", "trc")
    assert set(every) == {"body.trc", "second.trc"}
    alone = exported(path, "--format", "trc", "--body", "second")
    assert alone == {"second.trc": every["second.trc"]}
    capsys.readouterr()
    scripts = exported(path, "--format", "fbx", "--body", "second")
    assert b"second.glb" in scripts["second_to_fbx.py"]
    assert "--python second_to_fbx.py" in capsys.readouterr().err


def test_a_body_that_is_not_tracked_is_said_and_the_rest_is_exported(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    session = load_session(path)
    save_session(session.with_body(session.bodies[1].model_copy(update={"results": None})), path)
    assert set(exported(path, "--format", "trc,glb")) == {"body.trc", "body.glb"}
    assert "second (box) is not tracked and left out." in capsys.readouterr().err
    asked = ["export", str(path), "--format", "trc", "--out", str(path.parent / "o")]
    assert main([*asked, "--body", "second"]) == 2
    assert "not been tracked yet" in capsys.readouterr().err
    assert main([*asked, "--body", "horse"]) == 2
    assert "No body is called 'horse'" in capsys.readouterr().err


def test_together_is_refused_where_no_format_can(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = str(path.parent / "o")
    assert main(["export", str(path), "--format", "bvh", "--together", "--out", out]) == 2
    assert "All bodies in one file is for glb, fbx, usd, trc, c3d, csv and npz alone" in (
        capsys.readouterr().err
    )
    assert not Path(out).exists()
