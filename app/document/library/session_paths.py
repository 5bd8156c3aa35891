"""Where the session of a video lives."""

from __future__ import annotations

import os
from pathlib import Path

from pydantic_core import from_json

from keypose.app.document.library.files import SESSION_FOLDER
from keypose.app.document.library.names import numbered
from keypose.tracker.errors import KeyposeError
from keypose.tracker.files import read_regular
from keypose.tracker.storage.atomic import require_folder
from keypose.tracker.storage.files import LARGEST_SESSION_BYTES

SESSION = "session.json"

USUAL = ("Videos", "Movies", "Downloads", "Desktop")
"""Folders of a home where people keep films."""


def usual_folders(home: Path) -> list[Path]:
    """Those of them that there are."""
    return [home / name for name in USUAL if (home / name).is_dir()]


def session_for(video: Path, workspace: Path) -> Path:
    """`jump.keypose/session.json` beside jump.mp4; in the workspace where nothing can be written
    there. Another video's session of that name is left alone: then it is `jump 2.keypose`.

    Nothing is made: the path may not exist yet.
    """
    video = video.absolute()
    beside, ours = _place(video.parent, video), _place(workspace, video)
    for place in (beside, ours):
        if place.exists():
            return place
    return beside if _is_writable(video.parent) else ours


def _place(folder: Path, video: Path) -> Path:
    """That of this video in a folder, or the first that is free."""
    stem = video.name if video.is_dir() else video.stem
    for name in numbered(stem + SESSION_FOLDER):
        place = folder / name / SESSION
        if not place.exists() or _is_about(place, video):
            return place
    raise AssertionError("names never end")


def _is_about(session: Path, video: Path) -> bool:
    """A file that cannot be read counts: opening it reports what is wrong with it."""
    try:
        path = str(from_json(read_regular(session, LARGEST_SESSION_BYTES))["video"]["path"])
        return os.path.realpath(session.parent / path) == os.path.realpath(video)
    except (OSError, ValueError, KeyError, TypeError):
        return True


def _is_writable(folder: Path) -> bool:
    try:
        require_folder(folder, error=KeyposeError)
    except KeyposeError:
        return False
    return True
