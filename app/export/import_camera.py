"""A camera from elsewhere brought to a session: its lens, what is up, and the floor."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from keypose.app.editor.documents import require_sound, seen_as_before
from keypose.app.orders.imports import ImportCamera
from keypose.tracker.body.trajectory import runs
from keypose.tracker.errors import FormatError, KeyposeError, one_sentence
from keypose.tracker.formats.cameras.camera_file import CameraReading
from keypose.tracker.formats.cameras.placing import FilmFrames, placed
from keypose.tracker.formats.reading_camera import STILL_M, CameraFile, CameraWay
from keypose.tracker.formats.text import Note
from keypose.tracker.geometry.camera_path import CameraPath, rigid_inverse
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.camera_motion import CameraFinding, CameraMotion, CameraPiece
from keypose.tracker.session.schema import Session
from keypose.tracker.video import Video
from keypose.tracker.video.info import VideoInfo

DECIMALS = 6
SAME_DEG = 1e-3
SAME_M = 1e-4
"""What a file's rounding may change: the session then keeps its own, and tracked motion its key."""
FASTEST_M_S = 8.0
"""A camera that goes faster is driven, or its file is in another unit."""
UNKNOWN_RATE = 30.0
"""Frames a second of a film that cannot be opened."""
LEAST_FLOOR_M = 0.05
"""The floor lies at least this far above or below the camera."""


def reading_of(order: ImportCamera) -> CameraReading:
    """How a file is meant, as somebody chose."""
    return CameraReading(order.rotation_order, order.lens_column, order.unit, order.world)


def film_frames(session: Session, info: VideoInfo | None) -> FilmFrames:
    """The frames of a session's film; of one that cannot be opened their number alone."""
    count = session.view.video.frame_count
    if info is None:
        return FilmFrames(np.arange(count) / UNKNOWN_RATE)
    times_s, code = session.evidence.times_s(info.times_s), info.timecode
    number = code.number if code is not None and code.of_files else None
    return FilmFrames(times_s, number)


@contextmanager
def film_or_none(opened: Callable[[], Video]) -> Iterator[Video | None]:
    """The film for as long as a camera is compared with it; None where it cannot be opened, of
    which there is a note then."""
    try:
        video = opened()
    except KeyposeError:
        yield None
        return
    with video:
        yield video


def brought(
    session: Session,
    camera_file: CameraFile,
    file: str,
    order: ImportCamera,
    video: Video | None,
) -> CameraFile:
    """A file's camera in frames of the film, compared with its background, with what was taken for
    granted or may be wrong. FormatError where it has nothing of the film.

    video: None where the film cannot be opened, or is not to be looked at.
    """
    if camera_file.way is None:
        return camera_file
    if video is None and camera_file.way.clock == "seconds":
        raise FormatError(f"{file} has times, and the film that they are of cannot be opened.")
    film = film_frames(session, None if video is None else video.info)
    camera_way, notes = placed(file, camera_file.way, film, order.offset_frames)
    is_metric = (
        camera_way.is_metric and camera_file.floor_m is None
    )  # which Keypose alone writes, in metres
    speed = _speed(camera_way, film) if is_metric and order.unit is None else ()
    here = replace(camera_file, way=camera_way, notes=(*camera_file.notes, *notes, *speed))
    if video is None:
        return replace(here, notes=(*here.notes, Note("film not compared")))
    if session.evidence.has_surface:
        return here
    from keypose.app.export.camera_check import compared  # loads what only this needs

    said = compared(session, file, here, camera_file, reading_of(order), film, video)
    notes = here.notes if said.note is None else (*here.notes, said.note)
    return replace(here, notes=notes, background_px=said.off_px)


def _speed(camera_way: CameraWay, film: FilmFrames) -> tuple[Note, ...]:
    """A note where a camera goes faster than one is carried, were its unit the metre."""
    frames = np.clip(camera_way.frames[[0, -1]], 0, len(film) - 1)
    seconds = film.second(float(frames[1])) - film.second(float(frames[0]))
    metres = float(
        np.linalg.norm(np.diff(camera_way.Ts_world_camera[:, :3, 3], axis=0), axis=1).sum()
    )
    return (Note("camera speed", (metres, seconds)),) if metres > FASTEST_M_S * seconds else ()


def with_camera_file(session: Session, camera_file: CameraFile, file: str) -> Session:
    """The session with the camera of a file of this name.

    What was posed keeps its place in the picture as far as the focal length goes: a longer lens
    shows it as large as before from farther away. What is as it was stays, so that a camera that
    comes back unchanged outdates no motion. Refused where that cannot be.
    """
    count = session.view.video.frame_count
    if camera_file.way is not None:
        camera_file = replace(camera_file, way=_of_film(camera_file.way, count, file))
        camera_file = camera_file.from_row(_first_of_film(camera_file.way))
    old, new = session.view.camera, camera_file.camera
    new_session = session
    if new is not None:
        new_session = session.changed({"lens_source": "calibration", "camera": new})
        if new.model_copy(update={"origin": old.origin}) == old:
            new_session = new_session.changed({"camera": old})
    if camera_file.up_camera is not None:
        turned = new_session.with_up(camera_file.up_camera)
        if turned_deg(session, turned) > SAME_DEG:
            new_session = turned
    if camera_file.way is not None:
        motion = camera_motion_of(camera_file.way, count, file)
        new_session = new_session.changed({"camera_motion": motion, "camera_keyframes": ()})
        settings = session.settings.model_copy(update={"static_camera": False})
        new_session = new_session.changed({"settings": settings})
    floor_m = camera_file.floor_m
    if floor_m is not None and abs(floor_m) >= LEAST_FLOOR_M and not _is_near(floor_m, session):
        new_session = new_session.changed({"floor_m": round(floor_m, DECIMALS)})
    made = seen_as_before(session, new_session)
    require_sound(session, made, "import the camera")
    return made


def camera_motion_of(camera_way: CameraWay, frame_count: int, file: str) -> CameraMotion:
    """The motion of a file's camera over a film of so many frames.

    Frames that the file does not name are bridged, held at the ends, and reported. FormatError
    where it names none of the film.
    """
    camera_way = _of_film(camera_way, frame_count, file)
    camera_way = camera_way.rows((camera_way.frames >= 0) & (camera_way.frames < frame_count))
    frames: NDArray[np.int64] = camera_way.frames
    here = CameraPath(_from_first(camera_way.Ts_world_camera), camera_way.zoom)
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
    moves = exact.moves or bool(camera_way.unscaled)
    kind: Literal["turns", "moves"] = "moves" if moves else "turns"
    metres = 1.0 if camera_way.is_metric or kind == "turns" else None
    pieces = _pieces(metres, camera_way.unscaled, frame_count)
    try:
        return CameraMotion.of(kind, exact, None, findings, file[:120], pieces)
    except ValidationError as error:
        raise FormatError(f"{file} has numbers that no camera has: {one_sentence(error)}") from None


def _pieces(
    metres: float | None, unscaled: tuple[tuple[int, int], ...], frame_count: int
) -> tuple[CameraPiece, ...]:
    """What hangs together of a motion whose unit is as long, but for the spans without scale."""
    within = [(max(a, 0), min(b, frame_count - 1)) for a, b in unscaled]
    spans = [(a, b) for a, b in within if a <= b]
    metres_of_start = {0: metres, **{b + 1: metres for _, b in spans if b + 1 < frame_count}}
    units = {**metres_of_start, **dict.fromkeys((a for a, _ in spans))}
    return tuple(CameraPiece(first_frame=at, metres=units[at]) for at in sorted(units))


def _from_first(Ts_world_camera: Array) -> Array:
    """(K, 4, 4) the camera of the first frame in that of each; one that goes no farther than files
    round turns alone."""
    Ts = rigid_inverse(Ts_world_camera) @ Ts_world_camera[0]
    if np.ptp(Ts_world_camera[:, :3, 3], axis=0).max() <= STILL_M:
        Ts[:, :3, 3] = 0.0
    return np.asarray(Ts)


def _first_of_film(camera_way: CameraWay | None) -> int:
    """The row of the first frame of the film that a file names."""
    return 0 if camera_way is None else int((camera_way.frames >= 0).argmax())


def _of_film(camera_way: CameraWay, frame_count: int, file: str) -> CameraWay:
    """The way in frames of the film; of a film of which only their number is known, as its file
    counts them. FormatError where none lies in it."""
    if (
        camera_way.clock == "frames"
        and (camera_way.frames < frame_count).any()
        and (camera_way.frames >= 0).any()
    ):
        return camera_way
    return placed(file, camera_way, FilmFrames(np.arange(frame_count, dtype=float)))[0]


def turned_deg(session: Session, made: Session) -> float:
    """By how much what is up has changed, degrees."""
    cosine = session.world.up @ made.world.up
    return float(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))))


def _is_near(floor_m: float, session: Session) -> bool:
    return session.world.floor_m is not None and abs(session.world.floor_m - floor_m) < SAME_M
