"""The motion of a view's camera: as it was found or imported, and as a person corrected it."""

from __future__ import annotations

import base64
import binascii
import math
import operator
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import Annotated, Literal, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, Field, FiniteFloat, field_validator, model_validator

from keypose.tracker.geometry.camera_path import CameraCorrection, CameraPath, corrected
from keypose.tracker.geometry.rotations import (
    Array,
    frozen,
    quaternion_wxyz,
    rotation_from_quaternion,
    transform,
)
from keypose.tracker.session.keyframe import Quaternion
from keypose.tracker.session.settings import FrameIndex, Plain, Position, is_unknown

NUMBERS = 8
"""Of a frame: a quaternion w, x, y, z, a place x, y, z, and the zoom."""
OFF_UNIT = 1e-3
"""How far the length of a quaternion may be from 1."""
MOST_ZOOM = 1000.0
MOST_METRES = 1e6
"""Of the unit of a path: one that is longer goes nowhere in it."""
FARTHEST = 1e6
"""Metres, or units of its own, that a camera may be away from where it was at first."""


def packed(numbers: Array) -> str:
    """Numbers as text: base64 of little-endian doubles. A film of an hour is megabytes of digits
    otherwise."""
    return base64.b64encode(np.asarray(numbers, dtype="<f8").tobytes()).decode()


@lru_cache(maxsize=64)
def unpacked(text: str) -> Array:
    """The numbers of a text, read-only; ValueError where it holds none."""
    try:
        content = base64.b64decode(text, validate=True)
        numbers = np.frombuffer(content, dtype="<f8")
    except (binascii.Error, ValueError):
        raise ValueError("is no base64 of numbers of eight bytes") from None
    if not np.isfinite(numbers).all():
        raise ValueError("holds numbers that are not finite")
    return frozen(numbers.astype(np.float64))


def _are_numbers(text: str) -> str:
    unpacked(text)
    return text


Packed: TypeAlias = Annotated[str, AfterValidator(_are_numbers)]


class CameraFinding(Plain):
    """What is not known of a camera's motion, or not as surely, over some frames.

    no_texture: too few points of the background can be followed.  body_fills: what is not
    background leaves too little of the picture.  cut: another scene begins at the first frame, and
    nothing ties it to what was before.  not_rigid: what is seen does not move as one, such as
    water or a crowd.  no_picture: frames cannot be read.  rolling_shutter: rows are exposed one
    after another, over `amount` of the time between frames; 0 where that is not taken out.
    no_parallax: nothing shows that the camera was elsewhere than at the first frame.  not_in_file:
    the file that it was imported from does not name these frames.  no_scale: nothing tells how far
    the camera went.
    """

    kind: Literal[
        "no_texture",
        "body_fills",
        "cut",
        "not_rigid",
        "no_picture",
        "rolling_shutter",
        "no_parallax",
        "not_in_file",
        "no_scale",
    ]
    first_frame: FrameIndex
    last_frame: FrameIndex
    amount: FiniteFloat = Field(default=0.0, exclude_if=operator.not_)


def _is_one(metres: float | None) -> bool:
    return metres == 1.0


class CameraPiece(Plain):
    """Frames of a camera's motion that hang together, up to the next piece: nothing in the film
    ties it to what was before, so its unit is its own."""

    first_frame: FrameIndex
    metres: Annotated[FiniteFloat, Field(gt=0, le=MOST_METRES)] | None = Field(
        default=1.0,
        exclude_if=_is_one,
        description="How long the unit of its places is; null where nothing tells: then the "
        "camera is taken to turn alone. Left out where they are metres.",
    )
    sigma: Annotated[FiniteFloat, Field(gt=0)] | None = Field(
        default=None,
        exclude_if=is_unknown,
        description="The standard deviation of that as a share of it, where it was found from feet "
        "that stand and how the body moves; left out where it is known.",
    )


@dataclass(frozen=True)
class CameraWay:
    """How far a camera went over the frames of a piece.

    metres: of the unit of its places; None where nothing tells.  sigma: of that, as a share.
    farthest: from where it began, in that unit.
    """

    first_frame: int
    last_frame: int
    metres: float | None
    sigma: float | None
    farthest: float

    @property
    def farthest_m(self) -> float | None:
        """Metres; None where nothing tells."""
        return None if self.metres is None else self.metres * self.farthest


WHOLE = (CameraPiece(first_frame=0),)
"""A motion in metres that hangs together."""


class CameraMotion(Plain):
    """How a camera turned, zoomed and moved, for every frame of its film."""

    kind: Literal["turns", "moves"]
    source: str = Field(
        default="",
        exclude_if=operator.not_,
        description="Name of the file it was imported from; left out where it was found in the "
        "film.",
    )
    samples: Packed = Field(
        description="Of every frame eight numbers: the world's rotation in the camera frame as a "
        "quaternion w, x, y, z, its origin there, metres, and the focal length as a multiple of "
        "the camera's; base64 of little-endian doubles."
    )
    pieces: tuple[CameraPiece, ...] = Field(
        default=WHOLE,
        exclude_if=lambda pieces: tuple(pieces) == WHOLE,
        description="What hangs together, in order, from frame 0 on; left out where all of it "
        "does, in metres.",
    )
    error_px: Packed = Field(
        default="",
        exclude_if=operator.not_,
        description="Of every frame how far points of the background usually lie off, pixels; "
        "negative where nothing of the camera is known. Base64 as the samples.",
    )
    findings: tuple[CameraFinding, ...] = Field(default=(), exclude_if=operator.not_)

    @classmethod
    def of(
        cls,
        kind: Literal["turns", "moves"],
        path: CameraPath,
        error_px: Array | None = None,
        findings: tuple[CameraFinding, ...] = (),
        source: str = "",
        pieces: tuple[CameraPiece, ...] = WHOLE,
    ) -> Self:
        """The motion along a path.  error_px: (N,), NaN where nothing is known."""
        T = path.Ts_camera_world
        rows = np.column_stack([quaternion_wxyz(T[:, :3, :3]), T[:, :3, 3], path.zoom])
        error = np.zeros(0) if error_px is None else np.nan_to_num(error_px, nan=-1.0)
        return cls(
            kind=kind,
            source=source,
            samples=packed(rows.ravel()),
            error_px=packed(error) if len(error) else "",
            findings=findings,
            pieces=pieces,
        )

    @property
    def frame_count(self) -> int:
        """The number of frames."""
        return len(unpacked(self.samples)) // NUMBERS

    @property
    def path(self) -> CameraPath:
        """The path, uncorrected."""
        metres = [piece.metres or 0.0 for piece in self.pieces]
        return _path(self.samples, tuple(self._starts), tuple(metres))

    @property
    def in_its_units(self) -> CameraPath:
        """The path in units of its own, before the pieces' `metres` say how long these are."""
        return _path(self.samples, (0,), (1.0,))

    @property
    def spans(self) -> list[tuple[int, int]]:
        """The first and the last frame of every piece."""
        ends = [*self._starts[1:], self.frame_count]
        return [(first, end - 1) for first, end in zip(self._starts, ends, strict=True)]

    @property
    def _starts(self) -> list[int]:
        return [piece.first_frame for piece in self.pieces]

    @property
    def unscaled(self) -> tuple[CameraFinding, ...]:
        """The frames whose translation has no scale: nothing tells how far the camera went."""
        return tuple(
            CameraFinding(kind="no_scale", first_frame=first, last_frame=last, amount=1.0)
            for piece, (first, last) in zip(self.pieces, self.spans, strict=True)
            if piece.metres is None
        )

    @property
    def ways(self) -> tuple[CameraWay, ...]:
        """For every piece how far the camera went from where it was as that begins."""
        places = self.in_its_units.Ts_world_camera[:, :3, 3]
        return tuple(
            CameraWay(
                first,
                last,
                piece.metres,
                piece.sigma,
                float(np.linalg.norm(places[first : last + 1] - places[first], axis=1).max()),
            )
            for piece, (first, last) in zip(self.pieces, self.spans, strict=True)
        )

    def with_way(self, first_frame: int, farthest_m: float) -> Self:
        """The motion whose piece that begins at a frame goes so far from there, as somebody knows;
        ValueError in one sentence where there is no such piece, or its camera goes nowhere."""
        camera_way = next((each for each in self.ways if each.first_frame == first_frame), None)
        if camera_way is None:
            raise ValueError("No way of the camera begins at this frame.")
        if camera_way.farthest * MOST_METRES < farthest_m:
            raise ValueError(
                f"The camera stays where it is in frames {camera_way.first_frame}–"
                f"{camera_way.last_frame}: its path there has no length that a scale could be "
                "taken from."
            )
        metres = float(f"{farthest_m / camera_way.farthest:.7g}")
        measured_piece = CameraPiece(first_frame=first_frame, metres=metres)
        pieces = (
            measured_piece if camera_piece.first_frame == first_frame else camera_piece
            for camera_piece in self.pieces
        )
        return self.model_copy(update={"pieces": tuple(pieces)})

    @property
    def untied(self) -> NDArray[np.bool_]:
        """(N − 1,) which steps lead from one piece to the next: of what is known of each."""
        steps = np.zeros(max(self.frame_count - 1, 0), bool)
        unknown = np.isnan(self.errors_px) if self.error_px else np.zeros(self.frame_count, bool)
        measured_steps = np.flatnonzero(~unknown)
        for first in self._starts[1:]:
            before = int(measured_steps[measured_steps < first].max(initial=0))
            after = int(measured_steps[measured_steps >= first].min(initial=self.frame_count - 1))
            steps[before:after] = True
        return steps

    @property
    def errors_px(self) -> Array:
        """(N,) pixels, NaN where nothing is known; none where that was not measured."""
        error = unpacked(self.error_px)
        return np.where(error < 0, np.nan, error)

    @model_validator(mode="after")
    def _is_a_path(self) -> Self:
        numbers = unpacked(self.samples)
        if not len(numbers) or len(numbers) % NUMBERS:
            raise ValueError(f"samples: {len(numbers)} numbers are no multiple of {NUMBERS}")
        rows = numbers.reshape(-1, NUMBERS)
        if not (np.abs(np.linalg.norm(rows[:, :4], axis=1) - 1) < OFF_UNIT).all():
            raise ValueError("samples: a quaternion is not of unit length")
        if not ((rows[:, 7] > 1 / MOST_ZOOM) & (rows[:, 7] < MOST_ZOOM)).all():
            raise ValueError("samples: a zoom is not between a thousandth and a thousand")
        if not (np.abs(rows[:, 4:7]) <= FARTHEST).all():
            raise ValueError(f"samples: a place is farther away than {FARTHEST:g}")
        if len(unpacked(self.error_px)) not in (0, len(rows)):
            raise ValueError("error_px: has another number of frames than the samples")
        starts = [*self._starts, len(rows)]
        if starts[0] != 0 or any(before >= after for before, after in pairwise(starts)):
            raise ValueError("pieces: do not begin at frame 0, or not one after another")
        return self


class CameraKeyframe(Plain):
    """The camera at one frame, as a person set it. Its motion meets it exactly. At the first frame
    it is the world's own."""

    frame: Annotated[FrameIndex, Field(ge=1)]
    R_camera_world_wxyz: Quaternion
    p_camera_world: Position = (0.0, 0.0, 0.0)
    zoom: Annotated[FiniteFloat, Field(ge=1 / MOST_ZOOM, le=MOST_ZOOM)] = 1.0

    @field_validator("R_camera_world_wxyz")
    @classmethod
    def _is_rotation(cls, wxyz: Quaternion) -> Quaternion:
        if abs(math.hypot(*wxyz) - 1.0) > OFF_UNIT:
            raise ValueError("is not a unit quaternion [w, x, y, z]")
        return wxyz

    @classmethod
    def of(cls, frame: int, T_camera_world: Array, zoom: float) -> Self:
        w, x, y, z = (float(v) for v in quaternion_wxyz(T_camera_world[:3, :3]))
        a, b, c = (float(v) for v in T_camera_world[:3, 3])
        return cls(
            frame=frame, R_camera_world_wxyz=(w, x, y, z), p_camera_world=(a, b, c), zoom=zoom
        )

    @property
    def correction(self) -> CameraCorrection:
        """As the path takes it."""
        R = rotation_from_quaternion(np.array(self.R_camera_world_wxyz))
        return CameraCorrection(self.frame, transform(R, np.array(self.p_camera_world)), self.zoom)


@lru_cache(maxsize=8)
def _path(samples: str, pieces: tuple[int, ...], metres: tuple[float, ...]) -> CameraPath:
    rows = unpacked(samples).reshape(-1, NUMBERS)
    Rs = rotation_from_quaternion(rows[:, :4])
    Rs[(rows[:, :4] == (1.0, 0.0, 0.0, 0.0)).all(axis=1)] = np.eye(3)  # to the last digit
    return CameraPath.of(Rs, rows[:, 4:7], rows[:, 7]).in_metres(pieces, metres)


@lru_cache(maxsize=8)
def path_through(motion: CameraMotion, keyframes: tuple[CameraKeyframe, ...]) -> CameraPath:
    """The path of a motion as a person corrected it."""
    return corrected(motion.path, [each.correction for each in keyframes], motion.untied)
