"""Joints as markers: TRC read as a plain table, C3D by ezc3d."""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import ezc3d
import numpy as np
import pytest

from keypose.tracker.body.body import preset
from keypose.tracker.body.pose import joint_names
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import FormatError
from keypose.tracker.formats.marker_files import c3d, trc
from keypose.tracker.formats.recording import MARKER_SETS, MarkerSetName, Recording
from keypose.tracker.formats.sampling import at_rate
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.pins import Pin
from tests.rendering.motions import crossing
from tests.tracker.formats import recordings

WALKER = Skeleton.of(preset("adult_female"))


@dataclass
class Table:
    """A TRC file; positions (N, J, 3) in its own unit."""

    header: dict[str, str]
    names: list[str]
    frames: list[int]
    times_s: list[float]
    positions: np.ndarray  # type: ignore[type-arg]


def read_trc(text: str) -> Table:
    """The table, cell by cell, as strictly as OpenSim reads it."""
    lines = text.split("\n")
    assert lines[0].split("\t")[:3] == ["PathFileType", "4", "(X/Y/Z)"]
    header = dict(zip(lines[1].split("\t"), lines[2].split("\t"), strict=True))
    names = [cell for cell in lines[3].split("\t") if cell]
    assert names[:2] == ["Frame#", "Time"]
    count = int(header["NumMarkers"])
    axes = [cell for cell in lines[4].split("\t") if cell]
    assert axes == [f"{axis}{i + 1}" for i in range(count) for axis in "XYZ"]
    assert lines[5] == ""
    assert lines[-1] == ""
    rows = [line.split("\t") for line in lines[6:-1]]
    for row in rows:
        assert len(row) == 2 + 3 * count
        assert all(row)  # OpenSim refuses a row whose last cell is empty
    numbers = [[float(cell) for cell in row[2:]] for row in rows]
    positions = np.array(numbers).reshape(len(rows), count, 3)
    assert len(rows) == int(header["NumFrames"])
    return Table(
        header, names[2:], [int(r[0]) for r in rows], [float(r[1]) for r in rows], positions
    )


def _on_ground(made: Recording) -> Array:
    """Joints and landmarks (N, J, 3), metres: x ahead, y up, z right."""
    return made.ground.points(made.trajectory.joints(made.skeleton))


@pytest.mark.parametrize("name", recordings.NAMES)
def test_trc_holds_every_joint_in_millimetres_with_y_up(name: str) -> None:
    made = recordings.recording(name)
    table = read_trc(trc(made))
    assert table.header["Units"] == "mm"
    assert table.names == list(joint_names(made.skeleton))
    assert table.frames == list(made.frames)
    np.testing.assert_allclose(table.times_s, made.times_s, atol=1e-6)
    np.testing.assert_allclose(table.positions / 1e3, _on_ground(made), atol=1e-6)
    rate = (len(made) - 1) / (made.times_s[-1] - made.times_s[0])
    assert float(table.header["DataRate"]) == pytest.approx(rate)
    assert float(table.header["CameraRate"]) == pytest.approx(rate)


@pytest.mark.parametrize("marker_set", MARKER_SETS)
def test_markers_stand_on_the_floor_and_look_ahead_in_trc_as_in_c3d(
    marker_set: MarkerSetName, tmp_path: Path
) -> None:
    made = replace(recordings.recording("person"), marker_set=marker_set)
    table = read_trc(trc(made))
    per_metre = {"mm": 1000.0, "m": 1.0}[table.header["Units"]]
    assert (marker_set, per_metre) in [("keypose", 1000.0), ("halpe26", 1.0)]
    ps = table.positions / per_metre
    point = read_c3d(c3d(made), tmp_path)
    in_c3d = np.moveaxis(point["data"]["points"][:3], 0, -1).swapaxes(0, 1) / 1e3
    np.testing.assert_allclose(ps, in_c3d, atol=1e-5)
    assert -0.06 < ps[..., 1].min() < 0.12
    assert 1.4 < ps[..., 1].max() < 2.0
    place = {name.lower(): ps[:, i] for i, name in enumerate(table.names)}
    toe, heel = ("left_toe", "left_heel") if marker_set == "keypose" else ("lbigtoe", "lheel")
    ahead = (place[toe] - place[heel]).mean(axis=0)
    assert ahead[0] > 0.5 * np.linalg.norm(ahead)


def test_a_whole_rate_is_a_whole_number_in_trc() -> None:
    made = recordings.recording("person")
    whole = replace(made, times_s=np.array(made.frames) / 30, rate=30.0)
    assert read_trc(trc(whole)).header["DataRate"] == "30"
    film = replace(made, times_s=np.array(made.frames) * 1001 / 30000, rate=30000 / 1001)
    assert read_trc(trc(film)).header["DataRate"] == "29.97003"


def test_trc_leaves_frames_empty_that_are_not_tracked() -> None:
    made = recordings.recording("person", without=(1,))
    table = read_trc(trc(made))
    missing = np.isnan(table.positions).all(axis=(1, 2))
    assert np.flatnonzero(missing).tolist() == list(range(25, 48))
    assert table.frames == list(range(73))
    np.testing.assert_allclose(table.positions / 1e3, _on_ground(made), atol=1e-6, equal_nan=True)


def test_markers_with_blanks_are_one_word_in_trc() -> None:
    made = recordings.recording("box")
    part = made.skeleton.body.parts[0].model_copy(update={"name": "the box"})
    body = made.skeleton.body.model_copy(update={"parts": (part,)})
    renamed = Recording(
        Skeleton.of(body), made.camera, made.tracks, (), made.times_s, made.up_camera
    )
    assert read_trc(trc(renamed)).names[0] == "the_box"


def read_c3d(content: bytes, folder: Path) -> Any:
    (folder / "read.c3d").write_bytes(content)
    return ezc3d.c3d(str(folder / "read.c3d"))


@pytest.mark.parametrize("name", recordings.NAMES)
def test_c3d_holds_every_joint_in_millimetres_with_y_up(name: str, tmp_path: Path) -> None:
    made = recordings.recording(name)
    file = read_c3d(c3d(made), tmp_path)
    point = file["parameters"]["POINT"]
    assert point["UNITS"]["value"] == ["mm"]
    assert point["LABELS"]["value"] == list(joint_names(made.skeleton))
    assert [point[axis]["value"] for axis in ("X_SCREEN", "Y_SCREEN")] == [["+X"], ["+Y"]]
    rate = (len(made) - 1) / (made.times_s[-1] - made.times_s[0])
    assert point["RATE"]["value"][0] == pytest.approx(rate, rel=1e-6)
    assert file["header"]["points"]["first_frame"] == 0
    assert file["header"]["points"]["last_frame"] == len(made) - 1
    assert file["parameters"]["ANALOG"]["USED"]["value"][0] == 0
    found = np.moveaxis(file["data"]["points"][:3], 0, -1).swapaxes(0, 1) / 1e3
    np.testing.assert_allclose(found, _on_ground(made), atol=1e-5)
    assert (file["data"]["meta_points"]["residuals"] >= 0).all()


def test_c3d_marks_points_of_frames_that_are_not_tracked(tmp_path: Path) -> None:
    made = recordings.recording("person", without=(1,))
    file = read_c3d(c3d(made), tmp_path)
    lacking = file["data"]["meta_points"]["residuals"][0] == -1
    assert np.flatnonzero(lacking.all(axis=0)).tolist() == list(range(25, 48))
    assert lacking.any(axis=0).sum() == 23


def test_frames_keep_their_numbers_where_the_first_keyframe_is_late(tmp_path: Path) -> None:
    made = recordings.recording("person", first_key=1)
    file = read_c3d(c3d(made), tmp_path)
    assert file["header"]["points"]["first_frame"] == 24
    assert file["header"]["points"]["last_frame"] == 72
    found = np.moveaxis(file["data"]["points"][:3], 0, -1).swapaxes(0, 1) / 1e3
    np.testing.assert_allclose(found, _on_ground(made), atol=1e-5)
    table = read_trc(trc(made))
    assert table.frames == list(range(24, 73))
    assert table.header["OrigDataStartFrame"] == "24"
    assert table.times_s[0] == pytest.approx(recordings.uneven_times(73)[24], abs=1e-6)


def test_c3d_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ezc3d", None)
    with pytest.raises(FormatError) as reported:
        c3d(recordings.recording("box"))
    assert str(reported.value) == "C3D files need ezc3d: pip install 'keypose[c3d]'."


def test_c3d_says_where_its_room_ends() -> None:
    made = recordings.recording("box")
    part = made.skeleton.body.parts[0]

    def with_part(**more: Any) -> Recording:
        body = made.skeleton.body.model_copy(update={"parts": (part.model_copy(update=more),)})
        return Recording(
            Skeleton.of(body), made.camera, made.tracks, (), made.times_s, made.up_camera
        )

    many = {f"mark {i}": (0.0, 0.0, 0.1) for i in range(260)}
    with pytest.raises(FormatError, match="holds 255 points and the body has 261"):
        c3d(with_part(landmarks=many))
    with pytest.raises(FormatError, match=r"no room for the name .* of 240 bytes"):
        c3d(with_part(name="\N{GRINNING FACE}" * 60))


def test_a_motion_without_two_times_has_no_rate() -> None:
    made = recordings.recording("box")
    still = Recording(
        made.skeleton, made.camera, made.tracks, (), np.zeros(len(made)), made.up_camera
    )
    for write in (lambda: c3d(still), lambda: trc(still)):
        with pytest.raises(FormatError, match="two frames and the time between"):
            write()


def test_c3d_has_heel_strikes_and_toe_offs_as_events(tmp_path: Path) -> None:
    made = recordings.recorded(WALKER, crossing(WALKER), 30.0)
    event = read_c3d(c3d(made), tmp_path)["parameters"]["EVENT"]
    expected = sorted(
        (frame / 30, label, stance.part)
        for stance in made.gait.stances
        for frame, label in ((stance.heel_strike, "Foot Strike"), (stance.toe_off, "Foot Off"))
        if frame is not None
    )
    assert event["USED"]["value"][0] == len(expected) > 8
    assert event["LABELS"]["value"] == [label for _, label, _ in expected]
    sides = [part.removesuffix("_foot").capitalize() for _, _, part in expected]
    assert event["CONTEXTS"]["value"] == sides
    minutes, seconds = event["TIMES"]["value"]
    np.testing.assert_allclose(60 * minutes + seconds, [time for time, _, _ in expected], atol=1e-5)
    assert "EVENT" not in read_c3d(c3d(recordings.recording("box")), tmp_path)["parameters"]


@pytest.mark.parametrize("rate", [15.0, 60.0])
def test_events_of_pinned_feet_are_the_same_at_another_rate(rate: float) -> None:
    sole = ("left_heel", "left_toe")
    pins = tuple(
        Pin(part="left_foot", landmarks=sole, first_frame=a, last_frame=a + 22) for a in (45, 96)
    )
    made = replace(recordings.recorded(WALKER, crossing(WALKER), 30.0), pins=pins)
    other = at_rate(made, rate)
    assert len(made.gait.strides) == len(other.gait.strides) == 1
    (one,), (same,) = made.gait.strides, other.gait.strides
    assert same.time_s == pytest.approx(one.time_s, abs=1.5 / 15)
    assert same.length_m == pytest.approx(one.length_m, abs=0.02)
