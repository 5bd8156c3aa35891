"""The links that let a person in: those in the terminal, and the file a browser is started with."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from keypose.app.server.addresses import host_in_url
from keypose.app.server.guard import TOKEN, Guard
from keypose.app.server.redirect_file import RedirectFile


class Links:
    """Each lets one browser in; when the printed one has been used, the next is printed.

    hosts: where the server is reached, its own address first.  public_names: those of a proxy or a
    name server, which lead to it with their own port or, left out, with this one's.
    """

    def __init__(self, guard: Guard, hosts: Sequence[str], public_names: Sequence[str]) -> None:
        self._guard = guard
        self._places = [f"{host_in_url(host)}:{guard.port}" for host in hosts]
        self._places += public_names
        self._printed = ""
        self._file: RedirectFile | None = None
        self._token_in_file = ""
        guard.entered = self._entered

    def print_first(self) -> None:
        """Where the server is."""
        self._print("Keypose is at")

    def file(self, workspace: Path) -> Path:
        """A file for the browser that is started; KeyposeError when it cannot be written."""
        self._token_in_file = self._guard.tokens.issue()
        address = self._address(self._places[0], self._token_in_file)
        self._file = RedirectFile(address, workspace)
        return self._file.path

    def end(self) -> None:
        """Leave no file behind."""
        if self._file is not None:
            self._file.remove()
            self._file = None

    def _entered(self, token: str) -> None:
        if token == self._token_in_file:
            self.end()
        elif token == self._printed:
            with suppress(OSError):  # nobody reads the terminal any more; who is in stays in
                self._print("For another browser:")

    def _print(self, words: str) -> None:
        """One line for each address."""
        self._printed = self._guard.tokens.issue()
        lines = [f"{words} {self._address(place, self._printed)}" for place in self._places]
        sys.stdout.write("".join(f"{line}\n" for line in lines))
        sys.stdout.flush()

    def _address(self, place: str, token: str) -> str:
        return f"http://{place}/?{TOKEN}={token}"
