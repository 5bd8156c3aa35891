"""GLB: the meshes of the scene that is shown, as trimesh reads them.

What trimesh would leave out, open or take for something else is refused before.
"""

from __future__ import annotations

import json
import os
import struct
from io import BytesIO
from typing import Any, BinaryIO, Final

import numpy as np

from keypose.tracker.surface.files.parsing.raw import MeshRefused, RawMesh, require_counts
from keypose.tracker.surface.files.parsing.tidying import require_range

_JSON: Final = 0x4E4F534A
"""The type of the chunk that describes the others, "JSON" as a little-endian number."""
_FAN: Final = 6
"""The mode of triangles that share their first vertex."""
_COMPRESSED: Final = {
    "KHR_draco_mesh_compression",
    "EXT_meshopt_compression",
    "KHR_mesh_quantization",
}


def read_glb(file: BinaryIO) -> RawMesh:
    """The mesh of an open GLB file. Refused where it is none, cut short, too large, or moves."""
    _require_plain(read_document(file))
    file.seek(0)
    import trimesh  # half a second and 60 MB, which other kinds of files do without

    nameless = BytesIO(file.read())  # beside a file with a name it looks for others
    scene = trimesh.load_scene(nameless, file_type="glb", process=False, skip_materials=True)
    placed = [scene.graph[node] for node in scene.graph.nodes_geometry]
    solids = [
        (T, scene.geometry[name])
        for T, name in placed
        if isinstance(scene.geometry[name], trimesh.Trimesh)
    ]
    total = sum(len(solid.vertices) for _, solid in solids)
    require_counts(total, sum(len(solid.faces) for _, solid in solids))
    vertices, faces, count = [], [], 0
    for T, solid in solids:
        require_range(solid.faces, len(solid.vertices))
        mirrored = np.linalg.det(T[:3, :3]) < 0
        vertices.append(solid.vertices @ T[:3, :3].T + T[:3, 3])
        faces.append((solid.faces[:, ::-1] if mirrored else solid.faces) + count)
        count += len(solid.vertices)
    return RawMesh(np.concatenate(vertices), np.concatenate(faces))


def read_document(file: BinaryIO) -> dict[str, Any]:
    """What a GLB file says of itself. Refused where it is none, or cut short."""
    size = file.seek(0, os.SEEK_END)
    file.seek(0)
    head = file.read(20)
    if head[:4] != b"glTF" or len(head) < 20:
        raise MeshRefused("does not begin as a GLB file does: export it again.")
    version, whole, length, kind = struct.unpack("<4I", head[4:])
    if version != 2:
        raise MeshRefused(f"is a GLB file of version {version}: export it as version 2.")
    if max(whole, len(head) + length) > size:
        raise MeshRefused("is cut short: export it again.")
    try:
        document = json.loads(file.read(length))
    except (ValueError, RecursionError):
        document = None
    if kind != _JSON or not isinstance(document, dict):
        raise MeshRefused("is a damaged GLB file: export it again.")
    return document


def _require_plain(document: dict[str, Any]) -> None:
    """Refused where there is more to the document than meshes at rest."""
    named = {*document.get("extensionsUsed", []), *document.get("extensionsRequired", [])}
    if named & _COMPRESSED:
        raise MeshRefused("holds a compressed mesh: export it without mesh compression.")
    if any("uri" in buffer for buffer in document.get("buffers", [])):
        raise MeshRefused("keeps its numbers in other files: export it as a single GLB file.")
    primitives = [p for mesh in document.get("meshes", []) for p in mesh["primitives"]]
    moved = document.get("animations") or document.get("skins")
    if moved or any(p.get("targets") for p in primitives):
        raise MeshRefused(
            "has an animation, a skin or morph targets, which are not played: "
            "export numbered meshes, one per time step."
        )
    fans = any(p.get("mode") == _FAN for p in primitives)
    if fans or any("sparse" in accessor for accessor in document.get("accessors", [])):
        raise MeshRefused(
            "holds fans of triangles or sparse numbers: export it with plain triangles."
        )
