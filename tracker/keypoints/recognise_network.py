"""Tell what kind of network an ONNX file holds, by its inputs and by what it answers with."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final, get_args

import numpy as np
from pydantic import ValidationError

from keypose.tracker.errors import KeypointError, listed
from keypose.tracker.files import read_regular
from keypose.tracker.keypoints.joint_kinds import KINDS, prepared
from keypose.tracker.keypoints.joint_network import needs_onnx_runtime, open_heads
from keypose.tracker.keypoints.known_person import seen_on_person
from keypose.tracker.keypoints.layouts import AP_10K, LAYOUTS
from keypose.tracker.keypoints.mmdeploy import levels_of
from keypose.tracker.keypoints.model_files import (
    LARGEST_BYTES,
    OF_ANIMALS,
    JointHeads,
    JointKind,
    JointLayout,
)
from keypose.tracker.keypoints.onnx_header import Shape, Signature, read_signature
from keypose.tracker.keypoints.opencv_nodes import differing_operation
from keypose.tracker.keypoints.runtimes import (
    ONNX,
    Runtime,
    Tensor,
    cannot_run,
    fast_is_here,
    open_runtime,
)

_OF_A_HAND: Final = 21
ALIKE: Final = 0.01
"""A share by which two libraries may differ on noise."""
_USUAL: Final = (256, 192)
"""Height and width of ViTPose's input where the file leaves them open."""


def recognised(
    path: Path, source: str, pipeline: bytes | None = None, animals: bool = False
) -> JointHeads:
    """What a network of joints is shown and answers with. It is run on a blank picture, on noise
    where both libraries are here, and on one of a person, by libraries that it may end: in a
    process of its own.

    path: of the ONNX file.  source: what it is called in a sentence.  pipeline: the
    `pipeline.json` that lies beside it.  animals: whether it is said to see animals, of whom there
    is no picture to show it.
    KeypointError in one sentence where it is no such network, or cannot be run here.
    """
    content = read_regular(path, LARGEST_BYTES)
    heads = promised(content, source)
    if (differs := differing_operation(content)) is not None:
        if not fast_is_here(ONNX):
            raise needs_onnx_runtime(f"{source} has {differs}, which OpenCV computes otherwise: it")
        heads = heads.model_copy(update={"needs_fast": True})
    if pipeline is not None:
        levels = levels_of(pipeline, (heads.width, heads.height), source)
        heads = heads.model_copy(update={"levels": levels})
    runtime = open_heads(path.name, content, heads)
    outputs = _run_blank(runtime, heads, source)
    heads = _with_layout(heads, outputs, content, source, animals)
    if not heads.needs_fast and not KINDS[heads.kind].needs_fast and fast_is_here(ONNX):
        heads = heads.model_copy(update={"needs_fast": _differ_on_noise(path.name, content, heads)})
    return heads if animals else seen_on_person(heads, runtime)


def _run_blank(runtime: Runtime, heads: JointHeads, source: str) -> list[Tensor]:
    blank = np.zeros((3, heads.height, heads.width), np.float32)
    try:
        return runtime.run(prepared(heads, blank))
    except Exception as error:  # noqa: BLE001  ONNX Runtime's have no other base
        raise cannot_run(source, runtime.name, error) from None


def _with_layout(
    heads: JointHeads,
    head_outputs: Sequence[Tensor],
    content: bytes,
    source: str,
    animals: bool,
) -> JointHeads:
    """The same with the order of its joints, by how many there are."""
    shapes = [output.shape for output in head_outputs]
    count = _count(heads, shapes)
    if count is None:
        inputs = read_signature(content).inputs
        outputs = dict(zip(heads.outputs, shapes, strict=True))
        raise _other(source, Signature(inputs, outputs))
    if animals and count != len(AP_10K):
        raise KeypointError(
            f"{source} is a network of {count} joints: of animals are read those with AP-10K's "
            f"{len(AP_10K)}."
        )
    of_people = (name for name in get_args(JointLayout) if name in LAYOUTS)
    layout = next((name for name in of_people if len(LAYOUTS[name]) == count), None)
    layout = OF_ANIMALS if animals else layout
    if layout is None:
        subject = "a hand alone" if count == _OF_A_HAND else f"{count} joints"
        raise KeypointError(
            f"{source} is a network of {subject}: only those of a whole person are read, with 17 "
            "(COCO), 26 (Halpe) or 133 joints (COCO-WholeBody), and of animals with AP-10K's 17."
        )
    return JointHeads.model_validate({**heads.model_dump(), "layout": layout})


def _differ_on_noise(file: str, content: bytes, heads: JointHeads) -> bool:
    """Whether OpenCV answers otherwise than ONNX Runtime, or not at all."""
    levels = np.random.default_rng(0).uniform(0, 255, (3, heads.height, heads.width))
    shown = prepared(heads, levels.astype(np.float32))
    expected = open_runtime(file, content, heads.outputs, fast=True).run(shown)
    try:
        answers = open_runtime(file, content, heads.outputs, fast=False).run(shown)
    except Exception:  # noqa: BLE001  then only the other one runs it, which is what is asked
        return True
    return not all(
        mine.shape == theirs.shape
        and np.allclose(mine, theirs, rtol=ALIKE, atol=ALIKE * _range(theirs))
        for mine, theirs in zip(answers, expected, strict=True)
    )


def _range(values: Tensor) -> float:
    return float(np.ptp(values)) if values.size else 0.0


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
        "maps" if len(names) == 1 else "simcc" if _are_bins(signature) else None,
    )
    shapes = list(signature.inputs.values())
    if kind is None or len(shapes) != 1 or shapes[0] is None or len(shapes[0]) != 4:
        return None
    _, levels, height, width = shapes[0]
    if kind == "maps" and (height, width) == (None, None):
        height, width = _USUAL
    named = KINDS[kind].outputs
    outputs = named if names >= set(named) and named else tuple(signature.outputs)
    if levels not in (3, None):
        return None
    try:
        return JointHeads.model_validate(
            {
                "kind": kind,
                "layout": "COCO_17",  # until its joints are counted
                "width": width,
                "height": height,
                "outputs": outputs,
            }
        )
    except ValidationError:  # no size, or none of a picture
        return None


def _are_bins(signature: Signature) -> bool:
    """Whether two outputs, however they are called, are of each joint the columns, then the rows of
    the input, in equal parts of a pixel."""
    shapes, inputs = list(signature.outputs.values()), list(signature.inputs.values())
    if len(shapes) != 2 or len(inputs) != 1 or inputs[0] is None or len(inputs[0]) != 4:
        return False
    (_, _, height, width), (columns, rows) = inputs[0], shapes
    if columns is None or rows is None or len(columns) != 3 or len(rows) != 3:
        return False
    sizes = (height, width, columns[2], rows[2])
    if any(size is None for size in sizes) or columns[1] != rows[1]:
        return False
    high, wide, across, down = (size or 0 for size in sizes)
    return wide > 0 and across % wide == 0 and across * high == down * wide


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
    readable = listed(
        [
            f"{kind.title} ({listed(kind.outputs) or 'one output, a map for each joint'})"
            for kind in KINDS.values()
        ]
    )
    return KeypointError(
        f"{source} has the input {_shown(signature.inputs)} and the output "
        f"{_shown(signature.outputs)}: read are {readable}, with one float32 picture of fixed size "
        "as their input."
    )


def _shown(shapes: Mapping[str, Shape | None]) -> str:
    def one(name: str, shape: Shape | None) -> str:
        sizes = "not float32" if shape is None else " × ".join(str(n or "?") for n in shape)
        return f"{name!r:.40} ({sizes})"

    more = [f"{len(shapes) - 4} more"] if len(shapes) > 4 else []
    first = list(shapes.items())[:4]
    return listed([*(one(*each) for each in first), *more]) or "nothing"
