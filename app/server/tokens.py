"""One-time tokens: each opens the page in one browser."""

from __future__ import annotations

import hmac
import secrets

_BYTES = 24


class OneTimeTokens:
    """Those that can still be used. They end with the process."""

    def __init__(self) -> None:
        self._valid: set[str] = set()

    def issue(self) -> str:
        """A new one."""
        token = secrets.token_urlsafe(_BYTES)
        self._valid.add(token)
        return token

    def spend(self, given: str) -> bool:
        """Whether it was valid; it is no longer."""
        bytes_given = given.encode("utf-8", "replace")
        found = [one for one in self._valid if hmac.compare_digest(bytes_given, one.encode())]
        self._valid.difference_update(found)
        return bool(found)
