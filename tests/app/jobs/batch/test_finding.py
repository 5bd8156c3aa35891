"""Which sessions a path stands for."""

from __future__ import annotations

from pathlib import Path

import pytest

from keypose.app.jobs.batch.finding import common_folder, find_sessions, name_of
from keypose.tracker.errors import SessionError
from tests.app.jobs.batch.batch_cases import write_sessions


def test_a_folder_stands_for_all_sessions_below_it_and_nothing_else(tmp_path: Path) -> None:
    one, deep = write_sessions(tmp_path, "one", "two/deep/deeper")
    write_sessions(tmp_path, ".hidden")
    (tmp_path / "one" / "notes.json").write_text('{"schema_version": 1}')
    (tmp_path / "one" / "session.json.previous").write_bytes(one.read_bytes())
    other = one.with_name("take2.json")
    other.write_bytes(one.read_bytes())
    assert find_sessions([tmp_path]) == (one, other, deep)


def test_what_was_set_aside_of_a_session_is_none_unless_it_is_named(tmp_path: Path) -> None:
    (one,) = write_sessions(tmp_path, "one")
    aside = one.with_name("session.theirs-0123abcd.json")
    aside.write_bytes(one.read_bytes())
    assert find_sessions([tmp_path]) == (one,)
    assert find_sessions([aside]) == (aside,)


def test_a_session_named_twice_counts_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    one, two = write_sessions(tmp_path, "one", "two")
    (tmp_path / "link.json").symlink_to(two)
    monkeypatch.chdir(tmp_path)
    asked = [Path("two"), tmp_path, Path("one/session.json"), Path("link.json"), one]
    assert find_sessions(asked) == (two, one)


def test_a_file_that_is_named_stands_for_itself_whatever_it_is(tmp_path: Path) -> None:
    odd = tmp_path / "odd.json"
    odd.write_text("{")
    assert find_sessions([odd]) == (odd,)


@pytest.mark.parametrize(("name", "words"), [("gone", "There is no"), (".", "no session in")])
def test_a_path_without_a_session_is_refused(tmp_path: Path, name: str, words: str) -> None:
    with pytest.raises(SessionError, match=words):
        find_sessions([tmp_path / name])


def test_every_session_has_a_name_of_its_own(tmp_path: Path) -> None:
    names = ["walk/session.json", "walk/take2.json", "session.json", "a/b/session.json"]
    assert [name_of(tmp_path / name, tmp_path) for name in names] == [
        "walk",
        "walk/take2.json",
        tmp_path.name,
        "a/b",
    ]


def test_the_common_folder_of_one_session_is_its_own(tmp_path: Path) -> None:
    assert common_folder([tmp_path / "a" / "session.json"]) == tmp_path / "a"
    several = [tmp_path / "a" / "session.json", tmp_path / "b" / "c" / "session.json"]
    assert common_folder(several) == tmp_path
