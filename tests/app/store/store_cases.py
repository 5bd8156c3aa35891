"""A store that has a session open, with a tab that sends it messages."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any, TypeVar

from keypose.app.document.library import Library
from keypose.app.store.store import Store


class StoreDesk:
    """A store with a tab."""

    def __init__(self, store: Store) -> None:
        self.store, self.tab = store, store.join()

    def do(self, *messages: dict[str, Any]) -> None:
        for message in messages:
            self.store.receive(self.tab, message)


D = TypeVar("D", bound=StoreDesk)


def at_store(path: Path, desk: Callable[[Store], D], act: Callable[[D], Awaitable[None]]) -> None:
    """Open the session in a store, act, and stop the store."""

    async def run() -> None:
        store = Store(asyncio.get_running_loop(), lambda *_: None, Library(path.parent.parent))
        await store.open(path)
        try:
            await act(desk(store))
        finally:
            await store.stop()

    asyncio.run(run())
