"""How a person comes in: links that work once, a file for the browser, addresses that work."""

from __future__ import annotations

import os
import re
import socket
import stat
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from urllib.error import HTTPError
from urllib.request import ProxyHandler, Request, build_opener

import pytest

from keypose.app.cli import open as open_command
from keypose.app.server.addresses import bind, reachable
from keypose.tracker.errors import KeyposeError
from tests.app.serving import LONGEST_S, ROOT, Entered, Keypose, Visitor, enter


@pytest.fixture
def keypose(tmp_path: Path) -> Iterator[Keypose]:
    running = Keypose("--workspace", str(tmp_path / "workspace"))
    yield running
    running.end()


def status(address: str, **headers: str) -> int:
    """What the server answers to a GET."""
    try:
        request = Request(address, headers=headers)
        with build_opener(ProxyHandler({})).open(request, timeout=30) as answer:
            return int(answer.status)
    except HTTPError as error:
        error.close()
        return error.code


def is_in(keypose: Keypose, entered: Entered) -> bool:
    return status(f"{keypose.origin}/library", **entered.headers) == 200


def test_a_link_works_once_and_the_next_is_printed_when_it_was_used(keypose: Keypose) -> None:
    first = keypose.address
    one = enter(first)
    second = keypose.address
    assert second != first
    with pytest.raises(HTTPError) as refused:
        enter(first)
    refused.value.close()
    other = enter(second)
    assert one != other
    assert is_in(keypose, one)
    assert is_in(keypose, other)
    assert len(keypose.addresses) == 3


def test_nobody_is_let_in_by_what_the_workspace_keeps(keypose: Keypose, tmp_path: Path) -> None:
    entered = keypose.entered
    kept = tmp_path / "workspace" / "browsers.json"
    assert stat.S_IMODE(kept.stat().st_mode) == 0o600
    for secret in (entered.cookie.partition("=")[2], entered.key, keypose.token):
        assert secret not in kept.read_text()
    for digest in re.findall(r'"([0-9a-f]{64})"', kept.read_text()):
        thief = Entered(f"keypose_{keypose.port}={digest}", digest)
        assert not is_in(keypose, thief)


def test_a_link_that_was_not_used_lets_in_after_a_restart(tmp_path: Path) -> None:
    workspace = str(tmp_path / "workspace")
    with Keypose("--workspace", workspace) as keypose:
        link, port = keypose.address, keypose.port
        keypose.kill()
    with Keypose("--workspace", workspace, port=port) as again:
        assert is_in(again, enter(link))


def test_a_browser_that_was_let_in_comes_back_to_a_restarted_server(tmp_path: Path) -> None:
    workspace = str(tmp_path / "workspace")
    with Keypose("--workspace", workspace) as keypose:
        entered, port = keypose.entered, keypose.port
        keypose.kill()
    with Keypose("--workspace", workspace, port=port) as again:
        assert is_in(again, entered)
    with Keypose("--workspace", str(tmp_path / "other"), port=port) as elsewhere:
        assert not is_in(elsewhere, entered)


def test_where_the_usual_port_is_taken_the_next_one_is_it_each_time() -> None:
    for first in range(20000, 30000, 97):  # to where nobody else is: it and the next are free
        with suppress(KeyposeError), bind("127.0.0.1", first), bind("127.0.0.1", first + 1):
            break
    with bind("127.0.0.1", first):
        for _ in range(2):
            with open_command._listener("127.0.0.1", None, first) as listener:
                assert listener.getsockname()[1] == first + 1
    with open_command._listener("127.0.0.1", None, first) as listener:
        assert listener.getsockname()[1] == first


@pytest.fixture
def browser(tmp_path: Path) -> tuple[str, Path]:
    """A command that stands for a browser, and where it writes its arguments."""
    reported = tmp_path / "arguments"
    script = tmp_path / "browser"
    script.write_text(
        f'#!/bin/sh\nprintf "%s" "$*" > {reported}.part\nmv {reported}.part {reported}\n'
    )
    script.chmod(0o700)
    return f"{script} %s &", reported


def started_with(reported: Path) -> str:
    end = time.monotonic() + LONGEST_S
    while not reported.exists():
        assert time.monotonic() < end, "no browser was started"
        time.sleep(0.02)
    return reported.read_text()


def test_the_browser_is_started_with_a_file_that_only_its_owner_reads(
    browser: tuple[str, Path], tmp_path: Path
) -> None:
    workspace = os.path.relpath(tmp_path / "my work", ROOT)
    with Keypose("--workspace", workspace, browser=browser[0]) as keypose:
        argument = started_with(browser[1])
        assert argument.startswith("file:///")
        assert "token" not in argument
        file = Path(argument.removeprefix("file://").replace("%20", " "))
        assert stat.S_IMODE(file.stat().st_mode) == 0o600
        assert stat.S_IMODE(file.parent.stat().st_mode) == 0o700
        address = re.search(r'location.replace\("([^"]+)"\)', file.read_text())
        assert address is not None
        printed = keypose.address
        assert address[1] != printed
        assert is_in(keypose, enter(address[1]))
        assert not file.parent.exists()
        assert keypose.address == printed  # nobody used the link in the terminal
        assert is_in(keypose, enter(printed))


def test_a_file_that_no_browser_used_goes_with_the_server(
    browser: tuple[str, Path], tmp_path: Path
) -> None:
    with Keypose("--workspace", str(tmp_path / "work"), browser=browser[0]):
        file = Path(started_with(browser[1]).removeprefix("file://"))
        assert file.exists()
    assert not file.parent.exists()


@pytest.mark.parametrize("host", ["0.0.0.0", "::"])
def test_at_any_address_others_come_in_by_each_that_is_printed_and_by_no_foreign_name(
    host: str, tmp_path: Path
) -> None:
    if host == "::" and not socket.has_dualstack_ipv6():
        pytest.skip("This computer has no IPv6.")
    others = ("--let-others-in", "--public-name", "workshop.lan:80")
    with Keypose("--host", host, *others, "--workspace", str(tmp_path)) as keypose:
        places = [address.split("/?")[0] for address in keypose.addresses]
        port = int(places[0].rsplit(":", 1)[1])
        assert places[0] == f"http://127.0.0.1:{port}"
        assert places[-1] == "http://workshop.lan:80"
        shown = [f"[{a}]" if ":" in a else a for a in reachable(host)]
        assert places[:-1] == [f"http://{a}:{port}" for a in shown]
        token = keypose.addresses[0].partition("token=")[2]
        for place in (*places[:-1], f"http://127.0.0.2:{port}"):
            entered = enter(f"{place}/?token={token}")
            assert status(f"{place}/library", **entered.headers) == 200
            origin = {"Host": f"evil.example:{port}"}
            assert status(f"{place}/library", **entered.headers, **origin) == 403
            named = {"Host": "workshop.lan:80"}
            assert status(f"{place}/library", **entered.headers, **named) == 200
            token = keypose.token


def test_no_address_that_does_not_work_is_printed() -> None:
    for host in ("0.0.0.0", "::"):
        assert not {"0.0.0.0", "::"} & set(reachable(host))
    assert reachable("192.0.2.7") == ["192.0.2.7"]
    assert reachable("localhost") == ["localhost"]


def test_a_second_address_of_this_computer_can_be_served_alone(tmp_path: Path) -> None:
    with Keypose("--host", "127.0.0.2", "--workspace", str(tmp_path)) as keypose:
        assert keypose.origin == f"http://127.0.0.2:{keypose.port}"
        tab = Visitor(keypose)
        assert tab.seen["file"] is None
        tab.leave()


@pytest.mark.parametrize("host", ["0.0.0.0", "192.0.2.7", "::"])
def test_an_address_that_others_reach_needs_an_explicit_word(host: str) -> None:
    command = [sys.executable, "-m", "keypose.app", "open", "--no-browser", "--host", host]
    ended = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=LONGEST_S)
    assert ended.returncode == 2
    assert "ssh -L 8090:127.0.0.1:8090" in ended.stderr
    assert "--let-others-in" in ended.stderr
    assert ended.stdout == ""


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--public-name", "workshop.lan"], "--public-name lets others in: add --let-others-in."),
        (["--public-name", "http://x/", "--let-others-in"], "is no host name"),
    ],
)
def test_a_public_name_needs_an_explicit_word_and_is_a_host_name(
    arguments: list[str], words: str
) -> None:
    command = [sys.executable, "-m", "keypose.app", "open", "--no-browser", *arguments]
    ended = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=60)
    assert ended.returncode == 2
    assert words in " ".join(ended.stderr.split())
    assert ended.stdout == ""
