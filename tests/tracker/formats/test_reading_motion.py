"""Recorded motion in: what other programs wrote is read as they meant it, the rest is refused."""

from __future__ import annotations

import warnings
from pathlib import Path

import ezc3d
import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.body.pose import joint_names
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import FormatError
from keypose.tracker.formats import reading_bvh
from keypose.tracker.formats.csv import joints_csv
from keypose.tracker.formats.joint_motion import JointMotion
from keypose.tracker.formats.reading import load_motion
from tests.tracker.formats import recordings
from tests.tracker.formats.recordings import bvh_of

with warnings.catch_warnings():  # it imports a library by a name that is going out of use
    warnings.simplefilter("ignore", PendingDeprecationWarning)
    import bvhio

MOCAP = Path(__file__).parents[3].parent / "shared/data/mocap"
SKELETON = Skeleton.of(recordings.session("person").subject.body)
TRUTH = recordings.trajectory("person")

BVH = """HIERARCHY
ROOT hips
{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Yrotation Xrotation Zrotation
  JOINT knee
  {
    OFFSET 0 -40 0
    CHANNELS 3 Xrotation Yrotation Zrotation
    End Site
    {
      OFFSET 0 -30 0
    }
  }
}
MOTION
Frames: 2
Frame Time: 0.04
10 90 0 0 0 0 0 0 0
10 90 0 90 0 0 90 0 0
"""


def nested(count: int) -> str:
    """A BVH file of joints of one name, each inside the one before it."""
    joints = "".join(f"{'JOINT' if i else 'ROOT'} a {{ OFFSET 0 0 0\n" for i in range(count))
    end = "} " * count
    return f"HIERARCHY\n{joints}{end}\nMOTION\nFrames: 1\nFrame Time: 0.1\n\n"


TRC = (
    "PathFileType\t4\t(X/Y/Z)\twalk.trc\n"
    "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames\n"
    "50\t50\t2\t2\tmm\t50\t1\t2\n"
    "Frame#\tTime\tLHIP\t\t\tRHIP\t\t\n"
    "\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n"
    "\n"
    "1\t0.00\t100\t900\t0\t-100\t900\t0\n"
    "2\t0.02\t110\t900\t5\t\t\t\n"
)

CSV = "time,hip_x,hip_y,hip_z,knee_x,knee_y,knee_z\n0,0,1,0,0,0.5,0\n0.1,0,1,0.1,,,\n"


def _read(folder: Path, name: str, content: str | bytes) -> JointMotion:
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return load_motion(path)


def _refusal(folder: Path, name: str, content: str | bytes) -> str:
    with pytest.raises(FormatError) as refused:
        _read(folder, name, content)
    sentence = str(refused.value)
    assert sentence.endswith(".")
    assert "\n" not in sentence
    return sentence


def test_bvh_turns_joints_in_the_order_of_their_channels(tmp_path: Path) -> None:
    motion = _read(tmp_path, "a.bvh", BVH)
    assert motion.names == ("hips", "knee", "knee_end")
    assert np.allclose(motion.times_s, [0, 0.04])
    assert np.allclose(motion.ps_world_joint[0], [[0.1, 0.9, 0], [0.1, 0.5, 0], [0.1, 0.2, 0]])
    # the knee bends about x, which the hips have turned to −z: the shin points along −x
    assert np.allclose(motion.ps_world_joint[1, 2], [0.1 - 0.3, 0.5, 0.0])
    assert (motion.unit, motion.assumed, motion.world) == (None, "cm", "y up")


def test_bvh_of_ours_is_read_as_an_independent_reader_reads_it(tmp_path: Path) -> None:
    text = bvh_of(SKELETON, TRUTH, 1 / 30)
    motion = _read(tmp_path, "ours.bvh", text)
    root = bvhio.readAsHierarchy(str(tmp_path / "ours.bvh"))
    for frame in (0, 31, 72):
        root.loadPose(frame)
        for joint, _, _ in root.layout():
            theirs = np.array(list(joint.PositionWorld)) / 100
            ours = motion.ps_world_joint[frame, motion.names.index(joint.Name)]
            assert np.allclose(ours, theirs, atol=1e-5)


@pytest.mark.skipif(not MOCAP.is_dir(), reason="the recorded motions are not here")
def test_bvh_of_a_motion_library_has_its_joints_where_they_were() -> None:
    motion = load_motion(MOCAP / "pirouette.bvh")
    with np.load(MOCAP / "pirouette.npz") as known:
        assert motion.names == tuple(str(name) for name in known["names"])
        # the reference leaves out the first frame and then every other one
        assert np.abs(motion.ps_world_joint[2::2][:295] - known["xyz"]).max() < 1e-5


def test_our_own_table_comes_back_in_the_camera_frame(tmp_path: Path) -> None:
    text = joints_csv(SKELETON, TRUTH, np.arange(len(TRUTH)) / 30)
    motion = _read(tmp_path, "joints.csv", text)
    assert (motion.world, motion.unit) == ("camera", "m")
    assert motion.names == joint_names(SKELETON)
    assert np.abs(motion.ps_world_joint - TRUTH.joints(SKELETON)).max() < 1e-6


def test_a_wide_table_has_gaps_where_nothing_is_written(tmp_path: Path) -> None:
    motion = _read(tmp_path, "wide.csv", CSV)
    assert motion.names == ("hip", "knee")
    assert (motion.world, motion.unit) == ("y up", None)
    assert np.isnan(motion.ps_world_joint[1, 1]).all()
    assert np.allclose(motion.ps_world_joint[1, 0], [0, 1, 0.1])


def test_trc_honours_its_unit_and_its_gaps(tmp_path: Path) -> None:
    motion = _read(tmp_path, "walk.trc", TRC)
    assert motion.unit == "mm"
    assert np.allclose(motion.ps_world_joint[0], [[0.1, 0.9, 0], [-0.1, 0.9, 0]])
    assert np.isnan(motion.ps_world_joint[1, 1]).all()
    assert np.allclose(motion.times_s, [0, 0.02])


def test_c3d_is_read_with_its_unit_its_up_and_what_was_not_seen(tmp_path: Path) -> None:
    ps = np.random.default_rng(3).normal(size=(3, 4, 5)) * 500
    file = ezc3d.c3d()
    file["parameters"]["POINT"]["RATE"]["value"] = [100]
    file["parameters"]["POINT"]["UNITS"]["value"] = ["mm"]
    file["parameters"]["POINT"]["LABELS"]["value"] = ["LASI", "RASI", "LKNE", "RKNE"]
    file["data"]["points"] = np.concatenate([ps, np.ones((1, 4, 5))])
    residuals = np.zeros((1, 4, 5))
    residuals[0, 2, 1] = -1
    file["data"]["meta_points"]["residuals"] = residuals
    file["data"]["meta_points"]["camera_masks"] = np.zeros((7, 4, 5), dtype=bool)
    file.write(str(tmp_path / "a.c3d"))
    motion = load_motion(tmp_path / "a.c3d")
    assert motion.names == ("LASI", "RASI", "LKNE", "RKNE")
    assert (motion.unit, motion.world) == ("mm", "z up")
    assert np.isnan(motion.ps_world_joint[1, 2]).all()
    expected = np.moveaxis(ps, 0, -1).swapaxes(0, 1) / 1000
    expected[1, 2] = np.nan
    assert np.allclose(motion.ps_world_joint, expected, atol=1e-6, equal_nan=True)
    assert np.allclose(np.diff(motion.times_s), 0.01)


def test_joints_of_one_name_are_told_apart_without_trying_every_name_for_each(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lookups = 0

    class Counting(set[str]):
        def __contains__(self, name: object) -> bool:
            nonlocal lookups
            lookups += 1
            return super().__contains__(name)

    monkeypatch.setattr(reading_bvh, "set", Counting, raising=False)
    (tmp_path / "a.bvh").write_text(nested(1000))
    motion = load_motion(tmp_path / "a.bvh")
    assert motion.names[:3] == ("a", "a_", "a__")
    assert len(set(motion.names)) == 1000
    assert lookups <= 2000


def test_positions_between_frames_lie_on_straight_lines_and_outside_there_are_none() -> None:
    ps: NDArray[np.float64] = np.arange(4.0)[:, None, None] * np.ones((4, 1, 3))
    ps[3] = np.nan
    motion = JointMotion(("a",), ps, np.arange(4) / 10, "y up", "m")
    there = motion.at(np.array([-0.1, 0.0, 0.05, 0.2, 0.25, 0.3, 0.4]))[:, 0, 0]
    assert np.allclose(there, [np.nan, 0, 0.5, 2, np.nan, np.nan, np.nan], equal_nan=True)


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("a.bvh", BVH.replace("MOTION", ""), "MOTION"),
        ("a.bvh", BVH.replace("10 90 0 90", "10 nan 0 90"), "finite"),
        ("a.bvh", BVH.replace("10 90 0 90", "10 x 0 90"), "numbers"),
        ("a.bvh", BVH.replace("Zrotation\n  JOINT", "Wrotation\n  JOINT"), "damaged"),
        ("a.bvh", BVH.replace("}\n}\nMOTION", "}\nMOTION"), "does not end"),
        ("a.bvh", BVH.replace("Frame Time: 0.04", "Frame Time: 0"), "0 s apart"),
        ("a.bvh", BVH.replace("10 90 0 90", "10 90 0 90 1"), "one of "),
        ("a.bvh", nested(2001), "more than 2000 joints"),
        ("a.bvh", BVH.replace("hips", "h" * 5001), "longer than 5000"),
        ("a.bvh", BVH.replace("CHANNELS 6", "CHANNELS 999999999"), "more than 12 channels"),
        ("a.bvh", BVH.replace("OFFSET 0 0 0\n", "OFFSET 0 0 0\n" * 310_000), "too much"),
        ("a.bvh", b"\xff\xfe\x00HIERARCHY", "HIERARCHY"),
        ("a.bvh", "", "HIERARCHY"),
        ("a.trc", TRC.replace("mm", "ell"), "unit"),
        ("a.trc", TRC.replace("-100", "left"), "numbers"),
        ("a.trc", TRC + "3\t0.01\t1\t1\t1\t1\t1\t1\n", "ascend"),
        ("a.trc", "nothing", "PathFileType"),
        ("a.csv", CSV.replace("knee_x", "hip_x"), "twice"),
        ("a.csv", CSV + "0.2,1\n", "row 4"),
        ("a.csv", CSV + "0.05,1,1,1,1,1,1\n", "ascend"),
        ("a.csv", CSV.replace("0.5", "half"), "half"),
        ("a.csv", "time,a_x,a_y,a_z\n0,,,\n1,,,\n", "no position"),
        ("a.csv", "", "empty"),
        ("a.csv", "time,a_x_m,a_y_cm,a_z_m\n0,1,1,1\n", "units"),
        ("a.c3d", b"\x02\x50" + b"\x00" * 600, "c3d"),
        ("a.c3d", b"\x00" * 600, "begin"),
        ("a.fbx", b"Kaydara", "expected"),
    ],
)
def test_what_is_wrong_with_a_file_is_said_in_one_sentence(
    tmp_path: Path, name: str, content: str | bytes, words: str
) -> None:
    assert words in _refusal(tmp_path, name, content)


def test_a_missing_file_and_a_folder_are_told_apart(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match="no motion file"):
        load_motion(tmp_path / "none.bvh")
    with pytest.raises(FormatError, match="is a folder"):
        load_motion(tmp_path)
