"""References of every kind are read, and anything else is refused in one sentence."""

from __future__ import annotations

import contextlib
import io
import json
import struct
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from keypose.app.cli.main import main
from keypose.tracker.body.body import preset
from keypose.tracker.body.pose import joint_names
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.errors import FormatError
from keypose.tracker.evaluate import JointReference
from keypose.tracker.formats.reference import load_reference
from keypose.tracker.storage.archive import archive_arrays
from keypose.tracker.storage.files import save_session
from keypose.tracker.storage.tracks import save_result
from tests.tracker import session_cases as cases


def poses(**changes: Any) -> dict[str, Any]:
    trajectory = cases.motion(cases.SKELETON)
    return {
        "Rs_parent_part": trajectory.Rs_parent_part,
        "ps_camera_root": trajectory.ps_camera_root,
        "first_frame": 7,
        **changes,
    }


def joints(**changes: Any) -> dict[str, Any]:
    names = joint_names(cases.SKELETON)
    positions = cases.motion(cases.SKELETON).joints(cases.SKELETON)
    return {"names": names, "ps_camera_joint": positions, "first_frame": 7, **changes}


def test_a_reference_of_poses_is_read(tmp_path: Path) -> None:
    path = tmp_path / "truth.npz"
    np.savez(path, **poses(part_names=cases.SKELETON.body.names))
    truth = load_reference(path, cases.SKELETON)
    assert isinstance(truth, Trajectory)
    assert (truth.first_frame, truth.last_frame) == (7, 11)


def test_a_reference_of_joints_is_read(tmp_path: Path) -> None:
    path = tmp_path / "truth.npz"
    np.savez_compressed(path, **joints())
    truth = load_reference(path, cases.SKELETON)
    assert isinstance(truth, JointReference)
    assert truth.has_depth
    assert truth.frames.tolist() == [7, 8, 9, 10, 11]


def test_marked_joints_are_read_by_their_usual_names(tmp_path: Path) -> None:
    path = tmp_path / "marks.json"
    marks = {"30": {"LWrist": [1, 2.5], "Head": [3, 4]}, "9": {"hip": [5, 6]}}
    path.write_text(json.dumps({"note": "by hand", "frames": marks}))
    skeleton = Skeleton.of(preset("adult_male"))
    truth = load_reference(path, skeleton)
    assert isinstance(truth, JointReference)
    assert not truth.has_depth
    assert truth.frames.tolist() == [9, 30]
    hand, thighs = skeleton.body.index("left_hand"), ("left_thigh", "right_thigh")
    places = dict(zip(truth.names, truth.places, strict=True))
    assert places["LWrist"] == ((hand, (0.0, 0.0, 0.0)),)
    assert [i for i, _ in places["hip"]] == [skeleton.body.index(name) for name in thighs]
    [(head, centre)] = places["Head"]
    assert head == skeleton.body.index("head")
    assert centre[1] < -0.05
    assert truth.positions[1, truth.names.index("LWrist")].tolist() == [1, 2.5]
    assert np.isnan(truth.positions[0, truth.names.index("Head")]).all()


Writer = Callable[[Path], Any]
NOT_REFERENCES: dict[str, tuple[str, Writer, str]] = {
    "another suffix": ("a.txt", lambda p: p.write_text(""), ".npz or .json"),
    "empty npz": ("a.npz", lambda p: p.write_bytes(b""), "archive of plain arrays"),
    "text as npz": ("a.npz", lambda p: p.write_text("hello"), "archive of plain arrays"),
    "a bare array": ("a.npz", lambda p: _bare(p), "archive of plain arrays"),
    "objects": (
        "a.npz",
        lambda p: np.savez(p, Rs_parent_part=np.array([None])),
        "archive of plain arrays",
    ),
    "other arrays": ("a.npz", lambda p: np.savez(p, xyz=[1.0]), "it holds xyz"),
    "no first frame": ("a.npz", lambda p: np.savez(p, **_less(poses(), "first_frame")), "first_fr"),
    "half a frame": ("a.npz", lambda p: np.savez(p, **poses(first_frame=0.5)), "whole number"),
    "no positions": ("a.npz", lambda p: np.savez(p, **_less(poses(), "ps_camera_root")), "lacks"),
    "too few parts": (
        "a.npz",
        lambda p: np.savez(p, **poses(Rs_parent_part=np.zeros((5, 3, 3, 3)))),
        "must be N×4×3×3 numbers; it is 5×3×3×3",
    ),
    "other parts": (
        "a.npz",
        lambda p: np.savez(p, **poses(part_names=["a", "b", "c", "d"])),
        "other parts than the body",
    ),
    "no rotations": (
        "a.npz",
        lambda p: np.savez(p, **poses(Rs_parent_part=np.ones((5, 4, 3, 3)))),
        "not rotations",
    ),
    "numbers too large for any rotation": (
        "a.npz",
        lambda p: np.savez(p, **poses(Rs_parent_part=np.full((5, 4, 3, 3), 1e200))),
        "not rotations",
    ),
    "NaN": (
        "a.npz",
        lambda p: np.savez(p, **poses(ps_camera_root=np.full((5, 3), np.nan))),
        "not finite",
    ),
    "no frames at all": (
        "a.npz",
        lambda p: np.savez(p, **poses(Rs_parent_part=np.zeros((0, 4, 3, 3)))),
        "must be",
    ),
    "joints without names": ("a.npz", lambda p: np.savez(p, **_less(joints(), "names")), "names"),
    "unknown joint": (
        "a.npz",
        lambda p: np.savez(p, **joints(names=["tail", *joint_names(cases.SKELETON)[1:]])),
        "'tail'",
    ),
    "a header that does not close": (
        "a.npz",
        lambda p: _entries(p, {"xyz.npy": _header("{'descr': '<f8', (")}),
        "'xyz.npy' has a header that cannot be read",
    ),
    "a header without end": (
        "a.npz",
        lambda p: _entries(p, {"xyz.npy": _header("-" * 9000 + "1")}),
        "a header that cannot be read",
    ),
    "a header that claims 745 GiB": (
        "a.npz",
        lambda p: _entries(p, {"xyz.npy": _header(_claim("(100000000000,)"))}),
        "'xyz.npy' has another size than it says",
    ),
    "a shape beyond all numbers": (
        "a.npz",
        lambda p: _entries(p, {"xyz.npy": _header(_claim(f"(0, {10**30})"))}),
        "archive of plain arrays",
    ),
    "a shape of less than nothing": (
        "a.npz",
        lambda p: _entries(p, {"xyz.npy": _header(_claim("(-1, -1)")) + bytes(8)}),
        "another size than it says",
    ),
    "an entry that is no array": (
        "a.npz",
        lambda p: _entries(p, {"readme.txt": b"hello"}),
        "'readme.txt' is no array",
    ),
    "an entry that only says it is an array": (
        "a.npz",
        lambda p: _entries(p, {"xyz.npy": b"hello"}),
        "'xyz.npy' is no array",
    ),
    "an encrypted archive": ("a.npz", lambda p: _encrypted(p), "is encrypted"),
    "an unusual compression": (
        "a.npz",
        lambda p: _entries(p, {"xyz.npy": bytes(99)}, zipfile.ZIP_LZMA),
        "compressed in an unusual way",
    ),
    "a little file that unpacks to a large one": (
        "a.npz",
        lambda p: _entries(p, {f"{i}.npy": bytes(2**26) for i in range(5)}, zipfile.ZIP_DEFLATED),
        "hold more than 256 MB",
    ),
    "a file too large": ("a.npz", lambda p: _hollow(p), "too large for a reference"),
    "a first frame beyond all videos": (
        "a.npz",
        lambda p: np.savez(p, **poses(first_frame=10**8 + 1)),
        "one whole number from 0 to 100000000",
    ),
    "a first frame beyond all numbers": (
        "a.npz",
        lambda p: np.savez(p, **poses(first_frame=1e300)),
        "one whole number from 0 to 100000000",
    ),
    "a first frame before the video": (
        "a.npz",
        lambda p: np.savez(p, **joints(first_frame=-1)),
        "one whole number from 0 to 100000000",
    ),
    "no JSON": ("a.json", lambda p: p.write_text("{"), "invalid JSON"),
    "JSON of something else": ("a.json", lambda p: p.write_text("{}"), "frames"),
    "no frames marked": ("a.json", lambda p: p.write_text('{"frames": {}}'), "frames"),
    "no joint marked": ("a.json", lambda p: p.write_text('{"frames": {"1": {}}}'), "no joint"),
    "an unknown marker": (
        "a.json",
        lambda p: p.write_text('{"frames": {"1": {"LShoulder": [1, 2]}}}'),
        "'LShoulder'",
    ),
    "a mark at NaN": (
        "a.json",
        lambda p: p.write_text('{"frames": {"1": {"tip": [NaN, 2]}}}'),
        "finite",
    ),
    "a frame of no number": (
        "a.json",
        lambda p: p.write_text('{"frames": {"first": {"tip": [1, 2]}}}'),
        "integer",
    ),
}


def _bare(path: Path) -> None:
    with path.open("wb") as file:
        np.save(file, np.zeros(3))


def _entries(path: Path, files: dict[str, bytes], how: int = zipfile.ZIP_STORED) -> None:
    with zipfile.ZipFile(path, "w", how) as archive:
        for name, content in files.items():
            archive.writestr(name, content)


def _header(text: str) -> bytes:
    """The beginning of a .npy file with this text for a header."""
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text) + 1) + f"{text}\n".encode()


def _claim(shape: str) -> str:
    return f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}}}"


def _encrypted(path: Path) -> None:
    """An archive whose one entry says that it is encrypted, in both places that tell."""
    _entries(path, {"xyz.npy": bytes(40)})
    content = bytearray(path.read_bytes())
    content[6] |= 1
    content[content.index(b"PK\x01\x02") + 8] |= 1
    path.write_bytes(content)


def _hollow(path: Path) -> None:
    with path.open("wb") as file:
        file.truncate(2**28 + 1)


def _less(arrays: dict[str, Any], name: str) -> dict[str, Any]:
    return {key: value for key, value in arrays.items() if key != name}


@pytest.mark.parametrize("kind", NOT_REFERENCES)
def test_anything_else_is_refused_in_one_sentence(tmp_path: Path, kind: str) -> None:
    name, write, words = NOT_REFERENCES[kind]
    write(tmp_path / name)
    with pytest.raises(FormatError) as caught:
        load_reference(tmp_path / name, cases.SKELETON)
    text = str(caught.value)
    assert words in text
    assert name in text
    assert text.endswith(".")
    assert "\n" not in text


def test_a_missing_reference_or_a_folder_is_named(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match="There is no reference file"):
        load_reference(tmp_path / "none.npz", cases.SKELETON)
    with pytest.raises(FormatError, match="is a folder"):
        load_reference(tmp_path, cases.SKELETON)


@pytest.mark.parametrize("order", ["C", "F"])
def test_arrays_are_read_in_either_order_and_may_be_written_to(tmp_path: Path, order: Any) -> None:
    path = tmp_path / "a.npz"
    arrays = {"numbers": np.arange(6.0).reshape(2, 3, order=order), "one": np.array(7)}
    arrays |= {"none": np.zeros((0, 3)), "words": np.array(["a", "längst"])}
    for write in (np.savez, np.savez_compressed):
        write(path, allow_pickle=False, **arrays)
        found = archive_arrays(path.read_bytes(), packed=True)
        assert found.keys() == arrays.keys()
        for name, array in arrays.items():
            np.testing.assert_array_equal(found[name], array)
            assert found[name].dtype == array.dtype
            assert found[name].flags.writeable


@settings(deadline=None, max_examples=200)
@given(st.data())
def test_a_spoilt_archive_is_read_or_refused_and_nothing_else(data: st.DataObject) -> None:
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **poses())
    content = bytearray(buffer.getvalue())
    for _ in range(data.draw(st.integers(1, 4))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    with contextlib.suppress(ValueError):
        archive_arrays(bytes(content), packed=True)


def test_a_wrong_reference_ends_the_command_with_one_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    session = save_result(cases.session(), tmp_path / "session.json", cases.result())
    save_session(session, tmp_path / "session.json")
    _entries(tmp_path / "a.npz", {"xyz.npy": _header(_claim("(100000000000,)"))})
    command = ["evaluate", tmp_path / "session.json", "--reference", tmp_path / "a.npz"]
    assert main([str(argument) for argument in command]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
