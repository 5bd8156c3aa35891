"""The tabs that show the session, and what is still to be sent to each.

What waits for a slow tab is merged: of each section only the newest value is sent.
"""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from typing import Any


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
        """What they changed is on the disk, too."""
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
