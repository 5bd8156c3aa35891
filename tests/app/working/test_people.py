"""People are looked for behind all else: once a picture, quietly, and never in a person's way."""

from __future__ import annotations

from typing import Any

import pytest

from keypose.app.jobs.draft import DraftClip
from keypose.app.jobs.find_people import FindPeople
from keypose.app.jobs.job import Failed, Finished
from keypose.app.working import queue
from tests.app.store.test_drafting import DRAFT, Desk, desk, path
from tests.app.working.test_fitting import Worker

__all__ = ["desk", "path"]
BOXES = ((10, 20, 60, 220), (300, 100, 330, 180))


@pytest.fixture(autouse=True)
def _no_worker(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(queue, "JobRunner", Worker)


def look(desk: Desk, frame: int) -> list[int]:
    """Ask for the people of a frame; the frames that were looked at by then."""
    desk.do({"do": "go", "frame": frame}, {"do": "find_people", "frame": frame})
    return [job.frame for job in Worker.newest.of(FindPeople)]


async def test_who_is_found_is_shown_at_that_frame_and_asked_for_once(desk: Desk) -> None:
    assert look(desk, 7) == [7]
    before, job = desk.doc, desk.store.app_state.job
    assert desk.section("people") is None
    Worker.newest.end(BOXES)
    assert desk.section("people") == {"frame": 7, "boxes": [list(box) for box in BOXES]}
    assert desk.section("undo")["undo"] is None
    assert desk.doc is before
    assert desk.store.app_state.job == job
    desk.do({"do": "go", "frame": 8})
    assert desk.section("people") is None
    assert look(desk, 7) == [7]


async def test_it_is_no_job_that_the_page_shows_and_no_draft_waits_for_it(desk: Desk) -> None:
    look(desk, 7)
    assert desk.section("job")["state"] == "idle"
    desk.do(DRAFT)
    assert isinstance(Worker.newest.jobs[-1], DraftClip)
    Worker.newest.report(Finished(1, cancelled=True))
    assert desk.section("job")["title"] == "Drafting poses"
    assert desk.section("people") is None, "it was ended by other work, and may be asked for again"


async def test_while_something_is_at_work_nobody_is_looked_for_and_nothing_is_cancelled(
    desk: Desk,
) -> None:
    desk.do(DRAFT)
    cancelled = Worker.newest.cancelled
    assert look(desk, 7) == []
    assert Worker.newest.cancelled == cancelled
    assert desk.section("job")["title"] == "Drafting poses"


ENDS: dict[str, Any] = {
    "left": (Finished(1, cancelled=True), None),
    "failed": (Failed(1, "Frame 7 cannot be read."), None),
    "nobody": (Finished(1, ()), []),
}


@pytest.mark.parametrize("ended", ENDS)
async def test_that_nobody_is_there_is_said_only_where_all_was_looked_at(
    desk: Desk, ended: str
) -> None:
    end, boxes = ENDS[ended]
    look(desk, 7)
    Worker.newest.report(end)
    assert desk.section("people") == {"frame": 7, "boxes": boxes}
    assert look(desk, 7) == [7]


@pytest.mark.parametrize("frame", [-1, 10**6])
async def test_a_frame_that_is_not_there_is_not_looked_at(desk: Desk, frame: int) -> None:
    desk.do({"do": "find_people", "frame": frame})
    assert not Worker.newest.of(FindPeople)
