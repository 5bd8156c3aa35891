"""Read what an ONNX file says of its inputs and outputs, without running it.

The file is a protobuf message; its fields are numbered as in onnx.proto.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Final, TypeAlias

Shape: TypeAlias = "tuple[int | None, ...]"
"""None where the file leaves a size open."""

_GRAPH, _WEIGHTS, _INPUT, _OUTPUT = 7, 5, 11, 12
_NAME, _TYPE, _WEIGHTS_NAME = 1, 2, 8
_TENSOR, _ELEMENTS, _SHAPE, _DIM, _SIZE = 1, 1, 2, 1, 1
_FLOAT32: Final = 1
_VARINT, _BYTES = 0, 2
_FIXED: Final = {1: 8, 5: 4}
"""Bytes of a field, by its wire type."""
_LONGEST_VARINT: Final = 10


@dataclass(frozen=True)
class Signature:
    """Shapes of inputs and outputs by their names; those that are not float32 have None."""

    inputs: Mapping[str, Shape | None]
    outputs: Mapping[str, Shape | None]


def read_signature(content: bytes) -> Signature:
    """ValueError where it is no ONNX file, or a part of one."""
    graph = _last(memoryview(content), _GRAPH)
    inputs: dict[str, Shape | None] = {}
    outputs: dict[str, Shape | None] = {}
    weights = set()
    for number, value in _fields(graph):
        if number == _WEIGHTS:
            weights.add(_text(_last(_message(value), _WEIGHTS_NAME)))
        elif number in (_INPUT, _OUTPUT):
            of = inputs if number == _INPUT else outputs
            of[_text(_last(_message(value), _NAME))] = _shape(_message(value))
    return Signature({name: inputs[name] for name in inputs if name not in weights}, outputs)


def _shape(value: memoryview) -> Shape | None:
    tensor = _last(_last(value, _TYPE), _TENSOR)
    if (_ELEMENTS, _FLOAT32) not in _fields(tensor):
        return None
    dims = [_message(dim) for number, dim in _fields(_last(tensor, _SHAPE)) if number == _DIM]
    return tuple(
        next((n for number, n in _fields(dim) if number == _SIZE and isinstance(n, int)), None)
        for dim in dims
    )


def _last(message: memoryview, wanted: int) -> memoryview:
    """A field that is itself a message or text; empty where it is left out."""
    found = [_message(value) for number, value in _fields(message) if number == wanted]
    return found[-1] if found else memoryview(b"")


def _message(value: int | memoryview) -> memoryview:
    if isinstance(value, int):
        raise ValueError("a number stands where a message belongs")
    return value


def _text(value: memoryview) -> str:
    return bytes(value).decode("utf-8")


def _fields(message: memoryview) -> Iterator[tuple[int, int | memoryview]]:
    """Numbers and values of a message's fields; floating-point ones as their bytes."""
    at = 0
    while at < len(message):
        tag, at = _varint(message, at)
        number, wire = tag >> 3, tag & 7
        if wire == _VARINT:
            value, at = _varint(message, at)
            yield number, value
            continue
        if wire == _BYTES:
            size, at = _varint(message, at)
        elif wire in _FIXED:
            size = _FIXED[wire]
        else:
            raise ValueError(f"there are no fields of type {wire}")
        if size > len(message) - at:
            raise ValueError("it ends early")
        yield number, message[at : at + size]
        at += size


def _varint(message: memoryview, at: int) -> tuple[int, int]:
    """A number, seven bits a byte, and where it ends."""
    value = 0
    for k, byte in enumerate(message[at : at + _LONGEST_VARINT]):
        value |= (byte & 0x7F) << 7 * k
        if byte < 0x80:
            return value, at + k + 1
    raise ValueError("it ends early")
