"""Networks of a person's own: each kind finds its joints wherever the region lies and is turned."""

from __future__ import annotations

import hashlib
import re
from dataclasses import replace
from pathlib import Path
from typing import get_args

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.errors import KeypointError
from keypose.tracker.keypoints import joint_network
from keypose.tracker.keypoints.joint_kinds import KINDS
from keypose.tracker.keypoints.joint_network import JointNetwork
from keypose.tracker.keypoints.layouts import LAYOUTS
from keypose.tracker.keypoints.model_files import LARGEST_BYTES, OF_ANIMALS, JointLayout, Model
from keypose.tracker.keypoints.recognise_network import recognised
from keypose.tracker.keypoints.region import Region
from keypose.tracker.keypoints.runtimes import ONNX, fast_is_here
from keypose.tracker.storage.networks import add_own
from tests.tracker.keypoints import tiny_networks as tiny

PLACES = np.array([(212.4, 151.7), (301.2, 260.6), (255.8, 333.1)])
"""Of the brightest red, green and blue in the picture."""
REGION = Region(260.0, 240.0, 360.0)
TINY = {
    "RTMPose": (tiny.simcc(), "simcc", "COCO_17"),
    "RTMPose with feet": (tiny.simcc(26, 288, 384), "simcc", "HALPE_26"),
    "RTMW": (tiny.simcc(133, 288, 384, batch=1), "simcc", "COCO_WHOLEBODY_133"),
    "a square": (tiny.simcc(17, 256, 256), "simcc", "COCO_17"),
    "ViTPose": (tiny.maps(), "maps", "COCO_17"),
    "ViTPose whose input is left open": (
        tiny.maps(133, is_open=True),
        "maps",
        "COCO_WHOLEBODY_133",
    ),
}


@pytest.fixture(autouse=True)
def _alone(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


def added(tmp_path: Path, content: bytes) -> Model:
    file = tmp_path / "network.onnx"
    file.write_bytes(content)
    return add_own("mine", file, hashlib.sha256(content).hexdigest())


def spots(places: NDArray[np.float64], sigma_px: float = 5.0) -> NDArray[np.uint8]:
    """A picture with a soft spot of each colour."""
    rows, columns = np.indices((480, 520))
    levels = [
        255 * np.exp(-((columns - x) ** 2 + (rows - y) ** 2) / (2 * sigma_px**2)) for x, y in places
    ]
    return np.stack(levels, axis=-1).round().astype(np.uint8)


def test_every_layout_of_networks_is_tried_and_known_by_how_many_joints_it_has(
    tmp_path: Path,
) -> None:
    layouts = [layout for layout in get_args(JointLayout) if layout != OF_ANIMALS]
    assert {layout for _, _, layout in TINY.values()} == set(layouts)
    counts = {len(LAYOUTS[layout]) for layout in layouts}
    assert len(counts) == len(layouts)
    with pytest.raises(KeypointError) as refused:
        added(tmp_path, tiny.maps(68))
    sentence = str(refused.value).partition("with ")[2].partition("animals")[0]
    assert set(map(int, re.findall(r"\d+", sentence))) == counts


@pytest.mark.parametrize("name", TINY)
def test_the_brightest_pixels_are_found_to_a_third_of_a_pixel(tmp_path: Path, name: str) -> None:
    content, kind, layout = TINY[name]
    model = added(tmp_path, content)
    assert model.heads is not None
    assert (model.heads.kind, model.heads.layout) == (kind, layout)
    network = JointNetwork.open(model, fast=False)
    assert network.names == LAYOUTS[layout]
    expected = PLACES[np.arange(len(network.names)) % 3]
    for turn_rad in (0.0, 0.6, -2.5):
        seen = network.infer(spots(PLACES), replace(REGION, turn_rad=turn_rad))
        away = np.hypot(*(seen.uv - expected).T).max()
        assert away < (0.3 if kind == "simcc" else 0.45), turn_rad
        assert (seen.confidence > 0.5).all()
        assert (seen.confidence <= 1.0).all()


@pytest.mark.parametrize("size", [(192, 256), (288, 384), (256, 256)])
def test_hands_and_feet_on_the_circle_around_a_body_are_in_the_input(
    tmp_path: Path, size: tuple[int, int]
) -> None:
    radius = 0.4 * REGION.side - 4.0
    around = np.array([(radius, 0.0), (-radius, 0.0), (0.0, radius)])
    ends = around + np.array([REGION.x, REGION.y])
    network = JointNetwork.open(added(tmp_path, tiny.simcc(17, *size)), fast=False)
    seen = network.infer(spots(ends), REGION)
    assert np.hypot(*(seen.uv[:3] - ends).T).max() < 0.3


def test_an_upright_persons_height_is_near_what_such_networks_are_trained_on() -> None:
    """BlazePose's circle goes from the hips, a little above half of the height, to the feet."""
    height, circle = 1.0, 2 * 0.53
    region = Region(0.0, 0.0, 1.25 * circle)
    shown = replace(region, side=KINDS["simcc"].share * region.side).to_picture(192, 256)
    share = height / (256 * shown[1, 1])
    assert 0.8 / 1.15 < share < 0.8 * 1.15


class Broken:
    """A runtime whose numbers ran over."""

    name = "broken"

    def run(self, image: NDArray[np.float32]) -> list[NDArray[np.float32]]:
        outputs = [np.zeros((1, 17, 2 * side), np.float32) for side in (192, 256)]
        outputs[0][0, 3, 200] = np.nan
        return outputs


def test_a_joint_that_is_no_number_is_nowhere(tmp_path: Path) -> None:
    model = added(tmp_path, tiny.simcc())
    assert model.heads is not None
    seen = JointNetwork(model, model.heads, Broken()).infer(spots(PLACES), REGION)
    assert np.flatnonzero(~np.isfinite(seen.uv).all(axis=1)).tolist() == [3]


BOXES = np.array([(0, 0, 90, 200, 0.9), (200, 200, 440, 600, 0.8), (300, 320, 340, 330, 0.05)])
PEOPLE = np.arange(3 * 17 * 3.0).reshape(3, 17, 3)


def test_of_several_people_the_one_in_the_middle_is_taken() -> None:
    uv, confidence = KINDS["rtmo"].decoded([BOXES[None], PEOPLE[None]], (640, 640))
    assert np.array_equal(uv, PEOPLE[1, :, :2])
    assert (confidence == 1.0).all()


@pytest.mark.parametrize("count", [0, 1])
def test_where_nobody_is_seen_there_are_no_joints(count: int) -> None:
    boxes = np.zeros((count, 5))
    uv, confidence = KINDS["rtmo"].decoded([boxes[None], PEOPLE[None, :count]], (640, 640))
    assert uv.shape == (17, 2)
    assert np.isnan(uv).all()
    assert (confidence == 0.0).all()


def test_rtmo_is_shown_blue_first() -> None:
    levels = np.zeros((3, 2, 2), np.float32)
    levels[0] = 255
    assert KINDS["rtmo"].prepared(levels)[:, 0, 0].tolist() == [0, 0, 255]


def test_rtmo_says_that_it_needs_onnx_runtime(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where there are no wheels of it."""
    monkeypatch.setattr(joint_network, "fast_is_here", lambda suffix: False)
    path = tmp_path / "network.onnx"
    path.write_bytes(tiny.rtmo(BOXES.astype(np.float32), PEOPLE.astype(np.float32)))
    with pytest.raises(KeypointError, match=r"RTMO needs ONNX Runtime.*pip install onnxruntime"):
        recognised(path, "It")


@pytest.mark.skipif(not fast_is_here(ONNX), reason="ONNX Runtime is not installed")
def test_rtmo_gives_pixels_of_the_picture(tmp_path: Path) -> None:
    network = JointNetwork.open(
        added(tmp_path, tiny.rtmo(BOXES.astype(np.float32), PEOPLE.astype(np.float32)))
    )
    seen = network.infer(spots(PLACES), REGION)
    left, top = REGION.x - REGION.side / 2, REGION.y - REGION.side / 2
    expected = (PEOPLE[1, :, :2] + 0.5) * REGION.side / 640 + (left, top)
    assert seen.uv == pytest.approx(expected, abs=1e-6)


@pytest.mark.skipif(not fast_is_here(ONNX), reason="ONNX Runtime is not installed")
@pytest.mark.parametrize("name", TINY)
def test_onnx_runtime_gives_the_same(tmp_path: Path, name: str) -> None:
    model = added(tmp_path, TINY[name][0])
    slow, fast = (JointNetwork.open(model, fast=fast) for fast in (False, True))
    one, other = (network.infer(spots(PLACES), REGION) for network in (slow, fast))
    assert one.uv == pytest.approx(other.uv, abs=0.01)


def test_the_largest_real_networks_fit() -> None:
    assert LARGEST_BYTES > 235e6
