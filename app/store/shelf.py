"""What a person does with whole sessions: rename, duplicate, delete, put back."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Any, Protocol

from keypose.app.document.library import Library
from keypose.app.editor import actions
from keypose.app.store.state import AppState

LIBRARY_CHANGED = {"t": "library"}
"""Has the tabs look anew at what can be opened."""


class Host(Protocol):
    """Who owns the state."""

    @property
    def app_state(self) -> AppState: ...

    def do(self, action: actions.Action) -> None: ...

    async def open(self, path: Path) -> None: ...

    async def close_session(self) -> None: ...

    async def saved_path(self) -> Path: ...

    def broadcast(self, message: dict[str, Any]) -> None: ...

    def note(self, kind: str, words: str, button: dict[str, Any] | None = None) -> None: ...


class Shelf:
    """Sessions of the library, open or not. All on the loop; files are dealt with in threads."""

    def __init__(self, host: Host, library: Library) -> None:
        self._host, self._library = host, library

    async def do(self, action: actions.Shelving) -> None:
        """Do it, and say what was done; KeyposeError, in one sentence, when it cannot be."""
        try:
            if isinstance(action, actions.RenameSession):
                await self._rename(action)
            elif isinstance(action, actions.DuplicateSession):
                await self._duplicate(action.id)
            elif isinstance(action, actions.DeleteSession):
                await self._delete(action.id)
            else:
                await self._restore(action)
        finally:
            self._host.broadcast(LIBRARY_CHANGED)

    def _is_open(self, id: str) -> bool:
        opened = self._host.app_state.opened
        return opened is not None and opened.id == id

    async def _rename(self, action: actions.RenameSession) -> None:
        if self._is_open(action.id):
            self._host.do(actions.Rename(title=action.title))
        else:
            await asyncio.to_thread(self._library.rename, action.id, action.title)

    async def _duplicate(self, id: str) -> None:
        if self._is_open(id):
            await self._host.saved_path()
        copy, name = await asyncio.to_thread(self._library.duplicate, id)
        button = {"label": "Open", "send": {"do": "open", "kind": "recent", "id": copy}}
        self._host.note("good", f"Duplicated as {name}.", button)

    async def _delete(self, id: str) -> None:
        was_open = self._is_open(id)
        if was_open:
            await self._host.close_session()
        in_trash, name = await asyncio.to_thread(self._library.delete, id)
        undo = {"do": "restore_session", "id": in_trash, "open": was_open}
        words = f"{name} moved to the trash. Its video stays."
        self._host.note("good", words, {"label": "Undo", "send": undo})

    async def _restore(self, action: actions.RestoreSession) -> None:
        id, name = await asyncio.to_thread(self._library.restore, action.id)
        if action.open:
            await self._host.open(await asyncio.to_thread(self._library.find, "recent", id))
        self._host.note("good", f"{name} is back.")
