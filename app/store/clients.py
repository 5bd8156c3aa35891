"""Which messages of which tabs the open session has had, so that each is dealt with once.

A tab gives itself a name and numbers its messages. What was not acknowledged when the line or the
server broke off it sends again, in order, also to the next server: what is in the journal by then
must not be done twice.
"""

from __future__ import annotations

import re
import secrets
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from keypose.tracker.storage.chronicle import Received

CLIENT = re.compile(r"[0-9A-Za-z_-]{8,64}")
"""What a tab may call itself."""

MOST = 200
"""Tabs that are remembered: those with the newest messages."""


@dataclass(frozen=True)
class _Gesture:
    """name: of the gesture under way.  client: whose.  before: the number before its first move."""

    name: str
    client: str
    before: int


class Clients:
    """Of the open session. A client without a name is not remembered."""

    def __init__(self, received: Mapping[str, int] | None = None) -> None:
        self._last = dict(received or {})
        self._client, self._before = "", 0
        self._gesture: _Gesture | None = None

    def begin(self, client: str, number: int) -> bool:
        """A message is to be dealt with, until `end`; False where it was already."""
        before = self._last.get(client, 0)
        if client and number <= before:
            return False
        self._client, self._before = client, before
        if client:
            self._last.pop(client, None)  # the newest stands last
            self._last[client] = number
            while len(self._last) > MOST:
                self._last.pop(next(iter(self._last)))
        return True

    def end(self) -> None:
        """What comes now comes of itself."""
        self._client = ""

    def resume_gesture(self) -> None:
        """What comes now comes of the one whose gesture is under way."""
        self._client = self._gesture.client if self._gesture is not None else ""

    def received(self, gesture: str | None) -> Received:
        """Whose messages are in the document, without the gesture under way, as it is now."""
        settled = dict(self._last)
        if gesture is None:
            self._gesture = None
        elif self._gesture is None or self._gesture.name != gesture:
            self._gesture = _Gesture(gesture, self._client, self._before)
        if self._gesture is not None and self._gesture.client in settled:
            settled[self._gesture.client] = self._gesture.before
        return Received(settled, self._revision())

    def _revision(self) -> str:
        """Of a tab's own edits it names the tab: they do not surprise it."""
        if self._client:
            return f"{self._client}:{self._last[self._client]}"
        return secrets.token_hex(8)


def split_envelope(message: Any) -> tuple[str, int, Any]:
    """Who sends a message, its number, and what is left of it. Without a number nothing is sent
    about it, and without a client it is not remembered."""
    if not isinstance(message, dict):
        return "", 0, message
    number, client = message.get("n", 0), message.get("client", "")
    is_number = type(number) is int and 0 <= number < 2**53
    is_client = isinstance(client, str) and CLIENT.fullmatch(client)
    rest = {key: value for key, value in message.items() if key not in ("n", "client")}
    return client if is_client and is_number and number else "", number if is_number else 0, rest
