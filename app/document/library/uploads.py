"""A file that arrives in pieces: whole under its name in the end, or not there at all."""

from __future__ import annotations

import os
import secrets
import shutil
from contextlib import suppress
from pathlib import Path, PurePath
from types import TracebackType
from typing import BinaryIO, Final, Self

from keypose.app.document.library.names import clean_name, numbered
from keypose.tracker.errors import KeyposeError
from keypose.tracker.storage.atomic import make_folder, sweep
from keypose.tracker.video.container import CONVERT_IMAGES, SUFFIXES, UNREAD_IMAGES

LARGEST_BYTES: Final = 8 * 2**30
SPARE_BYTES: Final = 256 * 2**20
"""Left free on the disk: sessions and results have to be saved too."""

"""Of observed surfaces that are one file; a folder of meshes is opened where it lies."""
STALE_SECONDS = 24 * 3600
"""An upload that was left so long ago is removed."""


class Upload:
    """One upload. Written to a hidden file, which `finish` gives its name; else it is removed."""

    def __init__(
        self, folder: Path, name: str, size: int | None, largest_bytes: int = LARGEST_BYTES
    ) -> None:
        """Begin: KeyposeError in words for the page when it is no video or has no room.

        name: what the sender calls it; any path in it is dropped.
        size: the bytes announced, None when unknown; more or fewer in the end is an error.
        """
        self.name = clean_name(name)
        self.size = size
        self._folder = folder
        self._most = largest_bytes if size is None else size
        self._received = 0
        self._require_video()
        self._require_room(largest_bytes)
        make_folder(folder, error=KeyposeError)
        sweep(folder, old_seconds=STALE_SECONDS)  # younger ones may be at work
        self._temporary = folder / f".{self.name}.{secrets.token_hex(6)}.part"
        self._file: BinaryIO | None = self._create()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.abort()

    def write(self, chunk: bytes) -> None:
        """Add a piece; KeyposeError, and nothing is left, when it is too much for size or disk."""
        if self._file is None:
            raise KeyposeError(f"{self.name} was cancelled.")
        self._received += len(chunk)
        if self._received > self._most:
            self.abort()
            raise KeyposeError(f"{self.name} is larger than announced. Choose it again.")
        try:
            self._file.write(chunk)
        except OSError as problem:
            raise self._abort_with(problem) from None

    def finish(self) -> str:
        """Put the file under its name, or the next free one; that name is its id."""
        if self._file is None:
            raise KeyposeError(f"{self.name} was cancelled.")
        if self._received == 0 or (self.size is not None and self._received < self.size):
            self.abort()
            raise KeyposeError(f"{self.name} was not copied completely. Choose it again.")
        try:
            self._file.flush()
            os.fsync(self._file.fileno())
            self._file.close()
            name = self._claim_name()
        except OSError as problem:
            raise self._abort_with(problem) from None
        self._file = None
        return name

    def abort(self) -> None:
        """Leave nothing behind; after `finish`, or a second time, nothing happens."""
        if self._file is None:
            return
        with suppress(OSError):  # closing writes what is left, for which there may be no room
            self._file.close()
        self._file = None
        with suppress(OSError):
            self._temporary.unlink()

    def _require_video(self) -> None:
        if (kind := UNREAD_IMAGES.get(PurePath(self.name).suffix.lower())) is not None:
            raise KeyposeError(
                f"{self.name} is an image of a kind that is not read, {kind}. Put all images of "
                f"the film into a folder, {CONVERT_IMAGES}, and open the folder."
            )
        if not self.name.lower().endswith(SUFFIXES):
            raise KeyposeError(
                f"{self.name} is not a video. Keypose opens MP4, MOV, MKV, WebM, AVI, TS, MPG and "
                "similar files."
            )

    def _require_room(self, largest_bytes: int) -> None:
        wanted = self.size or 0
        if wanted > largest_bytes:
            raise KeyposeError(
                f"{self.name} is too large to copy. It has {_gigabytes(wanted)} GB, "
                f"{_gigabytes(largest_bytes)} GB are allowed: put it into a folder that Keypose "
                "sees, then choose it there."
            )
        free = free_bytes(self._folder) - SPARE_BYTES
        self._most = min(self._most, max(free, 0))
        if wanted > free:
            raise KeyposeError(
                f"There is no room for {self.name}. It needs {_gigabytes(wanted)} GB, "
                f"{_gigabytes(max(free, 0))} GB are free."
            )

    def _create(self) -> BinaryIO:
        try:
            return self._temporary.open("xb")
        except OSError as problem:
            why = problem.strerror or problem
            raise KeyposeError(f"{self.name} cannot be copied: {why}.") from None

    def _claim_name(self) -> str:
        """The first free name is taken by an empty file, which no one else can then take."""
        for name in numbered(self.name):
            place = self._folder / name
            try:
                place.touch(exist_ok=False)
            except FileExistsError:
                continue
            try:
                self._temporary.replace(place)
            except OSError:
                place.unlink()
                raise
            return name
        raise AssertionError("names never end")

    def _abort_with(self, problem: OSError) -> KeyposeError:
        self.abort()
        return KeyposeError(f"{self.name} was not copied: {problem.strerror or problem}.")


def free_bytes(folder: Path) -> int:
    """Free on the disk a folder lies on, or will lie on."""
    nearest = next(p for p in (folder, *folder.absolute().parents) if p.exists())
    return shutil.disk_usage(nearest).free


def _gigabytes(size: int) -> str:
    return f"{size / 1e9:.1f}"
