"""What commands that draw or export read: the session, and its video where it is there."""

from __future__ import annotations

import argparse
from contextlib import nullcontext
from pathlib import Path
from typing import Any

from keypose.app.cli.arguments import note
from keypose.tracker.errors import FormatError, SessionError
from keypose.tracker.session import Session
from keypose.tracker.storage.atomic import require_absent, require_folder
from keypose.tracker.storage.files import load_session, open_video_of, video_path


def session_to_draw(arguments: argparse.Namespace, noun: str, *suffixes: str) -> Session:
    """The session to draw, once it is known that the file can be written."""
    out: Path = arguments.out
    if out.suffix.lower() not in suffixes:
        raise FormatError(f"{str(out)!r} must end in {suffixes[0]}, the format of the {noun}.")
    session = load_session(arguments.session)
    if not arguments.overwrite:
        require_absent([out])
    require_folder(out.parent)
    return session


def video_if_there(session: Session, session_path: Path, otherwise: str) -> Any:
    """The session's video, opened; where it is gone, nothing, with a note."""
    try:
        return open_video_of(session, session_path)
    except SessionError:
        if _exists(video_path(session, session_path)):  # another one, or damaged
            raise
    note(f"the {session.evidence.words.noun_with_is} missing; {otherwise}.")
    return nullcontext()


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except OSError:  # such as a name too long for any file
        return False
