"""A copy of a session leads to all its films, and has what was seen in each."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from keypose.app.document.library.session_files import duplicate_session
from keypose.app.document.open import copy_session
from keypose.tracker.keypoints.keypoints import JOINTS, Keypoints
from keypose.tracker.session.views import Clock
from keypose.tracker.storage.files import load_session, save_session, video_path
from keypose.tracker.storage.sidecars import keypoints_of_session, save_keypoints
from tests.app.film_beside_cases import with_film
from tests.tracker import session_cases as cases

COPIES: dict[str, Callable[[Path], Path]] = {
    "duplicated": duplicate_session,
    "kept elsewhere": lambda path: copy_session(path, path.parents[1] / "a" / "b" / "out"),
}


@pytest.fixture
def two_films(tmp_path: Path) -> Path:
    """A session with another film beside it, and its keypoints."""
    path = cases.write_session(tmp_path / "here")
    side = cases.write_frames(tmp_path / "here" / "side", brightness=150)
    doc = load_session(path)
    video = doc.view.video.model_copy(update={"path": side.name, "fingerprint": ""})
    doc = with_film(doc, Clock(begins=2.0), video=video)
    rows = np.full((5, len(JOINTS), 2), 7.0)
    keypoints = Keypoints(0, JOINTS, rows, np.ones(rows.shape[:2]))
    alone = save_keypoints(doc.alone("film-2"), path, keypoints, "a detector")
    film = doc.views[1].model_copy(update={"keypoints": alone.view.keypoints})
    save_session(doc.model_copy(update={"views": (doc.view, film)}), path)
    return path


@pytest.mark.parametrize("name", COPIES)
def test_a_copy_has_every_film_and_its_keypoints(two_films: Path, name: str) -> None:
    copy = COPIES[name](two_films)
    assert copy.parent != two_films.parent
    doc = load_session(copy)
    for view, was in zip(doc.views, load_session(two_films).views, strict=True):
        there = video_path(doc.alone(view.id), copy).resolve()
        assert there == (two_films.parent / was.video.path).resolve()
    assert keypoints_of_session(doc.alone("film-2"), copy.parent) is not None
