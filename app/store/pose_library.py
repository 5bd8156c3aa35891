"""The poses that were kept, as the page works with them: kept, renamed, deleted, inserted."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from pathlib import Path

from keypose.app.document.library.poses import KeptPose, PoseShelf
from keypose.app.editor import actions
from keypose.app.editor.copied import Copied
from keypose.app.editor.refusal import Refused
from keypose.app.editor.shown import shown_pose
from keypose.app.editor.state import EditorState
from keypose.app.render.pose_strokes import pose_strokes
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

    def inserting(self, action: actions.InsertPose) -> actions.PastePose:
        """The edit that puts a kept pose to where the body stands."""
        for pose in self._known:
            if pose.id == action.id:
                return actions.PastePose(
                    copied=pose.copied, mirrored=action.mirrored, onto_body=True, name=pose.name
                )
        raise Refused("This pose is not in the library any more.")

    def _change(self, action: actions.PoseKeeping, edit: EditorState | None) -> None:
        if isinstance(action, actions.KeepPose):
            if edit is None:
                raise Refused("Open a video first.")
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
