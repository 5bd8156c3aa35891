"""A link lets one browser in, also after a restart, and its file lets nobody in."""

from __future__ import annotations

import stat
from pathlib import Path

import pytest

from keypose.app.server.admission import LINKS_FILE, TOKEN_LONGEST_S, OneTimeTokens


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "workspace" / LINKS_FILE


def test_a_link_that_was_not_used_lets_one_browser_in_after_a_restart(file: Path) -> None:
    token = OneTimeTokens(file).issue()
    again = OneTimeTokens(file)
    assert not again.spend("guess")
    assert not again.spend("")
    assert again.spend(token)
    assert not again.spend(token)
    assert not OneTimeTokens(file).spend(token)


def test_the_file_is_its_owners_alone_and_holds_no_token(file: Path) -> None:
    token = OneTimeTokens(file).issue()
    assert stat.S_IMODE(file.stat().st_mode) == 0o600
    assert token not in file.read_text()


def test_what_the_file_holds_is_no_token(file: Path) -> None:
    tokens = OneTimeTokens(file)
    tokens.issue()
    digest = file.read_text().split('"sha256": "')[1].split('"')[0]
    assert not tokens.spend(digest)


def test_two_servers_of_one_workspace_know_each_others_links_and_each_is_used_once(
    file: Path,
) -> None:
    one, other = OneTimeTokens(file), OneTimeTokens(file)
    tokens = [one.issue(), other.issue(), one.issue()]
    assert [other.spend(tokens[0]), one.spend(tokens[1]), other.spend(tokens[2])] == [True] * 3
    assert not any(one.spend(token) or other.spend(token) for token in tokens)


def test_a_link_of_a_clock_of_the_future_lets_nobody_in_under_the_right_one(file: Path) -> None:
    token = OneTimeTokens(file, lambda: 10 * TOKEN_LONGEST_S).issue()
    assert not OneTimeTokens(file, lambda: 0.0).spend(token)


def test_a_link_is_good_for_a_day(file: Path) -> None:
    now = [0.0]
    tokens = OneTimeTokens(file, lambda: now[0])
    token = tokens.issue()
    now[0] = TOKEN_LONGEST_S + 1
    assert not tokens.spend(token)


@pytest.mark.parametrize("how", ["readable", "damaged", "folder"])
def test_a_file_that_others_may_have_made_lets_nobody_in_and_keeps_nobody_out(
    file: Path, how: str
) -> None:
    token = OneTimeTokens(file).issue()
    content = file.read_bytes()
    file.unlink()
    if how == "readable":
        file.write_bytes(content)
        file.chmod(0o644)
    elif how == "damaged":
        file.write_text("{")
        file.chmod(0o600)
    else:
        file.mkdir()
    tokens = OneTimeTokens(file)
    assert not tokens.spend(token)
    assert tokens.spend(tokens.issue())
