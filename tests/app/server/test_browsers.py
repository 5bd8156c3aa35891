"""Who was let in is remembered by digests, for a while, in a file of its owner alone."""

from __future__ import annotations

import stat
from pathlib import Path

import pytest

from keypose.app.server.admission import BROWSERS_FILE, LONGEST_S, MOST, Browsers, Clock


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "workspace" / BROWSERS_FILE


def clock_of(seconds: list[float]) -> Clock:
    """A clock that is right: what it says is what has passed."""
    return Clock(lambda: seconds[0], lambda: seconds[0])


def test_a_browser_is_known_by_cookie_and_key_also_to_the_next_server(file: Path) -> None:
    given = Browsers(file).admit()
    again = Browsers(file)
    assert again.has_cookie(given.cookie)
    assert again.has_key(given.cookie, given.key)
    assert not again.has_key(given.cookie, given.cookie)
    assert not again.has_cookie(given.key)
    assert not again.has_cookie("")
    assert not again.has_key(given.cookie, "")


def test_the_file_is_its_owners_alone_and_holds_no_secret(file: Path) -> None:
    given = Browsers(file).admit()
    assert stat.S_IMODE(file.stat().st_mode) == 0o600
    assert given.cookie not in file.read_text()
    assert given.key not in file.read_text()


def test_two_servers_of_one_workspace_forget_none_of_each_others_browsers(file: Path) -> None:
    one, other = Browsers(file), Browsers(file)
    given = [one.admit(), other.admit(), one.admit()]
    assert all(Browsers(file).has_cookie(g.cookie) for g in given)


def test_the_newest_are_remembered_for_a_while(file: Path) -> None:
    now = [0.0]
    browsers = Browsers(file, clock_of(now))
    given = []
    for now[0] in range(MOST + 1):
        given.append(browsers.admit())
    assert not browsers.has_cookie(given[0].cookie)
    assert browsers.has_cookie(given[1].cookie)
    now[0] = LONGEST_S + 1.5
    assert not browsers.has_cookie(given[1].cookie)
    assert browsers.has_cookie(given[2].cookie)
    assert not Browsers(file, clock_of(now)).has_cookie(given[1].cookie)


def test_one_that_was_let_in_under_a_clock_of_the_future_is_not_known_under_the_right_one(
    file: Path,
) -> None:
    given = Browsers(file, clock_of([10 * LONGEST_S])).admit()
    assert not Browsers(file, clock_of([0.0])).has_cookie(given.cookie)
    near = Browsers(file, clock_of([60.0])).admit()
    assert Browsers(file, clock_of([0.0])).has_cookie(near.cookie)


@pytest.mark.parametrize("step_s", [-3 * 3600.0, -10 * LONGEST_S, 3 * 3600.0, 2 * LONGEST_S])
@pytest.mark.parametrize("restarted", [False, True])
def test_a_clock_that_is_set_while_it_runs_locks_nobody_out_and_keeps_nobody_in(
    file: Path, step_s: float, restarted: bool
) -> None:
    start = 20 * LONGEST_S
    now, elapsed = [start], [5.0]
    clock = Clock(lambda: now[0], lambda: elapsed[0])
    first = Browsers(file, clock)
    given = first.admit()
    browsers = Browsers(file, clock) if restarted else first
    now[0] += step_s
    assert browsers.has_key(given.cookie, given.key)
    other = browsers.admit()
    assert browsers.has_cookie(given.cookie)
    # the file has the times of the clock as it is now
    assert Browsers(file, clock_of([now[0]])).has_cookie(given.cookie)
    assert Browsers(file, clock_of([now[0]])).has_cookie(other.cookie)
    elapsed[0] += LONGEST_S + 1.0
    assert not browsers.has_cookie(given.cookie)


@pytest.mark.parametrize("how", ["readable", "link", "folder", "damaged", "other", "huge"])
def test_a_file_that_others_may_have_made_lets_nobody_in(file: Path, how: str) -> None:
    given = Browsers(file).admit()
    content = file.read_bytes()
    if how == "readable":
        file.chmod(0o644)
    elif how == "link":
        file.rename(file.with_name("elsewhere"))
        file.symlink_to("elsewhere")
    elif how == "folder":
        file.unlink()
        file.mkdir()
    else:
        bad = {"damaged": content[:-9], "other": b"[7]", "huge": content + b" " * (1 << 20)}[how]
        file.write_bytes(bad)
    again = Browsers(file)
    assert not again.has_cookie(given.cookie)
    other = again.admit()
    assert again.has_key(other.cookie, other.key)


def test_where_the_workspace_cannot_be_written_it_still_lets_in(tmp_path: Path) -> None:
    (tmp_path / "workspace").write_text("a file")
    browsers = Browsers(tmp_path / "workspace" / BROWSERS_FILE)
    given = browsers.admit()
    assert browsers.has_key(given.cookie, given.key)
