"""References to compare a tracked motion with. Three kinds of file:

poses     .npz with `Rs_parent_part` (N, P, 3, 3), `ps_camera_root` (N, 3) metres and `first_frame`;
          `part_names` (P,) when given must be the body's.
joints    .npz with `names` (J,), `ps_camera_joint` (N, J, 3), metres in the camera frame, NaN where
          not known, and `first_frame`.
marks     .json: {"frames": {"30": {"LShoulder": [u, v], …}, …}}, pixels with centres at integers.

Joints are named as the body's parts (each at its own joint) and landmarks are, or by the usual
names of joint markers, such as LShoulder or RAnkle; Head is the middle of the head's shape and hip
the middle between both thighs. NPZ files hold plain arrays, never Python objects.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, ValidationError

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.errors import FormatError, one_sentence
from keypose.tracker.evaluate import JointReference
from keypose.tracker.files import TooLarge, read_regular
from keypose.tracker.formats.marker_sets import places_of
from keypose.tracker.geometry.rotations import Array, transpose
from keypose.tracker.storage.archive import LARGEST_PACKED_BYTES, archive_arrays

LARGEST_MARKS_BYTES = 256 * 2**20

LAST_FRAME = 10**8
"""No video is longer."""

ROTATION_TOLERANCE = 1e-4
"""A reference may have been written in single precision."""


class _Marks(BaseModel):
    model_config = ConfigDict(extra="ignore")

    frames: Annotated[
        dict[
            Annotated[int, Field(ge=0, le=LAST_FRAME)], dict[str, tuple[FiniteFloat, FiniteFloat]]
        ],
        Field(min_length=1),
    ]


def load_reference(path: Path, skeleton: Skeleton) -> Trajectory | JointReference:
    """The reference in a file; FormatError in one sentence for anything that is not one."""
    if path.is_dir():
        raise FormatError(f"{str(path)!r} is a folder; name the reference file in it.")
    try:
        if path.suffix.lower() == ".json":
            return _marks(path, skeleton)
        if path.suffix.lower() == ".npz":
            return _arrays(path, skeleton)
    except FileNotFoundError:
        raise FormatError(f"There is no reference file {str(path)!r}.") from None
    except OSError as error:
        raise FormatError(f"{path.name} cannot be read: {error.strerror or error}.") from None
    raise FormatError(f"{path.name} is not a reference: a .npz or .json file is expected.")


def _marks(path: Path, skeleton: Skeleton) -> JointReference:
    try:
        marks = _Marks.model_validate_json(read_regular(path, LARGEST_MARKS_BYTES)).frames
    except TooLarge:
        raise FormatError(f"{path.name} is too large for a file of marked joints.") from None
    except ValidationError as error:
        text = one_sentence(error)
        raise FormatError(f"{path.name}: {text[:1].lower()}{text[1:]}") from None
    names = tuple(dict.fromkeys(name for joints in marks.values() for name in joints))
    if not names:
        raise FormatError(f"{path.name} marks no joint.")
    places = places_of(skeleton, names, path.name)
    frames = sorted(marks)
    positions = np.full((len(frames), len(names), 2), np.nan)
    for row, frame in enumerate(frames):
        for name, uv in marks[frame].items():
            positions[row, names.index(name)] = uv
    return JointReference(names, places, positions, np.array(frames, dtype=np.int64))


def _arrays(path: Path, skeleton: Skeleton) -> Trajectory | JointReference:
    try:
        arrays = archive_arrays(read_regular(path, LARGEST_PACKED_BYTES), packed=True)
    except TooLarge:
        raise FormatError(f"{path.name} is too large for a reference.") from None
    except ValueError as error:
        why = " ".join(str(error).split()).rstrip(".")
        raise FormatError(f"{path.name} is not an archive of plain arrays: {why}.") from None
    _require_the_videos_frames(path.name, arrays)
    if "Rs_parent_part" in arrays:
        return _poses(path.name, arrays, skeleton)
    if "ps_camera_joint" in arrays:
        return _joints(path.name, arrays, skeleton)
    listed = ", ".join(sorted(arrays)) or "nothing"
    raise FormatError(
        f"{path.name} is not a reference: Rs_parent_part or ps_camera_joint is expected; it holds "
        f"{listed}."
    )


def _require_the_videos_frames(file: str, arrays: Mapping[str, NDArray[Any]]) -> None:
    frame, film = arrays.get("frame"), arrays.get("film_frame")
    if frame is not None and film is not None and not np.array_equal(frame, film):
        raise FormatError(
            f"{file} has a rate of its own, not the video's frames: export it without --fps."
        )


def _poses(file: str, arrays: Mapping[str, NDArray[Any]], skeleton: Skeleton) -> Trajectory:
    names = skeleton.body.names
    if "part_names" in arrays and tuple(arrays["part_names"].ravel().tolist()) != names:
        raise FormatError(f"{file} has other parts than the body: {', '.join(names)} are expected.")
    Rs = _numbers(file, arrays, "Rs_parent_part", (None, len(names), 3, 3))
    ps = _numbers(file, arrays, "ps_camera_root", (len(Rs), 3))
    if not (np.isfinite(Rs).all() and np.isfinite(ps).all()):
        raise FormatError(f"{file} holds poses that are not finite numbers.")
    if np.abs(Rs).max() > 2 or np.abs(Rs @ transpose(Rs) - np.eye(3)).max() > ROTATION_TOLERANCE:
        raise FormatError(f"{file}: Rs_parent_part holds matrices that are not rotations.")
    return Trajectory(_first_frame(file, arrays), Rs, ps)


def _joints(file: str, arrays: Mapping[str, NDArray[Any]], skeleton: Skeleton) -> JointReference:
    if "names" not in arrays:
        raise FormatError(f"{file} needs `names`, the joints of ps_camera_joint.")
    names = tuple(str(name) for name in arrays["names"].ravel())
    positions = _numbers(file, arrays, "ps_camera_joint", (None, len(names), 3))
    frames = _first_frame(file, arrays) + np.arange(len(positions))
    return JointReference(names, places_of(skeleton, names, file), positions, frames)


def _numbers(
    file: str, arrays: Mapping[str, NDArray[Any]], name: str, shape: tuple[int | None, ...]
) -> Array:
    """An array of this shape (None: any length but 0) as floats."""
    if name not in arrays:
        raise FormatError(f"{file} lacks {name}.")
    array = arrays[name]
    fits = array.ndim == len(shape) and all(
        wanted in (None, length) for length, wanted in zip(array.shape, shape, strict=True)
    )
    if not fits or array.dtype.kind not in "fiu" or not array.size:
        wanted_text = "×".join("N" if n is None else str(n) for n in shape)
        actual = "×".join(str(n) for n in array.shape)
        raise FormatError(f"{file}: {name} must be {wanted_text} numbers; it is {actual}.")
    if 8 * array.size > LARGEST_PACKED_BYTES:  # small integers grow when they become floats
        raise FormatError(f"{file} is too large for a reference.")
    return array.astype(np.float64)


def _first_frame(file: str, arrays: Mapping[str, NDArray[Any]]) -> int:
    first = arrays.get("first_frame")
    if first is None or first.size != 1 or first.dtype.kind not in "iuf":
        raise FormatError(f"{file} needs `first_frame`, one whole number.")
    value = float(first.ravel()[0])
    if not (math.isfinite(value) and value == int(value) and 0 <= value <= LAST_FRAME):
        raise FormatError(f"{file} needs `first_frame`, one whole number from 0 to {LAST_FRAME}.")
    return int(value)
