"""What was compiled counts as compiled where the loops' files are the same ones, and only there."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable
from pathlib import Path

import numba
import pytest

from keypose.tracker import kernels, warm, warming
from keypose.tracker.body.body import preset
from keypose.tracker.session.references import Surface
from keypose.tracker.session.settings import TrackSettings
from keypose.tracker.warming import WarmPart
from tests.tracker import session_cases as cases


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


@pytest.fixture
def compiled(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What has been compiled, by this process or another, of parts that only say so."""
    done: list[str] = []

    def part(name: str, share: int) -> WarmPart:
        return WarmPart(lambda box: done.append(name), share)

    tracking = {"chains": part("chains", 3), "track": part("track", 1)}
    monkeypatch.setattr(warming, "TRACKING", tracking)
    monkeypatch.setattr(warming, "PARTS", {**tracking, "surface": part("surface", 9)})
    monkeypatch.setattr(warm, "_helpers", lambda: 0)
    return done


def test_what_a_run_needs_is_compiled_and_nothing_else(loops: Path, compiled: list[str]) -> None:
    warm.warm(["surface"])
    assert compiled == ["surface"]
    assert warm.is_warm(["surface"])
    assert not warm.is_warm(["chains", "surface"])
    assert not warm.is_warm()
    warm.warm(["chains", "surface"])
    assert compiled == ["surface", "chains"]
    warm.warm(["chains", "surface"])
    assert compiled == ["surface", "chains"]


def test_once_all_is_compiled_so_is_each_part(loops: Path, compiled: list[str]) -> None:
    warm.warm_tracking(lambda percent: None)
    finish()
    assert warm.is_warm(["chains", "surface"])


def test_all_loops_are_compiled_by_one_call_once(loops: Path, compiled: list[str]) -> None:
    for _ in range(2):
        warm.warm_all()
        assert sorted(compiled) == ["chains", "surface", "track"]
    assert warm.is_warm()


NEEDED = {
    "a person, by keypoints": ("adult_male", ("brightness", "keypoints"), "keypoints", "drift"),
    "a person, by brightness": ("adult_male", ("brightness",), "drift", "keypoints"),
    "an animal": ("dog", ("brightness", "keypoints"), "drift", "keypoints"),
}


@pytest.mark.parametrize("case", NEEDED)
def test_a_film_needs_the_loops_of_the_cues_that_count_for_its_body(case: str) -> None:
    body, cues, with_, without = NEEDED[case]
    settings = TrackSettings(cues=cues)
    asked = cases.session().changed({"body": preset(body), "keyframes": (), "settings": settings})
    needed = warm.needed(asked)
    assert with_ in needed
    assert without not in needed
    assert set(needed) < set(warming.PARTS)


def test_surfaces_need_none_of_a_films_loops() -> None:
    session = cases.session().changed({"surface": Surface(p_camera_surface=(0.0, 0.0, 3.0))})
    assert warm.needed(session) == ("surface",)


def finish() -> None:
    for thread in threading.enumerate():
        if thread.name == "compiling":
            thread.join()


def test_what_tracking_needs_is_compiled_first_and_its_share_told(
    loops: Path, compiled: list[str]
) -> None:
    told: list[tuple[int, list[str]]] = []
    warm.warm_tracking(lambda percent: told.append((percent, sorted(set(compiled)))))
    assert told == [(75, ["chains"]), (100, ["chains", "track"])]
    finish()
    assert "surface" in compiled
    assert warm.is_warm()
    assert warm.preparing_words(75).endswith("once: 75 % done.")


def test_where_another_process_dies_tracking_is_ready_all_the_same(
    loops: Path, compiled: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    class Dead(warming.Helper):
        def __init__(self) -> None:
            """No process."""

        def do(self, name: str) -> bool:
            return False

        def close(self) -> None:
            """Nothing to end."""

    monkeypatch.setattr(warming, "Helper", Dead)
    monkeypatch.setattr(warm, "_helpers", lambda: 1)
    warm.warm_tracking(lambda percent: None)
    assert "track" in compiled
    finish()


def test_another_process_compiles_what_it_is_told_until_nobody_tells_it_more() -> None:
    helper = warming.Helper()
    assert helper.do("drawing")
    assert not helper.do("juggling")
    assert not helper.do("drawing")
    helper.close()
