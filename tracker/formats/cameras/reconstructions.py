"""Read cameras of programs that reconstruct scenes: nerfstudio, instant-ngp, 3D Gaussian
splatting, COLMAP, and paths as TUM's benchmark has them.

transforms.json gives cameras that look along −z with y up, the others such as look along +z with y
down. Their worlds have a unit of their own, and nothing is said of what is up, unless it is said
how they are meant: in transforms.json y is up. Frames are told by numbers in the pictures' names.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Final

import numpy as np
from pydantic import BaseModel, Field, FiniteFloat, ValidationError

from keypose.tracker.errors import FormatError, one_sentence
from keypose.tracker.files import read_regular
from keypose.tracker.formats.cameras.camera_file import (
    CameraFile,
    CameraReading,
    CameraWay,
    Size,
    ascending,
    camera_file,
    resized,
)
from keypose.tracker.formats.cameras.keypose_json import Row
from keypose.tracker.formats.conventions import FLIP
from keypose.tracker.formats.text import Note
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import (
    Array,
    rotation_from_quaternion,
    transform,
    transpose,
)

LARGEST_BYTES: Final = 96 * 2**20
COLMAP_COLUMNS = 10
TUM_COLUMNS = 8
CAMERAS_FILE: Final = "cameras.txt"
_NUMBER = re.compile(r"\d{1,9}(?=\D*$)")
_LENSES: Final = {
    "SIMPLE_PINHOLE": "f cx cy",
    "PINHOLE": "fx fy cx cy",
    "SIMPLE_RADIAL": "f cx cy k1",
    "RADIAL": "f cx cy k1 k2",
    "OPENCV": "fx fy cx cy k1 k2 p1 p2",
}
"""COLMAP's models that this program has, and their parameters."""

Positive = Annotated[FiniteFloat, Field(gt=0)]


@dataclass(frozen=True, eq=False)
class _Seen:
    """A picture: its name, where its camera was, and the lens; None where that is not said."""

    name: str
    T_world_camera: Array
    lens: Camera | None


# --- transforms.json


class _Transform(BaseModel):
    """A picture of transforms.json."""

    file_path: str
    transform_matrix: tuple[Row, ...]
    fl_x: Positive | None = None
    fl_y: Positive | None = None


class _Transforms(BaseModel):
    """What is read of transforms.json."""

    frames: Annotated[tuple[_Transform, ...], Field(min_length=1)]
    camera_model: str = "OPENCV"
    camera_angle_x: Annotated[FiniteFloat, Field(gt=0, lt=np.pi)] | None = None
    fl_x: Positive | None = None
    fl_y: Positive | None = None
    cx: FiniteFloat | None = None
    cy: FiniteFloat | None = None
    w: Positive | None = None
    h: Positive | None = None
    k1: FiniteFloat = 0.0
    k2: FiniteFloat = 0.0
    k3: FiniteFloat = 0.0
    p1: FiniteFloat = 0.0
    p2: FiniteFloat = 0.0


def read_transforms(
    file: str, data: dict[str, Any], size: Size, reading: CameraReading
) -> CameraFile:
    """The cameras of transforms.json."""
    try:
        fields = _Transforms.model_validate(data)
    except ValidationError as error:
        raise FormatError(f"{file}: {one_sentence(error)}") from None
    if "FISHEYE" in fields.camera_model or "EQUI" in fields.camera_model:
        raise FormatError(f"{file} is of a fisheye lens: export cameras of undistorted pictures.")
    pictures = []
    for each in fields.frames:
        T = np.array(each.transform_matrix)
        if T.shape not in ((4, 4), (3, 4)):
            raise FormatError(f"{file}: transform_matrix should have four rows of four numbers.")
        lens = _lens_of_transforms(file, fields, each, size)
        T_world_camera = transform(T[:3, :3] * FLIP, T[:3, 3])
        pictures.append(_Seen(each.file_path, T_world_camera, lens))
    return _camera(file, pictures, size, reading, knows_up=True)


def _lens_of_transforms(
    file: str, fields: _Transforms, each: _Transform, size: Size
) -> Camera | None:
    width, height = round(fields.w or size[0]), round(fields.h or size[1])
    fx = each.fl_x or fields.fl_x
    if fx is None and fields.camera_angle_x is not None:
        fx = width / 2 / float(np.tan(fields.camera_angle_x / 2))
    if fx is None:
        return None
    fy = each.fl_y or (fields.fl_y if each.fl_x is None else None) or fx
    cx = width / 2 if fields.cx is None else fields.cx
    cy = height / 2 if fields.cy is None else fields.cy
    bent = (fields.k1, fields.k2, fields.p1, fields.p2, fields.k3)
    return _lens(file, (width, height), (fx, fy, cx, cy), bent)


# --- cameras.json of 3D Gaussian splatting


class _Splatted(BaseModel):
    """A picture of cameras.json."""

    img_name: str
    position: tuple[FiniteFloat, FiniteFloat, FiniteFloat]
    rotation: tuple[tuple[FiniteFloat, FiniteFloat, FiniteFloat], ...]
    width: Positive
    height: Positive
    fx: Positive
    fy: Positive


class _Splats(BaseModel):
    """What is read of cameras.json."""

    cameras: Annotated[tuple[_Splatted, ...], Field(min_length=1)]


def read_splats(file: str, data: list[Any], size: Size, reading: CameraReading) -> CameraFile:
    """The cameras of 3D Gaussian splatting's cameras.json."""
    try:
        fields = _Splats.model_validate({"cameras": data})
    except ValidationError as error:
        raise FormatError(f"{file}: {one_sentence(error)}") from None
    pictures = []
    for each in fields.cameras:
        if len(each.rotation) != 3:
            raise FormatError(f"{file}: rotation should have three rows of three numbers.")
        middle = (each.fx, each.fy, each.width / 2, each.height / 2)
        lens = _lens(file, (round(each.width), round(each.height)), middle)
        T = transform(np.array(each.rotation), np.array(each.position))
        pictures.append(_Seen(each.img_name, T, lens))
    return _camera(file, pictures, size, reading)


# --- COLMAP and TUM


def read_text(
    file: str, content: bytes, size: Size, reading: CameraReading, folder: Path
) -> CameraFile:
    """The cameras of COLMAP's images.txt, with cameras.txt beside it, or a path of TUM."""
    lines = [line.split() for line in content.decode("utf-8-sig").splitlines()]
    commented = [line for line in lines if not line or not line[0].startswith("#")]
    filled = [line for line in commented if line]
    if filled and all(len(line) == TUM_COLUMNS for line in filled):
        return _read_tum(file, filled, reading)
    if filled and len(filled[0]) == COLMAP_COLUMNS:
        return _read_colmap(file, commented, size, reading, folder)
    raise FormatError(
        f"{file} holds nothing that can be imported: of text, COLMAP's images.txt and paths of "
        "TUM are read, which have time, position and quaternion in every line."
    )


def _read_tum(file: str, lines: Sequence[Sequence[str]], reading: CameraReading) -> CameraFile:
    numbers = _numbers(file, lines)
    x, y, z, w = numbers[:, 4:].T
    Ts = _posed(file, np.stack([w, x, y, z], axis=1), numbers[:, 1:4])
    times_s = numbers[:, 0] - numbers[0, 0]
    camera_way = ascending(file, CameraWay(times_s, Ts, np.ones(len(Ts)), "seconds", 0.0))
    notes = (Note("camera lens kept"), Note("camera from first"))
    return camera_file(file, None, camera_way, reading, knows_up=False, notes=notes)


def _read_colmap(
    file: str, lines: Sequence[Sequence[str]], size: Size, reading: CameraReading, folder: Path
) -> CameraFile:
    """Every other line is a picture, the one after it its points, which may be empty."""
    start = next(i for i, line in enumerate(lines) if line)
    pictures = [line for line in lines[start::2] if line]
    if any(len(line) != COLMAP_COLUMNS for line in pictures):
        raise FormatError(f"{file} is damaged: COLMAP has two lines for every picture.")
    numbers = _numbers(file, [line[1:9] for line in pictures])
    lenses = _colmap_lenses(folder / CAMERAS_FILE)
    Ts_camera_world = _posed(file, numbers[:, :4], numbers[:, 4:7])
    R = transpose(Ts_camera_world[:, :3, :3])
    Ts = transform(R, -(R @ Ts_camera_world[:, :3, 3:])[..., 0])
    filmed = [_Seen(p[9], T, lenses.get(p[8])) for p, T in zip(pictures, Ts, strict=True)]
    return _camera(file, filmed, size, reading)


def _colmap_lenses(path: Path) -> dict[str, Camera]:
    """The lenses of cameras.txt by their numbers; none where there is no such file."""
    if not path.is_file():
        return {}
    lenses = {}
    for line in read_regular(path, LARGEST_BYTES).decode("utf-8-sig").splitlines():
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        if len(words) < 5 or words[1] not in _LENSES:
            model = words[1][:40] if len(words) > 1 else ""
            raise FormatError(
                f"{path.name} has a lens of the model {model!r}, and {', '.join(_LENSES)} are "
                "read: undistort the pictures, and export their cameras."
            )
        names = _LENSES[words[1]].split()
        values = _numbers(path.name, [words[2:]])[0]
        if len(values) != len(names) + 2:
            raise FormatError(f"{path.name} is damaged: {words[1]} has {len(names)} parameters.")
        parameters = dict(zip(names, values[2:].tolist(), strict=True))
        fx, fy = (parameters.get(name, parameters.get("f", 0.0)) for name in ("fx", "fy"))
        k1, k2, p1, p2 = (parameters.get(name, 0.0) for name in ("k1", "k2", "p1", "p2"))
        whole = (round(values[0]), round(values[1]))
        lenses[words[0]] = _lens(
            path.name, whole, (fx, fy, parameters["cx"], parameters["cy"]), (k1, k2, p1, p2, 0.0)
        )
    return lenses


def _numbers(file: str, lines: Sequence[Sequence[str]]) -> Array:
    try:
        numbers = np.array(lines, dtype=np.float64)
    except ValueError:
        raise FormatError(f"{file} has lines that are not numbers.") from None
    if not np.isfinite(numbers).all():
        raise FormatError(f"{file} has a number that is too large for a camera.")
    return numbers


def _posed(file: str, wxyz: Array, p: Array) -> Array:
    """(K, 4, 4) by quaternions and places."""
    if not (np.linalg.norm(wxyz, axis=1) > 0).all():
        raise FormatError(f"{file} has a quaternion of zeros.")
    return transform(rotation_from_quaternion(wxyz), p)


# --- together


def _lens(
    file: str,
    whole: Size,
    middle: tuple[float, float, float, float],
    distortion: tuple[float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0),
) -> Camera:
    """A lens by its focal lengths and its middle, from the corner of the picture, pixels."""
    fx, fy, cx, cy = middle
    try:
        return Camera(
            width=whole[0],
            height=whole[1],
            fx=fx,
            fy=fy,
            cx=cx - 0.5,
            cy=cy - 0.5,
            distortion=distortion,
            origin="intrinsics",
        )
    except ValidationError as error:
        raise FormatError(f"{file}: {one_sentence(error)}") from None


def _camera(
    file: str,
    pictures: Sequence[_Seen],
    size: Size,
    reading: CameraReading,
    *,
    knows_up: bool = False,
) -> CameraFile:
    """The camera that took all pictures, in the order of their numbers."""
    numbered = [(_NUMBER.search(Path(each.name).stem), each) for each in pictures]
    nameless = next((each.name for number, each in numbered if number is None), None)
    if nameless is not None:
        raise FormatError(
            f"{file} has the picture {nameless[:60]!r}, whose name has no number to tell the frame."
        )
    pairs = [(int(number[0]), each) for number, each in numbered if number is not None]
    ordered = sorted(pairs, key=lambda pair: pair[0])
    frames = np.array([number for number, _ in ordered], dtype=float)
    Ts = np.stack([each.T_world_camera for _, each in ordered])
    lenses = [each.lens for _, each in ordered]
    first, notes = lenses[0], []
    if first is None or any(lens is None for lens in lenses):
        camera, zoom = None, np.ones(len(Ts))
        notes.append(Note("camera lens kept"))
    else:
        camera = resized(file, first, size)
        zoom = np.array([lens.fy / lens.height for lens in lenses if lens is not None])
        zoom = zoom / zoom[0]
    camera_way = ascending(file, CameraWay(frames, Ts, zoom, "names", is_metric=False))
    return camera_file(file, camera, camera_way, reading, knows_up=knows_up, notes=tuple(notes))
