"""Read a camera as another program or this one wrote it: JSON, .chan, glTF.

JSON and .chan as `keypose.tracker.formats.camera_files` has them, glTF by its only camera. Their
world has y up. Of JSON and .chan the camera may move, by the frames that they name; glTF names no
frames, so that one that moves is refused.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Annotated, Any, Final, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, Field, FiniteFloat, ValidationError

from keypose.tracker.errors import FormatError, one_sentence
from keypose.tracker.files import TooLarge, read_regular
from keypose.tracker.formats.conventions import FLIP
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import (
    Array,
    log_rotation,
    nearest_rotation,
    rotation_from_quaternion,
    transform,
    transpose,
)
from keypose.tracker.surface.files.parsing.glb import read_document
from keypose.tracker.surface.files.parsing.raw import MeshRefused

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
    """Return what the first animation moves of these nodes, and the values (K, width) it takes."""
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
        raise MeshRefused("keeps its numbers in other files: export it as a single GLB file.")
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


LARGEST_BYTES: Final = 96 * 2**20
STILL_M, STILL_RAD = 1e-3, math.radians(0.01)
"""How far a camera that stands still may stray: files round."""
ALIKE: Final = 0.01
"""By what share the sides of pictures may differ that are taken for the same."""
EXACT: Final = 1e-4
CHAN_COLUMNS: Final = 8

Size: TypeAlias = tuple[int, int]
Row: TypeAlias = tuple[FiniteFloat, FiniteFloat, FiniteFloat, FiniteFloat]


@dataclass(frozen=True, eq=False)
class CameraWay:
    """frames (K,): ascending numbers, as the file counts.  Ts_world_camera (K, 4, 4): metres, the
    camera looks along +z.  zoom (K,): the focal length as a multiple of the camera's.
    """

    frames: NDArray[np.int64]
    Ts_world_camera: Array
    zoom: Array


@dataclass(frozen=True, eq=False)
class CameraFile:
    """A camera for pictures of a film's size.

    up_camera: (3,) the world's up in the camera frame.
    floor_m:   the floor's height along up, from the camera's centre; None where it is not given.
    way:       where the camera was at frames, where it moves; all above is of the first of these.
    """

    camera: Camera
    up_camera: Array
    floor_m: float | None
    way: CameraWay | None = None

    def from_row(self, row: int) -> CameraFile:
        """The same of a camera that moves, from a row of its way on, and of that."""
        if self.way is None or row == 0:
            return self
        Ts, zoom = self.way.Ts_world_camera[row:], self.way.zoom[row:]
        rise = float(Ts[0, 1, 3] - self.way.Ts_world_camera[0, 1, 3])
        return CameraFile(
            self.camera.zoomed(float(zoom[0])), np.asarray(Ts[0, 1, :3]),
            None if self.floor_m is None else self.floor_m - rise,
            CameraWay(self.way.frames[row:], Ts, zoom / zoom[0]),
        )  # fmt: skip


def load_camera(path: Path, size: Size) -> CameraFile:
    """The camera in a file, by the ending of its name, for pictures of (width, height).

    FormatError in one sentence where it is none, moves, or is for pictures of another shape.
    """
    read = CAMERA_READERS.get(path.suffix.lower())
    if read is None:
        raise FormatError(f"{path.name} is no camera: .json, .chan, .glb or .gltf is expected.")
    try:
        with np.errstate(all="ignore"):  # numbers too large become none, and are refused as such
            return read(path.name, read_regular(path, LARGEST_BYTES), size)
    except TooLarge:
        raise FormatError(f"{path.name} is too large for a camera.") from None
    except OSError as error:
        raise FormatError(f"{str(path)!r} cannot be read: {error.strerror or error}.") from None
    except UnicodeDecodeError:
        raise FormatError(f"{path.name} is not text, as a camera of its kind has to be.") from None
    except MeshRefused as refused:
        raise FormatError(f"{path.name} {refused}") from None


# --- JSON


class _CameraFields(BaseModel):
    """What is read of a JSON file."""

    format: Literal["keypose camera"]
    version: Literal[1, 2]
    T_world_camera: tuple[Row, Row, Row, Row]
    distortion: Annotated[tuple[FiniteFloat, ...], Field(alias="distortion_k1_k2_p1_p2_k3")]
    floor_m: FiniteFloat | None = None
    frames: tuple[_CameraFrame, ...] = ()
    first_frame: FiniteFloat = 0.0
    last_frame: FiniteFloat = 0.0
    film_frames: tuple[FiniteFloat, FiniteFloat] | None = None


class _CameraFrame(BaseModel):
    """Where the camera was at a frame, and its focal length in pixels."""

    frame: Annotated[int, Field(ge=0, le=100_000_000)]
    T_world_camera: tuple[Row, Row, Row, Row]
    fy: Annotated[FiniteFloat, Field(gt=0)]


def _read_json(file: str, content: bytes, size: Size) -> CameraFile:
    try:
        data = json.loads(content)
        fields = _CameraFields.model_validate(data)
        camera = _exact(data, fields.distortion)
    except ValidationError as error:
        raise FormatError(f"{file}: {one_sentence(error)}") from None
    except (ValueError, RecursionError):
        raise FormatError(f"{file} is not JSON.") from None
    T = np.array(fields.T_world_camera)
    floor_m = None if fields.floor_m is None else fields.floor_m - float(T[1, 3])
    way, rows = None, fields.frames
    if rows and fields.film_frames not in (None, (fields.first_frame, fields.last_frame)):
        raise FormatError(
            f"{file} has a rate of its own, not the video's frames: export it without --fps."
        )
    if rows:
        if rows[0].frame > 0:  # all else is of the film's first frame
            first = _CameraFrame(frame=0, T_world_camera=fields.T_world_camera, fy=camera.fy)
            rows = (first, *rows)
        Ts, zoom = np.array([each.T_world_camera for each in rows]), [each.fy for each in rows]
        way = _way(file, [each.frame for each in rows], Ts, np.array(zoom) / camera.fy)
    return CameraFile(_resized(file, camera, size), _up(file, T[:3, :3]), floor_m, way)


def _exact(data: dict[str, Any], distortion: Sequence[float]) -> Camera:
    names = ("width", "height", "fx", "fy", "cx", "cy", "projection", "telephoto_distance_m")
    known = {name: data[name] for name in names if name in data}
    return Camera.model_validate({**known, "distortion": tuple(distortion), "origin": "intrinsics"})


def _resized(file: str, camera: Camera, size: Size) -> Camera:
    """The camera for pictures of another size of the same shape."""
    if (camera.width, camera.height) == size:
        return camera
    across, down = size[0] / camera.width, size[1] / camera.height
    if abs(across / down - 1) > ALIKE:
        raise FormatError(
            f"{file} is for pictures of {camera.width} × {camera.height} pixels, and the film has "
            f"{size[0]} × {size[1]}: export the camera for the film's picture."
        )
    changes = {
        "width": size[0], "height": size[1], "fx": camera.fx * across, "fy": camera.fy * down,
        "cx": (camera.cx + 0.5) * across - 0.5, "cy": (camera.cy + 0.5) * down - 0.5,
    }  # fmt: skip
    return camera.model_copy(update=changes)


# --- .chan


def _read_chan(file: str, content: bytes, size: Size) -> CameraFile:
    lines = [line.split() for line in content.decode().splitlines() if line.strip()]
    if not lines or any(len(line) != CHAN_COLUMNS for line in lines):
        raise FormatError(
            f"{file} should have {CHAN_COLUMNS} numbers in every line: frame, position, rotation "
            "and the vertical field of view."
        )
    try:
        numbers = np.array(lines, dtype=np.float64)
    except ValueError:
        raise FormatError(f"{file} has lines that are not numbers.") from None
    if not np.isfinite(numbers).all() or not ((numbers[:, 7] > 0) & (numbers[:, 7] < 180)).all():
        raise FormatError(f"{file} has numbers that no camera has.")
    Rs = _rotations_zxy(np.radians(numbers[:, 4:7]))
    camera = _seeing(file, size, math.radians(numbers[0, 7]), None)
    zooms = np.ptp(numbers[:, 7]) > math.degrees(STILL_RAD)
    way = None
    if zooms or not _is_still(numbers[:, 1:4], Rs):
        focal = 1 / np.tan(np.radians(numbers[:, 7]) / 2)
        frames = [round(float(number)) for number in numbers[:, 0]]
        way = _way(file, frames, transform(Rs * FLIP, numbers[:, 1:4]), focal / focal[0])
    return CameraFile(camera, _up(file, Rs[0] * FLIP), None, way)


def _way(file: str, frames: Sequence[int], Ts_world_camera: Array, zoom: Array) -> CameraWay:
    """Where a camera was at frames that ascend."""
    numbers = np.array(frames, dtype=np.int64)
    if not (np.diff(numbers) > 0).all():
        raise FormatError(f"{file} names frames twice, or not in their order.")
    Rs = Ts_world_camera[:, :3, :3]
    if not np.allclose(Rs @ transpose(Rs), np.eye(3), atol=1e-3):
        raise FormatError(f"{file}: T_world_camera is no rotation.")
    Ts = transform(nearest_rotation(Rs), Ts_world_camera[:, :3, 3])
    return CameraWay(numbers, Ts, zoom)


def _rotations_zxy(angles: Array) -> Array:
    """(N, 3, 3) Qy·Qx·Qz of angles (N, 3) about x, y, z."""
    c, s = np.cos(angles).T, np.sin(angles).T
    x, y, z = (_about(axis, c[axis], s[axis]) for axis in range(3))
    return np.asarray(y @ x @ z)


def _about(axis: int, cosines: Array, sines: Array) -> Array:
    R = np.tile(np.eye(3), (len(cosines), 1, 1))
    i, k = (axis + 1) % 3, (axis + 2) % 3
    R[:, i, i] = R[:, k, k] = cosines
    R[:, k, i], R[:, i, k] = sines, -sines
    return R


# --- glTF


def _read_glb(file: str, content: bytes, size: Size) -> CameraFile:
    stream = BytesIO(content)
    document = read_document(stream)
    stream.read(8)  # the head of the block of numbers
    return _of_document(file, document, stream.read(), size)


def _read_gltf(file: str, content: bytes, size: Size) -> CameraFile:
    try:
        document = json.loads(content)
    except (ValueError, RecursionError):
        raise FormatError(f"{file} is not JSON.") from None
    if not isinstance(document, dict):
        raise FormatError(f"{file} is no glTF file.")
    return _of_document(file, document, b"", size)


def _of_document(file: str, document: dict[str, Any], block: bytes, size: Size) -> CameraFile:
    try:
        nodes = document.get("nodes", [])
        found = [i for i, node in enumerate(nodes) if "camera" in node]
        if len(found) != 1:
            many = "no camera" if not found else f"{len(found)} cameras"
            raise FormatError(f"{file} has {many}: export the scene with the one that is meant.")
        fields = document["cameras"][nodes[found[0]]["camera"]]
        Ts = places_of(document, block, found[0])
        camera = _lens(file, fields, size)
        if not np.isfinite(Ts).all():
            raise ValueError("not finite")
        own = document.get("asset", {}).get("generator") == "Keypose"
    except (LookupError, TypeError, ValueError, AttributeError, ArithmeticError, RecursionError):
        raise FormatError(f"{file} is a damaged glTF file: export it again.") from None
    Rs = nearest_rotation(Ts[:, :3, :3])
    if not _is_still(Ts[:, :3, 3], Rs):
        raise FormatError(
            f"{file} moves, and names no frames: export the camera as .chan, or as Keypose's JSON."
        )
    return CameraFile(camera, _up(file, Rs[0] * FLIP), -float(Ts[0, 1, 3]) if own else None)


def _lens(file: str, fields: dict[str, Any], size: Size) -> Camera:
    seen = fields.get("perspective")
    if fields.get("type") != "perspective" or not isinstance(seen, dict):
        raise FormatError(f"{file} has an orthographic camera: give it a perspective lens.")
    yfov, aspect = float(seen["yfov"]), seen.get("aspectRatio")
    if not 0 < yfov < math.pi:
        raise FormatError(f"{file} has a field of view that no camera has.")
    extras = fields.get("extras")
    if isinstance(extras, dict) and "fy" in extras:
        try:
            exact = _exact(extras, extras["distortion_k1_k2_p1_p2_k3"])
        except (ValidationError, KeyError, TypeError):
            exact = None
        if exact and abs(2 * math.atan(exact.height / 2 / exact.fy) - yfov) < EXACT:
            return _resized(file, exact, size)  # the program in between has not changed the lens
    return _seeing(file, size, yfov, None if aspect is None else float(aspect))


# --- together


def _seeing(file: str, size: Size, vertical_rad: float, aspect: float | None) -> Camera:
    """A lens by what it spans from top to bottom, its middle that of the picture."""
    width, height = size
    if aspect is not None and abs(aspect * height / width - 1) > ALIKE:
        raise FormatError(
            f"{file} has a camera for pictures of {aspect:.3g}:1, and the film's are "
            f"{width / height:.3g}:1: export it with the film's size."
        )
    f = height / 2 / math.tan(vertical_rad / 2)
    try:
        return Camera(
            width=width, height=height, fx=f, fy=f, cx=(width - 1) / 2, cy=(height - 1) / 2
        )
    except ValidationError as error:
        raise FormatError(f"{file}: {one_sentence(error)}") from None


def _is_still(ps_world: Array, Rs_world: Array) -> bool:
    turns = np.linalg.norm(log_rotation(transpose(Rs_world[:1]) @ Rs_world), axis=-1)
    return bool(np.ptp(ps_world, axis=0).max() <= STILL_M and turns.max() <= STILL_RAD)


def _up(file: str, R_world_camera: Array) -> Array:
    """(3,) the world's y in the camera frame."""
    if not np.allclose(R_world_camera @ R_world_camera.T, np.eye(3), atol=1e-3):
        raise FormatError(f"{file}: T_world_camera is no rotation.")
    return np.asarray(R_world_camera[1] / np.linalg.norm(R_world_camera[1]))


CAMERA_READERS: Final[dict[str, Callable[[str, bytes, Size], CameraFile]]] = {
    ".json": _read_json, ".chan": _read_chan, ".glb": _read_glb, ".gltf": _read_gltf,
}  # fmt: skip
