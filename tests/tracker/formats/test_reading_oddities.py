"""Files of other makers that are not quite as their format has them: read, and what is odd said."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from keypose.tracker.errors import ChoiceError, FormatError
from keypose.tracker.formats.joint_motion import JointMotion
from keypose.tracker.formats.reading import load_motion
from keypose.tracker.formats.text import Note
from tests.tracker.formats.test_reading_motion import BVH, CSV, TRC

LINES = BVH.splitlines(keepends=True)
LAST = "10 90 0 90 0 0 90 0 0\n"


def _read(folder: Path, name: str, content: str | bytes) -> JointMotion:
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return load_motion(path)


def _with_commas(text: str) -> str:
    return text.replace(".", ",")


def _semicolons(text: str) -> str:
    return text.replace(",", ";").replace(".", ",")


@pytest.mark.parametrize(
    ("name", "content", "joints", "frames"),
    [
        ("a.bvh", BVH.replace("ROOT hips", "ROOT Bip01 hips").lower(), "bip01 hips", 2),
        ("a.bvh", BVH.replace("hips", "ROOT_MOTION"), "ROOT_MOTION", 2),
        ("a.bvh", BVH.replace("JOINT knee", "JOINT LOCOMOTION knee"), "LOCOMOTION knee", 2),
        ("a.bvh", BVH.replace("ROOT hips\n{", "ROOT hips {").replace("\n", "\r\n"), "hips", 2),
        ("a.bvh", BVH.replace("hips", "腰").encode("shift_jis"), "knee", 2),
        ("a.bvh", _with_commas(BVH), "knee", 2),
        ("a.bvh", BVH.replace(LAST, "").replace("Frames: 2", "Frames: 1"), "knee", 1),
        ("a.bvh", "".join(LINES[:-1]) + LAST.replace(" 0 0 90", "\n0 0 90"), "knee", 2),
        ("a.trc", TRC.replace("walk.trc", "C:/Übung/walk.trc").encode("latin-1"), "LHIP", 2),
        ("a.trc", _with_commas(TRC), "RHIP", 2),
        ("a.trc", TRC.replace("LHIP\t\t\tRHIP\t\t", "LHIP\tRHIP"), "RHIP", 2),
        ("a.csv", _semicolons(CSV), "hip", 2),
        ("a.csv", CSV.replace(",", "\t"), "hip", 2),
        ("a.csv", "sep=;\r\n" + _semicolons(CSV), "hip", 2),
        ("a.csv", CSV.encode("utf-16"), "hip", 2),
        ("a.csv", CSV.replace("time", "Time [s]"), "hip", 2),
        ("a.csv", CSV.replace("time", "t (ms)").replace("\n0.1,", "\n100,"), "hip", 2),
        ("a.csv", CSV.replace("\n0,", ",\n0,").replace(",,\n", ",,,\n"), "hip", 2),
        ("a.trc", TRC.replace("900\t5\t\t\t\n", "900\t5\t\t\t\t7\t7\t7\n"), "RHIP", 2),
    ],
    ids=lambda value: "" if isinstance(value, str | bytes) else None,
)
def test_files_of_another_country_or_maker_hold_the_same_motion(
    tmp_path: Path, name: str, content: str | bytes, joints: str, frames: int
) -> None:
    plain = {"a.bvh": BVH, "a.trc": TRC, "a.csv": CSV}[name]
    expected, found = _read(tmp_path, name, plain), _read(tmp_path, name, content)
    assert joints in found.names
    assert len(found) == frames
    assert np.allclose(found.ps_world_joint, expected.ps_world_joint[:frames], equal_nan=True)
    assert np.allclose(found.times_s, expected.times_s[:frames])
    assert not found.notes


@pytest.mark.parametrize(
    ("name", "content", "frames", "note"),
    [
        ("a.bvh", BVH.replace("Frames: 2", "Frames: 3"), 2, Note("row count", ("3", 2))),
        ("a.bvh", BVH.replace("Frames: 2", "Frames: 1"), 2, Note("row count", ("1", 2))),
        ("a.bvh", BVH.replace("Frames: 2", "Frames: 999999999"), 2, None),
        ("a.bvh", BVH.replace("Frames: 2", "Frames: 3") + "1 2 3\n", 2, None),
        ("a.bvh", BVH[:-7], 1, Note("row count", ("2", 1))),
        ("a.trc", TRC.replace("50\t50\t2\t2", "50\t50\t900\t2"), 2, Note("row count", ("900", 2))),
        ("a.trc", TRC.replace("50\t50\t2\t2", "50\t50\t2\t9"), 2, Note("marker count", ("9", 2))),
    ],
    ids=lambda value: "" if isinstance(value, str) else None,
)
def test_rows_that_are_there_are_read_whatever_the_header_counts(
    tmp_path: Path, name: str, content: str, frames: int, note: Note | None
) -> None:
    found = _read(tmp_path, name, content)
    assert len(found) == frames
    assert [one.oddity for one in found.notes] == ["row count" if note is None else note.oddity]
    assert note is None or found.notes == (note,)


def test_an_end_site_without_length_is_no_joint(tmp_path: Path) -> None:
    assert "knee_end" in _read(tmp_path, "a.bvh", BVH).names
    assert "knee_end" not in _read(tmp_path, "a.bvh", BVH.replace("0 -30 0", "0 0 0")).names


def test_the_pose_at_rest_is_that_of_the_offsets_also_where_joints_have_places(
    tmp_path: Path,
) -> None:
    placed = BVH.replace(
        "CHANNELS 3 Xrotation", "CHANNELS 6 Xposition Yposition Zposition Xrotation"
    ).replace("90 0 0\n", "0 -40 0 90 0 0\n").replace("0 0 0\n10", "0 -40 0 0 0 0\n10")  # fmt: skip
    for text in (BVH, placed):
        rest = _read(tmp_path, "a.bvh", text).rest_m
        assert rest is not None
        assert np.allclose(rest[:, 1], [0.0, -0.4, -0.7])


@pytest.mark.parametrize("numbered", ["", "fnum", "frame"])
def test_a_table_without_times_has_a_row_for_each_frame_or_a_rate(
    tmp_path: Path, numbered: str
) -> None:
    head = "body_hip_x,body_hip_y,body_hip_z,body_hip_error" + f",{numbered}" * bool(numbered)
    rows = [f"1,2,{n},0.5" + f",{2 * n}" * bool(numbered) for n in range(3)]
    motion = _read(tmp_path, "a.csv", "\n".join([head, *rows]))
    frames = np.arange(3.0) * (2 if numbered else 1)
    assert motion.is_per_frame
    assert np.array_equal(motion.at_rate(50.0).times_s, frames / 50)
    there = motion.on_video("a.csv", np.arange(9) / 25)
    assert np.array_equal(there.times_s, frames / 25)
    assert there.notes == (Note("row per frame"),)
    with pytest.raises(FormatError, match="give the rows' rate"):
        motion.on_video("a.csv", np.arange(2) / 25)


def test_labels_of_many_points_go_on_in_further_parameters(tmp_path: Path) -> None:
    motion = load_motion(_c3d(tmp_path, [f"M{n:03}" for n in range(300)]))
    assert motion.names == tuple(f"M{n:03}" for n in range(300))


def test_points_without_a_label_and_labels_again_are_left_out(tmp_path: Path) -> None:
    every = load_motion(_c3d(tmp_path, ["w", "a", "b", "z"]))
    motion = load_motion(_c3d(tmp_path, ["", "a", "b", "a"]))
    assert motion.names == ("a", "b")
    assert np.array_equal(motion.ps_world_joint, every.ps_world_joint[:, 1:3])
    with pytest.raises(FormatError, match="no labels"):
        load_motion(_c3d(tmp_path, ["", ""]))


def test_of_several_subjects_one_is_asked_for(tmp_path: Path) -> None:
    joints = ("LSHO", "LELB", "LKNE", "LANK")
    path = _c3d(tmp_path, [f"{who}:{joint}" for who in ("Ann", "Bob") for joint in joints])
    motion = load_motion(path)
    with pytest.raises(ChoiceError, match="2 individuals, Ann and Bob") as asked:
        motion.of_individual(path.name, None)
    assert asked.value.choices == ("Ann", "Bob")
    bob = motion.of_individual(path.name, "Bob")
    assert bob.names == tuple(f"Bob:{joint}" for joint in joints)
    assert np.array_equal(bob.ps_world_joint, motion.ps_world_joint[:, 4:])
    alone = load_motion(_c3d(tmp_path, list(joints)))
    with pytest.raises(FormatError, match="does not tell individuals apart"):
        alone.of_individual(path.name, "Bob")


def test_a_joint_lies_between_the_markers_on_either_side_of_it(tmp_path: Path) -> None:
    motion = load_motion(_c3d(tmp_path, ["Ann:LWRA", "Ann:LWRB", "Ann:LELB"]))
    assert motion.names[-1] == "Ann:LWRA+LWRB"
    middle = motion.ps_world_joint[:, :2].mean(axis=1)
    assert np.allclose(motion.ps_world_joint[:, -1], middle)


def test_our_own_arrays_are_read_in_the_cameras_frame_at_the_films_times(tmp_path: Path) -> None:
    ps, times_s = np.arange(12.0).reshape(2, 2, 3), np.array([0.4, 0.5])
    arrays: dict[str, Any] = {"names": ["a", "b"], "ps_camera_joint": ps, "time_s": times_s}
    np.savez(tmp_path / "a.npz", **arrays)
    motion = load_motion(tmp_path / "a.npz")
    assert (motion.names, motion.world, motion.unit) == (("a", "b"), "camera", "m")
    assert np.array_equal(motion.ps_world_joint, ps)
    assert np.array_equal(motion.times_s, times_s)
    np.savez(tmp_path / "a.npz", **(arrays | {"time_s": times_s[:1]}))
    with pytest.raises(FormatError, match="not a place for each name"):
        load_motion(tmp_path / "a.npz")


def _c3d(folder: Path, names: list[str]) -> Path:
    """A file of points of two frames."""
    ezc3d = pytest.importorskip("ezc3d")
    file = ezc3d.c3d()
    point = file["parameters"]["POINT"]
    point["RATE"]["value"], point["UNITS"]["value"] = [50.0], ["mm"]
    point["LABELS"]["value"] = names
    places = np.ones((4, len(names), 2))
    places[:3] = np.random.default_rng(0).normal(size=(3, len(names), 2))
    file["data"]["points"] = places
    path = folder / "points.c3d"
    file.write(str(path))
    return path
