"""Repeated frames are found while a film is open, and its session knows them from then on."""

from __future__ import annotations

import asyncio
from pathlib import Path

import numpy as np
import pytest

from keypose.app.working import examining
from keypose.app.working.examining import Examiner
from keypose.tracker.session.references import Repeats
from keypose.tracker.storage.files import load_session
from keypose.tracker.video import Video
from tests.scenes import opened_store
from tests.tracker.video_cases import write_clip

FOUND = Repeats(frames=(3, 9, 15), even=False)
EDIT = {"do": "angles", "part": "left_forearm", "x": -30}


async def test_a_film_that_is_open_is_looked_through(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    noise = np.random.default_rng(0).integers(0, 255, (30, 48, 64, 3)).astype(np.uint8)
    shown = [noise[n - (n % 6 == 5)] for n in range(30)]
    monkeypatch.setattr(examining, "_PAUSE_S", 0.0)
    found: asyncio.Queue[Repeats] = asyncio.Queue()
    with Video.open(write_clip(tmp_path / "film.mp4", shown)) as video:
        loop = asyncio.get_running_loop()
        examiner = Examiner(loop, video, lambda info: None, found.put_nowait)
        assert (await found.get()).frames == (5, 11, 17, 23)
        await asyncio.to_thread(examiner.close)


async def test_they_are_saved_and_stay_when_an_edit_is_undone(path: Path) -> None:
    async with opened_store(path) as desk:
        tab = desk.join()
        desk.receive(tab, EDIT)
        before = desk._sections.all["file"]["repeated"]
        desk.show_repeats(FOUND)
        edit = desk.app_state.edit
        assert edit is not None
        assert edit.doc.view.video.repeats == FOUND
        desk._publish()
        assert (before, desk._sections.all["file"]["repeated"]) == (0, 3)
        desk.receive(tab, {"do": "undo"})
        desk.receive(tab, {"do": "redo"})
        edit = desk.app_state.edit
        assert edit is not None
        assert edit.doc.view.video.repeats == FOUND
    assert load_session(path).view.video.repeats == FOUND


async def test_a_drag_under_way_goes_on(path: Path) -> None:
    async with opened_store(path) as desk:
        tab = desk.join()
        desk.receive(tab, {**EDIT, "stroke": "drag"})
        desk.show_repeats(FOUND)
        edit = desk.app_state.edit
        assert edit is not None
        assert edit.stroke is not None
        assert edit.settled.view.video.repeats == FOUND
