"""Operations that OpenCV computes otherwise are known before a network is trusted to it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from keypose.tracker.keypoints.model_files import THUNDER
from keypose.tracker.keypoints.onnx_header import read_nodes
from keypose.tracker.keypoints.opencv_nodes import differing_operation
from tests.tracker.keypoints import tiny_networks as tiny

SHAPE = (1, 4, 16, 12)
KERNEL = {"kernel_shape": [3, 3]}


def network(
    operation: str,
    inputs: Sequence[str] = ("x",),
    version: int = 13,
    weights: dict[str, Any] | None = None,
    **attributes: Any,
) -> bytes:
    arrays = {name: np.asarray(value, np.float32) for name, value in (weights or {}).items()}
    node = tiny.node(operation, inputs, "y", **attributes)
    return tiny.model([node], arrays, {"x": SHAPE}, {"y": SHAPE}, version)


SCALED = ["x", "", "s"]
SLOPED = ["x", "s"]
OTHERWISE = {
    "softmax of a set of before": network("Softmax", version=11),
    "along the second axis": network("LogSoftmax", version=12, axis=1),
    "as many pixels, more of them first": network("Conv", auto_pad="SAME_LOWER", **KERNEL),
    "as many pixels, by steps": network("Conv", auto_pad="SAME_UPPER", strides=[2, 2], **KERNEL),
    "a pool of the same": network("MaxPool", auto_pad="SAME_UPPER", strides=[1, 2], **KERNEL),
    "a pool that ends late": network("AveragePool", ceil_mode=1, pads=[0, 0, 1, 1], **KERNEL),
    "transposed, of the same size": network("ConvTranspose", auto_pad="SAME_UPPER", **KERNEL),
    "transposed to a size": network("ConvTranspose", output_shape=[32, 24], **KERNEL),
    "smaller without aliases": network("Resize", ["x", "", "", "z"], antialias=1),
    "half as large": network("Resize", SCALED, weights={"s": [1, 1, 0.5, 0.5]}),
    "by what is computed": network("Resize", SCALED),
    "larger by a half": network("Upsample", SLOPED, 9, {"s": [1, 1, 1.5, 2]}),
    "slopes along rows": network("PRelu", SLOPED, weights={"s": np.ones(12)}),
    "slopes of each pixel": network("PRelu", SLOPED, weights={"s": np.ones((4, 16, 12))}),
    "a recurrent one": network("GRU"),
}
THE_SAME = {
    "softmax": network("Softmax", axis=1),
    "softmax along the last axis": network("Softmax", version=11, axis=-1),
    "softmax along the last of four": network("Softmax", version=11, axis=3),
    "padded by numbers": network("Conv", pads=[1, 1, 1, 1], strides=[2, 2], **KERNEL),
    "as many pixels": network("Conv", auto_pad="SAME_UPPER", **KERNEL),
    "valid ones": network("Conv", auto_pad="VALID", strides=[2, 2], **KERNEL),
    "a pool that ends late without padding": network("MaxPool", ceil_mode=1, **KERNEL),
    "transposed": network("ConvTranspose", pads=[1, 1, 1, 1], strides=[2, 2], **KERNEL),
    "twice as large": network("Resize", SCALED, weights={"s": [1, 1, 2, 2]}),
    "to a size": network("Resize", ["x", "", "", "z"]),
    "one slope": network("PRelu", SLOPED, weights={"s": [0.1]}),
    "slopes of channels": network("PRelu", SLOPED, weights={"s": np.ones((4, 1, 1))}),
    "another recurrent one": network("LSTM"),
    "the bundled network": THUNDER.path.read_bytes(),
}


@pytest.mark.parametrize("case", OTHERWISE)
def test_what_opencv_computes_otherwise_is_named(case: str) -> None:
    named = differing_operation(OTHERWISE[case])
    assert named is not None
    assert named.split()[0] in {node.operation for node in read_nodes(OTHERWISE[case])[0]}


@pytest.mark.parametrize("case", THE_SAME)
def test_what_it_computes_alike_is_not(case: str) -> None:
    assert differing_operation(THE_SAME[case]) is None


def test_operations_within_operations_are_known_too() -> None:
    inner = tiny.field(1, tiny.node("GRU", ["x"], "y"))
    branch = tiny.field(1, "then_branch") + tiny.field(6, inner) + tiny.field(20, 5)
    outer = tiny.node("If", ["c"], "y") + tiny.field(5, branch)
    content = tiny.model([outer], {}, {"x": SHAPE}, {"y": SHAPE}, 13)
    assert differing_operation(content) == "GRU layers"


@pytest.mark.parametrize("cut", [1, 7, 40])
def test_a_part_of_a_file_is_none(cut: int) -> None:
    with pytest.raises(ValueError, match=r"."):
        read_nodes(OTHERWISE["half as large"][:-cut])
