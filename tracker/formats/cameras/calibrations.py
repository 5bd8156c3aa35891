"""Read calibrations of several cameras: Qualisys, TOML of Anipose, FreeMoCap and Pose2Sim, OpenCV.

What a file says is where one begins: its cameras may have been touched since, and it may be for
pictures of another size. Lengths are in the file's own unit, which nobody needs to know: how far
cameras lie apart follows from the body that they see.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final
from xml.etree import ElementTree

import cv2
import numpy as np
from pydantic import ValidationError

from keypose.tracker.errors import FormatError
from keypose.tracker.files import TooLarge, read_regular
from keypose.tracker.formats.cameras.camera_file import Size, resized
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, nearest_rotation, transform

LARGEST_BYTES: Final = 2**20
SUBPIXELS: Final = 64.0
"""Of a Qualisys pixel."""
EXPECTED: Final = (
    "a Qualisys calibration (.txt, .xml), a TOML of Anipose, FreeMoCap or Pose2Sim, or a stereo "
    "calibration of OpenCV (.yml) is expected"
)


@dataclass(frozen=True, eq=False)
class CalibratedCamera:
    """One camera of several.

    fx, fy, cx, cy, distortion: pixels, of pictures of `size`, which is None where the file does not
    say it.  T_camera_world: (4, 4), the lengths in the file's unit.
    """

    name: str
    size: Size | None
    focal: tuple[float, float]
    centre: tuple[float, float]
    distortion: tuple[float, ...]
    T_camera_world: Array

    def seeing(self, file: str, size: Size) -> Camera:
        """The camera for pictures of a size; FormatError where they are of another shape."""
        width, height = self.size or size
        try:
            camera = Camera(
                width=width,
                height=height,
                fx=self.focal[0],
                fy=self.focal[1],
                cx=self.centre[0],
                cy=self.centre[1],
                distortion=_five(self.distortion),
                origin="intrinsics",
            )
        except ValidationError:
            raise FormatError(f"{file}: the lens of {self.name} is none.") from None
        return resized(file, camera, size)


def _five(values: tuple[float, ...]) -> tuple[float, float, float, float, float]:
    if any(values[5:]):
        raise FormatError("A lens has more than five numbers of distortion: such are not read.")
    k1, k2, p1, p2, k3 = (*values, *(0.0,) * 5)[:5]
    return k1, k2, p1, p2, k3


def load_calibration(path: Path) -> tuple[CalibratedCamera, ...]:
    """The cameras of a file, at least two; FormatError in one sentence where it has none."""
    read = READERS.get(path.suffix.lower())
    if read is None:
        raise FormatError(f"{path.name}: {EXPECTED}.")
    try:
        content = read_regular(path, LARGEST_BYTES)
    except TooLarge:
        raise FormatError(f"{path.name} is too large for a calibration.") from None
    except OSError as error:
        raise FormatError(f"{path.name} cannot be read: {error.strerror or error}.") from None
    try:
        cameras = read(content.decode("utf-8"))
    except FormatError:
        raise
    except (ArithmeticError, LookupError, TypeError, ValueError, AttributeError, SyntaxError):
        raise FormatError(f"{path.name} is damaged, or no calibration: {EXPECTED}.") from None
    if len(cameras) < 2:
        raise FormatError(f"{path.name} has fewer than two cameras.")
    if not all(np.isfinite(each.T_camera_world).all() for each in cameras):
        raise FormatError(f"{path.name}: a camera has no place.")
    return tuple(cameras)


def _from_toml(text: str) -> list[CalibratedCamera]:
    """A table a camera: matrix, distortions, rotation as a rotation vector, translation, size."""
    cameras = []
    for key, table in tomllib.loads(text).items():
        if not isinstance(table, dict) or "matrix" not in table:
            continue
        if table.get("fisheye"):
            raise FormatError(f"{table.get('name', key)} is a fisheye: such lenses are not read.")
        K = np.array(table["matrix"], np.float64).reshape(3, 3)
        turn = np.array(table["rotation"], np.float64).reshape(3, 1)
        shift = np.array(table["translation"], np.float64).reshape(3)
        width, height = (round(float(each)) for each in table["size"])
        cameras.append(
            CalibratedCamera(
                str(table.get("name", key)),
                (width, height),
                (float(K[0, 0]), float(K[1, 1])),
                (float(K[0, 2]), float(K[1, 2])),
                tuple(float(each) for each in np.ravel(table.get("distortions", ()))),
                transform(np.asarray(cv2.Rodrigues(turn)[0], np.float64), shift),
            )
        )
    return cameras


def _from_qualisys(text: str) -> list[CalibratedCamera]:
    """Places in millimetres of a world that a camera sees with y up and z toward it, turned so that
    it looks along z with y down."""
    if "<!DOCTYPE" in text or "<!ENTITY" in text:  # which may grow without end
        raise ValueError("entities")
    cameras = []
    for number, each in enumerate(ElementTree.fromstring(text).iter("camera"), start=1):
        placed, lens, fov = each.find("transform"), each.find("intrinsic"), each.find("fov_video")
        if placed is None or lens is None or fov is None:
            continue
        R = np.array([[float(placed.attrib[f"r{i}{j}"]) for j in (1, 2, 3)] for i in (1, 2, 3)])
        R = nearest_rotation(np.diag([1.0, -1.0, -1.0]) @ R)
        place = np.array([float(placed.attrib[axis]) for axis in "xyz"])
        left, top, right, bottom = (
            int(float(fov.attrib[side])) for side in ("left", "top", "right", "bottom")
        )
        values = {name: float(lens.attrib[name]) for name in _QUALISYS}
        cameras.append(
            CalibratedCamera(
                each.attrib.get("serial", f"camera {number}"),
                (right - left + 1, bottom - top + 1),
                (values["focalLengthU"] / SUBPIXELS, values["focalLengthV"] / SUBPIXELS),
                (
                    values["centerPointU"] / SUBPIXELS - left,
                    values["centerPointV"] / SUBPIXELS - top,
                ),
                tuple(values[name] for name in _QUALISYS[4:]),
                transform(R, -R @ place),
            )
        )
    return cameras


_QUALISYS: Final = (
    *("focalLengthU", "focalLengthV", "centerPointU", "centerPointV"),
    *("radialDistortion1", "radialDistortion2", "tangentalDistortion1", "tangentalDistortion2"),
    "radialDistortion3",
)
_MATRIX: Final = re.compile(
    r"^(\w+):\s*!!opencv-matrix\s+rows:\s*(\d+)\s+cols:\s*(\d+)\s+dt:\s*\w\s+data:\s*\[([^\]]*)\]",
    re.M,
)
_NAMES: Final = {
    "K": ("M", "K", "cameraMatrix", "camera_matrix_"),
    "D": ("D", "distCoeffs", "distortion_coefficients_"),
}


def _from_opencv(text: str) -> list[CalibratedCamera]:
    """Two cameras of a stereo calibration, the second placed by R and T in the first's frame."""
    matrices = {
        name: np.array([float(each) for each in data.split(",")]).reshape(int(rows), int(cols))
        for name, rows, cols, data in _MATRIX.findall(text)
    }
    cameras = []
    for number in (1, 2):
        K = _of(matrices, _NAMES["K"], number)
        distortion = tuple(float(each) for each in _of(matrices, _NAMES["D"], number).ravel())
        T = np.eye(4)
        if number == 2:
            T = transform(nearest_rotation(matrices["R"]), matrices["T"].ravel())
        cameras.append(
            CalibratedCamera(
                f"camera {number}",
                _size_of(text),
                (float(K[0, 0]), float(K[1, 1])),
                (float(K[0, 2]), float(K[1, 2])),
                distortion,
                T,
            )
        )
    return cameras


def _of(matrices: Mapping[str, Array], names: tuple[str, ...], number: int) -> Array:
    numbered = [f"{name}{number}" for name in names]
    return matrices[next((name for name in numbered if name in matrices), numbered[0])]


def _size_of(text: str) -> Size | None:
    sides = [re.search(rf"^image_?{side}:\s*(\d+)", text, re.M | re.I) for side in _SIDES]
    if all(sides):
        width, height = (int(each[1]) for each in sides if each)
        return width, height
    return None


_SIDES: Final = ("width", "height")
READERS: Final[Mapping[str, Callable[[str], list[CalibratedCamera]]]] = {
    ".toml": _from_toml,
    ".txt": _from_qualisys,
    ".xml": _from_qualisys,
    ".yml": _from_opencv,
    ".yaml": _from_opencv,
}
"""By the ending of the file's name."""
