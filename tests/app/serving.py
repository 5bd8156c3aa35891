"""A running `keypose open`, and a tab that speaks to it without a browser."""

from __future__ import annotations

import json
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from websockets.sync.client import ClientConnection, connect

ROOT = Path(__file__).resolve().parents[2]


class Keypose:
    """The program as a process of its own. `address` lets a browser in."""

    def __init__(self, *arguments: str) -> None:
        command = [sys.executable, "-m", "app", "open", "--no-browser", "--port", "0", *arguments]
        self.process = subprocess.Popen(
            command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
        )
        self.address = self._address()

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

    @property
    def cookie(self) -> str:
        return f"keypose_{self.port}={self.token}"

    def end(self, number: int = signal.SIGTERM) -> tuple[int, str]:
        """Ask it to end; its exit code and last words."""
        self.process.send_signal(number)
        try:
            words, _ = self.process.communicate(timeout=30)
        finally:
            self.process.kill()
        return self.process.returncode, words

    def _address(self) -> str:
        assert self.process.stdout is not None
        told = []
        for line in self.process.stdout:
            told.append(line)
            if found := re.search(r"http://\S+", line):
                return found[0]
        raise AssertionError("the server did not start: " + "".join(told))


class Visitor:
    """One tab: `seen` holds the newest of every section."""

    def __init__(self, keypose: Keypose) -> None:
        self.line: ClientConnection = connect(
            f"ws://{keypose.host}/events",
            origin=keypose.origin,  # type: ignore[arg-type]
            additional_headers={"Cookie": keypose.cookie},
            proxy=None,
            max_queue=None,  # one that does not listen for a while must not be taken for gone
        )
        self.seen: dict[str, Any] = {}
        self.said: list[dict[str, Any]] = []
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
        self.until(lambda: any(m.get("id") == number for m in self.said))
        return next(m for m in self.said if m.get("id") == number)

    def until(self, there: Any, seconds: float = 60.0) -> None:
        """Listen until something is so."""
        end = time.monotonic() + seconds
        while not there():
            left = end - time.monotonic()
            assert left > 0, "it never came"
            self._take(json.loads(self.line.recv(timeout=left)))

    def refusal(self) -> str:
        """What the last refused action was told."""
        return str([m for m in self.said if m["t"] == "refused"][-1]["words"])

    def leave(self) -> None:
        self.line.close()

    def _take(self, message: dict[str, Any]) -> None:
        if message["t"] == "state":
            self.seen.update(message["set"])
            self.ack = max(self.ack, message["ack"])
        else:
            self.said.append(message)
