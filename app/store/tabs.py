"""The tabs that show the session, and what each still has to be told.

What waits for a slow tab is merged: of each section only the newest value is sent.
"""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from typing import Any


class Tab:
    """One tab's way out: sections merged, other messages in order."""

    def __init__(self) -> None:
        self._sections: dict[str, Any] = {}
        self._messages: list[dict[str, Any]] = []
        self._done = self._ack = 0
        self._told = (0, 0)
        self._dones: dict[str, int] = {}
        self._acks: dict[str, int] = {}
        self._news = asyncio.Event()

    def tell(self, sections: Mapping[str, Any]) -> None:
        """These sections have new values."""
        self._sections.update(sections)
        self._news.set()

    def say(self, message: dict[str, Any]) -> None:
        """A message that must arrive, such as an answer."""
        self._messages.append(message)
        self._news.set()

    def settle(self, number: int, client: str = "") -> None:
        """The action of this number, and all before it, have been done or refused.

        client: who gave it that number, where it says so: a tab also sends what it kept of another.
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
        """Whether more is done, or kept, than the page knows."""
        news = self._dones or self._acks
        return bool(news) or (self._done, self._ack) != self._told

    async def next(self) -> list[dict[str, Any]]:
        """Wait for news; everything there is to send now."""
        while not (self._messages or self._sections or self._is_behind()):
            self._news.clear()
            await self._news.wait()
        out, self._messages = self._messages, []
        self._told = (self._done, self._ack)
        state: dict[str, Any] = {"t": "state", "done": self._done, "ack": self._ack}
        out.append({**state, "dones": self._dones, "acks": self._acks, "set": self._sections})
        self._sections, self._dones, self._acks = {}, {}, {}
        return out


class Tabs:
    """All tabs that are open."""

    def __init__(self) -> None:
        self._open: set[Tab] = set()
        self._unheard: list[dict[str, Any]] = []

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

    def greet(self, tab: Tab, sections: Mapping[str, Any]) -> None:
        """Tell one everything, and what was said while there was none."""
        tab.tell(sections)
        for message in self._unheard:
            tab.say(message)
        self._unheard.clear()

    def tell(self, sections: Mapping[str, Any]) -> None:
        """These sections have new values."""
        if sections:
            for tab in self._open:
                tab.tell(sections)

    def say(self, message: dict[str, Any]) -> None:
        """A message for every tab; when there is none, for the first that comes."""
        for tab in self._open:
            tab.say(message)
        if not self._open:
            self._unheard.append(message)
