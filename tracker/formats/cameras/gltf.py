"""Read the camera of a glTF scene, also one that moves and zooms: its times are seconds."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from io import BytesIO
from typing import Any, Final

import numpy as np
from pydantic import ValidationError

from keypose.tracker.errors import FormatError
from keypose.tracker.formats.cameras.camera_file import (
    CameraFile,
    CameraReading,
    CameraWay,
    Size,
    ascending,
    camera_file,
    exact,
    json_of,
    resized,
    seeing,
)
from keypose.tracker.formats.conventions import FLIP
from keypose.tracker.formats.text import Note
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import (
    Array,
    nearest_rotation,
    rotation_from_quaternion,
    transform,
)
from keypose.tracker.surface.files.parsing.glb import read_document
from keypose.tracker.surface.files.parsing.raw import MeshRefused

EXACT: Final = 1e-4
"""Radians by which the angle of a camera may differ from that of the numbers beside it."""
ROUNDED: Final = 1e-6
"""Share by which a focal length differs that was rounded."""
MOST_MOMENTS: Final = 200_000
_WIDTHS: Final = {"translation": 3, "rotation": 4, "scale": 3, "yfov": 1}
_REST: Final[Mapping[str, Sequence[float]]] = {
    "translation": (0, 0, 0), "rotation": (0, 0, 0, 1), "scale": (1, 1, 1),
}  # fmt: skip
_FLOAT: Final = 5126
_DAMAGE = (LookupError, TypeError, ValueError, AttributeError, ArithmeticError, RecursionError)


@dataclass(frozen=True, eq=False)
class _Curve:
    """What a channel says: values (K, width) at ascending seconds (K,). Between them it goes
    evenly, of a cubic spline too: programs that export cameras write a key for every frame."""

    times_s: Array
    values: Array
    is_stepped: bool

    def at(self, times_s: Array) -> Array:
        """(N, width) at these times; beyond its ends what it begins and ends with."""
        row = np.clip(np.searchsorted(self.times_s, times_s, "right") - 1, 0, len(self.times_s) - 1)
        following = np.minimum(row + 1, len(self.times_s) - 1)
        length = self.times_s[following] - self.times_s[row]
        share = np.clip((times_s - self.times_s[row]) / np.where(length > 0, length, 1), 0, 1)
        if self.is_stepped:
            share = np.floor(share)
        s, before, after = share[:, None], self.values[row], self.values[following]
        if self.values.shape[1] != _WIDTHS["rotation"]:
            return np.asarray(before + s * (after - before))
        return _slerped(before, after, s)


def read_glb(file: str, content: bytes, size: Size, reading: CameraReading) -> CameraFile:
    """The camera of a GLB file."""
    stream = BytesIO(content)
    document = read_document(stream)
    stream.read(8)  # the head of the block of numbers
    return _of_document(file, document, stream.read(), size, reading)


def read_gltf(file: str, content: bytes, size: Size, reading: CameraReading) -> CameraFile:
    """The camera of a glTF file that keeps no numbers in others."""
    document = json_of(file, content)
    if not isinstance(document, dict):
        raise FormatError(f"{file} is no glTF file.")
    return _of_document(file, document, b"", size, reading)


def _of_document(
    file: str, document: dict[str, Any], block: bytes, size: Size, reading: CameraReading
) -> CameraFile:
    try:
        nodes = document.get("nodes", [])
        holders = [i for i, node in enumerate(nodes) if "camera" in node]
        if len(holders) != 1:
            many = "no camera" if not holders else f"{len(holders)} cameras"
            raise FormatError(f"{file} has {many}: export the scene with the one that is meant.")
        number = nodes[holders[0]]["camera"]
        curves, several = _curves(document, block, _above(nodes, holders[0]), number)
        lens = _lens(file, document["cameras"][number], size)
        times_s = _moments(list(curves.values()))
        Ts = _places(nodes, _above(nodes, holders[0]), curves, times_s)
        lens, zoom = _zoomed(lens, curves, times_s)
        own = document.get("asset", {}).get("generator") == "Keypose"
        begins = _begins(document) if own else None
        if not np.isfinite(Ts).all():
            raise ValueError("not finite")
    except _DAMAGE:
        raise FormatError(f"{file} is a damaged glTF file: export it again.") from None
    Ts_world_camera = transform(nearest_rotation(Ts[:, :3, :3]) * FLIP, Ts[:, :3, 3])
    camera_way = CameraWay(times_s, Ts_world_camera, zoom, "seconds", begins)
    notes = (Note("several animations"),) if several else ()
    read = camera_file(file, lens, camera_way, reading, floor_y=0.0 if own else None, notes=notes)
    if read.way is not None:
        ascending(file, read.way)
    return read


def _begins(document: dict[str, Any]) -> float | None:
    """The film's frame at which Keypose's own animation begins; None where it has none."""
    animations = document.get("animations", [])
    extras: dict[str, Any] = animations[0].get("extras", {}) if animations else {}
    return float(extras["film_frames"][0]) if "film_frames" in extras else None


def _zoomed(lens: Camera, curves: dict[Any, _Curve], times_s: Array) -> tuple[Camera, Array]:
    """The lens at the first of these times, and the focal length at each as a multiple of it."""
    if "yfov" not in curves:
        return lens, np.ones(len(times_s))
    angles = curves["yfov"].at(times_s)[:, 0]
    if not ((angles > 0) & (angles < math.pi)).all():
        raise ValueError("no field of view")
    focal = lens.height / 2 / np.tan(angles / 2)
    ratio = float(focal[0]) / lens.fy
    return (lens if abs(ratio - 1) < ROUNDED else lens.zoomed(ratio)), focal / focal[0]


def _above(nodes: list[dict[str, Any]], node: int) -> list[int]:
    """A node, what it hangs in, and so on."""
    parents = {child: i for i, each in enumerate(nodes) for child in each.get("children", [])}
    above = [node]
    while (parent := parents.get(above[-1])) is not None:
        if parent in above:
            raise ValueError("each other's parents")
        above.append(parent)
    return above


def _curves(
    document: dict[str, Any], block: bytes, nodes: list[int], camera: int
) -> tuple[dict[Any, _Curve], bool]:
    """What the first animation that moves the camera says, by (node, path) and `yfov`; and whether
    others move it as well."""
    pointer = f"/cameras/{camera}/perspective/yfov"
    every = []
    for animation in document.get("animations", []):
        curves: dict[Any, _Curve] = {}
        for channel in animation["channels"]:
            target, path = channel["target"], channel["target"]["path"]
            key: Any = (target.get("node"), path)
            pointed = target.get("extensions", {}).get("KHR_animation_pointer", {}).get("pointer")
            if path == "pointer" and pointed == pointer:
                key, path = "yfov", "yfov"
            elif target.get("node") not in nodes or path not in _WIDTHS:
                continue
            curves[key] = _curve(document, block, animation["samplers"][channel["sampler"]], path)
        if curves:
            every.append(curves)
    return (every[0] if every else {}), len(every) > 1


def _curve(document: dict[str, Any], block: bytes, sampler: dict[str, Any], path: str) -> _Curve:
    width, how = _WIDTHS[path], sampler.get("interpolation", "LINEAR")
    times_s = _floats(document, block, sampler["input"], 1)[:, 0]
    values = _floats(document, block, sampler["output"], width)
    if not (np.isfinite(times_s).all() and (np.diff(times_s) > 0).all()):
        raise ValueError("times that do not ascend")
    values = values[1::3] if how == "CUBICSPLINE" else values  # between the slopes beside it
    count = min(len(times_s), len(values))
    return _Curve(times_s[:count], values[:count], how == "STEP")


def _floats(document: dict[str, Any], block: bytes, number: int, width: int) -> Array:
    """(count, width) numbers of an accessor."""
    facts = document["accessors"][number]
    view = document["bufferViews"][facts["bufferView"]]
    if view["buffer"] != 0 or "uri" in document["buffers"][0]:
        raise MeshRefused("keeps its numbers in other files: export it as a single GLB file.")
    if facts["componentType"] != _FLOAT or facts["count"] < 1:
        raise ValueError("not floats")
    start = view.get("byteOffset", 0) + facts.get("byteOffset", 0)
    numbers = np.frombuffer(block, "<f4", facts["count"] * width, start)
    return numbers.reshape(-1, width).astype(np.float64)


def _moments(curves: list[_Curve]) -> Array:
    """The seconds at which any curve has a key; the first one where none changes."""
    if not curves:
        return np.zeros(1)
    if all(np.array_equal(curve.values[1:], curve.values[:-1]) for curve in curves):
        return np.asarray(curves[0].times_s[:1])
    keys = np.unique(np.concatenate([curve.times_s for curve in curves]))
    if len(keys) > MOST_MOMENTS:
        raise ValueError("too many keys")
    return np.asarray(keys)


def _places(
    nodes: list[dict[str, Any]], above: list[int], curves: dict[Any, _Curve], times_s: Array
) -> Array:
    """(N, 4, 4) of the first of the nodes in the world, at these times; each hangs in the next."""
    T = np.tile(np.eye(4), (len(times_s), 1, 1))
    for i in above:
        node = nodes[i]
        if "matrix" in node:
            T = np.reshape(node["matrix"], (4, 4)).T @ T
            continue
        p, q, s = (
            curves[i, path].at(times_s)
            if (i, path) in curves
            else np.broadcast_to(np.asarray(node.get(path, rest), float), (len(times_s), len(rest)))
            for path, rest in _REST.items()
        )
        R = rotation_from_quaternion(np.roll(q, 1, axis=1))
        T = transform(R * s[:, None, :], p) @ T
    return np.asarray(T)


def _slerped(first: Array, second: Array, share: Array) -> Array:
    """Quaternions (N, 4) on the shorter way from one to another, turning evenly."""
    cosine = (first * second).sum(axis=1, keepdims=True)
    second, cosine = np.where(cosine < 0, -second, second), np.minimum(np.abs(cosine), 1.0)
    angle = np.arccos(cosine)
    sine = np.where(angle > 1e-6, np.sin(angle), 1.0)
    a = np.where(angle > 1e-6, np.sin((1 - share) * angle) / sine, 1 - share)
    b = np.where(angle > 1e-6, np.sin(share * angle) / sine, share)
    return np.asarray(a * first + b * second)


def _lens(file: str, fields: dict[str, Any], size: Size) -> Camera:
    perspective = fields.get("perspective")
    if fields.get("type") != "perspective" or not isinstance(perspective, dict):
        raise FormatError(f"{file} has an orthographic camera: give it a perspective lens.")
    yfov, aspect = float(perspective["yfov"]), perspective.get("aspectRatio")
    if not 0 < yfov < math.pi:
        raise FormatError(f"{file} has a field of view that no camera has.")
    extras = fields.get("extras")
    if isinstance(extras, dict) and "fy" in extras:
        try:
            lens = exact(extras, extras["distortion_k1_k2_p1_p2_k3"])
        except (ValidationError, KeyError, TypeError):
            lens = None
        if lens and abs(2 * math.atan(lens.height / 2 / lens.fy) - yfov) < EXACT:
            return resized(file, lens, size)  # the program in between has not changed the lens
    return seeing(file, size, yfov, None if aspect is None else float(aspect))
