"""A film that is added on the page: a job, one step of undo, and what was found in words."""

from __future__ import annotations

import asyncio
import shutil
from collections.abc import AsyncIterator, Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from keypose.app.jobs.adding_film import AddFilm, PlaceFilm
from keypose.app.jobs.found_film import FoundFilm
from keypose.app.working import queue
from keypose.tracker.keypoints.keypoints import JOINTS, Keypoints
from keypose.tracker.session import Session
from keypose.tracker.session.views import Clock
from keypose.tracker.storage.files import load_session
from tests.app.film_beside_cases import with_film
from tests.app.working.test_fitting import Worker
from tests.scenes import StoreDesk, at_desk, sample

ASKED = {"do": "add_film", "kind": "file", "id": "0/side.mp4"}
FOUND_WORDS = "side.mp4 begins 3.4 ± 0.2 frames after the first film."


class Desk(StoreDesk):
    """A store with a tab and the worker's side of its jobs."""

    async def ask(self, *messages: dict[str, Any]) -> list[AddFilm]:
        """What is asked of the worker by then; the library looks for files in a thread."""
        self.do(*messages)
        await asyncio.gather(*self.store._tasks)
        jobs: list[AddFilm] = Worker.newest.of(AddFilm)
        return jobs

    @property
    def words(self) -> list[str]:
        """The sentences that the tab was sent."""
        return [message["words"] for message in self.tab._messages if "words" in message]


@pytest.fixture(autouse=True)
def _no_worker(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(queue, "JobRunner", Worker)


@pytest.fixture
async def desk(tmp_path: Path) -> AsyncIterator[Desk]:
    path = sample(tmp_path)
    shutil.copy(path.with_name("person.mp4"), tmp_path / "side.mp4")
    async with at_desk(path, Desk) as made:
        yield made


def found(job: AddFilm, words: str = FOUND_WORDS) -> FoundFilm:
    """The film and a keyframe that was mended, as the worker finds it."""
    doc = Session.model_validate_json(job.session)
    first, *rest = doc.subject.keyframes
    mended = first.model_copy(update={"root_m": (0.5, 0.0, 5.0)})
    doc = doc.changed({"keyframes": (mended, *rest)})
    rows = np.full((5, len(JOINTS), 2), 7.0)
    keypoints = Keypoints(0, JOINTS, rows, np.ones(rows.shape[:2]))
    return FoundFilm(with_film(doc, Clock(begins=3.4)), keypoints, "abc", 2, words)


async def test_it_comes_with_its_keypoints_and_mended_keyframes_as_one_step(desk: Desk) -> None:
    before = desk.doc
    (job,) = await desk.ask(ASKED)
    assert Path(job.film).name == "side.mp4"
    assert desk.section("job")["title"] == "Adding a film"
    Worker.newest.end(found(job))
    view = desk.doc.views[1]
    assert view.clock.begins == 3.4
    assert desk.doc.subject.keyframes[0].root_m == (0.5, 0.0, 5.0)
    assert desk.section("films")[0]["begins"] == 3.4
    assert FOUND_WORDS in desk.words
    folder = Path(desk.store.app_state.opened.session_path).parent  # type: ignore[union-attr]
    assert (folder / view.keypoints.file).is_file()
    assert desk.section("undo")["undo"] == "add a film"
    desk.do({"do": "undo"})
    assert desk.doc == before
    desk.do({"do": "redo"})
    await desk.store.stop()
    assert load_session(folder / "session.json").views[1].clock == view.clock


async def test_what_is_said_of_the_motion_meanwhile_stays(desk: Desk) -> None:
    (job,) = await desk.ask(ASKED)
    desk.do({"do": "set_note", "frame": 5, "text": "here"})
    Worker.newest.end(found(job))
    assert len(desk.doc.views) == 2
    assert [note.text for note in desk.doc.notes] == ["here"]


OTHERWISE: dict[str, dict[str, Any]] = {
    "a keyframe is deleted": {"do": "delete_key", "frame": 24},
    "another body": {"do": "preset", "name": "child"},
}


@pytest.mark.parametrize("name", OTHERWISE)
async def test_of_what_is_posed_otherwise_by_then_nothing_is_taken_over(
    desk: Desk, name: str
) -> None:
    (job,) = await desk.ask(ASKED)
    result = found(job)
    desk.do(OTHERWISE[name])
    Worker.newest.end(result)
    assert len(desk.doc.views) == 1
    assert any("cancelled because" in words for words in desk.words)


ENDS: dict[str, Callable[[Desk], Any]] = {
    "cancelled": lambda desk: desk.do({"do": "cancel"}),
    "failed": lambda desk: Worker.newest.fail("side.mp4 and person.mp4 show no motion in common."),
}


@pytest.mark.parametrize("name", ENDS)
async def test_a_film_that_is_not_added_leaves_all_as_it_was(desk: Desk, name: str) -> None:
    before = desk.doc
    await desk.ask(ASKED)
    ENDS[name](desk)
    assert desk.doc is before
    assert desk.section("undo")["undo"] is None


async def test_a_file_that_is_gone_is_said_in_one_sentence(desk: Desk) -> None:
    assert await desk.ask({**ASKED, "id": "7/side.mp4"}) == []
    assert desk.words == ["This file no longer exists."]


async def test_asked_twice_it_is_added_once(desk: Desk) -> None:
    assert len(await desk.ask(ASKED, ASKED)) == 1


async def test_a_film_that_begins_elsewhere_gets_its_camera_in_one_step(desk: Desk) -> None:
    (job,) = await desk.ask(ASKED)
    Worker.newest.end(found(job))
    before = desk.doc
    desk.do({"do": "place_film", "view": "film-2", "begins": 31.5})
    place = Worker.newest.of(PlaceFilm)[-1]
    assert (place.view, place.begins) == ("film-2", 31.5)
    doc = Session.model_validate_json(place.session)
    film = doc.views[1].model_copy(
        update={"clock": Clock(begins=31.5), "p_camera_world": (1.0, 0.0, 4.0)}
    )
    session = doc.model_copy(update={"views": (doc.view, film)})
    rows = np.full((5, len(JOINTS), 2), 7.0)
    keypoints = Keypoints(0, JOINTS, rows, np.ones(rows.shape[:2]))
    Worker.newest.end(FoundFilm(session, keypoints, "abc", 2, "side.mp4 begins 31.5 frames later."))
    assert desk.doc.views[1].clock.begins == 31.5
    assert desk.doc.views[1].p_camera_world == (1.0, 0.0, 4.0)
    assert desk.doc.views[1].keypoints == before.views[1].keypoints
    desk.do({"do": "undo"})
    assert desk.doc == before


@pytest.mark.parametrize(
    ("view", "begins", "words"),
    [("film-9", 3.0, "not in the session any more"), ("film-2", 1e6, "nothing of the first")],
)
async def test_a_camera_that_cannot_be_found_is_not_looked_for(
    desk: Desk, view: str, begins: float, words: str
) -> None:
    (job,) = await desk.ask(ASKED)
    Worker.newest.end(found(job))
    desk.do({"do": "place_film", "view": view, "begins": begins})
    assert Worker.newest.of(PlaceFilm) == []
    assert any(words in each for each in desk.words)
