"""Saving writes the newest state, one write at a time, and says so when it cannot."""

from __future__ import annotations

import asyncio
import threading

import pytest

from keypose.app.state.app_state import Saved
from keypose.app.store.saving import Saver
from keypose.tracker.errors import SessionError


async def test_while_a_write_is_at_work_only_the_newest_of_the_others_waits() -> None:
    written: list[int] = []
    gate = threading.Event()

    def write(number: int) -> None:
        gate.wait(10)
        written.append(number)

    saver = Saver(lambda _: None)
    for number in range(50):
        saver.save(lambda number=number: write(number))  # type: ignore[misc]
        await asyncio.sleep(0)
    gate.set()
    await saver.wait()
    assert written[-1] == 49
    assert len(written) <= 2


async def test_a_failed_write_is_reported_in_its_own_words_and_can_be_tried_again() -> None:
    reported: list[Saved] = []
    full = True

    def write() -> None:
        if full:
            raise SessionError("The disk is full.")

    saver = Saver(reported.append)
    saver.save(write)
    await saver.wait()
    full = False
    saver.retry()
    await saver.wait()
    assert [(saved.state, saved.words) for saved in reported] == [
        ("saving", ""),
        ("failed", "The disk is full."),
        ("saving", ""),
        ("saved", ""),
    ]


async def test_what_is_unsaved_is_reported_so_until_it_is_written_and_is_tried_again_by_itself(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("keypose.app.store.saving.SECONDS_BETWEEN_TRIES", 0.01)
    reported: list[Saved] = []
    tries: list[int] = []

    def write(number: int) -> None:
        tries.append(number)
        if len(tries) < 5:
            raise SessionError("The disk is full.")

    saver = Saver(reported.append)
    saver.save(lambda: write(1))
    await saver.wait()
    saver.save(lambda: write(2))
    while reported[-1].state != "saved":
        await asyncio.sleep(0.005)
    assert saver.problem is None
    assert [saved.state for saved in reported] == ["saving", *4 * ["failed"], "saved"]
    assert tries == [1, 2, 2, 2, 2]


async def test_the_time_of_the_last_save_survives_a_failure() -> None:
    reported: list[Saved] = []

    def fail() -> None:
        raise SessionError("The disk is full.")

    saver = Saver(reported.append)
    saver.save(lambda: None)
    await saver.wait()
    saver.save(fail)
    await saver.wait()
    assert reported[-1].state == "failed"
    assert reported[-1].at_s == reported[1].at_s > 0
