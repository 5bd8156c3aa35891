"""Cameras of other programs: read, or refused in one sentence."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from keypose.tracker.errors import FormatError
from keypose.tracker.formats.camera_files import camera_json, chan
from keypose.tracker.formats.reading_camera import CameraFile, load_camera
from tests.tracker.formats.test_camera_files import TILTED, WIDE, tilted
from tests.tracker.formats.test_glb import written

SIZE = (WIDE.width, WIDE.height)
HALF = math.tan(math.radians(20))


def read(folder: Path, name: str, content: str | bytes, size: tuple[int, int] = SIZE) -> CameraFile:
    path = folder / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return load_camera(path, size)


def gltf(**node: Any) -> dict[str, Any]:
    """A scene with a camera at the end of an arm."""
    return {
        "asset": {"version": "2.0"},
        "nodes": [{"name": "arm", "children": [1]}, {"camera": 0, **node}],
        "cameras": [
            {"type": "perspective", "perspective": {"yfov": math.radians(40), "znear": 0.1}}
        ],
    }


def test_json_comes_back_as_it_was_written(tmp_path: Path) -> None:
    found = read(tmp_path, "camera.json", camera_json(tilted()))
    assert found.camera == WIDE
    np.testing.assert_allclose(found.up_camera, TILTED, atol=1e-8)
    assert found.floor_m == pytest.approx(-1.4)


def test_a_telephoto_lens_comes_back_from_json(tmp_path: Path) -> None:
    lens = WIDE.model_copy(update={"projection": "telephoto", "telephoto_distance_m": 9.0})
    found = read(tmp_path, "camera.json", camera_json(replace(tilted(), camera=lens)))
    assert found.camera == lens


def test_our_own_glb_gives_the_exact_lens_and_the_floor(tmp_path: Path) -> None:
    found = read(tmp_path, "motion.glb", written(tilted()))
    assert found.camera == WIDE
    np.testing.assert_allclose(found.up_camera, TILTED, atol=1e-6)
    assert found.floor_m == pytest.approx(-1.4)


def test_a_lens_changed_on_the_way_counts_and_not_the_old_numbers(tmp_path: Path) -> None:
    document = gltf()
    document["cameras"][0]["extras"] = {
        **WIDE.model_dump(), "distortion_k1_k2_p1_p2_k3": [0.1, 0, 0, 0, 0]
    }  # fmt: skip
    found = read(tmp_path, "shot.gltf", json.dumps(document))
    assert found.camera.fy == pytest.approx(180 / HALF)
    assert not found.camera.is_distorted


def test_a_chan_file_gives_the_lens_and_what_is_up(tmp_path: Path) -> None:
    found = read(tmp_path, "shot.chan", chan(tilted()))
    assert found.camera.fx == pytest.approx(700)
    assert (found.camera.cx, found.camera.cy) == (319.5, 179.5)
    np.testing.assert_allclose(found.up_camera, TILTED, atol=1e-8)
    assert found.floor_m is None


def test_a_gltf_camera_gives_its_angle_and_what_is_up(tmp_path: Path) -> None:
    s = math.sin(math.radians(-15))
    pitched = gltf(rotation=[s, 0, 0, math.sqrt(1 - s * s)], translation=[1, 2, 3])
    found = read(tmp_path, "shot.gltf", json.dumps(pitched))
    assert found.camera.fx == found.camera.fy == pytest.approx(180 / HALF)
    angle = math.radians(30)  # looking down by so much: up leans toward the camera
    np.testing.assert_allclose(found.up_camera, [0, -math.cos(angle), -math.sin(angle)], atol=1e-9)
    assert found.floor_m is None


def test_a_camera_for_smaller_pictures_of_the_same_shape_is_scaled(tmp_path: Path) -> None:
    found = read(tmp_path, "camera.json", camera_json(tilted()), (1280, 720)).camera
    assert (found.width, found.height, found.fx, found.fy) == (1280, 720, 1400, 1400)
    point = np.array([0.3, -0.2, 2.0])
    smaller = WIDE.project(point)
    np.testing.assert_allclose(found.project(point), 2 * (smaller + 0.5) - 0.5)


def animated(
    values: list[list[float]],
    path: str = "translation",
    how: str = "LINEAR",
    node: int = 0,
    arm: dict[str, Any] | None = None,
) -> bytes:
    """A GLB whose camera's arm is moved."""
    from keypose.tracker.formats.glb_file import Numbers

    numbers = Numbers()
    clock = numbers.add(np.arange(len(values), dtype=np.float32), "SCALAR", "animation")
    output = numbers.add(np.array(values, dtype=np.float32), f"VEC{len(values[0])}", "animation")
    channel = {"sampler": 0, "target": {"node": node, "path": path}}
    sampler = {"input": clock, "output": output, "interpolation": how}
    document = gltf() | {"animations": [{"channels": [channel], "samplers": [sampler]}]}
    document["nodes"][0] |= arm or {}
    return numbers.file(document)


def test_a_camera_with_keys_that_are_all_alike_stands_still(tmp_path: Path) -> None:
    found = read(tmp_path, "shot.glb", animated([[1, 2, 3], [1, 2, 3]]))
    np.testing.assert_allclose(found.up_camera, [0, -1, 0], atol=1e-9)


def test_keys_of_a_camera_that_stands_still_count_and_not_its_rest(tmp_path: Path) -> None:
    s = math.sqrt(0.5)  # rolled by a right angle: up is to the camera's left
    for node in (0, 1):
        rolled = animated([[0, 0, s, s]] * 3, "rotation", node=node)
        found = read(tmp_path, "shot.glb", rolled)
        np.testing.assert_allclose(found.up_camera, [1, 0, 0], atol=1e-6)
    slopes = [[9, 9, 9, 9], [0, 0, s, s], [9, 9, 9, 9]] * 2
    found = read(tmp_path, "shot.glb", animated(slopes, "rotation", "CUBICSPLINE"))
    np.testing.assert_allclose(found.up_camera, [1, 0, 0], atol=1e-6)


def test_half_a_millimetre_of_a_scene_in_millimetres_is_no_motion(tmp_path: Path) -> None:
    trembling = animated([[0, 0, 0], [0, 0, 0.5]], node=1, arm={"scale": [0.001, 0.001, 0.001]})
    found = read(tmp_path, "shot.glb", trembling)
    np.testing.assert_allclose(found.up_camera, [0, -1, 0], atol=1e-9)


def test_a_node_that_gives_a_matrix_lies_where_that_puts_it(tmp_path: Path) -> None:
    document = gltf()
    document["nodes"][0]["matrix"] = [0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1]
    found = read(tmp_path, "shot.gltf", json.dumps(document))
    np.testing.assert_allclose(found.up_camera, [1, 0, 0], atol=1e-9)


def moved_chan(column: int) -> str:
    first, second = chan(tilted()).splitlines()[:2]
    numbers = second.split("\t")
    numbers[column] = str(float(numbers[column]) + 1)
    return "\n".join([first, "\t".join(numbers)])


REFUSED: dict[str, tuple[str, Any, str]] = {
    "a frame twice": ("shot.chan", "1 0 0 0 0 0 0 30\n1 0 0 1 0 0 0 30", "names frames twice"),
    "frames back": ("shot.chan", "2 0 0 0 0 0 0 30\n1 0 0 1 0 0 0 30", "not in their order"),
    "a chan of six columns": ("shot.chan", "1 0 0 0 0 0", "should have 8 numbers in every line"),
    "a line that is shorter": ("shot.chan", "1 0 0 0 0 0 0 30\n2 0 0 0 0 0 0", "8 numbers"),
    "no number": ("shot.chan", "1 0 0 0 nan 0 0 30", "has lines that are not numbers"),
    "5,000 digits": ("shot.chan", f"1 {'9' * 5000} 0 0 0 0 0 30", "a number that is too large"),
    "a frame of 5,000 digits": ("shot.chan", f"{'9' * 5000} 0 0 0 0 0 0 30", "is too large"),
    "a frame beyond all films": ("shot.chan", "1e300 0 0 0 0 0 0 30", "is too large"),
    "a json number of 5,000 digits": (
        "shot.json", camera_json(tilted()).replace("640", "9" * 5000), "shot.json: width: "
    ),
    "a list": ("shot.json", "[3]", "shot.json: it holds no camera that can be read"),
    "a frame that is no object": (
        "shot.json",
        json.dumps({"frames": [{"transform_matrix": 3}, 4]}),
        "shot.json: frames.0.file_path: field required",
    ),
    "words": ("shot.chan", "a b c d e f g h", "has lines that are not numbers"),
    "no field of view": ("shot.chan", "1 0 0 0 0 0 0 0", "has numbers that no camera has"),
    "nothing": ("shot.chan", "", "should have 8 numbers"),
    "another file": ("shot.fbx", "", "shot.fbx is no camera: .json, .chan, .glb or .gltf is"),
    "other json": ("shot.json", "{}", "shot.json: "),
    "no json": ("shot.json", "{", "shot.json is not JSON"),
    "no camera": ("shot.gltf", json.dumps({"nodes": [{}]}), "shot.gltf has no camera"),
    "two cameras": (
        "shot.gltf", json.dumps(gltf() | {"nodes": [{"camera": 0}, {"camera": 0}]}), "2 cameras"
    ),
    "an orthographic one": (
        "shot.gltf", json.dumps(gltf() | {"cameras": [{"type": "orthographic"}]}), "perspective"
    ),
    "nodes that hang in each other": (
        "shot.gltf",
        json.dumps(gltf() | {"nodes": [{"children": [1]}, {"children": [0], "camera": 0}]}),
        "is a damaged glTF",
    ),
    "keys in other files": (
        "shot.gltf",
        json.dumps(gltf() | {
            "buffers": [{"uri": "shot.bin", "byteLength": 24}],
            "bufferViews": [{"buffer": 0, "byteLength": 24}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": 2, "type": "VEC3"}],
            "animations": [{
                "channels": [{"sampler": 0, "target": {"node": 1, "path": "translation"}}],
                "samplers": [{"input": 0, "output": 0}],
            }],
        }),
        "keeps its numbers in other files",
    ),
    "a damaged one": ("shot.gltf", json.dumps(gltf() | {"cameras": []}), "is a damaged glTF"),
    "a lens of many digits": (
        "shot.gltf",
        json.dumps(
            gltf() | {"cameras": [{"type": "perspective", "perspective": {"yfov": 10**400}}]}
        ),
        "is a damaged glTF",
    ),
    "no glb": ("shot.glb", b"glTF", "shot.glb "),
    "a matrix": (
        "shot.json", camera_json(tilted()).replace("0.0,\n   1.0", "0.0,\n   NaN"), "shot.json"
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_what_is_no_standing_camera_is_reported_in_one_sentence(case: str, tmp_path: Path) -> None:
    name, content, words = REFUSED[case]
    with pytest.raises(FormatError) as refusal:
        read(tmp_path, name, content)
    assert words in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_an_animated_camera_is_where_its_keys_are_at_their_seconds(tmp_path: Path) -> None:
    s = math.sqrt(0.5)
    for content, path, expected in (
        (animated([[0, 0, 0], [1, 0, 0]]), (slice(3), 3), [1, 0, 0]),
        (animated([[0, 0, 0], [0, 0, 0.002]], node=1), (slice(3), 3), [0, 0, 0.002]),
        (animated([[0, 0, 0, 1], [0, 0, s, s]], "rotation"), (slice(3), 0), [0, 1, 0]),
        (animated([[0, 0, 0], [4, 0, 0]], how="STEP"), (slice(3), 3), [4, 0, 0]),
    ):
        way = read(tmp_path, "shot.glb", content).way
        assert way is not None
        assert way.clock == "seconds"
        assert way.begins is None
        np.testing.assert_allclose(way.frames, [0, 1])
        np.testing.assert_allclose(way.Ts_world_camera[1][path], expected, atol=1e-6)


def test_keys_that_do_not_ascend_are_no_animation(tmp_path: Path) -> None:
    content = animated([[0, 0, 0], [1, 0, 0]])
    times = np.array([0, 1], "<f4").tobytes()
    broken = content.replace(times, np.array([1, 0], "<f4").tobytes())
    with pytest.raises(FormatError, match="is a damaged glTF"):
        read(tmp_path, "shot.glb", broken)


@pytest.mark.parametrize("name", ["camera.json", "shot.gltf"])
def test_a_camera_for_pictures_of_another_shape_is_refused(name: str, tmp_path: Path) -> None:
    document = gltf()
    document["cameras"][0]["perspective"]["aspectRatio"] = 640 / 360
    content = camera_json(tilted()) if name == "camera.json" else json.dumps(document)
    with pytest.raises(FormatError, match="export"):
        read(tmp_path, name, content, (480, 640))
