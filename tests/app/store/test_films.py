"""What the page receives of other films: their frame of the moment, their camera, their picture."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from keypose.app.state.app_state import AppState
from keypose.app.store.other_films import OtherFilms
from keypose.app.store.sections import Sections
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import KeyposeError
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session import Session
from keypose.tracker.session.camera_motion import CameraMotion
from keypose.tracker.session.views import Clock
from keypose.tracker.storage.files import load_session
from tests.app.editor.desk import desk
from tests.app.film_beside_cases import ID, MIDDLE, R_SIDE, with_film
from tests.tracker import panned_cases
from tests.tracker import session_cases as cases


def films_of(doc: Session, frame: int = 0) -> Any:
    skeleton = Skeleton.of(doc.subject.body)
    edit = replace(desk(), doc=doc, skeleton=skeleton, frame=frame)
    return Sections().changed(AppState(edit=edit))["films"]


def seen_by(film: Any, p: Array) -> Array:
    """A point of the first camera's frame in that of a film's."""
    T = np.reshape(film["T"], (3, 4))
    return np.asarray(T[:, :3] @ p + T[:, 3])


def test_of_one_film_there_is_none_beside_it() -> None:
    assert films_of(desk().doc) == []


@pytest.mark.parametrize(
    ("begins", "rate", "frame", "own"),
    [
        (3.4, 1.0, 10, 7),
        (3.4, 1.0, 3, 0),
        (3.4, 1.0, 2, None),
        (0.0, 2.0, 20, 40),
        (0, 2, 60, None),
    ],
)
def test_the_nearest_frame_of_a_film_is_shown_and_none_beyond_its_ends(
    begins: float, rate: float, frame: int, own: int | None
) -> None:
    (film,) = films_of(with_film(desk().doc, Clock(begins=begins, rate=rate)), frame)
    assert film["frame"] == own


def test_its_camera_is_beside_the_first_one_s() -> None:
    (film,) = films_of(with_film(desk().doc))
    p = MIDDLE + np.array([0.3, -0.2, 0.5])
    assert seen_by(film, p) == pytest.approx(R_SIDE @ (p - MIDDLE) + MIDDLE, abs=1e-4)
    assert (film["begins"], film["sigma"], film["also"]) == (3.4, 0.1, [31.5])


@pytest.mark.parametrize("frame", [0, 7, panned_cases.FRAMES - 1])
def test_a_first_camera_that_pans_and_a_film_s_that_does_are_followed(frame: int) -> None:
    path = panned_cases.path()
    motion = CameraMotion.of("turns", path, np.full(panned_cases.FRAMES, 0.1), ())
    world = MIDDLE + np.array([0.3, -0.2, 0.5])
    R = path.Ts_camera_world[frame, :3, :3]  # it turns where it stands
    side = R_SIDE @ (world - MIDDLE) + MIDDLE
    doc = panned_cases.session(motion)
    (still,) = films_of(with_film(doc, Clock(begins=0.0)), frame)
    assert seen_by(still, R @ world) == pytest.approx(side, abs=1e-4)
    (panning,) = films_of(with_film(doc, Clock(begins=0.0), camera_motion=motion), frame)
    assert seen_by(panning, R @ world) == pytest.approx(R @ side, abs=1e-4)


@pytest.fixture
def session_path(tmp_path: Path) -> Path:
    """Of a session about a film, with a brighter one beside it."""
    path = cases.write_session(tmp_path)
    cases.write_frames(tmp_path / "bright", brightness=180)
    return path


def bright(path: Path) -> Session:
    doc = load_session(path)
    video = doc.view.video.model_copy(update={"path": "bright", "fingerprint": ""})
    return with_film(doc, video=video)


def brightness(jpeg: bytes) -> float:
    return float(cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR).mean())


async def test_pictures_of_a_film_are_its_own(session_path: Path) -> None:
    doc, films = bright(session_path), OtherFilms(session_path)
    jpeg = await films.jpeg(doc, doc.views[1], 3)
    assert brightness(jpeg) == pytest.approx(180 + 29.5, abs=3)
    await films.close()


async def test_a_film_that_is_gone_is_said_in_one_sentence_and_shown_once_it_is_back(
    session_path: Path,
) -> None:
    doc, films = bright(session_path), OtherFilms(session_path)
    folder = session_path.parent / "bright"
    shutil.move(folder, session_path.parent / "away")
    with pytest.raises(KeyposeError, match=r"^The video '.*bright' is missing; put it there"):
        await films.jpeg(doc, doc.views[1], 3)
    shutil.move(session_path.parent / "away", folder)
    assert await films.jpeg(doc, doc.views[1], 3)
    await films.close()


async def test_under_the_id_of_a_film_that_was_removed_another_is_shown(
    session_path: Path,
) -> None:
    doc, films = bright(session_path), OtherFilms(session_path)
    await films.jpeg(doc, doc.views[1], 3)
    dark = with_film(load_session(session_path))
    assert dark.views[1].id == doc.views[1].id == ID
    assert brightness(await films.jpeg(dark, dark.views[1], 3)) < 150
    await films.close()


async def test_once_a_session_is_closed_no_film_of_it_is_opened(session_path: Path) -> None:
    doc, films = bright(session_path), OtherFilms(session_path)
    await films.close()
    with pytest.raises(KeyposeError, match="closed"):
        await films.jpeg(doc, doc.views[1], 3)
