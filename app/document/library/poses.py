"""Poses that a person has kept, in one file of the workspace: for every session, newest last."""

from __future__ import annotations

import secrets
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from keypose.app.editor.copied import Copied
from keypose.app.editor.documents import ActionRefused
from keypose.app.editor.message import PoseId, PoseName
from keypose.app.render.pose_strokes import PoseStroke
from keypose.tracker.errors import KeyposeError
from keypose.tracker.files import read_own
from keypose.tracker.storage.atomic import make_folder, write_file

MOST = 200
"""Poses that are kept at most."""
LARGEST_BYTES = 8 * 2**20
"""Of the file of kept poses: all of them with their pictures."""
MOST_STROKES = 1000
"""Lines of a pose's picture."""


class KeptPose(BaseModel):
    """A pose under a name. strokes: its picture."""

    model_config = ConfigDict(frozen=True)

    id: PoseId
    name: PoseName
    copied: Copied
    strokes: Annotated[tuple[PoseStroke, ...], Field(max_length=MOST_STROKES)] = ()


class _Book(BaseModel):
    poses: Annotated[tuple[KeptPose, ...], Field(max_length=MOST)] = ()


class PoseShelf:
    """The poses of a workspace. Every change reads the file anew: another Keypose may have changed
    it. KeyposeError, in one sentence, when the disk refuses; the file is then as it was."""

    def __init__(self, file: Path) -> None:
        self._file = file

    def poses(self) -> tuple[KeptPose, ...]:
        """All of them; KeyposeError where there is a file that cannot be read."""
        try:
            return _Book.model_validate_json(read_own(self._file, LARGEST_BYTES)).poses
        except FileNotFoundError:
            return ()
        except (OSError, ValidationError):
            raise KeyposeError(
                f"The kept poses in {str(self._file)!r} cannot be read. Move the file away to keep "
                "new ones."
            ) from None

    def keep(self, name: str, copied: Copied, strokes: Sequence[PoseStroke]) -> KeptPose:
        """One more."""
        kept_poses = self.poses()
        if len(kept_poses) >= MOST:
            raise ActionRefused(
                f"The library holds {MOST} poses, which is the most. Delete some first."
            )
        id = secrets.token_hex(6)
        kept = KeptPose(id=id, name=name, copied=copied, strokes=tuple(strokes))
        self._write((*kept_poses, kept))
        return kept

    def rename(self, id: str, name: str) -> None:
        """Another name for one."""
        kept_poses = self.poses()
        _index_of_pose(kept_poses, id)
        self._write(p.model_copy(update={"name": name}) if p.id == id else p for p in kept_poses)

    def delete(self, id: str) -> tuple[int, KeptPose]:
        """Without one: where it stood, and itself, with which `put_back` undoes it."""
        kept_poses = self.poses()
        place = _index_of_pose(kept_poses, id)
        self._write((*kept_poses[:place], *kept_poses[place + 1 :]))
        return place, kept_poses[place]

    def put_back(self, place: int, pose: KeptPose) -> None:
        """One that was deleted, where it stood."""
        kept_poses = tuple(kept_pose for kept_pose in self.poses() if kept_pose.id != pose.id)
        self._write((*kept_poses[:place], pose, *kept_poses[place:])[:MOST])

    def _write(self, poses: Iterable[KeptPose]) -> None:
        book = _Book(poses=tuple(poses))
        make_folder(self._file.parent)
        write_file(self._file, book.model_dump_json().encode(), overwrite=True)


def _index_of_pose(poses: Sequence[KeptPose], id: str) -> int:
    for place, pose in enumerate(poses):
        if pose.id == id:
            return place
    raise ActionRefused("This pose is not in the library any more.")
