"""An edit that was acknowledged is never lost, and can be undone after a restart."""

from __future__ import annotations

import asyncio
import errno
import json
import os
import shutil
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from keypose.app.document.folder_lock import LockedElsewhere, SessionLock
from keypose.app.document.library import Library
from keypose.app.document.open import OpenSession, copy_session, edit_state
from keypose.app.store.store import Store
from keypose.app.store.tabs import Tab
from keypose.app.working import queue
from keypose.tracker.errors import SessionError
from keypose.tracker.storage.files import journal_path, load_session, open_session
from keypose.tracker.storage.journal import Journal, read_journal
from tests.app.killing import kill_once
from tests.scenes import SAMPLES, IdleWorker, opened_store, sample

KILLS = 5


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return sample(tmp_path)


@pytest.fixture
async def store(path: Path) -> AsyncIterator[Store]:
    async with opened_store(path) as made:
        yield made


@pytest.fixture(autouse=True)
def _without_worker(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(queue, "JobRunner", IdleWorker)


async def done(store: Store, *actions: dict[str, Any]) -> None:
    """Each is acknowledged before the next is sent."""
    tab = store.join()
    for number, action in enumerate(actions, start=1):
        store.receive(tab, {**action, "n": number})
        await reported(tab, "ack", number)
    store.leave(tab)


async def tried(store: Store, *actions: dict[str, Any]) -> Tab:
    """Each is done, and written as far as the disk takes it, before the next is sent. The tab."""
    tab = store.join()
    for number, action in enumerate(actions, start=1):
        store.receive(tab, {**action, "n": number})
        await reported(tab, "done", number)
        await store._writer.saver.wait()
    return tab


async def reported(tab: Tab, what: str, number: int) -> None:
    """The tab has been told that this action is done, or acknowledged."""
    while max(m.get(what, 0) for m in await tab.next()) < number:
        pass


def turn(x: float, **more: Any) -> dict[str, Any]:
    return {"do": "angles", "part": "left_forearm", "x": x, **more}


def labels(path: Path) -> list[str]:
    return [step.label for step in open_session(path).recovered.moment.history.past]


async def test_undo_and_redo_survive_a_restart(path: Path) -> None:
    first = load_session(path).subject.keyframes
    async with opened_store(path) as store:
        await done(store, turn(-10), turn(-20), {"do": "delete_key", "frame": 24}, {"do": "undo"})
    async with opened_store(path) as store:
        edit = store.app_state.edit
        assert edit is not None
        assert len(edit.history.past) == 2
        assert len(edit.history.future) == 1
        await done(store, {"do": "redo"})
        assert [k.frame for k in load_session(path).subject.keyframes] == [0, 48, 72]
        await done(store, {"do": "undo"}, {"do": "undo"}, {"do": "undo"})
    assert load_session(path).subject.keyframes == first
    assert len(open_session(path).recovered.moment.history.future) == 3


async def test_an_edit_is_in_the_journal_when_it_is_acknowledged(path: Path) -> None:
    async with opened_store(path, ends=False) as store:
        for number in range(1, 6):
            await done(store, turn(-10 * number))
            records = read_journal(journal_path(path)).records
            assert sum("kept" in record for record in records) == number


async def test_a_drag_is_one_line_of_the_journal(path: Path) -> None:
    async with opened_store(path) as store:
        drag = [turn(-x, stroke="d") for x in range(30)]
        await done(store, *drag, {"do": "end_stroke", "stroke": "d"})
    assert sum("kept" in r for r in read_journal(journal_path(path)).records) == 1
    assert len(labels(path)) == 1


async def test_what_the_journal_alone_has_comes_back_with_a_word(path: Path) -> None:
    before = path.read_bytes()
    async with opened_store(path) as store:
        await done(store, turn(-10), turn(-20))
    after = load_session(path).subject.keyframes
    path.write_bytes(before)  # as if the power had gone before the session file was written
    drop_saved(journal_path(path))
    assert load_session(path).subject.keyframes == after
    async with opened_store(path) as store:
        message = (await store.join().next())[0]
        assert message["words"] == "Restored 2 edits made before Keypose ended unexpectedly."


def drop_saved(path: Path) -> None:
    """As if the session file had never been written."""
    records = [record for record in read_journal(path).records if "saved" not in record]
    Journal(path, 0).begin_anew(records)


async def test_a_session_changed_outside_is_taken_as_it_is_and_reported(path: Path) -> None:
    async with opened_store(path) as store:
        await done(store, turn(-10))
    edited = load_session(path).subject.keyframes
    shutil.copy(SAMPLES / "person" / "session.json", path)
    async with opened_store(path) as store:
        message = (await store.join().next())[0]
        assert "changed outside" in message["words"]
        await done(store, {"do": "undo"})
    assert load_session(path).subject.keyframes == edited


async def test_what_another_program_writes_meanwhile_is_kept_beside(path: Path) -> None:
    theirs = path.read_bytes().replace(b'"note"', b'"words"') + b"\n"
    async with opened_store(path) as store:
        await done(store, turn(-10))
        await saved(store)
        path.write_bytes(theirs)
        tab = store.join()
        await done(store, turn(-20))
        await saved(store)
        words = [m["words"] for m in await tab.next() if m["t"] == "note"]
        assert len(words) == 1
        assert "Another program changed session.json" in words[0]
    kept = [file.read_bytes() for file in path.parent.glob("session.theirs-*.json")]
    assert kept == [theirs]
    assert len(labels(path)) == 2


async def saved(store: Store) -> None:
    while store.app_state.saved.state != "saved":
        await asyncio.sleep(0.01)


async def test_a_newer_session_is_shown_and_nothing_is_written(path: Path) -> None:
    content = path.read_bytes().replace(b'"schema_version": 4', b'"schema_version": 5', 1)
    path.write_bytes(content)
    async with opened_store(path) as store:
        tab = store.join()
        store.receive(tab, turn(-10, n=1))
        refused = [m for m in await tab.next() if m["t"] == "refused"]
        assert "a newer Keypose" in refused[0]["words"]
        assert store.app_state.saved.state == "readonly"
    assert path.read_bytes() == content
    assert not journal_path(path).exists()


@pytest.mark.parametrize("wrote", [False, True])
async def test_a_session_is_written_here_once_the_keypose_that_had_it_has_ended(
    path: Path, wrote: bool
) -> None:
    async with opened_store(path) as one:
        store = Store(asyncio.get_running_loop(), lambda *_: None, one._library)
        await store.open(path)
        tab = store.join()
        await store._opener.look_again()
        assert store.app_state.saved.state == "readonly"
        store.receive(tab, {"do": "go", "frame": 7})
        if wrote:
            one.receive(one.join(), turn(-33, n=1))
    await store._opener.look_again()
    assert store.app_state.saved.state == "saved"
    before = store.app_state.editing.doc
    assert before.subject.keyframes == load_session(path).subject.keyframes
    assert store.app_state.editing.frame == (7 if not wrote else 0)
    words = [message["words"] for message in await tab.next() if message["t"] == "note"]
    assert words == ["The other Keypose has ended: edit here."]
    store.receive(tab, turn(-12))
    edited = store.app_state.editing.doc
    assert edited is not before
    await store.stop()
    assert load_session(path).subject.keyframes == edited.subject.keyframes
    assert len(labels(path)) == (2 if wrote else 1)


async def test_a_disk_that_is_full_is_reported_and_what_was_done_is_written_once_there_is_room(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with opened_store(path) as store:
        with monkeypatch.context() as patch:
            patch.setattr(os, "write", _full)
            await tried(store, turn(-10), turn(-20))
            assert store.app_state.saved.state == "failed"
            assert "No space left" in store.app_state.saved.words
        await done(store, turn(-30))
    assert len(labels(path)) == 3


async def test_edits_on_a_full_disk_are_acknowledged_by_themselves_once_they_are_written(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("keypose.app.store.saving.SECONDS_BETWEEN_TRIES", 0.01)
    async with opened_store(path) as store:
        with monkeypatch.context() as patch:
            patch.setattr(os, "fsync", _full)
            tab = await tried(store, turn(-10), {"do": "go", "frame": 3})
            assert tab._ack == 0
            assert store.app_state.saved.state == "failed"
        await reported(tab, "ack", 2)
        assert len(labels(path)) == 1
        await store._writer.saver.wait()
        assert store.app_state.saved.state == "saved"


async def test_a_folder_that_was_renamed_is_not_made_anew_and_gets_the_edits_once_it_is_back(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("keypose.app.store.saving.SECONDS_BETWEEN_TRIES", 0.01)
    elsewhere = path.parent.with_name("renamed")
    async with opened_store(path) as store:
        await tried(store, turn(-10))
        path.parent.rename(elsewhere)
        tab = await tried(store, turn(-20))
        assert not path.parent.exists()
        assert store.app_state.saved.state == "failed"
        assert "is gone or was renamed" in store.app_state.saved.words
        assert tab._ack == 0
        elsewhere.rename(path.parent)
        await reported(tab, "ack", 1)
    assert len(labels(path)) == 2


async def test_another_folder_in_its_place_is_left_alone(path: Path) -> None:
    async def edit() -> None:
        async with opened_store(path) as store:
            await tried(store, turn(-10))
            path.parent.rename(path.parent.with_name("renamed"))
            path.parent.mkdir()
            await tried(store, turn(-20))
            assert list(path.parent.iterdir()) == []
            assert "is gone or was renamed" in store.app_state.saved.words

    with pytest.raises(SessionError, match="The last changes are lost"):
        await edit()
    assert list(path.parent.iterdir()) == []


async def test_a_session_put_back_from_a_copy_is_gone_on_with(path: Path) -> None:
    async with opened_store(path) as store:
        await tried(store, turn(-10))
        shutil.copytree(path.parent, path.parent.with_name("copy"))
        shutil.rmtree(path.parent)
        await tried(store, turn(-20))
        assert store.app_state.saved.state == "failed"
        path.parent.with_name("copy").rename(path.parent)
        await done(store, turn(-30))
        with pytest.raises(LockedElsewhere):
            SessionLock.take(path.parent)
    assert len(labels(path)) == 3


async def test_what_a_person_gives_up_by_closing_is_waited_for_no_more(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patch:
        patch.setattr(os, "fsync", _full)
        tab = await tried(store, turn(-10))
        with pytest.raises(SessionError, match="Repeat to continue"):
            await store.close_session()
        assert tab._ack == 0
        await store.close_session()
    assert tab._ack == 1


def _full(*_: object) -> int:
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


async def test_a_long_journal_is_begun_anew_without_losing_a_step(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("keypose.app.document.edit_log.MOST_BYTES", 100_000)
    async with opened_store(path) as store:
        await done(store, *(turn(-x / 4) for x in range(1, 60)))
    assert len(labels(path)) == 59
    records = read_journal(journal_path(path)).records
    assert sum("base" in record for record in records) == 1


async def test_one_that_opens_while_another_still_writes_reads_what_that_one_wrote_last(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with opened_store(path, ends=False) as first:
        await done(first, turn(-10))
        await saved(first)
        loop = asyncio.get_running_loop()

        def slowly(piece: OpenSession) -> Any:
            state = edit_state(piece)
            monkeypatch.setattr("keypose.app.store.opener.edit_state", edit_state)
            asyncio.run_coroutine_threadsafe(done(first, turn(-20), turn(-30)), loop).result()
            asyncio.run_coroutine_threadsafe(first.stop(), loop).result()
            return state

        monkeypatch.setattr("keypose.app.store.opener.edit_state", slowly)
        second = Store(loop, lambda *_: None, Library(path.parent / "work", [path.parent]))
        await second.open(path)
        await done(second, turn(-40))
        await second.stop()
    assert len(labels(path)) == 4


async def test_times_that_are_not_the_videos_do_not_spoil_the_file(path: Path) -> None:
    data = json.loads(path.read_text())
    for keyframe in data["bodies"][0]["keyframes"]:
        keyframe["time_s"] *= 3
    path.write_text(json.dumps(data))
    async with opened_store(path) as store:
        await done(store, {"do": "add_key", "frame": 30}, turn(-20))
    assert [keyframe.frame for keyframe in load_session(path).subject.keyframes] == [
        0,
        24,
        30,
        48,
        72,
    ]
    assert len(labels(path)) == 2


async def test_a_journal_that_is_removed_or_cut_while_open_is_begun_anew(path: Path) -> None:
    async with opened_store(path) as store:
        await done(store, turn(-10))
        await saved(store)
        journal_path(path).unlink()
        await done(store, turn(-20))
        await saved(store)
        journal_path(path).write_bytes(b"")
        await done(store, turn(-30))
    assert len(labels(path)) == 3


async def test_of_a_damaged_journal_a_copy_is_kept_and_it_is_reported(path: Path) -> None:
    async with opened_store(path) as store:
        await done(store, turn(-10), turn(-20), turn(-30))
    content = bytearray(journal_path(path).read_bytes())
    content[len(content) // 2] ^= 1
    journal_path(path).write_bytes(content)
    async with opened_store(path) as store:
        message = (await store.join().next())[0]
        assert "damaged" in message["words"]
        await done(store, turn(-40))
    assert path.with_name("journal.jsonl.previous").read_bytes() == content
    assert load_session(path).subject.keyframes[0].rotations_wxyz["left_forearm"] == pytest.approx(
        (np.cos(np.radians(20)), -np.sin(np.radians(20)), 0, 0), abs=1e-6
    )


async def test_a_journal_that_cannot_be_read_is_reported(path: Path) -> None:
    with journal_path(path).open("wb") as file:
        file.truncate(10**9)
    async with opened_store(path) as store:
        message = (await store.join().next())[0]
        assert "too large to be a session's journal" in message["words"]
    assert journal_path(path).stat().st_size == 10**9


async def test_fields_that_are_not_known_survive_undo(path: Path) -> None:
    async with opened_store(path) as store:
        await done(store, turn(-10))
    path.write_text(json.dumps({**json.loads(path.read_text()), "lab": 7}))
    async with opened_store(path) as store:
        await done(store, turn(-20), turn(-30))
    async with opened_store(path) as store:
        await done(store, {"do": "undo"})
    assert json.loads(path.read_text())["lab"] == 7


def test_a_copy_of_another_session_is_not_taken_for_this_one(path: Path, tmp_path: Path) -> None:
    box = SAMPLES / "box" / "session.json"
    copy_session(box, tmp_path / "copy")
    assert copy_session(box, tmp_path / "copy") == tmp_path / "copy" / "session.json"
    with pytest.raises(SessionError, match="another video"):
        copy_session(path, tmp_path / "copy")


def test_a_killed_keypose_loses_no_edit_it_has_acknowledged(path: Path) -> None:
    acknowledged = 0
    for seed in range(KILLS):
        death = kill_once(path, seed)
        assert death.lost == 0
        acknowledged += death.acknowledged
    assert acknowledged > KILLS


async def test_going_to_a_step_is_in_the_journal_as_if_step_by_step(path: Path) -> None:
    """A record for each, none of which holds the whole way; times are kept."""
    async with opened_store(path) as store:
        await done(store, *[turn(-10 * k) for k in range(1, 9)])
        size = journal_path(path).stat().st_size
        await done(store, {"do": "go_to_step", "done": 1, "of": 8})
        assert journal_path(path).stat().st_size < 2.5 * size
        await done(store, {"do": "go_to_step", "done": 6, "of": 8})
    moment = open_session(path).recovered.moment
    assert (len(moment.history.past), len(moment.history.future)) == (6, 2)
    assert moment.doc.model_dump() == load_session(path).changed({"results": None}).model_dump()
    made = [step.made_s for step in (*moment.history.past, *reversed(moment.history.future))]
    assert all(one is not None and one > 1e9 for one in made)
    assert made == sorted(made)  # type: ignore[type-var]


async def test_an_older_journal_has_no_times_and_is_read(path: Path) -> None:
    async with opened_store(path) as store:
        await done(store, turn(-10), turn(-20))
    whole = read_journal(journal_path(path)).records
    older = [
        {**one, "past": [{k: v for k, v in s.items() if k != "made"} for s in one["past"]]}
        if "past" in one
        else one
        for one in whole
    ]
    Journal(journal_path(path), 0).begin_anew(older)
    steps = open_session(path).recovered.moment.history.past
    assert [step.made_s for step in steps] == [None, None]
    assert len(labels(path)) == 2
