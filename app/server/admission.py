"""Admit browsers by one-time tokens, and know those admitted after a restart.

A browser holds two secrets: a cookie, and a key in the storage of the page's origin. Cookies ignore
ports, so every server on the same host is sent the cookie; the key stays with this one. The file
holds digests of both, which let nobody in.

Tokens of a workspace outlast the server that printed them, so that a link that was not used yet
still works after a restart. Their file holds digests too.

Files hold times of the computer's clock, which somebody may set while a server runs: what it has
let in, or read, grows old by a clock that nobody sets.
"""

from __future__ import annotations

import hashlib
import hmac
import math
import secrets
import time
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass
from operator import itemgetter
from pathlib import Path

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from keypose.tracker.errors import KeyposeError
from keypose.tracker.files import read_private
from keypose.tracker.storage.atomic import make_folder, write_file

MOST = 50
LONGEST_S = 30 * 24 * 3600.0
AHEAD_S = 3600.0
"""By which another computer's clock may be ahead."""
LARGEST_BYTES = 1 << 16
BROWSERS_FILE = "browsers.json"


@dataclass(frozen=True)
class Secrets:
    """What a browser is given: `cookie` for every request, `key` for all that matters."""

    cookie: str
    key: str


@dataclass(frozen=True)
class Clock:
    """now: seconds since 1970, which somebody may set.  elapsed: seconds since some moment, which
    nobody can."""

    now: Callable[[], float] = time.time
    elapsed: Callable[[], float] = time.monotonic


class _Ages:
    """How old secrets are, by the digest of each. One that a file says is of the future is too old:
    it would be let in for as long as a clock was wrong."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._since: dict[str, float] = {}
        """By `elapsed`, of those that were seen to be valid."""

    def of(self, digest: str, since_s: float) -> float:
        """The age in seconds. since_s: as a file has it, seconds since 1970."""
        if digest not in self._since:
            age = self._clock.now() - since_s
            if not age >= -AHEAD_S:
                return math.inf
            self._since[digest] = self._clock.elapsed() - max(age, 0.0)
        return self._clock.elapsed() - self._since[digest]

    def since_s(self, digest: str, since_s: float) -> float:
        """When it was let in by the clock as it is set now, seconds since 1970."""
        return self._clock.now() - self.of(digest, since_s)

    def keep(self, digests: Iterable[str]) -> None:
        """Forget all others."""
        self._since = {digest: self._since[digest] for digest in digests if digest in self._since}


class _Browser(BaseModel):
    model_config = ConfigDict(frozen=True)

    cookie_sha256: str = Field(max_length=64)
    key_sha256: str = Field(max_length=64)
    since_s: float


class _Known(BaseModel):
    browsers: tuple[_Browser, ...] = ()


class Browsers:
    """file: where they are stored; None: they are forgotten with the process."""

    def __init__(self, file: Path | None = None, clock: Clock | None = None) -> None:
        self._file, self._clock = file, clock or Clock()
        self._ages = _Ages(self._clock)
        self._known = self._valid(self._read())

    def admit(self) -> Secrets:
        """The secrets of one more browser."""
        admitted = Secrets(secrets.token_urlsafe(24), secrets.token_urlsafe(24))
        added = _Browser(
            cookie_sha256=_digest(admitted.cookie),
            key_sha256=_digest(admitted.key),
            since_s=self._clock.now(),
        )
        # Another Keypose of the same workspace may have let others in meanwhile.
        met = {browser.cookie_sha256: browser for browser in (added, *self._known, *self._read())}
        self._known = self._valid(met.values())
        self._ages.keep(browser.cookie_sha256 for browser in self._known)
        self._write()
        return admitted

    def has_cookie(self, cookie: str) -> bool:
        """Whether a browser with this cookie was let in."""
        return self._of_cookie(cookie) is not None

    def has_key(self, cookie: str, key: str) -> bool:
        """Whether the browser with this cookie was given this key."""
        browser = self._of_cookie(cookie)
        return browser is not None and _is_same(browser.key_sha256, _digest(key))

    def _of_cookie(self, cookie: str) -> _Browser | None:
        digest, of_cookie = _digest(cookie), None
        for browser in self._valid(self._known):
            if _is_same(browser.cookie_sha256, digest):
                of_cookie = browser
        return of_cookie

    def _valid(self, browsers: Iterable[_Browser]) -> tuple[_Browser, ...]:
        """The newest, as long as they are let in without a new link."""
        ages = ((self._ages.of(b.cookie_sha256, b.since_s), b) for b in browsers)
        recent = [(age, browser) for age, browser in ages if age <= LONGEST_S]
        return tuple(browser for _, browser in sorted(recent, key=itemgetter(0))[:MOST])

    def _read(self) -> tuple[_Browser, ...]:
        """None where the file is not there, or others could have written it."""
        if self._file is None:
            return ()
        try:
            content = read_private(self._file, LARGEST_BYTES)
            return _Known.model_validate_json(content).browsers
        except (OSError, ValidationError):
            return ()

    def _write(self) -> None:
        if self._file is None:
            return
        dated = (
            b.model_copy(update={"since_s": self._ages.since_s(b.cookie_sha256, b.since_s)})
            for b in self._known
        )
        content = _Known(browsers=tuple(dated)).model_dump_json(indent=1).encode()
        with suppress(KeyposeError):  # after a restart the new link would be needed
            make_folder(self._file.parent)
            write_file(self._file, content, overwrite=True, private=True, error=KeyposeError)


def _digest(secret: str) -> str:
    return hashlib.sha256(secret.encode("utf-8", "replace")).hexdigest()


def _is_same(first: str, second: str) -> bool:
    return hmac.compare_digest(first.encode(), second.encode())


TOKEN_LONGEST_S = 24 * 3600.0

LINKS_FILE = "links.json"

_BYTES = 24
"""Random bytes of a token."""


class _Token(BaseModel):
    model_config = ConfigDict(frozen=True)

    sha256: str = Field(max_length=64)
    since_s: float


class _KnownToken(BaseModel):
    tokens: tuple[_Token, ...] = ()


class OneTimeTokens:
    """Those that can still be used.

    file: where they are stored; None: they end with the process.
    """

    def __init__(self, file: Path | None = None, clock: Clock | None = None) -> None:
        self._file, self._clock = file, clock or Clock()
        self._ages = _Ages(self._clock)
        self._valid = self._recent(self._read() or ())

    def issue(self) -> str:
        """A new one."""
        token = secrets.token_urlsafe(_BYTES)
        added = _Token(sha256=_digest(token), since_s=self._clock.now())
        self._valid = self._recent((added, *self._present()))
        self._write()
        return token

    def spend(self, token: str) -> bool:
        """Whether it was valid; from then on it is not, at no server of the workspace."""
        digest, present = _digest(token).encode(), self._recent(self._present())
        left = [t for t in present if not hmac.compare_digest(digest, t.sha256.encode())]
        self._valid = tuple(left)
        if len(left) == len(present):
            return False
        self._write()
        return True

    def _present(self) -> Iterable[_Token]:
        """Read the file, which counts: another server of the workspace may have issued or spent."""
        stored = self._read()
        return self._valid if stored is None else stored

    def _recent(self, tokens: Iterable[_Token]) -> tuple[_Token, ...]:
        ages = ((self._ages.of(t.sha256, t.since_s), t) for t in tokens)
        recent = tuple(token for age, token in ages if age <= TOKEN_LONGEST_S)[:MOST]
        self._ages.keep(token.sha256 for token in recent)
        return recent

    def _read(self) -> tuple[_Token, ...] | None:
        """None where there is no file, or others could have written it."""
        if self._file is None:
            return None
        try:
            return _KnownToken.model_validate_json(read_private(self._file, LARGEST_BYTES)).tokens
        except (OSError, ValidationError):
            return None

    def _write(self) -> None:
        if self._file is None:
            return
        dated = (
            t.model_copy(update={"since_s": self._ages.since_s(t.sha256, t.since_s)})
            for t in self._valid
        )
        content = _KnownToken(tokens=tuple(dated)).model_dump_json(indent=1).encode()
        with suppress(KeyposeError):  # then they end with the process
            make_folder(self._file.parent)
            write_file(self._file, content, overwrite=True, private=True, error=KeyposeError)
