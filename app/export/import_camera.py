"""A camera from elsewhere brought to a session: its lens, what is up, and the floor."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from keypose.app.editor.documents import require_sound, seen_as_before
from keypose.tracker.body.heading import CAMERA_UP
from keypose.tracker.body.trajectory import runs
from keypose.tracker.errors import FormatError, one_sentence
from keypose.tracker.formats.reading_camera import STILL_M, CameraFile, CameraWay
from keypose.tracker.geometry.camera_path import CameraPath, rigid_inverse
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.camera_motion import CameraFinding, CameraMotion
from keypose.tracker.session.schema import Session

DECIMALS = 6
SAME_DEG, SAME_M = 1e-3, 1e-4
"""What a file's rounding may change: the session then keeps its own, and tracked motion its key."""
LEAST_FLOOR_M = 0.05
"""The floor lies at least this far above or below the camera."""


def with_camera_file(session: Session, found: CameraFile, file: str) -> Session:
    """The session with the camera of a file of this name.

    What was posed keeps its place in the picture as far as the focal length goes: a longer lens
    shows it as large as before from farther away. What is as it was stays, so that a camera that
    comes back unchanged outdates no motion. Refused where that cannot be.
    """
    if found.way is not None:
        found = found.from_row(_first_of_film(found.way, session.view.video.frame_count))
    old, new = session.view.camera, found.camera
    seen = session.changed({"lens_source": "calibration", "camera": new})
    if new.model_copy(update={"origin": old.origin}) == old:
        seen = seen.changed({"camera": old})
    turned = seen.with_up(found.up_camera)
    if turned_deg(session, turned) > SAME_DEG:
        seen = turned
    if found.way is not None:
        count = session.view.video.frame_count
        motion = camera_motion_of(found.way, count, file)
        seen = seen.changed({"camera_motion": motion, "camera_keyframes": ()})
        settings = session.settings.model_copy(update={"static_camera": False})
        seen = seen.changed({"settings": settings})
    floor_m = found.floor_m
    if floor_m is not None and abs(floor_m) >= LEAST_FLOOR_M and not _is_near(floor_m, session):
        seen = seen.changed({"floor_m": round(floor_m, DECIMALS)})
    made = seen_as_before(session, seen)
    require_sound(session, made, "import the camera")
    return made


def camera_motion_of(way: CameraWay, frame_count: int, file: str) -> CameraMotion:
    """The motion of a file's camera over a film of so many frames.

    Frames that the file does not name are bridged, held at the ends, and reported. FormatError
    where it names none of the film.
    """
    frames = _of_film(way.frames, frame_count)
    inside = (frames >= 0) & (frames < frame_count)
    if not inside.any():
        raise FormatError(
            f"{file} has frames {way.frames[0]} to {way.frames[-1]}, and the film 0 to "
            f"{frame_count - 1}: export the camera of this film."
        )
    frames, Ts = frames[inside], way.Ts_world_camera[inside]
    here = CameraPath(_from_first(Ts), way.zoom[inside])
    row = np.interp(np.arange(frame_count), frames, np.arange(len(frames)))
    path = here.sampled(row)
    Ts_exact, zoom = path.Ts_camera_world.copy(), path.zoom.copy()
    Ts_exact[frames], zoom[frames] = here.Ts_camera_world, here.zoom
    Ts_exact[: frames[0] + 1] = np.eye(4)
    missing = np.ones(frame_count, dtype=np.bool_)
    missing[frames] = False
    findings = tuple(
        CameraFinding(kind="not_in_file", first_frame=first, last_frame=last)
        for first, last in runs(missing)
    )
    exact = CameraPath(Ts_exact, zoom)
    kind: Literal["turns", "moves"] = "moves" if exact.moves else "turns"
    try:
        return CameraMotion.of(kind, exact, None, findings, file[:120])
    except ValidationError as error:
        raise FormatError(f"{file} has numbers that no camera has: {one_sentence(error)}") from None


def _from_first(Ts_world_camera: Array) -> Array:
    """(K, 4, 4) the camera of the first frame in that of each; one that goes no farther than files
    round turns alone."""
    Ts = rigid_inverse(Ts_world_camera) @ Ts_world_camera[0]
    if np.ptp(Ts_world_camera[:, :3, 3], axis=0).max() <= STILL_M:
        Ts[:, :3, 3] = 0.0
    return np.asarray(Ts)


def _first_of_film(way: CameraWay, frame_count: int) -> int:
    """The row of the first frame of the film that a file names; 0 where it names none."""
    inside = _of_film(way.frames, frame_count) >= 0
    return int(inside.argmax())


def _of_film(frames: NDArray[np.int64], count: int) -> NDArray[np.int64]:
    """The film's numbers of frames that a file may count from 1, or as image files are."""
    if frames[0] >= 0 and frames[-1] < count:
        return frames
    whole = len(frames) == count and frames[-1] - frames[0] == count - 1
    return frames - frames[0] if whole else frames


def turned_deg(session: Session, made: Session) -> float:
    """Return by how much what is up has changed, degrees."""
    before, after = (np.array(s.world.up_world or CAMERA_UP) for s in (session, made))
    cosine = before @ after / np.linalg.norm(before) / np.linalg.norm(after)
    return float(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))))


def _is_near(floor_m: float, session: Session) -> bool:
    return session.world.floor_m is not None and abs(session.world.floor_m - floor_m) < SAME_M
