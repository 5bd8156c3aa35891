"""Write the links that let a person in, without a secret among the arguments of a process."""

from __future__ import annotations

import html
import json
import shutil
import sys
import tempfile
import time
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from keypose.app.server.addresses import host_in_url
from keypose.app.server.guard import TOKEN, Guard
from keypose.tracker.errors import KeyposeError
from keypose.tracker.storage.atomic import make_folder, write_file

_PREFIX = "start-"
_STALE_S = 3600.0

_PAGE = """\
<!doctype html>
<meta charset="utf-8">
<meta name="referrer" content="no-referrer">
<title>Keypose</title>
<script>location.replace({script})</script>
<noscript><meta http-equiv="refresh" content="0;url={address}"></noscript>
<p><a href="{address}">Open Keypose</a></p>
"""


class RedirectFile:
    """An HTML file in a folder that its owner alone may enter. It leads to an address."""

    def __init__(self, address: str, workspace: Path) -> None:
        """Written to the workspace, where browsers in a sandbox may read, else to the usual place
        of temporary files. KeyposeError when neither can be written."""
        self._folder = _private_folder(workspace.absolute())
        self.path = self._folder / "keypose.html"
        content = _PAGE.format(script=json.dumps(address), address=html.escape(address))
        write_file(self.path, content.encode(), private=True, error=KeyposeError)

    def remove(self) -> None:
        """It has been used, or is needed no more. May be called again."""
        shutil.rmtree(self._folder, ignore_errors=True)


def _private_folder(workspace: Path) -> Path:
    with suppress(KeyposeError, OSError):  # a workspace that cannot be written to
        make_folder(workspace, error=KeyposeError)
        _sweep(workspace)
        return Path(tempfile.mkdtemp(prefix=_PREFIX, dir=workspace))
    try:
        return Path(tempfile.mkdtemp(prefix="keypose-"))
    except OSError as problem:
        raise KeyposeError(f"No browser is started: {problem.strerror or problem}.") from None


def _sweep(workspace: Path) -> None:
    """Remove what a Keypose left that was killed; its token has ended with it."""
    for folder in workspace.glob(f"{_PREFIX}*"):
        with suppress(OSError):
            if time.time() - folder.stat().st_mtime > _STALE_S and folder.is_dir():
                shutil.rmtree(folder, ignore_errors=True)


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
        """Print where the server is."""
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
