"""Whatever is edited after whatever job, the page is sent every part of itself."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from keypose.app.scene.scenery import SceneryMaker
from keypose.app.store.store import Store
from keypose.app.store.tabs import Tab
from keypose.app.working import queue
from keypose.tracker.storage.files import load_session
from tests.app.store.random_edits import RandomEdits
from tests.app.working.test_fitting import Desk, Worker
from tests.scenes import at_desk, sample

SEEDS = int(os.environ.get("KEYPOSE_TEST_EDITS", "3"))
"""Rows of random edits; more by hand."""
EDITS = 75
"""In each row."""


@pytest.fixture(autouse=True)
def _no_worker(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(queue, "JobRunner", Worker)


@pytest.mark.parametrize("seed", range(8, 8 + SEEDS))
@pytest.mark.parametrize("name", ["person", "arms"])
async def test_after_any_edits_and_jobs_every_section_and_the_views_are_made(
    tmp_path: Path, name: str, seed: int
) -> None:
    maker, path = SceneryMaker(), sample(tmp_path, name)
    async with at_desk(path, Desk) as desk:
        edits = RandomEdits(desk, seed)
        for _ in range(EDITS):
            edits.act()
            publish(desk.store, maker)
            words = [one for one in said(desk.tab) if "internal error" in one]
            failed = desk.store._sections.failed
            assert not failed, (list(failed), edits.done[-5:])
            assert not words, (words, edits.done[-5:])
        settled = desk.edit.settled
    assert load_session(path).subject.keyframes == settled.subject.keyframes


def said(tab: Tab) -> list[str]:
    """The sentences that wait for a tab."""
    words = [message.get("words", "") for message in tab._messages]
    tab._messages.clear()
    return words


def publish(store: Store, maker: SceneryMaker) -> None:
    """What the turn of the loop does, with the views drawn."""
    store._publish()
    shown = store.app_state.displayed.edit
    if shown is not None:
        maker.of(shown, store._sections.all["trail"])
