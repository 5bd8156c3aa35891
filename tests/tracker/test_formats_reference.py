"""References of every kind are read, and anything else is refused in one sentence."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.tracker import session_cases as cases
from tracker.body import preset
from tracker.errors import FormatError
from tracker.evaluate import JointReference
from tracker.formats.reference import load_reference
from tracker.pose import joint_names
from tracker.skeleton import Skeleton
from tracker.trajectory import Trajectory


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
