"""What a file from elsewhere holds: a recorded motion, 2D keypoints, or a camera."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final, Literal, TypeAlias

from keypose.app.export.import_camera import film_frames, turned_deg, with_camera_file
from keypose.app.export.importing import names_of, video_facts
from keypose.app.orders.imports import EVERY
from keypose.app.words.imports import note_words
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import ChoiceError, FormatError
from keypose.tracker.files import TooLarge, read_regular
from keypose.tracker.formats.cameras.placing import placed
from keypose.tracker.formats.joint_motion import JointMotion
from keypose.tracker.formats.joint_names import matched
from keypose.tracker.formats.keypoint_files import (
    KEYPOINT_READERS,
    LARGEST_KEYPOINT_BYTES,
    is_table_of_keypoints,
    read_people,
)
from keypose.tracker.formats.people import People
from keypose.tracker.formats.reading import MOTION_READERS, load_motion
from keypose.tracker.formats.reading_camera import (
    CAMERA_READERS,
    CameraFile,
    is_splats,
    is_transforms,
    load_camera,
)
from keypose.tracker.formats.reading_keypoints import VideoFacts, keypoints_of, on_video
from keypose.tracker.formats.text import decoded
from keypose.tracker.session import Session
from keypose.tracker.video.info import VideoInfo

Kind: TypeAlias = Literal["motion", "keypoints", "camera"]

_CAMERA_PROGRAMS: Final = {
    ".json": "JSON",
    ".chan": "Nuke",
    ".glb": "glTF",
    ".gltf": "glTF",
    ".txt": "COLMAP or TUM",
}
_KINDS: Final[Sequence[tuple[Kind, frozenset[str]]]] = (
    ("motion", frozenset(MOTION_READERS)),
    ("keypoints", frozenset({*KEYPOINT_READERS, ".json"})),
    ("camera", frozenset(CAMERA_READERS)),
)
ENDINGS: Final = tuple(dict.fromkeys((*MOTION_READERS, *KEYPOINT_READERS, *CAMERA_READERS)))
"""Of the names of files that can be imported."""
PICKLED: Final = (".pkl", ".pickle")
"""Endings of what is refused in a sentence that says what to do."""
NOT_OFFERED: Final = (*PICKLED, ".txt")
"""Endings that a page does not offer: most text is no camera, and COLMAP's lenses lie beside it."""


@dataclass(frozen=True)
class Recognised:
    """What a file holds, for somebody who decides how to import it; see `facts` of each kind."""

    kind: Kind
    program: str
    facts: Mapping[str, Any]


def kind_of(path: Path) -> Kind:
    """What a file holds, by the ending of its name and, where several have that, by what is
    in it. FormatError in one sentence where it is nothing that can be imported.
    """
    ending = path.suffix.lower()
    if path.is_dir():
        return "keypoints"
    if ending not in ENDINGS:
        raise FormatError(
            f"{path.name} holds nothing that can be imported: a motion (BVH, TRC, C3D, CSV, .npz, "
            ".pt), keypoints (JSON, CSV, HDF5) or a camera (JSON, .chan, glTF, text of COLMAP) is "
            "expected."
        )
    kinds = [kind for kind, endings in _KINDS if ending in endings]
    if len(kinds) == 1 or ending in PICKLED:
        return kinds[0]
    content = _content(path)
    if ending == ".csv":
        return "keypoints" if is_table_of_keypoints(path.name, content) else "motion"
    return _kind_of_json(path.name, content)


def _content(path: Path) -> bytes:
    try:
        return read_regular(path, LARGEST_KEYPOINT_BYTES)
    except TooLarge:
        limit = LARGEST_KEYPOINT_BYTES // 2**20
        raise FormatError(f"{path.name} is larger than the {limit} MB a file may have.") from None
    except OSError as error:
        raise FormatError(f"{path.name} cannot be read: {error.strerror or error}.") from None


def _kind_of_json(file: str, content: bytes) -> Kind:
    try:
        data = json.loads(decoded(content))
    except (ValueError, RecursionError):
        raise FormatError(f"{file} is not JSON.") from None
    if isinstance(data, dict) and data.get("format") == "keypose camera":
        return "camera"
    if is_transforms(data) or is_splats(data):
        return "camera"
    if isinstance(data, dict) and "schema_version" in data:
        raise FormatError(f"{file} is a session: open it where it lies, beside its video.")
    return "keypoints"


def recognise(session: Session, path: Path, video: VideoInfo) -> Recognised:
    """What a file holds and how much of it the session can take; FormatError in one sentence
    where nothing.
    """
    kind = kind_of(path)
    if kind == "motion":
        return _recognised_motion(session, path)
    if kind == "keypoints":
        return _recognised_keypoints(session, path, video)
    return _recognised_camera(session, path, video)


def _recognised_motion(session: Session, path: Path) -> Recognised:
    motion, individuals = _motion(path)
    matches = matched(Skeleton.of(session.subject.body), motion.names, path.name)
    times_s = motion.times_s
    seconds = None if motion.is_per_frame else float(times_s[-1] - times_s[0])
    facts = {
        "frames": len(motion),
        "seconds": seconds,
        "fps": (len(motion) - 1) / seconds if seconds else None,
        "unit": motion.unit,
        "world": motion.world,
        "keyframes": len(session.subject.keyframes),
        "individuals": individuals,
        "notes": note_words(motion.notes),
        **names_of(matches, motion.names),
    }
    return Recognised("motion", MOTION_READERS[path.suffix.lower()][0], facts)


def _recognised_keypoints(session: Session, path: Path, video: VideoInfo) -> Recognised:
    """Where it must be said which of several is meant, those are listed, and the rest is
    reported of the first.
    """
    people, individuals = _people(path)
    facts_of = video_facts(session, video)
    layouts: tuple[str, ...] = ()
    people, notes = _numbered_as_video(path.name, people, facts_of)
    try:
        keypoints = keypoints_of(path.name, people, None, facts_of)
    except ChoiceError as several:
        layouts = several.choices
        keypoints = keypoints_of(path.name, people, layouts[0], facts_of)
    matches = matched(Skeleton.of(session.subject.body), keypoints.names, path.name)
    shown = keypoints.visibility.any(axis=1)
    facts = {
        "frames": int(shown.sum()),
        "first": keypoints.first_frame,
        "last": keypoints.last_frame,
        "fps": people.fps,
        "people": people.most_at_once,
        "individuals": individuals,
        "layouts": layouts,
        "every": EVERY,
        "notes": notes,
        **names_of(matches, keypoints.names),
    }
    return Recognised("keypoints", people.program, facts)


def _motion(path: Path) -> tuple[JointMotion, tuple[str, ...]]:
    """A motion, and the names of subjects to choose from: of the first, where there are several."""
    motion = load_motion(path)
    try:
        return motion.of_individual(path.name, None), ()
    except ChoiceError as several:
        return motion.of_individual(path.name, several.choices[0]), several.choices


def _people(path: Path) -> tuple[People, tuple[str, ...]]:
    """The people in a file, and the names of individuals to choose from: of the first, where
    there are several.
    """
    try:
        return read_people(path), ()
    except ChoiceError as several:
        return read_people(path, several.choices[0]), several.choices


def _numbered_as_video(file: str, people: People, video: VideoFacts) -> tuple[People, list[str]]:
    """Those within the video and what is left out, or all and why they need another start
    frame.
    """
    try:
        within, notes = on_video(file, people, video)
    except FormatError as error:
        return people, [str(error)]
    return within, note_words(notes)


def _recognised_camera(session: Session, path: Path, video: VideoInfo) -> Recognised:
    """What is known of it without a look at the film. Frames that do not overlap the film's are a
    note and no error, for another start frame may be chosen."""
    ending = path.suffix.lower()
    camera_file = load_camera(path, (session.view.camera.width, session.view.camera.height))
    notes = note_words(camera_file.notes)
    if camera_file.way is not None:
        try:
            camera_way, more = placed(path.name, camera_file.way, film_frames(session, video))
            camera_file, notes = replace(camera_file, way=camera_way), [*notes, *note_words(more)]
        except FormatError as beside:
            camera_file, notes = replace(camera_file, way=None), [*notes, str(beside)]
    made = with_camera_file(session, camera_file, path.name)
    facts = {
        **camera_facts(session, made, camera_file),
        "columns": ending == ".chan",
        "notes": notes,
    }
    return Recognised("camera", _CAMERA_PROGRAMS[ending], facts)


def camera_facts(session: Session, made: Session, camera_file: CameraFile) -> dict[str, Any]:
    """The lens, by how much up is turned, and the floor, of a session with a camera of a file."""
    camera = made.view.camera
    return {
        "focal_mm": camera.focal_mm,
        "across_deg": 2 * math.degrees(math.atan(camera.width / 2 / camera.fx)),
        "turned_deg": turned_deg(session, made),
        "floor_m": None
        if camera_file.floor_m is None or made.world.floor_m is None
        else -made.world.floor_m,
    }
