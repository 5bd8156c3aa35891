"""MoveNet: it finds what was marked, wherever the person is, however the region is turned."""

from __future__ import annotations

import hashlib
from dataclasses import replace

import numpy as np
import pytest

from keypose.tracker.keypoints.joint_network import JointNetwork
from keypose.tracker.keypoints.model_files import THUNDER, verified
from keypose.tracker.keypoints.region import Region
from keypose.tracker.keypoints.runtimes import ONNX, fast_is_here
from tests.tracker.keypoints import keypoint_cases as cases


@pytest.fixture(scope="module")
def thunder() -> JointNetwork:
    return JointNetwork.open(THUNDER, fast=False)


@pytest.fixture(scope="module")
def picture() -> np.ndarray:
    with cases.balance() as video:
        return video.frame(0)


REGION = Region(315.0, 440.0, 560.0)


def test_marked_joints_are_found_to_a_hundredth_of_the_mans_height(
    thunder: JointNetwork, picture: np.ndarray
) -> None:
    seen, marked = thunder.infer(picture, REGION), cases.marks()[0]
    height = np.ptp([uv[1] for uv in marked.values()])
    off = [seen.uv[k] - marked[name] for k, name in enumerate(thunder.names) if name in marked]
    assert len(off) >= 10
    assert np.median(np.hypot(*np.transpose(off))) < 0.015 * height
    assert (seen.confidence[5:] > 0.5).all()


def test_a_turned_picture_gives_turned_joints(thunder: JointNetwork, picture: np.ndarray) -> None:
    straight = thunder.infer(picture, REGION)
    turned = np.ascontiguousarray(np.rot90(picture, -1))  # clockwise
    height = picture.shape[0]
    there = replace(REGION, x=height - 1 - REGION.y, y=REGION.x, turn_rad=np.pi / 2)
    again = thunder.infer(turned, there)
    expected = np.column_stack([height - 1 - straight.uv[:, 1], straight.uv[:, 0]])
    assert again.uv == pytest.approx(expected, abs=0.5)


def test_the_same_picture_gives_the_same_numbers(
    thunder: JointNetwork, picture: np.ndarray
) -> None:
    other = JointNetwork.open(THUNDER, fast=False)
    assert np.array_equal(thunder.infer(picture, REGION).uv, other.infer(picture, REGION).uv)


@pytest.mark.skipif(not fast_is_here(ONNX), reason="ONNX Runtime is not installed")
def test_onnx_runtime_agrees_to_a_hundredth_of_a_pixel(
    thunder: JointNetwork, picture: np.ndarray
) -> None:
    other = JointNetwork.open(THUNDER, fast=True)
    assert other.infer(picture, REGION).uv == pytest.approx(
        thunder.infer(picture, REGION).uv, abs=0.01
    )


def test_the_bundled_file_is_the_one_it_is_named_for() -> None:
    assert hashlib.sha256(verified(THUNDER)).hexdigest() == THUNDER.sha256
    assert THUNDER.sha256 in THUNDER.path.with_name("NOTICE").read_text()
