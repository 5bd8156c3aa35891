"""A camera as it is read of a file: its lens, where it was, and how its numbers are meant."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, Literal, TypeAlias, get_args

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from keypose.tracker.errors import FormatError, one_sentence
from keypose.tracker.formats.joint_motion import METRES, Unit
from keypose.tracker.formats.text import Note
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import (
    Array,
    log_rotation,
    nearest_rotation,
    transform,
    transpose,
)

STILL_M = 1e-3
STILL_RAD = math.radians(0.01)
"""How far a camera that stands still may stray: files round."""
ALIKE: Final = 0.01
"""By what share the sides of pictures may differ that are taken for the same."""
MOST_NUMBER: Final = 1e9
"""Frames, seconds and zooms of a camera are smaller, and these no smaller a part of 1."""
LONGEST_WHOLE: Final = 4000
"""Digits of a whole number; Python reads none that are much longer."""

UPRIGHT_DEG = 45.0
LYING_DEG = 60.0
HANGING_DEG = 120.0
"""By which a camera leans that may be held so, one that is hardly, and one that is not."""

Size: TypeAlias = tuple[int, int]
RotationOrder: TypeAlias = Literal["zxy", "zyx", "xyz", "xzy", "yxz", "yzx"]
ROTATION_ORDERS: Final[tuple[RotationOrder, ...]] = get_args(RotationOrder)
"""The axes about which a camera is turned one after another, the first of them first."""
LensColumn: TypeAlias = Literal["vertical", "horizontal", "mm", "session"]
LENS_COLUMNS: Final[tuple[LensColumn, ...]] = get_args(LensColumn)
"""What the last column of .chan is: the vertical or the horizontal field of view, degrees; the
focal length in millimetres of a film 36 mm wide; or nothing that counts, the lens staying as it
is."""
CameraWorld: TypeAlias = Literal["y up", "z up"]
FrameClock: TypeAlias = Literal["numbers", "names", "frames", "seconds"]

_Z_UP_TO_Y_UP: Final = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])


@dataclass(frozen=True)
class CameraReading:
    """How a file is meant where it does not say: None as its kind usually is.

    rotation_order, lens_column: of .chan; by custom zxy, Nuke's own, and the vertical angle.
    """

    rotation_order: RotationOrder | None = None
    lens_column: LensColumn | None = None
    unit: Unit | None = None
    world: CameraWorld | None = None


AS_USUAL: Final = CameraReading()


@dataclass(frozen=True, eq=False)
class CameraWay:
    """Where a camera was at K moments.

    frames (K,): ascending numbers, of which `clock` says what they count.  Ts_world_camera
    (K, 4, 4): metres, the camera looks along +z.  zoom (K,): the focal length as a multiple of the
    camera's.

    clock: `numbers` of frames, as the shoot or the program counts them; `names`, numbers in the
    names of pictures; `frames` of the film; or `seconds`.
    begins: the film's frame of the first moment, where the file knows it.
    is_metric: whether the unit of length is known.
    unscaled: first and last frames of the film over which nothing tells how far the camera went.
    """

    frames: NDArray[Any]
    Ts_world_camera: Array
    zoom: Array
    clock: FrameClock = "numbers"
    begins: float | None = None
    is_metric: bool = True
    unscaled: tuple[tuple[int, int], ...] = ()

    def rows(self, kept: Any) -> CameraWay:
        """The same at some of the moments alone, a slice or a mask."""
        Ts, zoom = self.Ts_world_camera[kept], self.zoom[kept]
        return replace(self, frames=self.frames[kept], Ts_world_camera=Ts, zoom=zoom)


@dataclass(frozen=True, eq=False)
class CameraFile:
    """A camera for pictures of a film's size.

    camera:    None where the file says nothing of the lens.
    up_camera: (3,) the world's up in the camera frame; None where the file does not say.
    floor_m:   the floor's height along up, from the camera's centre; None where it is not given.
    way:       where the camera was, where it moves; all above is of the first of these.
    columns:   (K, 7 or 8) the numbers of a .chan file, to be read otherwise.
    notes:     what was taken for granted, or may be wrong.
    background_px: by how much points of the film's background are off where the camera shows them;
               None where that is not known.
    """

    camera: Camera | None
    up_camera: Array | None
    floor_m: float | None
    way: CameraWay | None = None
    columns: Array | None = None
    notes: tuple[Note, ...] = ()
    background_px: float | None = None

    def from_row(self, row: int) -> CameraFile:
        """The same of a camera that moves, from a row of its way on, and of that."""
        if self.way is None or row == 0:
            return self
        camera_way = self.way.rows(slice(row, None))
        rise = float(camera_way.Ts_world_camera[0, 1, 3] - self.way.Ts_world_camera[0, 1, 3])
        zoom = float(camera_way.zoom[0])
        return replace(
            self,
            camera=None if self.camera is None else self.camera.zoomed(zoom),
            up_camera=None
            if self.up_camera is None
            else np.asarray(camera_way.Ts_world_camera[0, 1, :3]),
            floor_m=None if self.floor_m is None else self.floor_m - rise,
            way=replace(camera_way, zoom=camera_way.zoom / zoom),
        )


def camera_file(
    file: str,
    camera: Camera | None,
    camera_way: CameraWay,
    reading: CameraReading = AS_USUAL,
    *,
    floor_y: float | None = None,
    knows_up: bool = True,
    notes: tuple[Note, ...] = (),
) -> CameraFile:
    """A camera that was somewhere at one moment or several, in the units and axes of its file;
    without its way where it stands still.

    floor_y: the floor's height in the file's world.  knows_up: whether that world is upright.
    """
    scale = METRES[reading.unit or "m"]
    R_up = _Z_UP_TO_Y_UP if reading.world == "z up" else np.eye(3)
    T = camera_way.Ts_world_camera
    Rs = T[:, :3, :3]
    if not np.isfinite(T).all() or not np.allclose(Rs @ transpose(Rs), np.eye(3), atol=1e-3):
        raise FormatError(f"{file}: T_world_camera is no rotation.")
    if not ((camera_way.zoom > 1 / MOST_NUMBER) & (camera_way.zoom < MOST_NUMBER)).all():
        raise FormatError(f"{file} has numbers that no camera has.")
    camera_way = replace(camera_way, Ts_world_camera=transform(Rs, T[:, :3, 3] * scale))
    stays = is_still(camera_way.Ts_world_camera) and np.ptp(np.log(camera_way.zoom)) <= STILL_RAD
    stays = stays and not camera_way.unscaled  # its way was left out
    camera_way = camera_way.rows(slice(1)) if stays else camera_way
    T = camera_way.Ts_world_camera
    Ts = transform(R_up @ nearest_rotation(T[:, :3, :3]), T[:, :3, 3] @ R_up.T)
    camera_way = replace(
        camera_way, Ts_world_camera=Ts, is_metric=camera_way.is_metric or reading.unit is not None
    )
    up = np.asarray(Ts[0, 1, :3]) if knows_up or reading.world is not None else None
    floor_m = None if floor_y is None else floor_y * scale - float(Ts[0, 1, 3])
    if knows_up and reading.world is None:
        notes = (*notes, *_upright(Rs[0]))
    return CameraFile(camera, up, floor_m, None if stays else camera_way, notes=notes)


def _upright(R_world_camera: Array) -> tuple[Note, ...]:
    """A note where a camera is upright if z is up and not if y is, or hangs head down."""
    by_y, by_z = np.degrees(np.arccos(np.clip(-R_world_camera[1:, 1], -1.0, 1.0)))
    if by_z < UPRIGHT_DEG and by_y > LYING_DEG:
        return (Note("camera upright", (float(by_y), float(by_z))),)
    return (Note("camera hanging", (float(by_y),)),) if by_y > HANGING_DEG else ()


def ascending(file: str, camera_way: CameraWay) -> CameraWay:
    """The way; FormatError where its moments do not ascend."""
    if (
        not (np.abs(camera_way.frames) < MOST_NUMBER).all()
        or not abs(camera_way.begins or 0.0) < MOST_NUMBER
    ):
        raise FormatError(f"{file} has a frame or time that is too large.")
    if not (np.diff(camera_way.frames) > 0).all():
        raise FormatError(f"{file} names frames twice, or not in their order.")
    return camera_way


def is_still(Ts_world_camera: Array) -> bool:
    """Whether a camera stays where it is but for what files round."""
    R, p = Ts_world_camera[:, :3, :3], Ts_world_camera[:, :3, 3]
    turns = np.linalg.norm(log_rotation(transpose(R[:1]) @ R), axis=-1)
    return bool(np.ptp(p, axis=0).max() <= STILL_M and turns.max() <= STILL_RAD)


# --- the lens


def seeing(file: str, size: Size, vertical_rad: float, aspect: float | None = None) -> Camera:
    """A lens by what it spans from top to bottom, its middle that of the picture."""
    width, height = size
    if aspect is not None and abs(aspect * height / width - 1) > ALIKE:
        raise FormatError(
            f"{file} has a camera for pictures of {aspect:.3g}:1, and the film's are "
            f"{width / height:.3g}:1: export it with the film's size."
        )
    return of_focal(file, size, height / 2 / math.tan(vertical_rad / 2))


def of_focal(file: str, size: Size, focal_px: float) -> Camera:
    """A lens by its focal length, its middle that of the picture."""
    (width, height), f = size, focal_px
    try:
        return Camera(
            width=width, height=height, fx=f, fy=f, cx=(width - 1) / 2, cy=(height - 1) / 2
        )
    except ValidationError as error:
        raise FormatError(f"{file}: {one_sentence(error)}") from None


def exact(data: dict[str, Any], distortion: Sequence[float]) -> Camera:
    """A camera by the fields that Keypose writes."""
    names = ("width", "height", "fx", "fy", "cx", "cy", "projection", "telephoto_distance_m")
    fields = {name: data[name] for name in names if name in data}
    return Camera.model_validate(
        {**fields, "distortion": tuple(distortion), "origin": "intrinsics"}
    )


def resized(file: str, camera: Camera, size: Size) -> Camera:
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
        "width": size[0],
        "height": size[1],
        "fx": camera.fx * across,
        "fy": camera.fy * down,
        "cx": (camera.cx + 0.5) * across - 0.5,
        "cy": (camera.cy + 0.5) * down - 0.5,
    }
    return camera.model_copy(update=changes)


# --- text


def json_of(file: str, content: bytes) -> Any:
    """What a JSON file holds; FormatError where it is none."""
    try:
        return json.loads(content, parse_int=_whole)
    except (ValueError, RecursionError):
        raise FormatError(f"{file} is not JSON.") from None


def _whole(digits: str) -> float:
    """A whole number; infinite where it is so long that Python takes it for no JSON."""
    return int(digits) if len(digits) <= LONGEST_WHOLE else float(digits)
