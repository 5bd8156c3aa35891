"""Mesh files for the tests of reading: written by hand, so that they can be wrong on purpose."""

from __future__ import annotations

import json
import struct
from collections.abc import Sequence
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array

CORNERS = np.array(
    [[x, y, z] for z in (0.0, 1.7) for y in (0.0, 0.3) for x in (0.0, 0.5)], dtype=np.float64
)
"""(8, 3) corners of a box as tall as a person."""
BOX = np.array(
    [
        [0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4],
        [2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6], [1, 3, 5], [3, 7, 5],
    ]
)  # fmt: skip
"""(12, 3) its faces, counter-clockwise seen from outside."""
QUADS = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]


def ply(
    vertices: Array = CORNERS,
    faces: Sequence[Sequence[int]] | NDArray[np.int64] = BOX,
    *,
    form: str = "binary_little_endian",
    extra: dict[str, Array] | None = None,
) -> bytes:
    """A PLY file with float vertices, further columns of them, and faces of any corner count."""
    extra = extra or {}
    order = ">" if form == "binary_big_endian" else "<"
    columns = "".join(f"property float {name}\n" for name in ("x", "y", "z", *extra))
    header = (
        f"ply\nformat {form} 1.0\ncomment by hand\nelement vertex {len(vertices)}\n{columns}"
        f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    ).encode()
    table = np.column_stack([vertices, *extra.values()])
    if form == "ascii":
        rows = [" ".join(f"{value:.9g}" for value in row) for row in table]
        rows += [" ".join(map(str, [len(face), *face])) for face in faces]
        return header + "\n".join(rows).encode() + b"\n"
    body = table.astype(order + "f4").tobytes()
    return (
        header
        + body
        + b"".join(struct.pack(f"{order}B{len(face)}i", len(face), *face) for face in faces)
    )


def obj(
    vertices: Array = CORNERS, faces: Sequence[Sequence[int]] | NDArray[np.int64] = BOX
) -> bytes:
    """An OBJ file."""
    lines = ["v " + " ".join(f"{value:.9g}" for value in vertex) for vertex in vertices]
    lines += ["f " + " ".join(str(corner + 1) for corner in face) for face in faces]
    return "\n".join(lines).encode() + b"\n"


class GlbFile:
    """A GLB file in the making: arrays go in, accessors' numbers come out."""

    _COMPONENTS: ClassVar = {"f4": 5126, "u1": 5121, "u2": 5123, "u4": 5125, "i1": 5120, "i2": 5122}
    _KINDS: ClassVar = {1: "SCALAR", 3: "VEC3", 4: "VEC4", 16: "MAT4"}

    def __init__(self) -> None:
        self.block = bytearray()
        self.document: dict[str, Any] = {
            "asset": {"version": "2.0"},
            "buffers": [{}],
            "bufferViews": [],
            "accessors": [],
            "meshes": [],
            "nodes": [],
        }

    def view(self, values: NDArray[Any]) -> int:
        """The number of a new buffer view that holds the array."""
        self.block += b"\0" * (-len(self.block) % 4)
        facts = {"buffer": 0, "byteOffset": len(self.block), "byteLength": values.nbytes}
        self.block += values.tobytes()
        self.document["bufferViews"].append(facts)
        return len(self.document["bufferViews"]) - 1

    def numbers(self, values: Any, kind: str = "f4", **facts: Any) -> int:
        """The number of a new accessor of (count,) or (count, width) values."""
        array = np.asarray(values, dtype="<" + kind)
        width = 1 if array.ndim == 1 else int(np.prod(array.shape[1:]))
        self.document["accessors"].append(
            {
                "bufferView": self.view(array),
                "componentType": self._COMPONENTS[kind],
                "count": len(array),
                "type": self._KINDS[width],
                **facts,
            }
        )
        return len(self.document["accessors"]) - 1

    def mesh(self, *primitives: dict[str, Any], **facts: Any) -> int:
        """The number of a new mesh."""
        self.document["meshes"].append({"primitives": list(primitives), **facts})
        return len(self.document["meshes"]) - 1

    def box(self, **facts: Any) -> dict[str, Any]:
        """A primitive: the box."""
        attributes = {"POSITION": self.numbers(CORNERS)}
        return {"attributes": attributes, "indices": self.numbers(BOX.ravel(), "u2"), **facts}

    def node(self, **facts: Any) -> int:
        """The number of a new node."""
        self.document["nodes"].append(facts)
        return len(self.document["nodes"]) - 1

    def content(self) -> bytes:
        """The bytes of the file."""
        self.document["buffers"][0].setdefault("byteLength", len(self.block))
        self.document.setdefault("scenes", [{"nodes": [*range(len(self.document["nodes"]))]}])
        text = json.dumps(self.document).encode()
        text += b" " * (-len(text) % 4)
        block = bytes(self.block) + b"\0" * (-len(self.block) % 4)
        chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
        chunks += struct.pack("<II", len(block), 0x004E4942) + block
        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def standing_box() -> bytes:
    """A GLB file with the box and nothing else."""
    glb = GlbFile()
    glb.node(mesh=glb.mesh(glb.box()))
    return glb.content()


def folder_of(place: Path, count: int, suffix: str = ".ply") -> Path:
    """A folder with boxes that wander along x, one unit of length a step."""
    write = {".ply": ply, ".obj": obj}[suffix]
    place.mkdir(parents=True, exist_ok=True)
    for step in range(count):
        (place / f"mesh_{step:03d}{suffix}").write_bytes(write(CORNERS + np.array([step, 0, 0])))
    return place
