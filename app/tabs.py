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
        self._ack = 0
        self._acked = 0
        self._news = asyncio.Event()

    def tell(self, sections: Mapping[str, Any]) -> None:
        """These sections have new values."""
        self._sections.update(sections)
        self._news.set()

    def say(self, message: dict[str, Any]) -> None:
        """A message that must arrive, such as an answer."""
        self._messages.append(message)
        self._news.set()

    def acknowledge(self, number: int) -> None:
        """The action of this number, and all before it, have been dealt with."""
        self._ack = max(self._ack, number)
        self._news.set()

    async def next(self) -> list[dict[str, Any]]:
        """Wait for news; everything there is to send now."""
        while not (self._messages or self._sections or self._ack > self._acked):
            self._news.clear()
            await self._news.wait()
        out, self._messages = self._messages, []
        out.append({"t": "state", "ack": self._ack, "set": self._sections})
        self._sections, self._acked = {}, self._ack
        return out
