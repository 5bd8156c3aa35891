"""A running `keypose open`, and a tab that speaks to it without a browser."""

from __future__ import annotations

import io
import json
import os
import re
import select
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self
from urllib.request import ProxyHandler, build_opener

from websockets.sync.client import ClientConnection, connect

ROOT = Path(__file__).resolve().parents[2]
LONGEST_S = 300.0
"""A wait ends with what it waits for; this is only for what would never come, however busy the
computer is."""


@dataclass(frozen=True)
class Entered:
    """What a browser is given when it is let in."""

    cookie: str
    key: str

    @property
    def headers(self) -> dict[str, str]:
        return {"Cookie": self.cookie, "X-Keypose-Key": self.key}

    @property
    def protocols(self) -> list[str]:
        return ["keypose", f"keypose-key.{self.key}"]


def enter(address: str) -> Entered:
    """Use a link as a browser would. HTTPError where it lets nobody in."""
    with build_opener(ProxyHandler({})).open(address, timeout=LONGEST_S) as answer:
        key = re.search(r'"keypose.key", "([^"]+)"', answer.read().decode())
        assert key is not None
        return Entered(answer.headers["Set-Cookie"].split(";")[0], key[1])


def family(pid: int) -> list[int]:
    """A process and all below it."""
    tasks = Path(f"/proc/{pid}/task").glob("*/children")
    children = [int(child) for task in tasks for child in task.read_text().split()]
    return [pid, *(below for child in children for below in family(child))]


class Keypose:
    """The program as a process of its own."""

    def __init__(self, *arguments: str, port: int = 0, browser: str | None = None) -> None:
        """port: 0 is any free one.  browser: a command that is started with what is to be shown."""
        command = [sys.executable, "-m", "keypose.app", "open", "--port", str(port), *arguments]
        if browser is None:
            command.append("--no-browser")
        self.process = subprocess.Popen(
            command,
            cwd=ROOT,
            env={**os.environ, "BROWSER": browser or ""},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
        )
        self.printed = ""
        self._entered: Entered | None = None
        while "Ctrl+C" not in self.printed:
            piece = self._read()
            assert piece, f"the server did not start: {self.printed}"
            self.printed += piece

    @property
    def addresses(self) -> list[str]:
        """All links it has printed until now."""
        while self._has_printed():
            self.printed += self._read()
        return re.findall(r"http://\S+", self.printed)

    @property
    def address(self) -> str:
        """The newest link: it lets one browser in. The one before was used when it is another."""
        return self.addresses[-1]

    @property
    def entered(self) -> Entered:
        """As a browser that was let in once."""
        self._entered = self._entered or enter(self.address)
        return self._entered

    def enter_again(self) -> None:
        """Be let in anew: of all browsers that ever were the newest are known alone."""
        self._entered = enter(self.address)

    @property
    def origin(self) -> str:
        return self.address.split("/?")[0]

    @property
    def host(self) -> str:
        return self.origin.removeprefix("http://")

    @property
    def port(self) -> int:
        return int(self.origin.rsplit(":", 1)[1])

    @property
    def token(self) -> str:
        return self.address.split("token=")[1]

    def end(self, number: int = signal.SIGTERM) -> tuple[int, str]:
        """Ask it to end; its exit code and last words."""
        self.process.send_signal(number)
        try:
            words, _ = self.process.communicate(timeout=LONGEST_S)
        finally:
            self.process.kill()
        return self.process.returncode, self.printed + words.decode()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self.process.returncode is None:
            self.end()

    def kill(self) -> None:
        """As a power cut would."""
        self.process.kill()
        self.process.communicate()

    @contextmanager
    def workers_stopped(self) -> Iterator[None]:
        """What it has set to work stands still meanwhile, and then goes on."""
        stopped = family(self.process.pid)[1:]
        for pid in stopped:
            os.kill(pid, signal.SIGSTOP)
        try:
            yield
        finally:
            for pid in stopped:
                with suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGCONT)

    def _has_printed(self) -> bool:
        """Whether something is there to read. What is printed before an answer is sent is there."""
        assert self.process.stdout is not None
        if self.process.stdout.closed:
            return False
        return bool(select.select([self.process.stdout], [], [], 0)[0]) and bool(self._peek())

    def _peek(self) -> bytes:
        assert isinstance(self.process.stdout, io.BufferedReader)
        return self.process.stdout.peek(1)

    def _read(self) -> str:
        assert isinstance(self.process.stdout, io.BufferedReader)
        return self.process.stdout.read1().decode()


class Visitor:
    """One tab: `seen` holds the newest of every section."""

    def __init__(self, keypose: Keypose) -> None:
        self.line: ClientConnection = connect(
            f"ws://{keypose.host}/events",
            origin=keypose.origin,  # type: ignore[arg-type]
            additional_headers={"Cookie": keypose.entered.cookie},
            subprotocols=keypose.entered.protocols,  # type: ignore[arg-type]
            proxy=None,
            max_queue=None,  # one that does not listen for a while must not be taken for gone
        )
        self.seen: dict[str, Any] = {}
        self.replies: list[dict[str, Any]] = []
        self.ack = 0
        self._number = 0
        self.until(lambda: "file" in self.seen)

    def send(self, **action: Any) -> int:
        """Send an action; its number."""
        self._number += 1
        self.line.send(json.dumps({**action, "n": self._number}))
        return self._number

    def do(self, **action: Any) -> None:
        """Send an action and wait until it has been dealt with."""
        number = self.send(**action)
        self.until(lambda: self.ack >= number)

    def ask(self, **question: Any) -> dict[str, Any]:
        """Ask, and wait for the answer."""
        self._number += 1
        number = self._number
        self.line.send(json.dumps({**question, "id": number}))
        self.until(lambda: any(m.get("id") == number for m in self.replies))
        return next(m for m in self.replies if m.get("id") == number)

    def until(self, there: Any, seconds: float = LONGEST_S) -> None:
        """Listen until something is so."""
        end = time.monotonic() + seconds
        while not there():
            left = end - time.monotonic()
            assert left > 0, "it never came"
            self._take(json.loads(self.line.recv(timeout=left)))

    def refusal(self) -> str:
        """What the last refused action was told."""
        return str([m for m in self.replies if m["t"] == "refused"][-1]["words"])

    def leave(self) -> None:
        self.line.close()

    def _take(self, message: dict[str, Any]) -> None:
        if message["t"] == "state":
            self.seen.update(message["set"])
            self.ack = max(self.ack, message["ack"])
        elif message["t"] != "beat":
            self.replies.append(message)
