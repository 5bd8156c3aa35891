"""The file a browser is started with, so that no secret stands among the arguments of a process."""

from __future__ import annotations

import html
import json
import shutil
import tempfile
import time
from contextlib import suppress
from pathlib import Path

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
