"""Where a node of a glTF file is, and where its animation takes it.  glTF 2.0, 3.5 and 3.11"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Final

import numpy as np

from keypose.tracker.geometry.rotations import Array, rotation_from_quaternion, transform
from keypose.tracker.surface.files.parsing.raw import Refused

_WIDTHS: Final = {"translation": 3, "rotation": 4, "scale": 3}
_FLOAT: Final = 5126
_MOST_KEYS: Final = 100


def places_of(document: dict[str, Any], block: bytes, node: int) -> Array:
    """(K, 4, 4) where a node is at every key of each channel that moves it, the others at their
    first; one, at rest, where nothing does."""
    nodes, above = document["nodes"], [node]
    parents = {child: i for i, found in enumerate(nodes) for child in found.get("children", [])}
    while (parent := parents.get(above[-1])) is not None:
        if parent in above:
            raise ValueError("each other's parents")
        above.append(parent)
    places = {i: dict(nodes[i]) for i in above}
    keyed = list(_keys(document, block, above))
    for i, path, values in keyed:
        places[i][path] = values[0]
    Ts = [_world(above, places)]
    for i, path, values in keyed:
        for value in values[:: max(len(values) // _MOST_KEYS, 1)]:
            Ts.append(_world(above, {**places, i: {**places[i], path: value}}))
    return np.stack(Ts)


def _keys(
    document: dict[str, Any], block: bytes, nodes: list[int]
) -> Iterator[tuple[int, str, Array]]:
    """Of the first animation, what it moves of these nodes, and the values (K, width) it takes."""
    for animation in document.get("animations", [])[:1]:
        for channel in animation["channels"]:
            node, path = channel["target"].get("node"), channel["target"]["path"]
            if node in nodes and path in _WIDTHS:
                sampler = animation["samplers"][channel["sampler"]]
                values = _floats(document, block, sampler["output"], _WIDTHS[path])
                has_slopes = sampler.get("interpolation") == "CUBICSPLINE"
                yield node, path, values[1::3] if has_slopes else values


def _floats(document: dict[str, Any], block: bytes, number: int, width: int) -> Array:
    """(count, width) numbers of an accessor."""
    facts = document["accessors"][number]
    view = document["bufferViews"][facts["bufferView"]]
    if view["buffer"] != 0 or "uri" in document["buffers"][0]:
        raise Refused("keeps its numbers in other files: export it as a single GLB file.")
    if facts["componentType"] != _FLOAT or facts["count"] < 1:
        raise ValueError("not floats")
    start = view.get("byteOffset", 0) + facts.get("byteOffset", 0)
    return np.frombuffer(block, "<f4", facts["count"] * width, start).reshape(-1, width)


def _world(above: list[int], places: dict[int, dict[str, Any]]) -> Array:
    """(4, 4) of a node in the world: above are the node, what it hangs in, and so on."""
    T = np.eye(4)
    for i in above:
        place = places[i]
        if "matrix" in place:
            T = np.reshape(place["matrix"], (4, 4)).T @ T
            continue
        x, y, z, w = place.get("rotation", (0, 0, 0, 1))
        R = rotation_from_quaternion([w, x, y, z])
        T = transform(R * place.get("scale", (1, 1, 1)), place.get("translation", (0, 0, 0))) @ T
    return T
