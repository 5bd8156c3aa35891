"""2D keypoints in: COCO annotations, or a folder with one OpenPose file for each frame.

COCO: a list of annotations, or an object that holds it as `annotations`, beside `images` and
`categories` when one likes. An annotation is of the frame whose number its `image_id` is, or else
the last number in its image's file name. OpenPose: `…_000000000012_keypoints.json` is frame 12.
Of several people in a frame the most confident counts. Pixels have their centres at integers.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from pydantic_core import from_json

from tracker.errors import FormatError
from tracker.files import TooLarge, read_regular
from tracker.geometry.rotations import Array

LARGEST_KEYPOINT_BYTES: Final = 256 * 2**20
LARGEST_PERSON_BYTES: Final = 16 * 2**20
MOST_FILES: Final = 200_000
FARTHEST_PX: Final = 1e6

_FIVE = ("Nose", "LEye", "REye", "LEar", "REar")
_COCO_17 = (
    *_FIVE, "LShoulder", "RShoulder", "LElbow", "RElbow", "LWrist", "RWrist",
    "LHip", "RHip", "LKnee", "RKnee", "LAnkle", "RAnkle",
)  # fmt: skip
_ARMS = (
    "Nose", "Neck", "RShoulder", "RElbow", "RWrist", "LShoulder", "LElbow", "LWrist",
)  # fmt: skip
_LEGS = ("RHip", "RKnee", "RAnkle", "LHip", "LKnee", "LAnkle")
_HEAD = ("REye", "LEye", "REar", "LEar")
_FEET = ("LBigToe", "LSmallToe", "LHeel", "RBigToe", "RSmallToe", "RHeel")
LAYOUTS: Final[dict[int, tuple[str, ...]]] = {
    17: _COCO_17,
    18: (*_ARMS, *_LEGS, *_HEAD),
    25: (*_ARMS, "MidHip", *_LEGS, *_HEAD, *_FEET),
}
"""The usual names by how many keypoints a person has."""


@dataclass(frozen=True, eq=False)
class Keypoints:
    """Keypoints of one person over time.

    names:  (J,).
    frames: of every frame, pixels (J, 2), NaN where not seen, and confidences (J,), 0 to 1.
    """

    names: tuple[str, ...]
    frames: Mapping[int, tuple[Array, Array]]

    def exchanged(self) -> Keypoints:
        """With left and right exchanged."""
        order = [self.names.index(_other_side(name, self.names)) for name in self.names]
        frames = {frame: (uv[order], sure[order]) for frame, (uv, sure) in self.frames.items()}
        return Keypoints(self.names, frames)


def load_keypoints(path: Path) -> Keypoints:
    """The keypoints in a COCO file or a folder of OpenPose files; FormatError in one sentence."""
    try:
        if path.is_dir():
            return _openpose(path)
        if re.search(r"_keypoints\.json$", path.name):
            return _from_people(path.name, None, {_number(path.name, 0): _people(path)})
        return _coco(path)
    except FileNotFoundError:
        raise FormatError(f"There is no file of keypoints {str(path)!r}.") from None
    except OSError as error:
        raise FormatError(f"{path.name} cannot be read: {error.strerror or error}.") from None


def _openpose(folder: Path) -> Keypoints:
    files = sorted(folder.glob("*_keypoints.json"))
    if not files:
        raise FormatError(f"{folder.name} holds no file …_keypoints.json, one for each frame.")
    if len(files) > MOST_FILES:
        raise FormatError(f"{folder.name} holds {len(files)} files, which is too many.")
    return _from_people(
        folder.name, None, {_number(file.name, i): _people(file) for i, file in enumerate(files)}
    )


def _people(path: Path) -> list[Any]:
    """The numbers of each person in an OpenPose file."""
    data = _json(path, LARGEST_PERSON_BYTES)
    people = data.get("people") if isinstance(data, dict) else None
    if not isinstance(people, list) or not all(isinstance(one, dict) for one in people):
        raise FormatError(f"{path.name} is no OpenPose file: it lists no people.")
    return [one.get("pose_keypoints_2d") for one in people]


def _coco(path: Path) -> Keypoints:
    data = _json(path, LARGEST_KEYPOINT_BYTES)
    given = data if isinstance(data, dict) else {"annotations": data}
    annotations = given.get("annotations")
    if not isinstance(annotations, list) or not all(isinstance(one, dict) for one in annotations):
        raise FormatError(f"{path.name} is no COCO file: it holds no list of annotations.")
    listed = given.get("images")
    images = {
        str(image.get("id")): str(image.get("file_name", ""))
        for image in (listed if isinstance(listed, list) else [])
        if isinstance(image, dict)
    }
    frames: dict[int, list[Any]] = {}
    for place, one in enumerate(annotations):
        image = one.get("image_id", place)
        name = images.get(str(image)) or str(image)
        frames.setdefault(_number(name, place), []).append(one.get("keypoints"))
    return _from_people(path.name, _category_names(given.get("categories")), frames)


def _category_names(categories: Any) -> tuple[str, ...] | None:
    """The names a COCO file gives to its keypoints, if it does."""
    for category in categories if isinstance(categories, list) else []:
        names = category.get("keypoints") if isinstance(category, dict) else None
        if isinstance(names, list) and names and all(isinstance(n, str) for n in names):
            return tuple(names)
    return None


def _from_people(
    file: str, names: tuple[str, ...] | None, frames: Mapping[int, Sequence[Any]]
) -> Keypoints:
    """Of each frame's people the most confident; FormatError where their numbers are no keypoints.

    A person may have none at all, such as one that is only a box, and is passed over.
    """
    found: dict[int, tuple[Array, Array]] = {}
    for frame, people in frames.items():
        tables = [_table(file, numbers) for numbers in people if numbers not in (None, [])]
        for table in tables:
            names = names or LAYOUTS.get(len(table))
            if names is None or len(table) != len(names):
                raise FormatError(
                    f"{file} has a person of {len(table)} keypoints; 17, 18 or 25 are expected."
                )
        if tables:
            best = max(tables, key=lambda table: float(_confidence(table).sum()))
            sure = _confidence(best)
            found[frame] = (np.where(sure[:, None] > 0, best[:, :2], np.nan), sure)
    if names is None or not any((sure > 0).any() for _, sure in found.values()):
        raise FormatError(f"{file} holds no keypoint of anybody.")
    return Keypoints(names, found)


def _table(file: str, numbers: Any) -> Array:
    """(J, 3) of u, v and confidence, from a flat list."""
    try:
        flat = np.array(numbers, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        flat = np.empty(1)
    if flat.ndim != 1 or not len(flat) or len(flat) % 3:
        raise FormatError(f"{file} has keypoints that are not u, v and confidence in turn.")
    if not np.isfinite(flat).all() or np.abs(flat).max() > FARTHEST_PX:
        raise FormatError(f"{file} has a keypoint that is nowhere near a picture.")
    return flat.reshape(-1, 3)


def _confidence(table: Array) -> Array:
    """0 to 1; COCO's visibility 1 and 2 is sure."""
    return np.asarray(np.clip(table[:, 2], 0.0, 1.0))


def _number(name: str, otherwise: int) -> int:
    """The last number in a name, without its ending."""
    stem = name.removesuffix("_keypoints.json")
    stem = stem.rsplit(".", 1)[0] if re.search(r"\.\D\w*$", stem) else stem
    digits = re.findall(r"\d+", stem)
    return int(digits[-1][-9:]) if digits else otherwise


def _other_side(name: str, names: Sequence[str]) -> str:
    for one, other in (("left", "right"), ("Left", "Right"), ("L", "R")):
        for a, b in ((one, other), (other, one)):
            if name.startswith(a) and b + name[len(a) :] in names:
                return b + name[len(a) :]
    return name


def _json(path: Path, largest: int) -> Any:
    try:
        return from_json(read_regular(path, largest))
    except TooLarge:
        raise FormatError(f"{path.name} is too large for keypoints.") from None
    except ValueError:
        raise FormatError(f"{path.name} is not JSON.") from None
