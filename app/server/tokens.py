"""One-time tokens: each opens the page in one browser.

Those of a workspace outlast the server that printed them, so that a link that was not used yet
still works after a restart. The file holds digests, which let nobody in.
"""

from __future__ import annotations

import hashlib
import hmac
import secrets
import time
from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from keypose.app.server.browsers import AHEAD_S
from keypose.tracker.errors import KeyposeError
from keypose.tracker.files import read_private
from keypose.tracker.storage.atomic import make_folder, write_file

MOST = 50
LONGEST_S = 24 * 3600.0
LARGEST_BYTES = 1 << 16
NAME = "links.json"

_BYTES = 24


class _Token(BaseModel):
    model_config = ConfigDict(frozen=True)

    sha256: str = Field(max_length=64)
    since_s: float


class _Known(BaseModel):
    tokens: tuple[_Token, ...] = ()


class OneTimeTokens:
    """Those that can still be used.

    file: where they are stored; None: they end with the process.
    """

    def __init__(self, file: Path | None = None, now: Callable[[], float] = time.time) -> None:
        self._file, self._now = file, now
        self._valid = self._recent(self._read() or ())

    def issue(self) -> str:
        """A new one."""
        token = secrets.token_urlsafe(_BYTES)
        added = _Token(sha256=_digest(token), since_s=self._now())
        self._valid = self._recent((added, *self._present()))
        self._write()
        return token

    def spend(self, given: str) -> bool:
        """Whether it was valid; it is no longer, for other servers of the workspace either."""
        digest, present = _digest(given).encode(), self._recent(self._present())
        left = [t for t in present if not hmac.compare_digest(digest, t.sha256.encode())]
        self._valid = tuple(left)
        if len(left) == len(present):
            return False
        self._write()
        return True

    def _present(self) -> Iterable[_Token]:
        """What the file says goes: another server of the workspace may have issued or spent."""
        stored = self._read()
        return self._valid if stored is None else stored

    def _recent(self, tokens: Iterable[_Token]) -> tuple[_Token, ...]:
        now = self._now()
        return tuple(t for t in tokens if now - LONGEST_S <= t.since_s <= now + AHEAD_S)[:MOST]

    def _read(self) -> tuple[_Token, ...] | None:
        """None where there is no file, or others could have written it."""
        if self._file is None:
            return None
        try:
            return _Known.model_validate_json(read_private(self._file, LARGEST_BYTES)).tokens
        except (OSError, ValidationError):
            return None

    def _write(self) -> None:
        if self._file is None:
            return
        content = _Known(tokens=self._valid).model_dump_json(indent=1).encode()
        with suppress(KeyposeError):  # then they end with the process
            make_folder(self._file.parent)
            write_file(self._file, content, overwrite=True, private=True, error=KeyposeError)


def _digest(token: str) -> str:
    return hashlib.sha256(token.encode("utf-8", "replace")).hexdigest()
