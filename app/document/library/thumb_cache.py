"""The small pictures of sessions and files, made when they are first asked for and kept."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from keypose.app.document.library.recents import id_of
from keypose.tracker.errors import KeyposeError
from keypose.tracker.files import read_own
from keypose.tracker.storage.atomic import make_folder, write_file
from keypose.tracker.storage.files import load_session, open_video_of

MOST = 500
"""Pictures; beyond so many the oldest are removed, and made anew when they are asked for."""
_LARGEST_BYTES = 4 * 2**20


class ThumbCache:
    """folder: where they are kept."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def get(self, name: str, make: Callable[[], bytes | None]) -> bytes | None:
        """The picture of this name, made where it is not kept yet; None where there is none."""
        cached = self._folder / f"{name}.jpg"
        with suppress(OSError):
            return read_own(cached, _LARGEST_BYTES)
        content = make()
        if content is not None:
            with suppress(KeyposeError):  # then it is made anew the next time
                make_folder(self._folder)
                write_file(cached, content, overwrite=True)
                self._tidy()
        return content

    def of_file(self, path: Path) -> bytes | None:
        """That of a session, a video or a folder of images, as it is now. OSError where there is
        nothing."""
        facts = path.stat()
        identity = f"{path.absolute()}\0{facts.st_mtime_ns}\0{facts.st_size}"
        make = of_session if path.suffix.lower() == ".json" else _of_film
        return self.get(f"file-{id_of(identity)}", lambda: make(path))

    def _tidy(self) -> None:
        """Remove the oldest pictures beyond so many."""
        with suppress(OSError):  # what is left over does no harm
            kept = list(self._folder.glob("*.jpg"))
            if len(kept) > MOST:
                for old in sorted(kept, key=lambda f: f.stat().st_mtime)[:-MOST]:
                    old.unlink()


def of_session(path: Path) -> bytes | None:
    """The body in the middle keyframe; None where that cannot be had."""
    from keypose.app.document.library.thumbnails import (
        thumbnail,  # with the decoder, when it is wanted
    )

    try:
        session = load_session(path)
        with open_video_of(session, path) as video:
            return thumbnail(session, video)
    except KeyposeError:
        return None


def _of_film(path: Path) -> bytes | None:
    from keypose.app.document.library.thumbnails import glimpse

    try:
        return glimpse(path)
    except (KeyposeError, ValueError):
        return None
