"""Rename, duplicate, delete and put back whole sessions; keep, rename and insert poses."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from pathlib import Path

from keypose.app.document.library import Library
from keypose.app.document.library.poses import KeptPose, PoseShelf
from keypose.app.editor import actions
from keypose.app.editor.copied import Copied
from keypose.app.editor.copy_paste import PastePose
from keypose.app.editor.documents import ActionRefused
from keypose.app.editor.notes import Rename
from keypose.app.editor.shown import shown_pose
from keypose.app.editor.state import EditorState
from keypose.app.render.pose_strokes import pose_strokes
from keypose.app.working.owner import StateOwner
from keypose.tracker.errors import KeyposeError

FILE = "poses.json"
MOST_DELETED = 20
"""Deleted poses that can be had back."""


class PoseLibrary:
    """`show` receives the poses whenever they changed. Work with the file is done in a thread, one
    change after another."""

    def __init__(self, workspace: Path, show: Callable[[tuple[KeptPose, ...]], None]) -> None:
        self._shelf = PoseShelf(workspace / FILE)
        self._show = show
        self._known: tuple[KeptPose, ...] = ()
        self._deleted: dict[str, tuple[int, KeptPose]] = {}
        self._one_at_a_time = asyncio.Lock()

    async def read(self) -> None:
        """Have the poses as they are on the disk; where they cannot be read there are none."""
        try:
            self._known = await asyncio.to_thread(self._shelf.poses)
        except KeyposeError:
            self._known = ()
        self._show(self._known)

    async def change(self, action: actions.PoseKeeping, edit: EditorState | None) -> None:
        """Do it and show the outcome; KeyposeError, in one sentence, when it cannot be done."""
        async with self._one_at_a_time:
            await asyncio.to_thread(self._change, action, edit)
            self._known = await asyncio.to_thread(self._shelf.poses)
        self._show(self._known)

    def inserting(self, action: actions.InsertPose) -> PastePose:
        """The edit that puts a kept pose to where the body stands."""
        for pose in self._known:
            if pose.id == action.id:
                return PastePose(
                    copied=pose.copied, mirrored=action.mirrored, onto_body=True, name=pose.name
                )
        raise ActionRefused("This pose is not in the library any more.")

    def _change(self, action: actions.PoseKeeping, edit: EditorState | None) -> None:
        if isinstance(action, actions.KeepPose):
            if edit is None:
                raise ActionRefused("Open a video first.")
            pose = shown_pose(edit).pose
            strokes = pose_strokes(edit.skeleton, pose)
            self._shelf.keep(action.name, Copied.pose_of(edit.skeleton, pose), strokes)
        elif isinstance(action, actions.RenamePose):
            self._shelf.rename(action.id, action.name)
        elif isinstance(action, actions.DeletePose):
            self._deleted[action.id] = self._shelf.delete(action.id)
            while len(self._deleted) > MOST_DELETED:
                self._deleted.pop(next(iter(self._deleted)))
        elif (gone := self._deleted.pop(action.id, None)) is not None:
            self._shelf.put_back(*gone)


LIBRARY_CHANGED = {"t": "library"}
"""Has the tabs look anew at what can be opened."""


class Shelf:
    """Sessions of the library, open or not. All on the loop; files are dealt with in threads."""

    def __init__(self, host: StateOwner, library: Library) -> None:
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
            self._host.do(Rename(title=action.title))
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
