"""What was compiled counts as compiled where the loops' files are the same ones, and only there."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import numba
import pytest

from keypose.tracker import kernels, warm


@pytest.fixture
def loops(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of a checkout's loops, with an empty cache beside it; warming is a mark alone."""
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path / "cache"))
    (tmp_path / "cache").mkdir()
    return checkout(tmp_path / "one", monkeypatch)


def checkout(place: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    place.mkdir()
    for name in ("__init__.py", "sums.py"):
        (place / name).write_text("LOOP = 1\n")
        os.utime(place / name, ns=(10**18, 10**18))
    monkeypatch.setattr(kernels, "__file__", str(place / "__init__.py"))
    return place


MARKS: dict[str, Callable[[], bool]] = {
    warm._DONE: warm.is_warm,
    warm._HULLS_DONE: warm.are_hulls_warm,
}


@pytest.mark.parametrize("name", MARKS)
def test_loops_that_were_compiled_stay_so_while_their_files_do(loops: Path, name: str) -> None:
    assert not MARKS[name]()
    warm._mark(name).touch()
    assert MARKS[name]()


@pytest.mark.parametrize("name", MARKS)
def test_loops_whose_file_was_written_again_are_to_be_compiled_again(
    loops: Path, name: str
) -> None:
    warm._mark(name).touch()
    os.utime(loops / "sums.py", ns=(10**18, 10**18 + 1000))
    assert not MARKS[name]()


@pytest.mark.parametrize("name", MARKS)
def test_loops_of_another_checkout_are_to_be_compiled_for_it(
    loops: Path, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    warm._mark(name).touch()
    checkout(tmp_path / "two", monkeypatch)
    assert not MARKS[name]()


@pytest.mark.parametrize("name", MARKS)
def test_a_mark_that_does_not_show_of_which_files_it_is_does_not_count(
    loops: Path, name: str
) -> None:
    (loops.parent / "cache" / name).touch()
    assert not MARKS[name]()
