"""Reading and writing the session file, and finding the video it is about."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError
from pydantic_core import from_json

from tracker.errors import SessionError
from tracker.session.atomic import write_file
from tracker.session.schema import SCHEMA_VERSION, Session
from tracker.wording import one_sentence

if TYPE_CHECKING:
    from tracker.video import Video

LARGEST_SESSION_BYTES = 256 * 2**20
"""Far above any session: what is larger is a video or an archive chosen by mistake."""


def load_session(path: Path) -> Session:
    """The session in a file; SessionError in one sentence that names the file and the field."""
    content = _read(path)
    try:
        _demand_version(path, from_json(content))
        return Session.model_validate_json(content)
    except ValidationError as error:
        text = one_sentence(error)
        raise SessionError(f"{path.name}: {text[:1].lower()}{text[1:]}") from None
    except ValueError as error:
        raise SessionError(f"{path.name} is not JSON: {error}.") from None


def save_session(session: Session, path: Path) -> None:
    """Write the session file in one step that either happens or does not.

    The file that was there is kept as `<name>.previous`, unless it says the same already; then
    nothing is written. SessionError when the disk refuses.
    """
    content = session_json(session)
    try:
        if path.is_file() and path.read_bytes() == content:
            return
    except OSError:  # it cannot be compared, so it is written, which tells what is wrong
        pass
    write_file(path, content, overwrite=True, keep_previous=True, error=SessionError)


def session_json(session: Session) -> bytes:
    """The bytes of the session's file; the same session has the same bytes."""
    return session.model_dump_json(indent=2).encode() + b"\n"


def video_path(session: Session, session_path: Path) -> Path:
    """Where the session's video should be: its path is relative to the session file's folder."""
    return Path(session_path).absolute().parent / session.video.path


def open_video_of(session: Session, session_path: Path) -> Video:
    """The session's video, opened.

    SessionError when it is missing or is not the one the keyframes were set on: frames are never
    shifted to fit. VideoError when it cannot be decoded.
    """
    from tracker.video import Video  # the decoder's libraries load when a video is wanted

    path = video_path(session, session_path)
    if not _exists(path):
        raise SessionError(
            f"The video {str(path)!r} is missing; put it there or change video.path in "
            f"{session_path.name}."
        )
    video = Video.open(path)
    try:
        _demand_same(session, path, video)
    except BaseException:
        video.close()
        raise
    return video


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except OSError:  # such as a name too long for any file
        return False


def _demand_same(session: Session, path: Path, video: Video) -> None:
    wanted, found = session.video, video.info
    if (found.width, found.height) != (wanted.width, wanted.height):
        difference = (
            f"it has {found.width}×{found.height} pixels instead of {wanted.width}×{wanted.height}"
        )
    elif found.frame_count != wanted.frame_count:
        difference = f"it has {found.frame_count} frames instead of {wanted.frame_count}"
    elif wanted.fingerprint not in ("", video.fingerprint()):
        difference = "fingerprint differs"
    else:
        return
    raise SessionError(
        f"The video {str(path)!r} is not the one this session was made for ({difference}); change "
        "video.path, or set the keyframes anew."
    )


def _read(path: Path) -> bytes:
    try:
        if path.is_dir():
            raise SessionError(f"{str(path)!r} is a folder; name the session file in it.")
        if path.stat().st_size > LARGEST_SESSION_BYTES:
            raise SessionError(f"{str(path)!r} is too large to be a session file.")
        return path.read_bytes()
    except FileNotFoundError:
        raise SessionError(f"There is no session file {str(path)!r}.") from None
    except (OSError, ValueError) as error:  # ValueError: a NUL character in the name
        why = getattr(error, "strerror", None) or error
        raise SessionError(f"The session file {str(path)!r} cannot be read: {why}.") from None


def _demand_version(path: Path, data: Any) -> None:
    """Told before everything else: a newer file's other fields would give misleading errors."""
    if not isinstance(data, dict):
        raise SessionError(f"{path.name} is not a session: its JSON is not an object.")
    if "schema_version" not in data:
        raise SessionError(
            f"{path.name}: schema_version is missing; a session of this Keypose says "
            f"{SCHEMA_VERSION}."
        )
    version = data["schema_version"]
    if isinstance(version, int) and version > SCHEMA_VERSION:
        raise SessionError(
            f"{path.name}: schema_version is {version}, written by a newer Keypose; this one reads "
            f"version {SCHEMA_VERSION}."
        )
    if version != SCHEMA_VERSION:
        raise SessionError(f"{path.name}: schema_version must be {SCHEMA_VERSION}.")
