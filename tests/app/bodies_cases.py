"""A session of two bodies: the sample's box twice, as tests of several bodies begin with it."""

from __future__ import annotations

from pathlib import Path

from keypose.app.cli.main import main
from keypose.tracker.session import Session
from keypose.tracker.storage.files import load_session, save_session
from tests.scenes import sample


def of_two(session: Session) -> Session:
    """The same body twice, the second a little aside."""
    first = session.subject
    moved = tuple(
        keyframe.model_copy(update={"root_m": (keyframe.root_m[0] + 0.01, *keyframe.root_m[1:])})
        for keyframe in first.keyframes
    )
    second = first.model_copy(update={"id": "second", "keyframes": moved})
    return session.model_copy(update={"bodies": (first, second)})


def two_tracked(folder: Path) -> Path:
    """The session of both, tracked."""
    path = sample(folder, "box")
    save_session(of_two(load_session(path)), path)
    assert main(["track", str(path), "--quality", "preview"]) == 0
    return path
