"""Track the tabs that show the session: what each has sent, and what is still to be sent to it.

A tab gives itself a name and numbers its messages. What was not acknowledged when the line or the
server broke off it sends again, in order, also to the next server: what is in the journal by then
must not be done twice.

What waits for a slow tab is merged: of each section only the newest value is sent.
"""

from __future__ import annotations

import asyncio
import re
import secrets
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from keypose.tracker.storage.edit_history import Received

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
        """End: what comes now comes of itself."""
        self._client = ""

    def resume_gesture(self) -> None:
        """Resume the gesture under way: what comes now comes of its client."""
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
        """The revision. A tab's own edits name the tab: they do not surprise it."""
        if self._client:
            return f"{self._client}:{self._last[self._client]}"
        return secrets.token_hex(8)


def split_envelope(message: Any) -> tuple[str, int, Any]:
    """Who sends a message, its number, and what is left of it. Without a number nothing is
    sent about it, and without a client it is not remembered.
    """
    if not isinstance(message, dict):
        return "", 0, message
    number, client = message.get("n", 0), message.get("client", "")
    is_number = type(number) is int and 0 <= number < 2**53
    is_client = isinstance(client, str) and CLIENT.fullmatch(client)
    rest = {key: value for key, value in message.items() if key not in ("n", "client")}
    return client if is_client and is_number and number else "", number if is_number else 0, rest


class Tab:
    """What one tab is still to be sent: sections merged, other messages in order."""

    def __init__(self) -> None:
        self._sections: dict[str, Any] = {}
        self._messages: list[dict[str, Any]] = []
        self._done = self._ack = 0
        self._reported = (0, 0)
        self._dones: dict[str, int] = {}
        self._acks: dict[str, int] = {}
        self._news = asyncio.Event()

    def update(self, sections: Mapping[str, Any]) -> None:
        """These sections have new values."""
        self._sections.update(sections)
        self._news.set()

    def send(self, message: dict[str, Any]) -> None:
        """A message that must arrive, such as an answer."""
        self._messages.append(message)
        self._news.set()

    def mark_done(self, number: int, client: str = "") -> None:
        """The action of this number, and all before it, have been done or refused.

        client: who gave it that number, where it says so: a tab also sends what another left.
        """
        if client:
            self._dones[client] = max(self._dones.get(client, 0), number)
        self._done = max(self._done, number)
        self._news.set()

    def acknowledge(self, number: int, client: str = "") -> None:
        """Acknowledge what they changed: it is on the disk, too."""
        if client:
            self._acks[client] = max(self._acks.get(client, 0), number)
        self._ack = max(self._ack, number)
        self._news.set()

    def _is_behind(self) -> bool:
        """Whether more is done, or on disk, than the page knows."""
        news = self._dones or self._acks
        return bool(news) or (self._done, self._ack) != self._reported

    async def next(self) -> list[dict[str, Any]]:
        """Wait for news; everything there is to send now."""
        while not (self._messages or self._sections or self._is_behind()):
            self._news.clear()
            await self._news.wait()
        out, self._messages = self._messages, []
        self._reported = (self._done, self._ack)
        state: dict[str, Any] = {"t": "state", "done": self._done, "ack": self._ack}
        out.append({**state, "dones": self._dones, "acks": self._acks, "set": self._sections})
        self._sections, self._dones, self._acks = {}, {}, {}
        return out


class Tabs:
    """All tabs that are open."""

    def __init__(self) -> None:
        self._open: set[Tab] = set()
        self._undelivered: list[dict[str, Any]] = []

    def __len__(self) -> int:
        return len(self._open)

    def join(self) -> Tab:
        """One more."""
        tab = Tab()
        self._open.add(tab)
        return tab

    def leave(self, tab: Tab) -> None:
        """One fewer."""
        self._open.discard(tab)

    def send_all(self, tab: Tab, sections: Mapping[str, Any]) -> None:
        """Send one tab everything, with the messages that no tab was there to receive."""
        tab.update(sections)
        for message in self._undelivered:
            tab.send(message)
        self._undelivered.clear()

    def update(self, sections: Mapping[str, Any]) -> None:
        """These sections have new values."""
        if sections:
            for tab in self._open:
                tab.update(sections)

    def send(self, message: dict[str, Any]) -> None:
        """A message for every tab; when there is none, for the first that comes."""
        for tab in self._open:
            tab.send(message)
        if not self._open:
            self._undelivered.append(message)
