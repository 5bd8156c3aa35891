"""Of two programs on one session, the first writes; a dead one holds nothing."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from keypose.app.document import folder_lock
from keypose.app.document.folder_lock import NAME, LockedElsewhere, SessionLock

_HOLD = """
import sys, time
from pathlib import Path
from keypose.app.document.folder_lock import SessionLock
lock = SessionLock.take(Path(sys.argv[1]))
print("held", flush=True)
time.sleep(60)
"""


@contextmanager
def holder(folder: Path) -> Iterator[subprocess.Popen[str]]:
    with subprocess.Popen(
        [sys.executable, "-c", _HOLD, str(folder)],
        cwd=Path(__file__).parents[3],
        stdout=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "held\n"
        yield process
        process.kill()


def test_a_second_one_learns_who_has_it(tmp_path: Path) -> None:
    message = r"another Keypose \(pid {}\)"
    with holder(tmp_path) as other, pytest.raises(LockedElsewhere, match=message.format(other.pid)):
        SessionLock.take(tmp_path)


def test_a_killed_one_holds_nothing(tmp_path: Path) -> None:
    with holder(tmp_path) as other:
        other.kill()
        other.wait()
    SessionLock.take(tmp_path).release()


def test_released_it_can_be_taken_again_and_twice_released_is_no_harm(tmp_path: Path) -> None:
    lock = SessionLock.take(tmp_path)
    with pytest.raises(LockedElsewhere, match=str(os.getpid())):
        SessionLock.take(tmp_path)
    lock.release()
    lock.release()
    SessionLock.take(tmp_path).release()


def test_where_nothing_can_be_written_there_is_nothing_to_lock(tmp_path: Path) -> None:
    SessionLock.take(tmp_path / "nowhere").release()


def test_where_files_cannot_be_locked_one_writes_all_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))

    monkeypatch.setattr(folder_lock, "lock_descriptor", refuse)
    SessionLock.take(tmp_path).release()


def test_a_full_disk_keeps_nobody_from_the_lock(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "write", refuse)
    lock = SessionLock.take(tmp_path)
    with pytest.raises(LockedElsewhere):
        SessionLock.take(tmp_path)
    lock.release()


def test_asking_for_a_lock_that_is_held_changes_nothing_in_it(tmp_path: Path) -> None:
    with holder(tmp_path) as other:
        for _ in range(2):
            with pytest.raises(LockedElsewhere, match=str(other.pid)):
                SessionLock.take(tmp_path)
        assert (tmp_path / NAME).read_text() == str(other.pid)


def test_who_has_it_is_reported_where_a_locked_byte_can_be_read_by_nobody_else(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As on Windows: the first byte of the file is the holder's alone."""
    monkeypatch.setattr(folder_lock, "_BEFORE_PID", b" ")
    SessionLock.take(tmp_path).release()
    lock, read = SessionLock.take(tmp_path), os.read

    def read_others(descriptor: int, length: int) -> bytes:
        if descriptor != lock._descriptor and os.lseek(descriptor, 0, os.SEEK_CUR) == 0:
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
        return read(descriptor, length)

    monkeypatch.setattr(os, "read", read_others)
    with pytest.raises(LockedElsewhere, match=rf"\(pid {os.getpid()}\)"):
        SessionLock.take(tmp_path)
    lock.release()
    assert (tmp_path / NAME).read_bytes() == b" %d" % os.getpid()
