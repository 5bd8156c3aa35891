"""Compiled loops are kept where this user alone can write and where they fit, and nowhere else."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from keypose.tracker import warm
from keypose.tracker.kernels import compiled
from keypose.tracker.kernels import folder as folders
from keypose.tracker.kernels.folder import LoopFolder, loop_folder
from tests.app.full_disks import mounted

NOBODY = 65534


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(folders, "NEEDED_BYTES", 2**21)
    return tmp_path / "cache"


def test_the_usual_place_is_this_users_alone(home: Path) -> None:
    found = loop_folder("1")
    assert found == LoopFolder(home / "keypose" / "kernels" / "1")
    assert (home / "keypose" / "kernels" / "1").stat().st_mode & 0o077 == 0


STRANGE: dict[str, Callable[[Path], None]] = {
    "another's loops": lambda home: os.chown(home / "keypose/kernels/1", NOBODY, NOBODY),
    "another's folder above": lambda home: os.chown(home / "keypose", NOBODY, NOBODY),
    "loops that a group may change": lambda home: (home / "keypose/kernels/1").chmod(0o770),
    "a folder above that all may change": lambda home: (home / "keypose/kernels").chmod(0o777),
}


@pytest.mark.skipif(not hasattr(os, "getuid") or os.getuid() != 0, reason="only root gives away")
@pytest.mark.parametrize("strange", STRANGE)
def test_loops_that_others_could_have_put_there_are_not_run(home: Path, strange: str) -> None:
    (home / "keypose" / "kernels" / "1").mkdir(parents=True, mode=0o700)
    STRANGE[strange](home)
    place = home / "keypose" / "kernels" / "1"
    assert loop_folder("1") == LoopFolder(None, f"others may write to {place}")


def test_a_folder_for_all_where_each_keeps_what_is_theirs_is_used(home: Path) -> None:
    home.mkdir()
    home.chmod(0o1777)
    assert loop_folder("1").problem == ""


def test_loops_that_do_not_fit_are_not_kept_and_the_words_say_where_room_is_needed(
    home: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with mounted(home, "1m"):
        found = loop_folder("1")
    assert found.path is None
    monkeypatch.setattr("keypose.tracker.kernels.FOLDER", found)
    assert not warm.is_warm()
    place = home / "keypose" / "kernels" / "1"
    assert warm.preparing_words() == (
        "Preparing the tracker: about a minute, and again at the next start, for "
        f"{place} cannot be written to: No space left on device. "
        "Make room there, or set XDG_CACHE_HOME to another folder of yours."
    )


def test_loops_that_are_there_already_are_used_on_a_full_disk(home: Path) -> None:
    with mounted(home, "1m"):
        place = home / "keypose" / "kernels" / "1"
        place.mkdir(parents=True, mode=0o700)
        (place / "warm-123").touch()
        assert loop_folder("1") == LoopFolder(place)


@compiled
def _twice(x: float) -> float:
    return 2 * x


def test_a_disk_that_fills_up_while_loops_are_compiled_stops_nothing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    loop: Any = _twice
    monkeypatch.setattr(loop._cache._cache_file, "save", full)
    monkeypatch.setattr(loop._cache, "load_overload", lambda *_: None)
    assert _twice(2.0) == 4.0


def test_of_many_versions_the_newest_stay(
    home: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(folders, "MOST_VERSIONS", 3)
    for age, version in enumerate("edcba"):
        place = loop_folder(version).path
        assert place is not None
        os.utime(place, (10**9 + age, 10**9 + age))
    loop_folder("f")
    assert {path.name for path in (home / "keypose" / "kernels").iterdir()} == {"a", "b", "f"}
    chosen = tmp_path / "mine"
    for version in "edcba":
        loop_folder(version, str(chosen))
    assert len(list(chosen.iterdir())) == 5
