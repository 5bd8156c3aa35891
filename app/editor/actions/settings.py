"""Masks, and how one tracks and observes."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import Field, FiniteFloat

from keypose.app.editor.actions.message import Edit, Metres, Spot
from keypose.tracker.session.references import FramesPerSecond
from keypose.tracker.session.settings import (
    ALL_CUES,
    Cues,
    FrameIndex,
    MethodName,
    NetworkName,
    Quality,
    Units,
    UpAxis,
    Weights,
)

Polygon: TypeAlias = Annotated[tuple[Spot, ...], Field(min_length=3, max_length=500)]


class AddMask(Edit):
    do: Literal["add_mask"] = "add_mask"
    polygon: Polygon
    first: FrameIndex
    last: FrameIndex


class ChangeMask(Edit):
    do: Literal["change_mask"] = "change_mask"
    index: Annotated[int, Field(ge=0, le=10_000)]
    polygon: Polygon | None = None
    first: FrameIndex | None = None
    last: FrameIndex | None = None
    note: Annotated[str, Field(max_length=200)] | None = None


class DeleteMask(Edit):
    do: Literal["delete_mask"] = "delete_mask"
    index: Annotated[int, Field(ge=0, le=10_000)]


class Settings(Edit):
    """Fields that are left out stay; `static_camera` may be given as null, as it was found, and
    `smooth`, not."""

    do: Literal["settings"] = "settings"
    method: MethodName | None = None
    quality: Quality | None = None
    static_camera: bool | None = None
    smooth: bool | None = None
    cues: Annotated[Cues, Field(max_length=len(ALL_CUES))] | None = None
    network: NetworkName | None = None


class Observe(Edit):
    """How observed surfaces are read and fitted. Fields that are left out stay; `model_frame` may
    be null, the first keyframe. about: the point, camera frame, that other axes turn about."""

    do: Literal["observe"] = "observe"
    units: Units | None = None
    up: UpAxis | None = None
    about: tuple[Metres, Metres, Metres] = (0.0, 0.0, 0.0)
    fps: Annotated[FiniteFloat, Field(ge=0.001, le=10_000)] | None = None
    model_frame: FrameIndex | None = None
    weights: Weights | None = None
    distance: Literal["plane", "point"] | None = None
    binding: Literal["nearest", "smooth"] | None = None


class ReadFilm(Edit):
    """How a film was taken. Fields that are left out stay; `recorded_fps` may be null, as its file
    says."""

    do: Literal["read_film"] = "read_film"
    recorded_fps: FramesPerSecond | None = None
    deinterlace: bool | None = None


Choosing: TypeAlias = AddMask | ChangeMask | DeleteMask | Settings | Observe | ReadFilm
