"""Read people as files of keypoints list them, frame by frame, before it is known what is what.

COCO, AlphaPose: a list of annotations, or an object that holds it as `annotations`, beside `images`
and `categories` when one likes. An annotation is of the frame whose number is in its image's file
name, or else in its `image_id`.
OpenPose, Pose2Sim: a folder with one file for each frame, `…_000000000012_keypoints.json` or
`…_000012.json` is frame 12; or a list of what these files hold, each with its `file_name`, as the
page makes it of a folder.
MMPose: frames with `frame_id` and `instances`, in a list or under `instance_info`, where frames
count from 1; or a folder with a list of instances for each picture.
MediaPipe: its results under their own names, `pose_landmarks` in Python and `landmarks` or
`poseLandmarks` in JavaScript, of one frame or in a list of frames, which may be under `frames`; the
33 of one person, or a list of people. A landmark is an object with x, y and visibility, or a list
of x, y, z and visibility; one that says nothing of its visibility is seen.

SLEAP, DeepLabCut: see `sleap` and `deeplabcut`; one individual of a file that tells them apart.
People are told apart by `track_id` or AlphaPose's `idx` of COCO, OpenPose's `person_id` and
`track_id` of MMPose, where everybody has one and no frame has it twice.

Of several numbers in the names of pictures the last that differs between all of them counts.
Width, height and fps of the video count where they are given: at the top, under `metadata`, `info`
or `video`, and the size in COCO's `images`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final

from pydantic_core import from_json

from keypose.tracker.errors import ChoiceError, FormatError
from keypose.tracker.files import TooLarge, read_regular
from keypose.tracker.formats import deeplabcut, hdf5, sleap
from keypose.tracker.formats.people import People, frame_numbers, identity
from keypose.tracker.formats.reading_csv import rows_of
from keypose.tracker.formats.text import decoded

LARGEST_KEYPOINT_BYTES: Final = 256 * 2**20
LARGEST_PERSON_BYTES: Final = 16 * 2**20
MOST_FILES: Final = 200_000
MOST_READ: Final = 64
"""Individuals of a file that are read at once."""

_LANDMARKS: Final = ("pose_landmarks", "poseLandmarks", "landmarks", "landmark")
_FRAME: Final = ("frame", "frame_index", "frameIndex", "frame_number", "frameNumber")
_ABOUT: Final = ("metadata", "info", "video")
"""Under which a file may describe its video, beside the top."""


def read_people(path: Path, individual: str | None = None) -> People:
    """The people in a file, or in a folder of files; FormatError in one sentence.

    individual: which one to read, in files that tell individuals apart.
    """
    try:
        if path.is_dir():
            return _openpose(path).of_individual(path.name, individual)
        read = KEYPOINT_READERS.get(path.suffix.lower())
        if read is not None:
            return read(path.name, read_regular(path, LARGEST_KEYPOINT_BYTES), individual)
        data = _json(path, LARGEST_KEYPOINT_BYTES)
    except FileNotFoundError:
        raise FormatError(f"There is no file of keypoints {str(path)!r}.") from None
    except TooLarge:
        raise FormatError(f"{path.name} is too large for keypoints.") from None
    except OSError as error:
        raise FormatError(f"{path.name} cannot be read: {error.strerror or error}.") from None
    if isinstance(data, dict) and ("people" in data or path.name.endswith("_keypoints.json")):
        people = _folder({path.name: data})
    elif _is_list_of_openpose(data):
        people = _folder({str(entry.get("file_name", n)): entry for n, entry in enumerate(data)})
    elif _is_mmpose(data):
        people = _mmpose(path.name, data)
    else:
        people = (_mediapipe if _has_landmarks(data) else _coco)(path.name, data)
    return people.of_individual(path.name, individual)


def read_each(path: Path, individual: str | None, every: bool) -> dict[str, People]:
    """The people in a file by their names: each of a file that tells individuals apart, where
    `every` asks for that and no individual is named; else as `read_people`, without a name."""
    if individual is not None or not every:
        return {individual or "": read_people(path, individual)}
    try:
        people = read_people(path)
    except ChoiceError as several:
        return {name: read_people(path, name) for name in several.choices[:MOST_READ]}
    names = people.individuals[:MOST_READ]
    return {name: people.of_individual(path.name, name) for name in names} or {"": people}


def _json(path: Path, largest: int) -> Any:
    try:
        content = read_regular(path, largest)
        return from_json(decoded(content) if content[:1] in b"\xef\xff\xfe" else content)
    except TooLarge:
        raise FormatError(f"{path.name} is too large for keypoints.") from None
    except ValueError:
        raise FormatError(f"{path.name} is not JSON.") from None


def _unknown(file: str) -> FormatError:
    return FormatError(
        f"{file} holds no keypoints in a form that is known: files of COCO, AlphaPose, OpenPose, "
        "Pose2Sim, MMPose, MediaPipe, SLEAP and DeepLabCut are read."
    )


# --- SLEAP, DeepLabCut


def is_table_of_keypoints(file: str, content: bytes) -> bool:
    """Whether a table is one of SLEAP or DeepLabCut; FormatError where it is none at all."""
    first = rows_of(file, decoded(content))[0]
    return deeplabcut.is_table(first) or sleap.is_table([head.strip() for head in first])


def _table(file: str, content: bytes, individual: str | None) -> People:
    rows = rows_of(file, decoded(content))
    if deeplabcut.is_table(rows[0]):
        return deeplabcut.read_table(file, rows, individual)
    if sleap.is_table([head.strip() for head in rows[0]]):
        return sleap.read_table(file, rows, individual)
    raise FormatError(
        f"{file} is no table of keypoints as SLEAP (frame_idx, NAME.x, NAME.y) or DeepLabCut "
        "(scorer, bodyparts, coords) writes it."
    )


def _hdf5(file: str, content: bytes, individual: str | None) -> People:
    with hdf5.opened(file, content) as root:
        if sleap.is_analysis(root):
            return sleap.read_analysis(root, individual)
        if deeplabcut.table_name(root) is not None:
            return deeplabcut.read_hdf(root, individual)
    raise FormatError(f"{file} is neither SLEAP's analysis nor a table of DeepLabCut.")


def _sleap_project(file: str, _content: bytes, _individual: str | None) -> People:
    raise FormatError(f"{file} is a SLEAP project: export it as analysis HDF5 or CSV.")


def _pickled(file: str, _content: bytes, _individual: str | None) -> People:
    raise FormatError(f"{file} may run code when it is read: use DeepLabCut's CSV or .h5.")


KEYPOINT_READERS: Final[Mapping[str, Callable[[str, bytes, str | None], People]]] = {
    ".csv": _table,
    ".h5": _hdf5,
    ".hdf5": _hdf5,
    ".slp": _sleap_project,
    ".pickle": _pickled,
    ".pkl": _pickled,
}


# --- a file for each frame


def _openpose(folder: Path) -> People:
    files = sorted(folder.glob("*_keypoints.json")) or sorted(folder.glob("*.json"))
    if not files:
        raise FormatError(f"{folder.name} holds no file …_keypoints.json, one for each frame.")
    if len(files) > MOST_FILES:
        raise FormatError(f"{folder.name} holds {len(files)} files, which is too many.")
    return _folder({file.name: _json(file, LARGEST_PERSON_BYTES) for file in files})


def _is_list_of_openpose(data: Any) -> bool:
    return isinstance(data, list) and any(
        isinstance(entry, dict) and {"people", "file_name"} <= entry.keys() for entry in data
    )


def _folder(contents: Mapping[str, Any]) -> People:
    """The people of files by their names."""
    numbers = frame_numbers(list(contents))
    is_mmpose = all(isinstance(content, list) for content in contents.values())
    of_file = _instances if is_mmpose else _openpose_people
    frames, ids = dict[int, list[Any]](), dict[int, list[str]]()
    for name, data in contents.items():
        frames.setdefault(numbers[name], []).extend(of_file(name, data))
        ids.setdefault(numbers[name], []).extend(_ids(data if is_mmpose else data["people"]))
    return People(frames, program="MMPose" if is_mmpose else "OpenPose", ids=ids)


def _ids(persons: list[Any] | None) -> list[str]:
    """Who each person of OpenPose or MMPose is, as far as that is said."""
    return [identity(each.get("track_id"), each.get("person_id")) for each in persons or []]


def _openpose_people(file: str, data: Any) -> list[Any]:
    """The numbers of each person in an OpenPose file."""
    people = data.get("people") if isinstance(data, dict) else None
    if not isinstance(people, list) or not all(isinstance(person, dict) for person in people):
        raise FormatError(f"{file} is no OpenPose file: it lists no people.")
    return [person.get("pose_keypoints_2d") for person in people]


# --- MMPose


def _is_mmpose(data: Any) -> bool:
    if isinstance(data, dict):
        return "instance_info" in data
    first = next((entry for entry in data if entry), None) if isinstance(data, list) else None
    return isinstance(first, dict) and {"frame_id", "instances"} <= first.keys()


def _mmpose(file: str, data: Any) -> People:
    listed, first = (data["instance_info"], 1) if isinstance(data, dict) else (data, 0)
    if not isinstance(listed, list) or not all(isinstance(entry, dict) for entry in listed):
        raise _unknown(file)
    frames, ids = dict[int, list[Any]](), dict[int, list[str]]()
    for place, entry in enumerate(listed):
        frame = entry.get("frame_id", place + first)
        if not isinstance(frame, int) or isinstance(frame, bool) or not first <= frame < 1e9:
            raise FormatError(f"{file} has a frame that is numbered {str(frame)[:20]}.")
        frames.setdefault(frame - first, []).extend(_instances(file, entry.get("instances")))
        ids.setdefault(frame - first, []).extend(_ids(entry.get("instances")))
    return People(frames, program="MMPose", ids=ids)


def _instances(file: str, data: Any) -> list[Any]:
    """The numbers of each person in MMPose's list of instances."""
    persons = data or []
    if not isinstance(persons, list) or not all(isinstance(person, dict) for person in persons):
        raise _unknown(file)
    return [_instance(file, person) for person in persons]


def _instance(file: str, person: Mapping[str, Any]) -> list[Any]:
    places, scores = person.get("keypoints"), person.get("keypoint_scores")
    if not isinstance(places, list) or not all(
        isinstance(place, list) and len(place) == 2 for place in places
    ):
        raise _unknown(file)
    if scores is None:
        scores = [1.0] * len(places)
    if not isinstance(scores, list) or len(scores) != len(places):
        raise FormatError(f"{file} has keypoints without a score for each.")
    return [number for place, sure in zip(places, scores, strict=True) for number in (*place, sure)]


# --- COCO


def _coco(file: str, data: Any) -> People:
    coco = data if isinstance(data, dict) else {"annotations": data}
    annotations = coco.get("annotations")
    if not isinstance(annotations, list) or not all(
        isinstance(annotation, dict) for annotation in annotations
    ):
        raise _unknown(file)
    if any(isinstance(annotation.get("keypoints"), dict) for annotation in annotations):
        raise _unknown(file)
    listed = coco.get("images")
    images = {
        str(image.get("id")): image
        for image in (listed if isinstance(listed, list) else [])
        if isinstance(image, dict)
    }
    frames, ids = dict[int, list[Any]](), dict[int, list[str]]()
    sizes = set(_size(coco))
    of_annotation = [
        str(annotation.get("image_id", place)) for place, annotation in enumerate(annotations)
    ]
    pictures = [str(images.get(i, {}).get("file_name", "")) or i for i in of_annotation]
    numbers = frame_numbers(pictures)
    for annotation, number, picture in zip(annotations, of_annotation, pictures, strict=True):
        frames.setdefault(numbers[picture], []).append(annotation.get("keypoints"))
        who = identity(annotation.get("track_id"), annotation.get("idx"))
        ids.setdefault(numbers[picture], []).append(who)
        if annotation.get("keypoints"):
            sizes.update(_size(images.get(number, {})))
    names = _category_names(coco.get("categories"))
    return People(frames, names, None, frozenset(sizes), _fps(coco), "COCO", ids)


def _category_names(categories: Any) -> tuple[str, ...] | None:
    """The names a COCO file gives to its keypoints, if it does."""
    for category in categories if isinstance(categories, list) else []:
        names = category.get("keypoints") if isinstance(category, dict) else None
        if isinstance(names, list) and names and all(isinstance(n, str) for n in names):
            return tuple(names)
    return None


# --- MediaPipe


def _has_landmarks(data: Any) -> bool:
    """Whether these are landmarks rather than annotations."""
    if isinstance(data, dict):
        return "annotations" not in data and any(key in data for key in ("frames", *_LANDMARKS))
    first = next((entry for entry in data if entry), None) if isinstance(data, list) else None
    if isinstance(first, dict):
        return not {"keypoints", "image_id"} & first.keys() and (
            any(key in entry for entry in data if isinstance(entry, dict) for key in _LANDMARKS)
        )
    return isinstance(first, list)


def _mediapipe(file: str, data: Any) -> People:
    about = data if isinstance(data, dict) else {}
    listed = about.get("frames", [data]) if isinstance(data, dict) else data
    if not isinstance(listed, list):
        raise FormatError(f"{file} holds no list of frames.")
    frames: dict[int, list[Any]] = {}
    for place, entry in enumerate(listed):
        frames.setdefault(_frame(file, entry, place), []).extend(_landmark_people(file, entry))
    return People(
        frames,
        layout="MEDIAPIPE_33",
        sizes=frozenset(_size(about)),
        fps=_fps(about),
        program="MediaPipe",
    )


def _frame(file: str, frame: Any, place: int) -> int:
    """The number a frame gives itself, or else its place in the list."""
    numbers = [frame[key] for key in _FRAME if key in frame] if isinstance(frame, dict) else []
    number = numbers[0] if numbers else place
    if not isinstance(number, int) or isinstance(number, bool) or number < 0:
        raise FormatError(f"{file} has a frame that is numbered {number!r}.")
    return number


def _landmark_people(file: str, value: Any, deep: int = 0) -> list[Any]:
    """The numbers of each person in a frame, however its landmarks are nested."""
    if isinstance(value, dict):
        if "keypoints" in value:
            raise _unknown(file)
        return _landmark_people(
            file, next((value[key] for key in _LANDMARKS if key in value), None), deep
        )
    if value is None or value == []:
        return []
    if not isinstance(value, list) or deep > 1:
        raise FormatError(f"{file} has landmarks that are not a list for each person.")
    if _is_landmark(value[0]):
        return [[number for landmark in value for number in _u_v_visibility(file, landmark)]]
    return [person for nested in value for person in _landmark_people(file, nested, deep + 1)]


def _is_landmark(value: Any) -> bool:
    if isinstance(value, dict):
        return "x" in value
    return isinstance(value, list) and bool(value) and not isinstance(value[0], dict | list)


def _u_v_visibility(file: str, landmark: Any) -> tuple[Any, Any, Any]:
    if isinstance(landmark, dict) and "x" in landmark and "y" in landmark:
        return landmark["x"], landmark["y"], landmark.get("visibility", 1.0)
    if isinstance(landmark, list) and len(landmark) == 4:
        return landmark[0], landmark[1], landmark[3]
    raise FormatError(f"{file} has a landmark that is not x, y, z and visibility.")


# --- the video they are of


def _size(about: Mapping[str, Any]) -> list[tuple[float, float]]:
    """Width and height where both are given, beside or under what describes the video."""
    sizes: list[tuple[Any, Any]] = [(a.get("width"), a.get("height")) for a in _descriptions(about)]
    return [(w, h) for w, h in sizes if _is_positive(w) and _is_positive(h)]


def _fps(about: Mapping[str, Any]) -> float | None:
    return next(
        (
            description["fps"]
            for description in _descriptions(about)
            if _is_positive(description.get("fps"))
        ),
        None,
    )


def _descriptions(about: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    return [about, *(about[key] for key in _ABOUT if isinstance(about.get(key), dict))]


def _is_positive(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and 0 < value < 1e6
