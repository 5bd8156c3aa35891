"""What goes between this program and the child process that reads files: plain facts and arrays.

A question is one line of JSON. An answer is a length (8 bytes), so much JSON, and the bytes of the
arrays that the JSON names. Nothing of it is ever executed, as a pickle would be.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping
from typing import IO, Any, Final

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.surface.files.parsing.raw import MOST_FACES, MOST_VERTICES

_TYPES: Final[dict[str, np.dtype[Any]]] = {"float": np.dtype("<f8"), "index": np.dtype("<i4")}
_LONGEST_HEADER: Final = 64 * 1024
"""Bytes of what describes a mesh between our processes."""
_MOST_NUMBERS: Final = 3 * max(MOST_FACES, MOST_VERTICES)


class BrokenConnection(Exception):
    """The other side ended, or sent nonsense."""


def ask(stream: IO[bytes], question: Mapping[str, Any]) -> None:
    """Send a question."""
    stream.write(json.dumps(question).encode() + b"\n")
    stream.flush()


def question_of(line: bytes) -> dict[str, Any]:
    """The question of a line."""
    return dict(json.loads(line))


def answer(
    stream: IO[bytes], facts: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]] | None = None
) -> None:
    """Send an answer: floats as float64, integers as int32."""
    kinds = {
        name: "float" if array.dtype.kind == "f" else "index"
        for name, array in (arrays or {}).items()
    }
    shapes = [[name, kinds[name], *array.shape] for name, array in (arrays or {}).items()]
    header = json.dumps({"facts": dict(facts), "arrays": shapes}).encode()
    stream.write(struct.pack("<Q", len(header)) + header)
    for name, array in (arrays or {}).items():
        stream.write(np.ascontiguousarray(array, _TYPES[kinds[name]]).data)
    stream.flush()


def receive(stream: IO[bytes]) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """An answer's facts and arrays. BrokenConnection where the child ended or sent nonsense."""
    (length,) = struct.unpack("<Q", _exactly(stream, 8))
    if length > _LONGEST_HEADER:
        raise BrokenConnection
    try:
        header = json.loads(_exactly(stream, length))
        facts = dict(header["facts"])
        arrays = {
            str(name): _array(stream, str(kind), shape) for name, kind, *shape in header["arrays"]
        }
    except (ValueError, TypeError, LookupError, OverflowError, RecursionError) as error:
        raise BrokenConnection from error
    return facts, arrays


def _array(stream: IO[bytes], kind: str, shape: list[Any]) -> NDArray[Any]:
    sizes = [int(size) for size in shape]
    count = int(np.prod(sizes, dtype=object))
    if min(sizes) < 0 or not 0 <= count <= _MOST_NUMBERS:
        raise BrokenConnection
    content = _exactly(stream, count * _TYPES[kind].itemsize)
    return np.frombuffer(content, _TYPES[kind]).reshape(sizes)


def _exactly(stream: IO[bytes], length: int) -> bytes:
    content = stream.read(length)
    if len(content) != length:
        raise BrokenConnection
    return content
