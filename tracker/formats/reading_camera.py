"""Read a camera as another program or this one wrote it, by the ending of its file's name.

JSON and .chan as `keypose.tracker.formats.camera_files` has them, glTF by its only camera, and
cameras of reconstructions. Their world has y up unless it is said otherwise. The camera may move:
by the frames that the file names, or by its times.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Final

import numpy as np

from keypose.tracker.errors import FormatError
from keypose.tracker.files import TooLarge, read_regular
from keypose.tracker.formats.cameras.camera_file import (
    AS_USUAL,
    STILL_M,
    CameraFile,
    CameraReading,
    CameraWay,
    Size,
    json_of,
)
from keypose.tracker.formats.cameras.chan import read_chan
from keypose.tracker.formats.cameras.gltf import read_glb, read_gltf
from keypose.tracker.formats.cameras.keypose_json import read_keypose_json
from keypose.tracker.formats.cameras.reconstructions import (
    read_splats,
    read_text,
    read_transforms,
)
from keypose.tracker.surface.files.parsing.raw import MeshRefused

__all__ = [
    "CAMERA_READERS",
    "STILL_M",
    "CameraFile",
    "CameraReading",
    "CameraWay",
    "load_camera",
]

LARGEST_BYTES: Final = 96 * 2**20
EXPECTED: Final = (
    ".json, .chan, .glb or .gltf is expected, or COLMAP's images.txt, a path of TUM, or "
    "transforms.json"
)


def load_camera(path: Path, size: Size, reading: CameraReading = AS_USUAL) -> CameraFile:
    """The camera in a file, by the ending of its name, for pictures of (width, height).

    FormatError in one sentence where it is none, or is for pictures of another shape.
    """
    ending = path.suffix.lower()
    read = CAMERA_READERS.get(ending)
    if read is None:
        raise FormatError(f"{path.name} is no camera: {EXPECTED}.")
    if ending != ".chan" and (reading.rotation_order or reading.lens_column):
        raise FormatError(
            f"{path.name} says itself how its camera is turned and what it sees: rotation order "
            "and last column are for .chan alone."
        )
    try:
        with np.errstate(all="ignore"):  # numbers too large become none, and are refused as such
            return read(path, read_regular(path, LARGEST_BYTES), size, reading)
    except TooLarge:
        raise FormatError(f"{path.name} is too large for a camera.") from None
    except OSError as error:
        raise FormatError(f"{str(path)!r} cannot be read: {error.strerror or error}.") from None
    except UnicodeDecodeError:
        raise FormatError(f"{path.name} is not text, as a camera of its kind has to be.") from None
    except MeshRefused as refused:
        raise FormatError(f"{path.name} {refused}") from None


def _read_json(path: Path, content: bytes, size: Size, reading: CameraReading) -> CameraFile:
    data = json_of(path.name, content)
    if isinstance(data, dict) and data.get("format") == "keypose camera":
        return read_keypose_json(path.name, data, size, reading)
    if is_transforms(data):
        return read_transforms(path.name, data, size, reading)
    if is_splats(data):
        return read_splats(path.name, data, size, reading)
    raise FormatError(
        f"{path.name}: it holds no camera that can be read: of JSON, export the camera as Keypose "
        "writes it, as transforms.json of nerfstudio or instant-ngp, or as cameras.json of 3D "
        "Gaussian splatting."
    )


def is_transforms(data: object) -> bool:
    """Whether a document of JSON is as nerfstudio and instant-ngp have their cameras."""
    frames = data.get("frames") if isinstance(data, dict) else None
    return isinstance(frames, list) and any(
        isinstance(each, dict) and "transform_matrix" in each for each in frames[:1]
    )


def is_splats(data: object) -> bool:
    """Whether a document of JSON is as 3D Gaussian splatting has its cameras."""
    first = data[0] if isinstance(data, list) and data else None
    return isinstance(first, dict) and {"img_name", "position", "rotation"} <= first.keys()


Reader = Callable[[Path, bytes, Size, CameraReading], CameraFile]

CAMERA_READERS: Final[dict[str, Reader]] = {
    ".json": _read_json,
    ".chan": lambda path, content, size, reading: read_chan(path.name, content, size, reading),
    ".glb": lambda path, content, size, reading: read_glb(path.name, content, size, reading),
    ".gltf": lambda path, content, size, reading: read_gltf(path.name, content, size, reading),
    ".txt": lambda path, content, size, reading: read_text(
        path.name, content, size, reading, path.parent
    ),
}
