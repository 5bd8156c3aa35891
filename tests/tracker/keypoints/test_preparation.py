"""How a network is shown pictures: as its file says, or as it finds a person, and that is said."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from keypose.tracker.errors import KeypointError
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints import known_person
from keypose.tracker.keypoints.joint_kinds import IMAGENET, KINDS, prepared
from keypose.tracker.keypoints.joint_network import JointNetwork
from keypose.tracker.keypoints.known_person import REGION, WAYS, seen_on_person
from keypose.tracker.keypoints.layouts import LAYOUTS
from keypose.tracker.keypoints.mmdeploy import levels_of
from keypose.tracker.keypoints.model_files import THUNDER, JointHeads, Levels
from keypose.tracker.keypoints.runtimes import Tensor

SIZE = (192, 256)
HEADS = JointHeads(
    kind="simcc", layout="COCO_17", width=SIZE[0], height=SIZE[1], outputs=("simcc_x", "simcc_y")
)
USUAL = {"type": "Normalize", "mean": IMAGENET.mean, "std": IMAGENET.std, "to_rgb": True}
BLUE_FIRST = {"type": "Normalize", "mean": [0, 0, 0], "std": [255, 255, 255], "to_rgb": False}
TENSOR = {"type": "NormalizeTensor", "mean": [0.485, 0.456, 0.406], "std": [0.229, 0.224, 0.225]}


def pipeline(*steps: dict[str, Any]) -> bytes:
    usual = [{"type": "LoadImageFromFile"}, {"type": "TopDownAffine", "image_size": list(SIZE)}]
    tasks = [{"name": "Preprocess", "transforms": [*usual, *steps, {"type": "PackPoseInputs"}]}]
    return json.dumps({"pipeline": {"tasks": [*tasks, {"name": "simcc"}]}}).encode()


SAID = {
    "as RTMPose's": (pipeline(USUAL), IMAGENET),
    "blue first, from 0 to 1": (
        pipeline(BLUE_FIRST), Levels(mean=(0, 0, 0), std=(255, 255, 255), rgb=False)
    ),
    "as older ones have it": (pipeline(TENSOR), IMAGENET),
    "nothing": (b"{}", None),
    "no normalisation": (pipeline(), None),
}  # fmt: skip


@pytest.mark.parametrize("said", SAID)
def test_a_pipeline_is_followed(said: str) -> None:
    content, expected = SAID[said]
    found = levels_of(content, SIZE, "it")
    if found is None or expected is None:
        assert found is expected
        return
    assert found.rgb == expected.rgb
    assert found.mean == pytest.approx(expected.mean, rel=1e-3)
    assert found.std == pytest.approx(expected.std, rel=1e-3)


REFUSED = {
    "a step that is not known": (pipeline({"type": "BottomupResize"}), "'BottomupResize'"),
    "another size": (
        pipeline({"type": "TopDownAffine", "image_size": [288, 384]}), "of 288 × 384 pixels"
    ),
    "no deviation": (pipeline({**USUAL, "std": [0, 1, 1]}), "is damaged"),
    "four means": (pipeline({**USUAL, "mean": [1, 2, 3, 4]}), "is damaged"),
    "no JSON": (b"{", "is damaged"),
    "a list": (b"[]", "is damaged"),
    "words": (pipeline({**USUAL, "mean": "low"}), "is damaged"),
}  # fmt: skip


@pytest.mark.parametrize("wrong", REFUSED)
def test_a_pipeline_that_cannot_be_followed_is_refused(wrong: str) -> None:
    content, words = REFUSED[wrong]
    with pytest.raises(KeypointError, match=words):
        levels_of(content, SIZE, "it")


def test_a_picture_is_shown_blue_first_where_that_is_said() -> None:
    picture = np.arange(12, dtype=np.float32).reshape(3, 2, 2)
    levels = Levels(mean=(1, 2, 3), std=(2, 2, 2), rgb=False)
    shown = prepared(HEADS.model_copy(update={"levels": levels}), picture)
    assert shown[0, 0, 0] == pytest.approx((8 - 1) / 2)
    assert shown[2, 1, 1] == pytest.approx((3 - 3) / 2)
    np.testing.assert_array_equal(prepared(HEADS, picture), KINDS["simcc"].prepared(picture))


class Trained:
    """A network that was trained on pictures shown in one way, and sees nothing otherwise."""

    name = "trained"

    def __init__(self, levels: Levels) -> None:
        self._expected = self._shown(levels)
        network = JointNetwork.open(THUNDER, fast=False)
        uv = network.infer(known_person._picture(), REGION).uv
        share = KINDS["simcc"].share
        to_picture = replace(REGION, side=share * REGION.side).to_picture(*SIZE)
        self._xy = (uv - to_picture[:, 2]) @ np.linalg.inv(to_picture[:, :2]).T

    def _shown(self, levels: Levels) -> Array:
        seen: list[Tensor] = []

        class Sees:
            name = "sees"

            def run(self, image: Tensor) -> list[Tensor]:
                seen.append(image)
                return [np.zeros((1, 17, 2 * side), np.float32) for side in SIZE]

        seen_on_person(HEADS.model_copy(update={"levels": levels}), Sees())
        return seen[0]

    def run(self, image: Tensor) -> list[Tensor]:
        found = [np.zeros((1, 17, 2 * side), np.float32) for side in SIZE]
        if np.allclose(image, self._expected, atol=1e-3):
            for k, (x, y) in enumerate(self._xy):
                found[0][0, k, round(2 * x)] = found[1][0, k, round(2 * y)] = 1
        return found


@pytest.mark.parametrize("way", range(len(WAYS)))
def test_a_network_is_shown_pictures_as_it_finds_a_person(way: int) -> None:
    heads = seen_on_person(HEADS, Trained(WAYS[way]))
    assert heads.finds is not None
    assert heads.finds >= 15
    assert heads.levels in ((None, WAYS[0]) if way == 0 else (WAYS[way],))


def test_what_its_file_says_is_not_changed_but_what_it_finds_is_counted() -> None:
    said = HEADS.model_copy(update={"levels": WAYS[3]})
    heads = seen_on_person(said, Trained(WAYS[1]))
    assert heads.levels == WAYS[3]
    assert heads.finds == 0


def test_the_order_of_names_is_that_of_the_person_in_the_picture() -> None:
    assert tuple(known_person._joints()) == LAYOUTS["COCO_17"]
