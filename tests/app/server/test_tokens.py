"""A link lets one browser in, also after a restart, and its file lets nobody in."""

from __future__ import annotations

import stat
from pathlib import Path

import pytest

from keypose.app.server.admission import LINKS_FILE, TOKEN_LONGEST_S, Clock, OneTimeTokens
from tests.app.server.test_browsers import clock_of


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
    token = OneTimeTokens(file, clock_of([10 * TOKEN_LONGEST_S])).issue()
    assert not OneTimeTokens(file, clock_of([0.0])).spend(token)


def test_a_link_is_good_for_a_day(file: Path) -> None:
    now = [0.0]
    tokens = OneTimeTokens(file, clock_of(now))
    token = tokens.issue()
    now[0] = TOKEN_LONGEST_S + 1
    assert not tokens.spend(token)


@pytest.mark.parametrize("step_s", [-3 * 3600.0, -10 * TOKEN_LONGEST_S, 2 * TOKEN_LONGEST_S])
@pytest.mark.parametrize("on_disk", [True, False])
def test_a_clock_that_is_set_while_it_runs_uses_up_no_link_and_makes_none_last(
    file: Path, step_s: float, on_disk: bool
) -> None:
    now, elapsed = [20 * TOKEN_LONGEST_S], [5.0]
    tokens = OneTimeTokens(file if on_disk else None, Clock(lambda: now[0], lambda: elapsed[0]))
    used, second, old = tokens.issue(), tokens.issue(), tokens.issue()
    assert tokens.spend(used)
    now[0] += step_s
    newest = tokens.issue()
    assert tokens.spend(second)
    assert tokens.spend(newest)
    assert not any(map(tokens.spend, (used, second, newest)))
    elapsed[0] += TOKEN_LONGEST_S + 1.0
    assert not tokens.spend(old)


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
