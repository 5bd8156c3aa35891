"""Drafts learn from keyframes at the page's server: by themselves, as part of a keyframe's step."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from keypose.app.jobs.learn import LearnDrafts
from keypose.app.working import queue
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.session import Session
from tests.app.store.test_drafting import BODY, DRAFT, Desk, desk, path
from tests.app.working.test_fitting import Worker
from tests.scenes import at_desk

__all__ = ["desk", "path"]
FRAMES = (3, 4, 5, 6)
ELSEWHERE = Pose.rest(Skeleton.of(BODY), (0.1, 0.0, 4.0))


@pytest.fixture(autouse=True)
def _no_worker(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(queue, "JobRunner", Worker)


def ordered() -> LearnDrafts:
    order = Worker.newest.fits[-1]
    assert isinstance(order, LearnDrafts)
    return order


def learn(*frames: int) -> None:
    Worker.newest.end(dict.fromkeys(frames, ELSEWHERE))


def moved(doc: Session) -> list[int]:
    """The drafts that stand elsewhere."""
    return [d.frame for d in doc.subject.drafts if np.isclose(d.root_m[0], 0.1)]


async def begin(desk: Desk) -> None:
    """A draft, and one of its frames corrected and confirmed."""
    desk.do(DRAFT)
    desk.find(*FRAMES)
    desk.do({"do": "go", "frame": 4}, {"do": "root", "y": 0.05}, {"do": "add_key", "frame": 4})


async def test_drafts_that_learned_from_a_keyframe_are_undone_and_done_again_with_it(
    desk: Desk,
) -> None:
    await begin(desk)
    assert ordered().around == (4,)
    sent = Session.model_validate_json(ordered().session)
    assert [k.frame for k in sent.subject.keyframes] == [4]
    learn(3, 5, 6)
    assert moved(desk.doc) == [3, 5, 6]
    assert all(draft.drafted for draft in desk.doc.subject.drafts)
    learned = desk.doc
    desk.do({"do": "undo"})
    assert not desk.doc.subject.keyframes
    assert moved(desk.doc) == []
    count = len(Worker.newest.fits)
    desk.do({"do": "redo"})
    assert desk.doc == learned
    assert len(Worker.newest.fits) == count  # they have learned it already


async def test_a_draft_that_is_confirmed_as_it_was_teaches_nothing_and_keeps_its_numbers(
    desk: Desk,
) -> None:
    desk.do(DRAFT)
    desk.find(*FRAMES)
    draft = next(d for d in desk.doc.subject.drafts if d.frame == 4)
    count = len(Worker.newest.fits)
    desk.do({"do": "go", "frame": 4}, {"do": "add_key", "frame": 4})
    assert len(Worker.newest.fits) == count
    assert desk.doc.subject.keyframes == (draft.model_copy(update={"soft": True}),)


async def test_what_a_person_posed_meanwhile_stays(desk: Desk) -> None:
    await begin(desk)
    desk.do({"do": "go", "frame": 5}, {"do": "root", "y": 0.2})
    posed = next(d for d in desk.doc.subject.drafts if d.frame == 5)
    assert not posed.drafted
    learn(3, 5, 6)
    assert moved(desk.doc) == [3, 6]
    assert next(d for d in desk.doc.subject.drafts if d.frame == 5) == posed


async def test_nothing_is_learned_from_a_keyframe_that_was_undone_meanwhile(desk: Desk) -> None:
    await begin(desk)
    desk.do({"do": "undo"})
    learn(3, 5, 6)
    assert moved(desk.doc) == []


async def test_drafts_wait_while_something_is_dragged(desk: Desk) -> None:
    await begin(desk)
    desk.do({"do": "go", "frame": 6})
    desk.do({"do": "root", "y": 0.1, "stroke": "a"})
    learn(3, 5, 6)
    assert moved(desk.doc) == []
    desk.do({"do": "end_stroke", "stroke": "a"})
    assert moved(desk.doc) == [3, 5]


async def test_what_was_learned_is_there_when_the_session_is_opened_again(path: Path) -> None:
    async with at_desk(path, Desk) as desk:
        await begin(desk)
        learn(3, 5, 6)
    async with at_desk(path, Desk) as desk:
        assert moved(desk.doc) == [3, 5, 6]
        desk.do({"do": "undo"})
        assert moved(desk.doc) == []
        assert not desk.doc.subject.keyframes


async def test_a_keyframe_deleted_or_on_another_body_teaches_nothing(desk: Desk) -> None:
    await begin(desk)
    learn(3, 5, 6)
    count = len(Worker.newest.fits)
    desk.do({"do": "delete_key", "frame": 4})
    assert len(Worker.newest.fits) == count
