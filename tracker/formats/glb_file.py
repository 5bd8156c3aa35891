"""The container of a GLB file: one JSON document and one block of numbers it points into.

Written here because it is short: trimesh writes no animations, and pygltflib takes 150 ms where
this takes 0.3, and adds six packages.
"""

from __future__ import annotations

import json
import struct
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

Kind: TypeAlias = Literal["SCALAR", "VEC2", "VEC3", "VEC4", "MAT4"]
Purpose: TypeAlias = Literal["vertices", "indices", "animation", "skin"]

MAGIC = 0x46546C67
VERSION = 2
JSON_CHUNK = 0x4E4F534A
BINARY_CHUNK = 0x004E4942
ALIGNMENT = 4
"""Numbers of the header and of chunks: the Binary glTF file format, version 2.0."""

_COMPONENTS = {np.dtype("<f4"): 5126, np.dtype("<u2"): 5123, np.dtype("<u4"): 5125}
_TARGETS: dict[Purpose, int | None] = {
    "vertices": 34962,
    "indices": 34963,
    "animation": None,
    "skin": None,
}


class Numbers:
    """The block of numbers while it is filled; adding an array returns its accessor's number."""

    def __init__(self) -> None:
        self._content = bytearray()
        self._views: list[dict[str, Any]] = []
        self._accessors: list[dict[str, Any]] = []

    def add(
        self, values: NDArray[Any], kind: Kind, purpose: Purpose, *, bounded: bool = False
    ) -> int:
        """Append an array of float32, uint16 or uint32; bounded: with its minimum and maximum."""
        self._view(values, purpose)
        accessor = {
            "bufferView": len(self._views) - 1,
            "componentType": _COMPONENTS[values.dtype.newbyteorder("<")],
            "count": len(values),
            "type": kind,
        }
        if bounded:
            columns = values.reshape(len(values), -1)
            accessor["min"] = columns.min(axis=0).tolist()
            accessor["max"] = columns.max(axis=0).tolist()
        self._accessors.append(accessor)
        return len(self._accessors) - 1

    def file(self, document: dict[str, Any]) -> bytes:
        """The bytes of the file; the document lacks nothing but its numbers."""
        filled = document | {
            "accessors": self._accessors,
            "bufferViews": self._views,
            "buffers": [{"byteLength": len(self._content)}],
        }
        text = json.dumps(filled, separators=(",", ":"), allow_nan=False).encode()
        body = _chunk(JSON_CHUNK, text, b" ") + _chunk(BINARY_CHUNK, bytes(self._content), b"\0")
        return struct.pack("<III", MAGIC, VERSION, 12 + len(body)) + body

    def _view(self, values: NDArray[Any], purpose: Purpose) -> None:
        content = values.astype(values.dtype.newbyteorder("<")).tobytes()
        view = {"buffer": 0, "byteOffset": len(self._content), "byteLength": len(content)}
        target = _TARGETS[purpose]
        self._views.append(view if target is None else view | {"target": target})
        self._content += _padded(content, b"\0")


def _chunk(kind: int, content: bytes, filler: bytes) -> bytes:
    padded = _padded(content, filler)
    return struct.pack("<II", len(padded), kind) + padded


def _padded(content: bytes, filler: bytes) -> bytes:
    return content + filler * (-len(content) % ALIGNMENT)
