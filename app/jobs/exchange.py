"""Export and import in a process of its own within limits, so that the page stays quick."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

from keypose.app.jobs.side_process import Progress
from keypose.tracker.formats.apart import LARGEST_COPY_BYTES, MEMORY_BYTES, SECONDS, died_words
from keypose.tracker.limits import limit_memory, limit_time
from keypose.tracker.session import Session

if TYPE_CHECKING:
    from keypose.app.export.film import FilmOrder
    from keypose.app.export.import_choices import Choices
    from keypose.app.export.importing import Import
    from keypose.app.export.recognising import Recognised
    from keypose.app.render.palette import Picture
    from keypose.app.render.stills import Still
    from keypose.app.render.studio import ViewStyle
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


@dataclass(frozen=True)
class FilmExport:
    """A film, as `keypose film` writes it."""

    order: FilmOrder
    suffix: str = ".mp4"

    def write(self, session: Session, path: Path, out: Path, progress: Progress) -> str:
        from keypose.app.export.film import film_of, film_words, write_film
        from keypose.app.render.poses import KnownPoses
        from keypose.tracker.storage.files import open_video_of

        poses = KnownPoses.of(session, path)
        film = film_of(path.name, poses, self.order)

        def seen(pictures: Iterator[Picture], count: int) -> Iterator[Picture]:
            for done, picture in enumerate(pictures, start=1):
                yield picture
                progress(done, count)

        with open_video_of(session, path) as video:
            write_film(out, session, video, poses, film, self.order.fps, seen=seen)
        return " ".join(film_words(session, poses, film))


@dataclass(frozen=True)
class SheetExport:
    """All keyframes on one picture, as `keypose sheet` writes it."""

    look: ViewStyle
    columns: int | None = None
    suffix: str = "-keyframes.png"

    def write(self, session: Session, path: Path, out: Path, progress: Progress) -> str:
        from keypose.app.export.pictures import sheet_png
        from keypose.tracker.storage.files import open_video_of

        with open_video_of(session, path) as video:
            content, problem = sheet_png(session, path, video, self.look, self.columns, progress)
        out.write_bytes(content)
        return problem or ""


@dataclass(frozen=True)
class PicturesExport:
    """A picture of every keyframe, or of every frame that has a pose, in one zip; or of one frame
    alone. As `keypose shot` draws them."""

    still: Still
    frames: Literal["keyframes", "posed"] | int = "keyframes"

    @property
    def suffix(self) -> str:
        """Return the ending of the file's name."""
        return f"-{self.frames}.png" if isinstance(self.frames, int) else "-pictures.zip"

    def write(self, session: Session, path: Path, out: Path, progress: Progress) -> str:
        from keypose.app.export.pictures import write_pictures
        from keypose.app.render.poses import KnownPoses
        from keypose.app.render.stills import still
        from keypose.app.render.studio import png
        from keypose.tracker.storage.files import open_video_of

        poses = KnownPoses.of(session, path)
        if isinstance(self.frames, int):
            with open_video_of(session, path) as video:
                out.write_bytes(png(still(session, video, self.frames, poses, self.still)))
            return ""
        keys = [keyframe.frame for keyframe in session.keyframes]
        frames = keys if self.frames == "keyframes" else list(poses.frames)
        with open_video_of(session, path) as video:
            write_pictures(out, session, video, poses, frames, self.still, progress)
        return ""


Export: TypeAlias = FilmExport | SheetExport | PicturesExport


@dataclass(frozen=True)
class ExportWork:
    """An export of a saved session to a file; its result is what should be known of what was
    written."""

    export: Export
    session_path: Path
    out: Path
    died: str = "The export stopped unexpectedly. Try again."

    def do(self, progress: Progress) -> str:
        from keypose.tracker.storage.files import load_session

        session = load_session(self.session_path)
        return self.export.write(session, self.session_path, self.out, progress)


def fps_of(value: float | None) -> Fraction | None:
    """Frames a second as a film counts them."""
    return None if value is None else Fraction(str(value)).limit_denominator(100_000)
