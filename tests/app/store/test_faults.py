"""A part of the page that cannot be made is said and logged; all others are sent."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from keypose.app.state.app_state import AppState
from keypose.app.store.sections import PLACES, changes
from keypose.app.working import queue
from tests.app.working.test_fitting import Desk, Worker
from tests.scenes import at_desk

FOREARM = {"do": "angles", "part": "left_forearm"}


@pytest.fixture(autouse=True)
def _no_worker(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(queue, "JobRunner", Worker)


def said(desk: Desk) -> list[str]:
    """The sentences that wait for the page."""
    words = [message["words"] for message in desk.tab._messages if "words" in message]
    desk.tab._messages.clear()
    return words


def broken(*names: str) -> dict[str, Any]:
    """The sections, some of which cannot be made at frames from 10 on."""

    def make(app_state: AppState) -> Any:
        if app_state.edit is not None and app_state.edit.frame >= 10:
            raise ZeroDivisionError("no such motion")
        return None

    known = changes.SECTIONS
    return {
        name: replace(known[name], make=make) if name in names else known[name] for name in known
    }


async def test_what_cannot_be_made_is_said_and_logged_once_and_all_else_is_sent(
    path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(changes, "SECTIONS", broken("suggest", "ghosts", "trail"))
    async with at_desk(path, Desk) as desk:
        desk.do({"do": "go", "frame": 3})
        desk.store._publish()
        assert said(desk) == []
        for frame in (12, 13):
            desk.do({"do": "go", "frame": frame})
            desk.store._publish()
        assert said(desk) == [
            "The timeline and the views are not up to date because of an internal error. Your "
            "edits are saved: undo the last one, or reload the page."
        ]
        assert capsys.readouterr().err.count("ZeroDivisionError: no such motion") == 1
        assert desk.store._sections.all["view"]["frame"] == 13
        other = desk.store.join()
        assert other._sections["view"]["frame"] == 13
        desk.do({"do": "go", "frame": 3})
        desk.store._publish()
        assert desk.store._sections.failed == {}
        desk.do({"do": "go", "frame": 12})
        desk.store._publish()
        assert len(said(desk)) == 1
        assert capsys.readouterr().err == ""


async def test_views_that_cannot_be_drawn_hold_nothing_up(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with at_desk(path, Desk) as desk:

        def fail(*_: object) -> None:
            raise ZeroDivisionError

        monkeypatch.setattr(desk.store, "_show", fail)
        desk.do({**FOREARM, "x": -50})
        desk.store._publish()
        assert [words.split(" because")[0] for words in said(desk)] == [
            "The views are not up to date"
        ]
        assert desk.store._sections.all["undo"]["undo"] == "turn left forearm"


def test_every_section_is_seen_somewhere() -> None:
    assert PLACES.keys() == changes.SECTIONS.keys()
