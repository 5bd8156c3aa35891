"""The film's camera for rotomation: JSON, .chan, glTF; and read back."""

from __future__ import annotations

import json
from dataclasses import replace
from io import BytesIO
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from keypose.tracker.errors import FormatError
from keypose.tracker.formats.camera_files import camera_json, chan
from keypose.tracker.formats.npz import npz
from keypose.tracker.formats.recording import Recording
from keypose.tracker.formats.sampling import at_rate
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import apply_transform
from keypose.tracker.video.info import Timecode
from tests.tracker.formats import recordings
from tests.tracker.formats.glb_reading import Player
from tests.tracker.formats.test_glb import written

TILTED = np.array([0.08, -0.95, -0.3]) / np.linalg.norm([0.08, -0.95, -0.3])
WIDE = Camera(
    width=640, height=360, fx=700, fy=700, cx=300, cy=170, distortion=(0.1, -0.02, 0, 0, 0)
)


def tilted(**more: Any) -> Recording:
    made = recordings.recording("person")
    return replace(made, up_camera=TILTED, floor_m=-1.4, camera=WIDE, **more)


def rows(text: str) -> np.ndarray:  # type: ignore[type-arg]
    return np.array([[float(n) for n in line.split("\t")] for line in text.splitlines()])


def test_json_gives_where_everything_is_seen() -> None:
    made = tilted(timecode=Timecode.read("01:00:00:00", 25))
    message = json.loads(camera_json(made))
    T = np.linalg.inv(np.array(message["T_world_camera"]))
    player = Player.of(written(made))
    hand = player.places(player.times_s)["left_hand"]
    p = made.trajectory.transforms(made.skeleton)[:, made.skeleton.body.index("left_hand"), :3, 3]
    np.testing.assert_allclose(apply_transform(T, hand), p, atol=1e-5)
    assert message["cx"] == 300
    assert message["distortion_k1_k2_p1_p2_k3"][1] == -0.02
    assert message["timecode_of_frame_0"] == "01:00:00:00"
    assert (message["first_frame"], message["last_frame"]) == (0, 72)
    assert message["horizontal_fov_deg"] == pytest.approx(2 * np.degrees(np.arctan(320 / 700)))


def test_a_chan_file_has_the_camera_of_the_glb_in_every_frame() -> None:
    made = tilted()
    lines = rows(chan(made))
    assert lines[:, 0].tolist() == list(range(73))
    assert np.ptp(lines[:, 1:], axis=0).max() == 0
    T = Player.of(written(made)).transforms(None)["camera"][0]
    np.testing.assert_allclose(lines[0, 1:4], T[:3, 3], atol=1e-6)
    # rotated about z first, then x, then y, all in the world's axes
    R = Rotation.from_euler("zxy", lines[0, [6, 4, 5]], degrees=True).as_matrix()
    np.testing.assert_allclose(R, T[:3, :3], atol=1e-6)
    (below,) = np.unique(rows(chan(replace(made, origin="camera")))[:, [1, 3, 5]], axis=0)
    np.testing.assert_allclose(below, 0, atol=1e-9)  # on its own ground it looks along −z
    assert lines[0, 7] == pytest.approx(2 * np.degrees(np.arctan(180 / 700)))


def test_frames_of_numbered_images_have_the_numbers_of_their_files() -> None:
    code = Timecode.of_numbers(range(1001, 1101), 30)
    made = tilted(timecode=code)
    assert rows(chan(made))[[0, -1], 0].tolist() == [1001, 1073]
    message = json.loads(camera_json(made))
    assert (message["file_number_of_frame_0"], message["timecode_of_frame_0"]) == (
        1001,
        "00:00:33:11",
    )
    at_half = at_rate(made, 15.0)
    assert rows(chan(at_half))[0, 0] == at_half.frames[0]  # which are those of no file


def test_the_world_of_a_camera_straight_above_is_reported_as_well() -> None:
    made = replace(tilted(origin="camera"), up_camera=np.array([0.0, 0.0, -1.0]))
    line = rows(chan(made))[0]
    R = Rotation.from_euler("zxy", line[[6, 4, 5]], degrees=True).as_matrix()
    np.testing.assert_allclose(R @ [0, 0, -1], [0, -1, 0], atol=1e-9)
    np.testing.assert_allclose(R @ [0, 1, 0], [0, 0, -1], atol=1e-9)


def test_a_telephoto_lens_is_reported_in_json_and_not_in_chan() -> None:
    lens = WIDE.model_copy(update={"projection": "telephoto", "telephoto_distance_m": 9.0})
    made = replace(tilted(), camera=lens)
    message = json.loads(camera_json(made))
    assert message["telephoto_distance_m"] == 9.0
    assert "vertical_fov_deg" not in message
    with pytest.raises(FormatError, match="a telephoto lens has none"):
        chan(made)


def test_frames_that_are_not_tracked_have_the_same_camera() -> None:
    made = recordings.recording("person", without=(1,))
    assert len(rows(chan(made))) == 73


def test_files_say_where_the_path_of_the_camera_has_no_scale() -> None:
    known = recordings.recording("person")
    made = replace(known, unscaled=((0, 9), (20, 30)))
    assert json.loads(camera_json(made))["without_scale"] == [[0, 9], [20, 30]]
    assert "without_scale" not in json.loads(camera_json(known))
    with np.load(BytesIO(npz(made))) as found:
        assert found["unscaled_frames"].tolist() == [[0, 9], [20, 30]]
    with np.load(BytesIO(npz(known))) as found:
        assert found["unscaled_frames"].shape == (0, 2)
    assert b'"camera_path_without_scale":[[0,9],[20,30]]' in written(made).replace(b" ", b"")
    assert b"camera_path_without_scale" not in written(known)
