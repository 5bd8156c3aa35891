"""Files of strangers for a session, read in a process of their own within limits."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

from keypose.app.jobs.side_process import Progress
from keypose.tracker.formats.apart import LARGEST_COPY_BYTES, MEMORY_BYTES, SECONDS, died_words
from keypose.tracker.limits import limit_memory, limit_time
from keypose.tracker.session import Session

if TYPE_CHECKING:
    from keypose.app.export.import_choices import Choices
    from keypose.app.export.importing import Import
    from keypose.app.export.recognising import Recognised
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
    choices: Choices

    @property
    def died(self) -> str:
        return f"{self.file.name} needs too much time or memory to be imported: shorten it."

    def do(self, progress: Progress) -> Import:
        from keypose.app.export.importing import import_file

        session = Session.model_validate_json(self.session)
        _limit(SECONDS_TO_FIT)
        return import_file(session, self.file, self.choices, self.video, progress)


def _limit(seconds: int) -> None:
    limit_memory(MEMORY_BYTES, LARGEST_COPY_BYTES)
    limit_time(seconds)
