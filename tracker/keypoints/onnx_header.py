"""Read what an ONNX file says of its inputs, outputs and nodes, without running it.

The file is a protobuf message; its fields are numbered as in onnx.proto.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Final, TypeAlias

Shape: TypeAlias = "tuple[int | None, ...]"
"""None where the file leaves a size open."""

_GRAPH = 7
_SETS = 8
_NODE = 1
_WEIGHTS = 5
_INPUT = 11
_OUTPUT = 12
_SET_DOMAIN = 1
_SET_VERSION = 2
_NODE_INPUT = 1
_NODE_OUTPUT = 2
_NODE_OPERATION = 4
_NODE_ATTRIBUTE = 5
_ATTRIBUTE_NAME = 1
_NUMBER = 3
_WORD = 4
_ARRAY = 5
_SUBGRAPH = 6
_NUMBERS = 8
_ARRAY_SIZES = 1
_ARRAY_TYPE = 2
_ARRAY_FLOATS = 4
_ARRAY_RAW = 9
_NAME = 1
_TYPE = 2
_WEIGHTS_NAME = 8
_TENSOR = 1
_ELEMENTS = 1
_SHAPE = 2
_DIM = 1
_SIZE = 1
_FLOAT32: Final = 1
_VARINT = 0
_BYTES = 2
"""Numbers of the fields of onnx.proto3 by the message they stand in, the number of its type for
32-bit floats, and the wire types of Protocol Buffers that matter here."""
_FIXED: Final = {1: 8, 5: 4}
"""Bytes of a field, by its wire type."""
_LONGEST_VARINT: Final = 10
"""Bytes of a whole number in seven bits each."""
_FEW_BYTES: Final = 1024
"""Of constants whose values are read: scales, not weights."""


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


@dataclass(frozen=True)
class Constant:
    """An array that the file holds. values: of float32 ones, empty of others."""

    sizes: tuple[int, ...]
    values: tuple[float, ...]


@dataclass(frozen=True)
class Node:
    """An operation. attributes: whole numbers, lists of them and words, by name; constants: of its
    inputs, by place."""

    operation: str
    inputs: tuple[str, ...]
    attributes: Mapping[str, int | tuple[int, ...] | str]
    constants: Mapping[int, Constant]


def read_nodes(content: bytes) -> tuple[list[Node], int]:
    """All operations, also of graphs within operations, and the version of the operator set.
    ValueError where it is no ONNX file, or a part of one."""
    whole = memoryview(content)
    version = 1
    for number, value in _fields(whole):
        if number == _SETS:
            of = dict(_fields(_message(value)))
            domain = _text(_message(of.get(_SET_DOMAIN, memoryview(b""))))
            set_version = of.get(_SET_VERSION, 1)
            if domain in ("", "ai.onnx") and isinstance(set_version, int):
                version = set_version
    return list(_nodes(_last(whole, _GRAPH), {})), version


def _nodes(graph: memoryview, outer_constants: Mapping[str, Constant]) -> Iterator[Node]:
    constants = dict(outer_constants)
    for number, value in _fields(graph):
        if number == _WEIGHTS:
            array = _message(value)
            constants[_text(_last(array, _WEIGHTS_NAME))] = _constant(array)
    for number, value in _fields(graph):
        if number == _NODE:
            yield from _node(_message(value), constants)


def _node(message: memoryview, constants: dict[str, Constant]) -> Iterator[Node]:
    """A node, and those of the graphs within it; what a Constant holds is known from there on."""
    inputs, outputs, operation = [], [], ""
    attributes: dict[str, int | tuple[int, ...] | str] = {}
    for number, value in _fields(message):
        if number == _NODE_INPUT:
            inputs.append(_text(_message(value)))
        elif number == _NODE_OUTPUT:
            outputs.append(_text(_message(value)))
        elif number == _NODE_OPERATION:
            operation = _text(_message(value))
        elif number == _NODE_ATTRIBUTE:
            attribute = _message(value)
            name = _text(_last(attribute, _ATTRIBUTE_NAME))
            attributes |= _attribute(name, attribute)
            if subgraph := _last(attribute, _SUBGRAPH):
                yield from _nodes(subgraph, constants)
            if operation == "Constant" and (array := _last(attribute, _ARRAY)) and outputs:
                constants[outputs[0]] = _constant(array)
    held = {place: constants[name] for place, name in enumerate(inputs) if name in constants}
    yield Node(operation, tuple(inputs), attributes, held)


def _attribute(name: str, message: memoryview) -> dict[str, int | tuple[int, ...] | str]:
    numbers = _numbers(message, _NUMBERS)
    for number, value in _fields(message):
        if number == _NUMBER and isinstance(value, int):
            return {name: _signed(value)}
        if number == _WORD:
            return {name: _text(_message(value))}
    return {name: numbers} if numbers else {}


def _constant(array: memoryview) -> Constant:
    sizes, floats = _numbers(array, _ARRAY_SIZES), _last_or_none(array, _ARRAY_FLOATS)
    is_float = (_ARRAY_TYPE, _FLOAT32) in _fields(array)
    raw = _last(array, _ARRAY_RAW) if floats is None else floats
    if not is_float or len(raw) > _FEW_BYTES or len(raw) % 4:
        return Constant(sizes, ())
    return Constant(sizes, struct.unpack(f"<{len(raw) // 4}f", raw))


def _last_or_none(message: memoryview, wanted: int) -> memoryview | None:
    field = _last(message, wanted)
    return field if len(field) else None


def _numbers(message: memoryview, wanted: int) -> tuple[int, ...]:
    """Whole numbers of a field, one by one or packed."""
    numbers: list[int] = []
    for number, value in _fields(message):
        if number != wanted:
            continue
        if isinstance(value, int):
            numbers.append(_signed(value))
            continue
        at = 0
        while at < len(value):
            packed, at = _varint(value, at)
            numbers.append(_signed(packed))
    return tuple(numbers)


def _signed(value: int) -> int:
    """A number of 64 bits, which may be negative."""
    return value - 2**64 if value >= 2**63 else value


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
    messages = [_message(value) for number, value in _fields(message) if number == wanted]
    return messages[-1] if messages else memoryview(b"")


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
