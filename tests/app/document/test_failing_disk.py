"""A disk that fills up or fails at any step of a save: the session stays whole, and it is told."""

from __future__ import annotations

import errno
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from keypose.app.document import edit_log
from keypose.app.working import queue
from keypose.tracker.errors import SessionError
from keypose.tracker.storage.edit_history import mark_of, without_results
from keypose.tracker.storage.files import load_session, open_session
from tests.app.document.test_edit_log import done, tried, turn
from tests.app.full_disks import fill
from tests.scenes import SAMPLES, IdleWorker, opened_store, sample

STEPS = 12
"""More calls than a save makes of any kind."""

CALLS = ("write", "fsync", "open", "ftruncate", "rename", "replace", "link", "lseek")


@pytest.fixture(autouse=True)
def _without_worker(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(queue, "JobRunner", IdleWorker)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return sample(tmp_path, "box")


def _part(path: Path) -> str:
    return load_session(path).subject.body.names[0]


class _Failing:
    """The n-th call from now fails, as every one after it does until the disk is well again."""

    def __init__(self, call: Callable[..., Any], number: int) -> None:
        self._call = call
        self._left = number
        self.failed = 0

    def __call__(self, *given: Any, **named: Any) -> Any:
        self._left -= 1
        if self._left < 0:
            self.failed += 1
            raise OSError(errno.EIO, os.strerror(errno.EIO))
        return self._call(*given, **named)


@pytest.mark.parametrize("name", CALLS)
async def test_a_disk_that_fails_at_any_step_of_a_save_loses_nothing(
    path: Path, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    part = _part(path)
    failures = 0
    for number in range(STEPS):
        before = mark_of(without_results(load_session(path)))
        async with opened_store(path) as store:
            failing = _Failing(getattr(os, name), number)
            with monkeypatch.context() as patch:
                patch.setattr(os, name, failing)
                await tried(store, turn(1 + number, part=part))
                for _ in range(3):
                    await store._writer.saver.wait()
            edited = mark_of(store.app_state.edit.settled)  # type: ignore[union-attr]
            assert mark_of(without_results(open_session(path).session)) in (before, edited)
            if store.app_state.saved.state == "failed":
                failures += 1
                assert store.app_state.saved.words.endswith(".")
                assert "Input/output error" in store.app_state.saved.words
            else:
                assert mark_of(without_results(load_session(path))) == edited
            await done(store, {"do": "save_again"})
        leftovers = [file.name for file in path.parent.iterdir() if file.name.endswith(".part")]
        assert leftovers == []
    assert failures or name in _UNUSED


_UNUSED = ("rename", "link")
"""A save does without them where they fail."""


async def test_a_save_that_fails_again_and_again_is_not_taken_for_another_programs(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> None:
        raise SessionError("No space left on device.")

    async with opened_store(path) as store:
        with monkeypatch.context() as patch:
            patch.setattr(edit_log, "save_session", full)
            for degrees in (1, 2, 3):
                await tried(store, turn(degrees, part=_part(path)))
                await store._writer.saver.wait()
                assert store.app_state.saved.state == "failed"
        await done(store, {"do": "save_again"})
    assert not list(path.parent.glob("*theirs*"))


async def test_a_full_disk_is_reported_and_every_edit_is_there_once_there_is_room(
    small_disk: Path,
) -> None:
    folder = small_disk / "person"
    folder.mkdir()
    sample = SAMPLES / "person"
    shutil.copy(sample / "session.json", folder)
    (folder / "person.mp4").symlink_to(sample / "person.mp4")
    path = folder / "session.json"
    ballast = small_disk / "ballast"
    async with opened_store(path) as store:
        await done(store, turn(-1))
        fill(ballast)
        await tried(store, *(turn(-x) for x in range(2, 40)))
        assert store.app_state.saved.state == "failed"
        assert "No space left on device" in store.app_state.saved.words
        assert open_session(path).recovered.moment.history.past
        ballast.unlink()
        await done(store, {"do": "save_again"}, turn(-40))
    assert len(open_session(path).recovered.moment.history.past) == 40
