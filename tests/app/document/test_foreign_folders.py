"""A session folder from a stranger costs the user no file, whatever lies in it."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest

from keypose.app.cli.main import main
from keypose.app.document.folder_lock import NAME as LOCK
from keypose.app.document.folder_lock import NotALock, SessionLock
from keypose.app.document.open import open_for_editing
from keypose.app.jobs.batch.journal import FOLDER, NAME
from keypose.app.working import queue
from keypose.tracker.errors import SessionError
from keypose.tracker.storage.files import load_session
from tests.app.cli_cases import refused
from tests.app.document.test_edit_log import done
from tests.app.document.test_edit_log import turn as turned
from tests.scenes import IdleWorker, opened_store, sample

PRECIOUS = b"precious\n"


@pytest.fixture
def precious(tmp_path: Path) -> Path:
    path = tmp_path / "v.txt"
    path.write_bytes(PRECIOUS)
    return path


def link(kind: str, path: Path, target: Path) -> None:
    if kind == "symbolic":
        path.symlink_to(os.path.relpath(target, path.parent))
    else:
        path.hardlink_to(target)


def test_a_session_in_a_folder_whose_name_is_no_text_is_refused_at_the_door(
    session_path: Path,
) -> None:
    folder = session_path.parent.rename(os.fsdecode(os.fsencode(session_path.parent) + b"\xff"))
    with pytest.raises(SessionError, match=r"is not valid UTF-8: rename it or its folder\.$"):
        open_for_editing(folder / session_path.name, lambda path: path)


def test_tracking_refuses_a_lock_that_is_a_link(
    session_path: Path, precious: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = session_path.parent
    link("symbolic", folder / LOCK, precious)
    sentence = refused(capsys, folder, ["track", session_path, "--overwrite"])
    assert f"{LOCK} in" in sentence
    assert "remove it if you trust this folder" in sentence
    assert precious.read_bytes() == PRECIOUS


@pytest.mark.parametrize("content", [PRECIOUS, b"12x", b"1" * 21])
def test_a_lock_that_holds_something_else_locks_and_keeps_what_it_holds(
    tmp_path: Path, content: bytes
) -> None:
    (tmp_path / LOCK).write_bytes(content)
    SessionLock.take(tmp_path).release()
    assert (tmp_path / LOCK).read_bytes() == content


def test_a_lock_with_a_second_name_locks_and_is_not_written(tmp_path: Path) -> None:
    other = tmp_path / "other"
    other.write_bytes(b"")
    link("hard", tmp_path / LOCK, other)
    SessionLock.take(tmp_path).release()
    assert other.read_bytes() == b""


@pytest.mark.parametrize("kind", ["pipe", "folder"])
def test_a_lock_that_is_no_file_is_named(tmp_path: Path, kind: str) -> None:
    os.mkfifo(tmp_path / LOCK) if kind == "pipe" else (tmp_path / LOCK).mkdir()
    with pytest.raises(NotALock, match="not a lock of Keypose"):
        SessionLock.take(tmp_path)


@pytest.mark.parametrize("what", ["import", "batch"])
def test_importing_and_batches_refuse_a_lock_that_is_a_link(
    session_path: Path,
    precious: Path,
    tmp_path: Path,
    what: str,
    capsys: pytest.CaptureFixture[str],
) -> None:
    export = ["export", str(session_path), "--format", "bvh", "--out", str(tmp_path)]
    assert main(["track", str(session_path)]) == main(export) == 0
    (session_path.parent / LOCK).unlink()
    link("symbolic", session_path.parent / LOCK, precious)
    motion = next(tmp_path.glob("*.bvh"))
    assert main([what, str(session_path), *([str(motion)] if what == "import" else [])]) != 0
    assert "not a lock of Keypose" in "".join(capsys.readouterr())
    assert precious.read_bytes() == PRECIOUS


@pytest.mark.parametrize("kind", ["symbolic", "hard"])
def test_a_batch_writes_its_journal_through_no_link(
    session_path: Path, precious: Path, kind: str, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = session_path.parent
    (folder / FOLDER).mkdir()
    link(kind, folder / FOLDER / NAME, precious)
    assert main(["batch", str(folder)]) == 2
    assert "cannot be written" in capsys.readouterr().err
    assert precious.read_bytes() == PRECIOUS


def test_a_batch_goes_into_no_linked_folder(
    session_path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mine = tmp_path / "mine"
    mine.mkdir()
    (mine / NAME).write_bytes(PRECIOUS)
    (session_path.parent / FOLDER).symlink_to(mine)
    assert main(["batch", str(session_path.parent)]) == 2
    assert "is a link" in capsys.readouterr().err
    assert {path.name for path in mine.iterdir()} == {NAME}
    assert (mine / NAME).read_bytes() == PRECIOUS


def test_a_batch_of_a_folder_passes_over_sessions_that_are_links(
    session_path: Path, tmp_path: Path
) -> None:
    mine = tmp_path / "mine"
    shutil.copytree(session_path.parent, mine)
    before = (mine / "session.json").read_bytes()
    (session_path.parent / "other.json").symlink_to(mine / "session.json")
    assert main(["batch", str(session_path.parent)]) == 0
    assert (mine / "session.json").read_bytes() == before


def test_a_session_named_by_a_link_is_tracked_where_it_lies(
    session_path: Path, tmp_path: Path
) -> None:
    elsewhere = tmp_path / "elsewhere" / "mine.json"
    elsewhere.parent.mkdir()
    elsewhere.symlink_to(session_path)
    assert main(["track", str(elsewhere)]) == 0
    assert [path.name for path in elsewhere.parent.iterdir()] == ["mine.json"]
    assert load_session(session_path).subject.results is not None


@pytest.mark.parametrize("name", ["motion.bvh", "shot.png"])
def test_overwriting_an_export_replaces_a_link_and_not_what_it_leads_to(
    session_path: Path, precious: Path, tmp_path: Path, name: str
) -> None:
    out = tmp_path / "out"
    out.mkdir()
    link("symbolic", out / name, precious)
    assert main(["track", str(session_path)]) == 0
    if name == "shot.png":
        place = str(out / name)
        given = ["shot", str(session_path), "--frame", "0", "--out", place, "--overwrite"]
    else:
        given = ["export", str(session_path), "--format", "bvh", "--out", str(out), "--overwrite"]
    assert main(given) == 0
    assert not (out / name).is_symlink()
    assert precious.read_bytes() == PRECIOUS


# --- in the page


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(queue, "JobRunner", IdleWorker)
    return sample(tmp_path).parent


async def test_the_page_opens_such_a_folder_to_be_looked_at_only(
    folder: Path, precious: Path
) -> None:
    link("symbolic", folder / LOCK, precious)
    async with opened_store(folder / "session.json") as store:
        assert "not a lock of Keypose" in store.app_state.saved.words
    assert precious.read_bytes() == PRECIOUS


@pytest.mark.parametrize("kind", ["symbolic", "hard"])
@pytest.mark.parametrize("name", ["journal.jsonl", "session.json.previous"])
async def test_an_edit_writes_through_no_link(
    folder: Path, precious: Path, name: str, kind: str
) -> None:
    link(kind, folder / name, precious)
    async with opened_store(folder / "session.json") as store:
        await done(store, turned(5), turned(9))
    assert precious.read_bytes() == PRECIOUS
    assert not (folder / name).is_symlink()


@pytest.mark.parametrize("name", ["journal.jsonl", "notes.json", "session.json.previous"])
@pytest.mark.parametrize("kind", ["pipe", "device"])
async def test_what_never_ends_beside_a_session_does_not_keep_it_from_opening(
    folder: Path, name: str, kind: str
) -> None:
    path = folder / name
    os.mkfifo(path) if kind == "pipe" else path.symlink_to("/dev/zero")
    async with opened_store(folder / "session.json") as store:
        await done(store, turned(5))
    assert load_session(folder / "session.json").subject.keyframes
