"""The container of a GLB file: a document, and a block of numbers that it points into.

Every offset and number is checked against the block before it is used. Other files that a document
may name (textures, buffers beside it, addresses) are never opened.

Own code: pygltflib takes 8 s for 20,000 nodes, not 40 ms, and checks no offset against its block.
"""

from __future__ import annotations

import json
import os
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, BinaryIO, Final, TypeVar

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.surface.files.parsing.raw import MOST_FACES, Refused

_JSON, _BINARY = 0x4E4F534A, 0x004E4942
_LONGEST_DOCUMENT: Final = 64 * 2**20
_MOST_ROWS: Final = 3 * MOST_FACES

_COMPONENTS: Final = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS: Final = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
_COMPRESSED: Final = {"KHR_draco_mesh_compression", "EXT_meshopt_compression"}

T = TypeVar("T")


def damaged() -> Refused:
    """The refusal of a document that contradicts itself."""
    return Refused("is a damaged GLB file, its parts do not fit together: export it again.")


def at(items: Sequence[T], index: Any) -> T:
    """items[index]. Refused where there is none; a negative index means none."""
    if not isinstance(index, int) or not 0 <= index < len(items):
        raise damaged()
    return items[index]


@dataclass(frozen=True, eq=False)
class Glb:
    """A document, and its block of numbers."""

    document: dict[str, Any]
    block: bytes

    @classmethod
    def read(cls, file: BinaryIO) -> Glb:
        """Refused where it is no GLB file of version 2, or is cut short."""
        length = _require_head(file)
        try:
            document = json.loads(_chunk(file, _JSON, _LONGEST_DOCUMENT) or b"null")
        except (ValueError, RecursionError):
            raise Refused("cannot be read: export it again.") from None
        block = _chunk(file, _BINARY, length)
        if not isinstance(document, dict):
            raise damaged()
        if _COMPRESSED & {*document.get("extensionsRequired", [])}:
            raise Refused("holds a compressed mesh: export it without mesh compression.")
        return cls(document, block)

    def items(self, name: str) -> list[Any]:
        """One of the document's lists; empty where it has none."""
        found = self.document.get(name, [])
        if not isinstance(found, list):
            raise damaged()
        return found

    def count(self, accessor: Any) -> int:
        """How many rows an accessor announces."""
        count = at(self.items("accessors"), accessor)["count"]
        if not isinstance(count, int) or count <= 0:
            raise damaged()
        return count

    def numbers(self, accessor: Any, *widths: int) -> NDArray[Any]:
        """(count, width) numbers of an accessor, width one of `widths`; normalised ones as floats.

        Floats are a view into the block where they can be. Refused where they do not lie within it.
        """
        facts = at(self.items("accessors"), accessor)
        count, width = self.count(accessor), _WIDTHS.get(facts["type"], 0)
        if width not in widths or count > _MOST_ROWS or facts["componentType"] not in _COMPONENTS:
            raise damaged()
        kind = np.dtype(_COMPONENTS[facts["componentType"]])
        if "bufferView" in facts:
            values = self._rows(facts, count, width, kind)
        else:
            values = np.zeros((count, width), kind)
        if "sparse" in facts:
            values = self._apply_sparse(values, facts["sparse"])
        if facts.get("normalized", False) and kind.kind != "f":
            return np.maximum(values / np.float64(np.iinfo(kind).max), -1.0)
        return values

    def _apply_sparse(self, values: NDArray[Any], sparse: dict[str, Any]) -> NDArray[Any]:
        """A copy in which some rows are others."""
        count = int(sparse["count"])
        kind = np.dtype(_COMPONENTS[sparse["indices"]["componentType"]])
        rows = self._rows(sparse["indices"], count, 1, kind)[:, 0]
        if kind.kind != "u" or (len(rows) and rows.max() >= len(values)):
            raise damaged()
        values = values.copy()
        values[rows] = self._rows(sparse["values"], count, values.shape[1], values.dtype)
        return values

    def _rows(
        self, place: dict[str, Any], count: int, width: int, kind: np.dtype[Any]
    ) -> NDArray[Any]:
        """(count, width) numbers that begin at `byteOffset` of a `bufferView`."""
        view = at(self.items("bufferViews"), place["bufferView"])
        if "uri" in at(self.items("buffers"), view["buffer"]) or view["buffer"] != 0:
            raise Refused("keeps its numbers in other files: export it as a single GLB file.")
        row = width * kind.itemsize
        stride = view.get("byteStride", row)
        start, offset = view.get("byteOffset", 0), place.get("byteOffset", 0)
        least = min(start, offset, count, stride - row)
        end = offset + stride * (count - 1) + row
        if least < 0 or end > view["byteLength"] or start + end > len(self.block):
            raise damaged()
        shape, strides = (count, width), (stride, kind.itemsize)
        return np.ndarray(shape, kind, self.block, start + offset, strides)


def require_whole(file: BinaryIO) -> None:
    """Refused where the file is no GLB file of version 2, or ends before what it announces."""
    whole = _require_head(file)
    for wanted, longest in ((_JSON, _LONGEST_DOCUMENT), (_BINARY, whole)):
        head = file.read(8)
        length = _length(head, wanted, longest) if head else 0
        if length > _bytes_left(file):
            raise _cut_short()
        file.seek(length, os.SEEK_CUR)


def _cut_short() -> Refused:
    return Refused("is cut short: export it again.")


def _require_head(file: BinaryIO) -> int:
    """How long the file says it is."""
    head = file.read(12)
    if head[:4] != b"glTF" or len(head) < 12:
        raise Refused("does not begin as a GLB file does: export it again.")
    version, length = struct.unpack("<II", head[4:])
    if version != 2:
        raise Refused(f"is a GLB file of version {version}: export it as version 2.")
    return int(length)


def _bytes_left(file: BinaryIO) -> int:
    """Bytes that are not read yet."""
    return os.fstat(file.fileno()).st_size - file.tell()


def _length(head: bytes, wanted: int, longest: int) -> int:
    """Of the chunk with this head (8 bytes)."""
    length, kind = struct.unpack("<II", head) if len(head) == 8 else (0, 0)
    if kind != wanted or length > longest:
        raise damaged()
    return int(length)


def _chunk(file: BinaryIO, wanted: int, longest: int) -> bytes:
    """The content of the next chunk; nothing where there is none. Refused where it is cut short."""
    head = file.read(8)
    if not head:
        return b""
    length = _length(head, wanted, longest)
    content = file.read(length)
    if len(content) < length:
        raise _cut_short()
    return content
