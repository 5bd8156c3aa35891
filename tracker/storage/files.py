"""Read and write the session file, and find the video it is about by its fingerprint."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from pydantic import ValidationError
from pydantic_core import from_json

from keypose.tracker.errors import SessionError, one_sentence
from keypose.tracker.files import TooLarge, read_named, read_own, read_regular
from keypose.tracker.session.migrate import PRESENT, migrate, version_in
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.atomic import write_file
from keypose.tracker.storage.edit_history import Recovered, recover, with_results_of
from keypose.tracker.storage.evidence import files_of
from keypose.tracker.storage.journal import NAME as JOURNAL
from keypose.tracker.storage.journal import Read, read_journal

if TYPE_CHECKING:
    from keypose.tracker.video import Video


MOST_FILES = 500
NOT_FILMS = (".json", ".jsonl", ".npz", ".csv", ".txt", ".md", ".py", ".previous", ".part")


def find_moved(session: Session, session_path: Path, was: Path) -> Path | None:
    """The same film near the session or near where it was; None where there is none.

    Looked at are the files of three folders: the session's, the one above, and that of `was`; and
    the folders in them, where the session is about a folder of meshes.
    """
    if not session.view.video.fingerprint:
        return None
    files = files_of(session)
    for place in _nearby(Path(session_path).absolute().parent, was):
        try:
            if files.fingerprint_at(session, place) == session.view.video.fingerprint:
                return place
        except OSError:  # it cannot be read, so it is not the one
            continue
    return None


def with_present_fingerprints(session: Session, session_path: Path, video: Video) -> Session:
    """The session with the present fingerprints of meshes and cameras, which may have been exported
    again; the same session where nothing differs. video: as it was opened."""
    folder = Path(session_path).absolute().parent
    return files_of(session).refresh_fingerprints(session, folder, video)


def _nearby(folder: Path, was: Path) -> Iterator[Path]:
    for place in dict.fromkeys((folder, folder.parent, was.parent)):
        try:
            there = [file for file in place.iterdir() if not file.name.lower().endswith(NOT_FILMS)]
        except (OSError, ValueError):  # ValueError: a NUL character in its name
            continue
        # One of the old name first; it is the likeliest.
        yield from sorted(there, key=lambda file: (file.name != was.name, file))[:MOST_FILES]


LARGEST_SESSION_BYTES = 64 * 2**20
"""Far above any session: a larger file is a video or an archive chosen by mistake."""


READING_TRIES = 20
"""How often session file and journal are read anew while another program writes them."""


@dataclass(frozen=True, eq=False)
class Opened:
    """A session as it was left, from its file and its journal.

    session:   the newest document, with the results of the session file.
    recovered: the same with its history, and whether the journal can be continued.
    journal:   what was read of it.
    problem:   why that cannot be read, in a sentence.
    """

    session: Session
    recovered: Recovered
    journal: Read
    problem: str = ""


def load_session(path: Path) -> Session:
    """The session in a file, with the edits that only its journal has.

    SessionError in one sentence that names the file and the field.
    """
    return open_session(path).session


def open_session(path: Path) -> Opened:
    """The same with its history."""
    session, journal, problem = _read_both(path)
    recovered = recover(session, journal.records)
    newest = with_results_of(recovered.moment.doc, session)
    return Opened(newest if recovered.ahead else session, recovered, journal, problem)


def _read_both(path: Path) -> tuple[Session, Read, str]:
    """Session file, journal, and why that cannot be read, as they stand at one moment: where the
    file is written anew between the two, it would seem older than its journal."""
    for _ in range(READING_TRIES):
        version = _version(path)
        session = read_session(path)
        try:
            journal, problem = read_journal(journal_path(path)), ""
        except SessionError as error:  # the session file is whole by itself
            journal, problem = Read(), str(error)
        if _version(path) == version:
            break
    return session, journal, problem


def _version(path: Path) -> tuple[int, int, int] | None:
    """Changes when a file is replaced or written; None where it is not to be seen."""
    try:
        facts = path.stat()
    except (OSError, ValueError):  # reading it says which
        return None
    return facts.st_ino, facts.st_mtime_ns, facts.st_size


def read_session(path: Path) -> Session:
    """The session file alone, without the edits that only the journal has."""
    content = read_named(path, LARGEST_SESSION_BYTES, "session file", SessionError)
    try:
        data = migrate(from_json(content), path.name)
    except ValueError as error:
        raise SessionError(f"{path.name} is not JSON: {error}.") from None
    try:
        return Session.model_validate(data)
    except ValidationError as error:
        text = one_sentence(error)
        version = data["schema_version"]
        newer = f"written by a newer Keypose (version {version}), and here " * (version > PRESENT)
        raise SessionError(f"{path.name}: {newer}{text[:1].lower()}{text[1:]}") from None


def journal_path(session_path: Path) -> Path:
    """Where the journal of a session file lies: journal.jsonl for session.json."""
    stem = "" if session_path.name == "session.json" else f"{session_path.stem}."
    return session_path.with_name(f"{stem}{JOURNAL}")


def save_session(session: Session, path: Path) -> None:
    """Write the session file in one step that either happens or does not.

    The file that was there is kept as `<name>.previous`, and one of an older version as
    `<name>.v2` for good, unless it says the same already; then nothing is written. SessionError
    when the disk refuses, and for a file of a newer Keypose, which stays as it is.
    """
    content = session_json(session)
    try:
        there = read_own(path, LARGEST_SESSION_BYTES)
    except OSError:  # cannot be compared, so write it, which reports what is wrong
        there = b""
    if there == content:
        return
    _require_not_newer(session, path, there)
    _back_up(path, there)
    write_file(path, content, overwrite=True, keep_previous=True, error=SessionError)


def _require_not_newer(session: Session, path: Path, there: bytes) -> None:
    version = max(version_in(there) or 0, session.schema_version)
    if version > PRESENT:
        raise SessionError(
            f"{path.name} is of a newer Keypose (version {version}) and is not changed by this one."
        )


def _back_up(path: Path, there: bytes) -> None:
    """Keep a file of an older version for going back to that Keypose."""
    version = version_in(there)
    if version is None or version >= PRESENT:
        return
    kept = path.with_name(f"{path.name}.v{version}")
    if not os.path.lexists(kept):
        write_file(kept, there, error=SessionError)


def set_aside(path: Path, own_contents: Collection[bytes]) -> Path | None:
    """Keep what another program wrote into a session file, before it is saved over.

    own_contents: what this program has read or written itself.  Returns the copy, None where
    nothing else was written. SessionError when it cannot be kept.
    """
    try:
        there = read_regular(path, LARGEST_SESSION_BYTES)
    except TooLarge as error:
        raise SessionError(
            f"{path.name} was replaced by a file that is too large for a session: move it away."
        ) from error
    except OSError:  # nothing there that could be lost
        return None
    if there in own_contents:
        return None
    copy = path.with_name(f"{path.stem}.theirs-{hashlib.sha256(there).hexdigest()[:8]}.json")
    if not os.path.lexists(copy):
        write_file(copy, there, error=SessionError)
    return copy


def session_json(session: Session) -> bytes:
    """The bytes of the session's file; the same session has the same bytes.

    SessionError for a session that could not be read back: it must never replace one that can.
    """
    try:
        content = session.model_dump_json(indent=2).encode() + b"\n"
        Session.model_validate_json(content)
    except ValidationError as error:
        sentence = one_sentence(error)
        raise SessionError(
            f"This session could not be opened again, so it is not saved ({sentence.rstrip('.')}). "
            "Undo the last edit."
        ) from None
    return content


def video_path(session: Session, session_path: Path) -> Path:
    """Where the session's video should be: its path is relative to the session file's
    folder.
    """
    return Path(session_path).absolute().parent / session.view.video.path


def open_video_of(session: Session, session_path: Path) -> Video:
    """The session's video, opened; where it was moved or renamed nearby, it is found again.

    Of observed surfaces it is what the session's camera sees of them (tracker.surface.picture).
    SessionError when it is missing or is not the one the keyframes were set on: frames are never
    shifted to fit. Meshes may have been exported again, as many as they were. VideoError or
    SurfaceError when it cannot be read.
    """
    path = video_path(session, session_path)
    try:
        return _open_as(session, session_path, path)
    except SessionError:
        moved = find_moved(session, session_path, path)
        if moved is None:
            raise
        return _open_as(session, session_path, moved)


def _open_as(session: Session, session_path: Path, path: Path) -> Video:
    if not _exists(path):
        raise SessionError(
            f"The {session.evidence.words.file} {str(path)!r} is missing; put it there or change "
            f"video.path in {session_path.name}."
        )
    return open_same_at(session, path, Path(session_path).absolute().parent)


def open_same_at(session: Session, path: Path, folder: Path) -> Video:
    """Open as `open_video_at`; SessionError where it is not what the session was made for."""
    return _same(session, path, open_video_at(session, path, folder))


def open_video_at(session: Session, path: Path, folder: Path) -> Video:
    """The video at a path, opened for this session whether it is the session's or not.

    folder: of the session's file.
    """
    return files_of(session).open(session, path, folder)


def open_for_work(session: Session, path: Path, folder: Path) -> Video:
    """The video at a path, opened for a session that is open already.

    SessionError where it may have been exported again and is not what the session was made for,
    such as with more surfaces than it has steps: every one after that would be another one's.
    """
    video = files_of(session).open_for_work(session, path, folder)
    return video if session.evidence.is_known_by_fingerprint else _same(session, path, video)


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except OSError:  # such as a name too long for any file
        return False


def _same(session: Session, path: Path, video: Video) -> Video:
    """The video; closed, and SessionError, where it is not what the session was made for."""
    try:
        _require_same(session, path, video)
    except BaseException:
        video.close()
        raise
    return video


def _require_same(session: Session, path: Path, video: Video) -> None:
    wanted, video_info = session.view.video, video.info
    if (video_info.width, video_info.height) != (wanted.width, wanted.height):
        difference = (
            f"it has {video_info.width}×{video_info.height} pixels instead of "
            f"{wanted.width}×{wanted.height}"
        )
    elif video_info.frame_count != wanted.frame_count:
        difference = f"it has {video_info.frame_count} frames instead of {wanted.frame_count}"
    elif not _fingerprint_matches(session, video):
        difference = "fingerprint differs"
    else:
        return
    raise SessionError(
        f"The {session.evidence.words.file} {str(path)!r} is not the one this session was made for "
        f"({difference}); change video.path, or set the keyframes anew."
    )


def _fingerprint_matches(session: Session, video: Video) -> bool:
    if not session.evidence.is_known_by_fingerprint:
        return True
    return session.view.video.fingerprint in ("", video.fingerprint())
