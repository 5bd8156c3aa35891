"""Read the JSON file of a camera that Keypose wrote (`keypose.tracker.formats.camera_files`)."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Any, Final, Literal, TypeAlias

import numpy as np
from pydantic import BaseModel, Field, FiniteFloat, ValidationError

from keypose.tracker.errors import FormatError, one_sentence
from keypose.tracker.formats.cameras.camera_file import (
    CameraFile,
    CameraReading,
    CameraWay,
    Size,
    ascending,
    camera_file,
    exact,
    resized,
)
from keypose.tracker.geometry.camera import Camera

Row: TypeAlias = tuple[FiniteFloat, FiniteFloat, FiniteFloat, FiniteFloat]
_Frame: TypeAlias = Annotated[int, Field(ge=0, le=100_000_000)]
WHOLE_FRAMES: Final = 1e-3
"""Frames by which rounding may stretch a film that keeps its rate."""


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
    without_scale: tuple[tuple[_Frame, _Frame], ...] = ()
    frames_per_second: Annotated[FiniteFloat, Field(gt=0)] | None = None


class _CameraFrame(BaseModel):
    """Where the camera was at a frame, and its focal length in pixels."""

    frame: _Frame
    T_world_camera: tuple[Row, Row, Row, Row]
    fy: Annotated[FiniteFloat, Field(gt=0)]


def read_keypose_json(
    file: str, data: dict[str, Any], size: Size, reading: CameraReading
) -> CameraFile:
    """The camera of such a document."""
    try:
        fields = _CameraFields.model_validate(data)
        camera = exact(data, fields.distortion)
    except ValidationError as error:
        raise FormatError(f"{file}: {one_sentence(error)}") from None
    camera_way = _way(file, fields, camera)
    lens = resized(file, camera.zoomed(float(camera_way.zoom[0])), size)
    camera_way = replace(
        camera_way, zoom=camera_way.zoom / camera_way.zoom[0], unscaled=fields.without_scale
    )
    return camera_file(file, lens, camera_way, reading, floor_y=fields.floor_m)


def _way(file: str, fields: _CameraFields, camera: Camera) -> CameraWay:
    """In frames of the film, the first of them, which all else in the file is of, before the rest;
    or in seconds, where the motion has a rate of its own."""
    first = CameraWay(
        np.zeros(1, np.int64), np.array(fields.T_world_camera)[None], np.ones(1), "frames"
    )
    if not fields.frames:
        return first
    frames = np.array([each.frame for each in fields.frames], dtype=np.int64)
    Ts = np.array([each.T_world_camera for each in fields.frames])
    zoom = np.array([each.fy for each in fields.frames]) / camera.fy
    camera_way = ascending(file, _timed(file, fields, CameraWay(frames, Ts, zoom, "frames")))
    if camera_way.clock == "seconds" or camera_way.frames[0] <= 0:
        return camera_way
    return replace(
        camera_way,
        frames=np.concatenate([first.frames, camera_way.frames]),
        Ts_world_camera=np.concatenate([first.Ts_world_camera, Ts]),
        zoom=np.concatenate([first.zoom, zoom]),
    )


def _timed(file: str, fields: _CameraFields, camera_way: CameraWay) -> CameraWay:
    """The way in frames of the film, or in seconds from one of them on."""
    film, span = fields.film_frames, fields.last_frame - fields.first_frame
    if film is None or film == (fields.first_frame, fields.last_frame):
        return camera_way
    shift = film[0] - fields.first_frame
    if abs(film[1] - film[0] - span) < WHOLE_FRAMES and abs(shift - round(shift)) < WHOLE_FRAMES:
        return replace(camera_way, frames=camera_way.frames + round(shift))
    if fields.frames_per_second is None:
        raise FormatError(f"{file} does not say its rate: export it again.")
    return replace(
        camera_way,
        frames=camera_way.frames / fields.frames_per_second,
        clock="seconds",
        begins=film[0],
    )
