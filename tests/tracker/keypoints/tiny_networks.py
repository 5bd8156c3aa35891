"""ONNX files of a few operations with the inputs and outputs of real networks of joints.

Their joints are the brightest pixels: joint k sees the level k mod 3, red, green or blue.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float32]
_FLOAT32 = 1
_INT64 = 7
_INT = 2
_TEXT = 3
_INTS = 7
"""Types of attributes."""


def field(number: int, value: int | str | bytes) -> bytes:
    """One field of a protobuf message: a number, or bytes with their length before them."""
    if isinstance(value, int):
        return _varint(number << 3) + _varint(value)
    content = value.encode() if isinstance(value, str) else value
    return _varint(number << 3 | 2) + _varint(len(content)) + content


def _varint(value: int) -> bytes:
    value %= 2**64  # negative ones as 64 bits have them
    low = value & 0x7F
    return bytes([low]) if value < 0x80 else bytes([low | 0x80]) + _varint(value >> 7)


def node(
    operation: str, inputs: Sequence[str], output: str, **attributes: list[int] | int | str
) -> bytes:
    written = b"".join(field(1, name) for name in inputs) + field(2, output) + field(4, operation)
    for name, value in attributes.items():
        if isinstance(value, list):
            content, kind = b"".join(field(8, n) for n in value), _INTS
        elif isinstance(value, str):
            content, kind = field(4, value), _TEXT
        else:
            content, kind = field(3, value), _INT
        written += field(5, field(1, name) + content + field(20, kind))
    return written


def model(
    nodes: Sequence[bytes],
    weights: Mapping[str, Array],
    inputs: Mapping[str, tuple[int | str, ...]],
    outputs: Mapping[str, tuple[int | str, ...]],
    version: int = 11,
) -> bytes:
    """version: of the operator set."""
    graph = b"".join(field(1, each) for each in nodes) + field(2, "tiny")
    for name, array in weights.items():
        sizes = b"".join(field(1, size) for size in array.shape)
        content = field(2, _FLOAT32) + field(8, name) + field(9, array.astype("<f4").tobytes())
        graph += field(5, sizes + content)
    for number, named in ((11, inputs), (12, outputs)):
        for name, shape in named.items():
            graph += field(number, _value(name, shape))
    return field(1, 6) + field(7, graph) + field(8, field(1, "") + field(2, version))


def _value(name: str, shape: tuple[int | str, ...]) -> bytes:
    dims = (field(1, field(1 if isinstance(size, int) else 2, size)) for size in shape)
    tensor = field(1, _FLOAT32) + field(2, b"".join(dims))
    return field(1, name) + field(2, field(1, tensor))


def _levels(count: int) -> Array:
    """Weights (K, 3, 1, 1) that choose each joint's level."""
    return np.eye(3, dtype=np.float32)[np.arange(count) % 3][:, :, None, None]


def between(cells: int, places: Array) -> Array:
    """(cells, places) weights of a cubic curve through the cells, at these places."""
    x = np.abs(np.arange(cells)[:, None] - places)
    near, far = 1.5 * x**3 - 2.5 * x**2 + 1, -0.5 * x**3 + 2.5 * x**2 - 4 * x + 2
    return np.where(x < 1, near, np.where(x < 2, far, 0)).astype(np.float32)


def simcc(
    count: int = 17,
    width: int = 192,
    height: int = 256,
    batch: int | str = "batch",
    names: tuple[str, str] = ("simcc_x", "simcc_y"),
    also: Sequence[bytes] = (),
) -> bytes:
    """As RTMPose: the brightest of each column and row, twice as many of them as pixels.

    also: operations whose outputs nobody asks for.
    """
    nodes = [node("Conv", ["input", "levels"], "seen")]
    weights = {"levels": _levels(count)}
    outputs = {}
    nodes += also
    for axis, side, over, name in (("x", width, 2, names[0]), ("y", height, 3, names[1])):
        weights[f"to_{axis}"] = between(side, np.arange(2 * side) / 2)
        nodes.append(node("ReduceMax", ["seen"], axis, axes=[over], keepdims=0))
        nodes.append(node("MatMul", [axis, f"to_{axis}"], name))
        outputs[name] = (batch, count, 2 * side)
    return model(nodes, weights, {"input": (batch, 3, height, width)}, outputs)


def maps(
    count: int = 17, width: int = 192, height: int = 256, cells: int = 4, is_open: bool = False
) -> bytes:
    """As ViTPose: a map of every joint, its outermost cells at the outermost pixels."""
    w, h = width // cells, height // cells
    weights = {
        "levels": _levels(count),
        "rows": between(height, np.linspace(0, height - 1, h)).T,
        "columns": between(width, np.linspace(0, width - 1, w)),
    }
    nodes = [
        node("Conv", ["image", "levels"], "seen"),
        node("MatMul", ["seen", "columns"], "narrow"),
        node("MatMul", ["rows", "narrow"], "heatmaps"),
    ]
    shape = ("batch", "channels", "height", "width") if is_open else (1, 3, height, width)
    output = ("batch", count, "rows", "columns") if is_open else (1, count, h, w)
    return model(nodes, weights, {"image": shape}, {"heatmaps": output})


def rtmo(boxes: Array, people: Array, side: int = 640) -> bytes:
    """As RTMO: boxes (N, 5) and joints (N, K, 3) of people, whatever it is shown."""
    nodes = [node("Identity", [name], name.lower()) for name in ("DETS", "KEYPOINTS")]
    weights = {"DETS": boxes[None], "KEYPOINTS": people[None]}
    outputs = {"dets": ("batch", "n", 5), "keypoints": ("batch", "n", *people.shape[1:])}
    return model(nodes, weights, {"input": ("batch", 3, side, side)}, outputs)
