"""An observed surface as it is sent to viser: one small GLB with a colour at every vertex.

The page draws it twice. "depth" gives its nearest layer without any colour, "sheet" the colours of
that layer alone, translucent, so that the body inside is seen through one sheet and no more.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from keypose.app.scene.decimation import decimate
from keypose.tracker.formats.glb_file import Numbers
from keypose.tracker.surface.mesh import SurfaceMesh

MOST_FACES = 8000
"""Of a surface in the small views, some 150 kB; twice as many could not be distinguished there."""


def skin(mesh: SurfaceMesh, colours: NDArray[np.uint8]) -> bytes:
    """The GLB of a surface (camera frame, metres) with colours (V, 3), in the camera frame."""
    thin = decimate(mesh.vertices, mesh.faces, MOST_FACES)
    numbers = Numbers()
    attributes = {
        "POSITION": numbers.add(thin.vertices.astype(np.float32), "VEC3", "vertices", bounded=True),
        "COLOR_0": numbers.add(_linear(thin.means(colours)), "VEC3", "vertices"),
    }
    wide = np.uint16 if len(thin.vertices) < 65535 else np.uint32
    corners = numbers.add(thin.faces.ravel().astype(wide), "SCALAR", "indices")
    return numbers.file(
        {
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}],
            "meshes": [
                {
                    "primitives": [
                        {"attributes": attributes, "indices": corners, "material": material}
                        for material in range(2)
                    ]
                }
            ],
            "materials": [_material("depth"), _material("sheet")],
        }
    )


def _material(name: str) -> dict[str, object]:
    rough = {"metallicFactor": 0.0, "roughnessFactor": 1.0}
    return {"name": name, "pbrMetallicRoughness": rough, "doubleSided": True}


def _linear(colours: NDArray[np.uint8]) -> NDArray[np.float32]:
    """sRGB bytes as glTF wants colours of vertices: linear, 0 to 1."""
    share = colours / 255.0
    bright = ((share + 0.055) / 1.055) ** 2.4
    return np.where(share <= 0.04045, share / 12.92, bright).astype(np.float32)
