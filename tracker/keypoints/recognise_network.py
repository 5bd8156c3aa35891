"""Tell what kind of network an ONNX file holds, by its inputs and by what it answers with."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

import numpy as np
from pydantic import ValidationError

from keypose.tracker.errors import KeypointError, listed
from keypose.tracker.keypoints.joint_kinds import KINDS
from keypose.tracker.keypoints.joint_network import open_heads
from keypose.tracker.keypoints.layouts import LAYOUTS
from keypose.tracker.keypoints.model_files import JointHeads, JointKind
from keypose.tracker.keypoints.onnx_header import Shape, Signature, read_signature
from keypose.tracker.keypoints.runtimes import cannot_run

_LAYOUTS: Final = ("COCO_17", "HALPE_26", "COCO_WHOLEBODY_133")
_OF_A_HAND: Final = 21
_USUAL: Final = (256, 192)
"""Height and width of ViTPose's input where the file leaves them open."""


def recognised(path: Path, content: bytes, source: str) -> JointHeads:
    """What a network of joints is shown and answers with. It is run once, on a blank picture.

    path, content: of the ONNX file.  source: what it is called in a sentence.
    KeypointError in one sentence where it is no such network, or cannot be run here.
    """
    heads = promised(content, source)
    runtime = open_heads(path, heads)
    blank = np.zeros((3, heads.height, heads.width), np.float32)
    try:
        found = runtime.run(KINDS[heads.kind].prepared(blank))
    except Exception as error:  # noqa: BLE001  ONNX Runtime's have no other base
        raise cannot_run(source, runtime.name, error) from None
    shapes = [output.shape for output in found]
    count = _count(heads, shapes)
    if count is None:
        inputs = read_signature(content).inputs
        outputs = dict(zip(heads.outputs, shapes, strict=True))
        raise _other(source, Signature(inputs, outputs))
    layout = next((name for name in _LAYOUTS if len(LAYOUTS[name]) == count), None)
    if layout is None:
        what = "a hand alone" if count == _OF_A_HAND else f"{count} joints"
        raise KeypointError(
            f"{source} is a network of {what}: only those of a whole person are read, with 17 "
            "(COCO), 26 (Halpe) or 133 joints (COCO-WholeBody)."
        )
    return JointHeads.model_validate({**heads.model_dump(), "layout": layout})


def promised(content: bytes, source: str) -> JointHeads:
    """What its file says of it, without running it; its layout is not known yet."""
    try:
        signature = read_signature(content)
    except ValueError as error:
        raise KeypointError(f"{source} is no ONNX file, or not all of one: {error}.") from None
    heads = _heads(signature)
    if heads is None:
        raise _other(source, signature)
    return heads


def _heads(signature: Signature) -> JointHeads | None:
    """What it may be by names and input."""
    names = set(signature.outputs)
    kind: JointKind | None = next(
        (kind for kind, each in KINDS.items() if each.outputs and names >= set(each.outputs)),
        "maps" if len(names) == 1 else None,
    )
    shapes = list(signature.inputs.values())
    if kind is None or len(shapes) != 1 or shapes[0] is None or len(shapes[0]) != 4:
        return None
    _, levels, height, width = shapes[0]
    if kind == "maps" and (height, width) == (None, None):
        height, width = _USUAL
    outputs = KINDS[kind].outputs or tuple(names)
    if levels not in (3, None):
        return None
    try:
        return JointHeads.model_validate(
            {
                "kind": kind,
                "layout": _LAYOUTS[0],
                "width": width,
                "height": height,
                "outputs": outputs,
            }
        )
    except ValidationError:  # no size, or none of a picture
        return None


def _count(heads: JointHeads, shapes: Sequence[tuple[int, ...]]) -> int | None:
    """How many joints there are; None where the outputs do not fit its kind."""
    width, height = heads.width, heads.height
    match heads.kind, shapes:
        case "simcc", [(1, count, columns), (1, also, rows)] if also == count:
            fits = columns % width == 0 and rows * width == columns * height
        case "maps", [(1, count, rows, columns)]:
            fits = (rows, columns) == (height // 4, width // 4)
        case "rtmo", [(1, people, 5), (1, also, count, 3)]:
            fits = also == people
        case "movenet", [(1, count, cells, also), (1, *reg), (1, *center), (1, *off)]:
            fits = width == height and also == cells and center == [1, cells, cells]
            fits = fits and reg == off == [2 * count, cells, cells]
        case _:
            return None
    return count if fits else None


def _other(source: str, signature: Signature) -> KeypointError:
    known = listed(
        [
            f"{kind.title} ({listed(kind.outputs) or 'one output, a map for each joint'})"
            for kind in KINDS.values()
        ]
    )
    return KeypointError(
        f"{source} has the input {_shown(signature.inputs)} and the output "
        f"{_shown(signature.outputs)}: read are {known}, with one float32 picture of fixed size as "
        "their input."
    )


def _shown(shapes: Mapping[str, Shape | None]) -> str:
    def one(name: str, shape: Shape | None) -> str:
        sizes = "not float32" if shape is None else " × ".join(str(n or "?") for n in shape)
        return f"{name!r:.40} ({sizes})"

    more = [f"{len(shapes) - 4} more"] if len(shapes) > 4 else []
    first = list(shapes.items())[:4]
    return listed([*(one(*each) for each in first), *more]) or "nothing"
