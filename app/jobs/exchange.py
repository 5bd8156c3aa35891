"""Export and import in a process of its own within limits, so that the page stays quick."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final, TypeAlias

from keypose.app.jobs.side_process import Progress
from keypose.app.orders.drawing import FilmOrder, MatteOrder, PicturesOrder, SheetOrder
from keypose.tracker.apart import LARGEST_COPY_BYTES, MEMORY_BYTES, SECONDS, died_words
from keypose.tracker.limits import limit_memory, limit_time
from keypose.tracker.session import Session

if TYPE_CHECKING:
    from keypose.app.export.importing import Import
    from keypose.app.export.recognising import Recognised
    from keypose.app.orders.imports import ImportOrder
    from keypose.tracker.video.info import VideoInfo


SECONDS_TO_FIT: Final = 3600
"""Of a processor; whoever does not want to wait that long cancels."""


@dataclass(frozen=True)
class RecogniseWork:
    """What a file holds. session: as JSON; video: the session's."""

    session: bytes
    file: Path
    video: VideoInfo

    @property
    def died(self) -> str:
        return died_words(self.file.name)

    def do(self, progress: Progress) -> Recognised:
        from keypose.app.export.recognising import recognise

        session = Session.model_validate_json(self.session)
        _limit(SECONDS)
        return recognise(session, self.file, self.video)


@dataclass(frozen=True)
class ImportWork:
    """What a session takes over of a file that was recognised."""

    session: bytes
    file: Path
    video: VideoInfo
    order: ImportOrder

    @property
    def died(self) -> str:
        return f"{self.file.name} needs too much time or memory to be imported: shorten it."

    def do(self, progress: Progress) -> Import:
        from keypose.app.export.importing import import_file

        session = Session.model_validate_json(self.session)
        _limit(SECONDS_TO_FIT)
        return import_file(session, self.file, self.order, self.video, progress)


def _limit(seconds: int) -> None:
    limit_memory(MEMORY_BYTES, LARGEST_COPY_BYTES)
    limit_time(seconds)


Export: TypeAlias = FilmOrder | SheetOrder | PicturesOrder | MatteOrder


def suffix_of(order: Export) -> str:
    """What follows the session's name in that of the file."""
    if isinstance(order, FilmOrder):
        return ".mp4"
    if isinstance(order, SheetOrder):
        return "-keyframes.png"
    if isinstance(order, MatteOrder):
        return f"-matte.{'zip' if order.kind == 'png' else order.kind}"
    return f"-{order.frames}.png" if isinstance(order.frames, int) else "-pictures.zip"


@dataclass(frozen=True)
class ExportWork:
    """An export of a saved session to a file; its result is what should be known of what was
    written."""

    order: Export
    session_path: Path
    out: Path
    died: str = "The export stopped unexpectedly. Try again."

    def do(self, progress: Progress) -> str:
        from keypose.app.export.drawn import write_drawn
        from keypose.tracker.storage.files import load_session

        session = load_session(self.session_path)
        return write_drawn(session, self.session_path, self.order, self.out, progress)
