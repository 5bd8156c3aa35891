"""What killed writers left is removed, and nothing else."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from keypose.app.document.folder_lock import SessionLock
from keypose.tracker.storage.atomic import OLD_SECONDS, sweep

PART = "0123456789ab.part"
OF_SESSION = [
    f".session.json.{PART}",
    f".session.json.previous.{PART}",
    f".journal.jsonl.{PART}",
    f".tracks-0123456789ab.npz.{PART}",
    f".first-0123456789ab.npz.{PART}",
    f".keypoints-0123456789ab.npz.{PART}",
]
NOT_OURS = [
    "session.json",
    f"session.json.{PART}",
    ".session.json.part",
    ".session.json.0123456789AB.part",
    ".session.json.0123456789abc.part",
    f".session.json.{PART}.txt",
]


def _made(folder: Path, *names: str, old: bool = False) -> None:
    for name in names:
        (folder / name).write_bytes(b"half")
        if old:
            _age(folder / name)


def _age(file: Path) -> None:
    long_ago = file.lstat().st_mtime - OLD_SECONDS - 60
    os.utime(file, (long_ago, long_ago), follow_symlinks=False)


def _names(folder: Path) -> set[str]:
    return {file.name for file in folder.iterdir()}


def test_whoever_takes_the_lock_removes_what_a_killed_writer_left_of_the_session(
    tmp_path: Path,
) -> None:
    _made(tmp_path, *OF_SESSION)
    with SessionLock.take(tmp_path):
        assert _names(tmp_path) == {".keypose.lock"}


def test_a_film_that_may_still_be_written_stays_and_an_old_one_goes(tmp_path: Path) -> None:
    young, old = f".young.mp4.{PART}", f".old.mp4.{PART}"
    _made(tmp_path, young)
    _made(tmp_path, old, f".{PART}", old=True)
    sweep(tmp_path, is_locked=True)
    assert _names(tmp_path) == {young}


def test_without_the_lock_young_files_of_the_session_stay(tmp_path: Path) -> None:
    _made(tmp_path, *OF_SESSION)
    sweep(tmp_path)
    assert _names(tmp_path) == set(OF_SESSION)


def test_files_of_other_names_links_and_folders_stay(tmp_path: Path) -> None:
    folder, elsewhere = tmp_path / "folder", tmp_path / "elsewhere"
    folder.mkdir()
    elsewhere.write_bytes(b"mine")
    _made(folder, *NOT_OURS, old=True)
    link, inner = f".link.json.{PART}", f".folder.json.{PART}"
    (folder / link).symlink_to(elsewhere)
    _age(folder / link)
    (folder / inner).mkdir()
    sweep(folder, is_locked=True)
    assert _names(folder) == {*NOT_OURS, link, inner}
    assert elsewhere.read_bytes() == b"mine"


def test_a_folder_that_is_not_there_is_nothing_to_sweep(tmp_path: Path) -> None:
    sweep(tmp_path / "gone", is_locked=True)


@pytest.mark.parametrize("name", ["session.json", "journal.jsonl"])
def test_names_are_those_that_files_are_written_by(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from keypose.tracker.storage import atomic

    monkeypatch.setattr(Path, "unlink", lambda *_, **__: None)  # a writer killed before it tidied
    atomic.write_file(tmp_path / name, b"one")
    atomic.write_file(tmp_path / name, b"two", overwrite=True, keep_previous=True)
    monkeypatch.undo()
    assert len(_names(tmp_path)) > 2
    sweep(tmp_path, is_locked=True)
    assert _names(tmp_path) == {name, f"{name}.previous"}
