"""Operations of ONNX files that OpenCV computes otherwise than ONNX Runtime, without a word.

Found by single operations on noise, OpenCV 5.0.0 beside ONNX Runtime 1.32.0: `findings/` has them.
What OpenCV cannot compute it says itself.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

from keypose.tracker.keypoints.onnx_header import Node, read_nodes

ALONG_ONE_AXIS: Final = 13
"""The operator set from which on Softmax and its like work along one axis, not along all from it
on, which is all that OpenCV knows."""
LAST_OF_FOUR: Final = 3


def differing_operation(content: bytes) -> str | None:
    """Name an operation of an ONNX file that OpenCV computes otherwise; None where there is none.
    ValueError where it is no ONNX file."""
    nodes, version = read_nodes(content)
    for node in nodes:
        differs = _DIFFERS.get(node.operation)
        if differs is not None and (why := differs(node, version)):
            return f"{node.operation} {why}"
    return None


def _softmax(node: Node, version: int) -> str:
    axis = node.attributes.get("axis", 1)
    is_last = axis == -1 or (isinstance(axis, int) and axis >= LAST_OF_FOUR)
    return f"of operator set {version}" if version < ALONG_ONE_AXIS and not is_last else ""


def _auto_pad(node: Node, _: int) -> str:
    pad = node.attributes.get("auto_pad", "NOTSET")
    strides = node.attributes.get("strides", (1,))
    steps = max(strides) if isinstance(strides, tuple) else 1
    if pad == "SAME_LOWER" or (pad == "SAME_UPPER" and steps > 1):
        return f"with auto_pad {pad}"
    return ""


def _pool(node: Node, version: int) -> str:
    pads = node.attributes.get("pads", ())
    if node.attributes.get("ceil_mode") and isinstance(pads, tuple) and any(pads):
        return "with ceil_mode and padding"
    return _auto_pad(node, version)


def _transposed(node: Node, _: int) -> str:
    if "output_shape" in node.attributes:
        return "with output_shape"
    pad = node.attributes.get("auto_pad", "NOTSET")
    return f"with auto_pad {pad}" if pad in ("SAME_UPPER", "SAME_LOWER") else ""


def _resize(node: Node, _: int) -> str:
    if node.attributes.get("antialias"):
        return "with antialias"
    if node.operation == "Resize" and node.inputs[3:4] not in ((), ("",)):
        return ""  # a size is named
    scales = node.constants.get(1 if len(node.inputs) == 2 else 2)
    is_whole = scales is not None and scales.values and all(s % 1 == 0 for s in scales.values)
    return "" if is_whole else "by a scale that is no whole number"


def _prelu(node: Node, _: int) -> str:
    slope = node.constants.get(1)
    if slope is None:
        return "with a slope that is computed"
    wide = [size for size in slope.sizes if size != 1]
    by_channel = len(wide) == 1 and slope.sizes[-3:-2] == tuple(wide)
    return "" if not wide or by_channel else "with slopes along the picture"


def _always(_: Node, __: int) -> str:
    return "layers"


_DIFFERS: Final[Mapping[str, Callable[[Node, int], str]]] = {
    **dict.fromkeys(("Softmax", "LogSoftmax", "Hardmax"), _softmax),
    "Conv": _auto_pad,
    **dict.fromkeys(("MaxPool", "AveragePool"), _pool),
    "ConvTranspose": _transposed,
    **dict.fromkeys(("Resize", "Upsample"), _resize),
    "PRelu": _prelu,
    "GRU": _always,
}
