"""Long exports in a process of their own, so that the page stays quick: films, sheets, pictures."""

from __future__ import annotations

import multiprocessing
import os
import traceback
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from fractions import Fraction
from multiprocessing.connection import Connection
from pathlib import Path
from threading import Thread
from typing import TYPE_CHECKING, Literal, TypeAlias

from keypose.app.jobs.process import PATIENCE_S
from keypose.tracker.errors import KeyposeError

if TYPE_CHECKING:
    from keypose.app.export.film import FilmOrder
    from keypose.app.render.palette import Picture
    from keypose.app.render.snapshots import Look
    from keypose.app.render.stills import Still
    from keypose.tracker.session import Session

Drawn: TypeAlias = Callable[[int, int], None]
"""Told how many pictures of how many are done."""

NICENESS = 10
"""After the page's server, before the tracker: somebody waits for the file."""

_DIED = "The export stopped unexpectedly. Try again."


@dataclass(frozen=True)
class FilmExport:
    """A film, as `keypose film` writes it."""

    order: FilmOrder
    suffix: str = ".mp4"

    def write(self, session: Session, path: Path, out: Path, drawn: Drawn) -> str:
        from keypose.app.export.film import film_of, film_words, write_film
        from keypose.app.render.poses import KnownPoses
        from keypose.tracker.storage.files import open_video_of

        poses = KnownPoses.of(session, path)
        film = film_of(path.name, session, poses, self.order)

        def seen(pictures: Iterator[Picture], count: int) -> Iterator[Picture]:
            for done, picture in enumerate(pictures, start=1):
                yield picture
                drawn(done, count)

        with open_video_of(session, path) as video:
            write_film(out, session, video, poses, film, self.order.fps, seen=seen)
        return " ".join(film_words(session, poses, film))


@dataclass(frozen=True)
class SheetExport:
    """All keyframes on one picture, as `keypose sheet` writes it."""

    look: Look
    columns: int | None = None
    suffix: str = "-keyframes.png"

    def write(self, session: Session, path: Path, out: Path, drawn: Drawn) -> str:
        from keypose.app.export.keyframe_sheet import sheet_png
        from keypose.tracker.storage.files import open_video_of

        with open_video_of(session, path) as video:
            content, problem = sheet_png(session, path, video, self.look, self.columns, drawn)
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
        """Of the file."""
        return f"-{self.frames}.png" if isinstance(self.frames, int) else "-pictures.zip"

    def write(self, session: Session, path: Path, out: Path, drawn: Drawn) -> str:
        from keypose.app.export.pictures import write_pictures
        from keypose.app.render.poses import KnownPoses
        from keypose.app.render.snapshots import png
        from keypose.app.render.stills import still
        from keypose.tracker.storage.files import open_video_of

        poses = KnownPoses.of(session, path)
        if isinstance(self.frames, int):
            with open_video_of(session, path) as video:
                out.write_bytes(png(still(session, video, self.frames, poses, self.still)))
            return ""
        keys = [keyframe.frame for keyframe in session.keyframes]
        frames = keys if self.frames == "keyframes" else list(poses.frames)
        with open_video_of(session, path) as video:
            write_pictures(out, session, video, poses, frames, self.still, drawn)
        return ""


Export: TypeAlias = FilmExport | SheetExport | PicturesExport


@dataclass(frozen=True)
class ExportState:
    """How far it is: `done` pictures of `of`, 0 where that is not known yet. words: why it failed,
    or what should be known of what was written."""

    state: Literal["running", "done", "failed", "cancelled"] = "running"
    done: int = 0
    of: int = 0
    words: str = ""


@dataclass
class ExportProcess:
    """One export under way. `state` is the newest; it may be read from any thread."""

    export: Export
    session_path: Path
    out: Path
    state: ExportState = field(default_factory=ExportState)

    def __post_init__(self) -> None:
        context = multiprocessing.get_context("spawn")
        ours, theirs = context.Pipe(duplex=False)
        self._process = context.Process(
            target=_work,
            args=(self.export, self.session_path, self.out, theirs),
            name="keypose-export",
            daemon=True,
        )
        self._process.start()
        theirs.close()  # so that its end is the end of the connection
        Thread(target=self._receive, args=(ours,), name="exports", daemon=True).start()

    def cancel(self) -> None:
        """End it, whatever it is doing; at most a second."""
        if self.state.state == "running":
            self.state = ExportState("cancelled")
        for end in (self._process.terminate, self._process.kill):
            end()
            self._process.join(PATIENCE_S)
            if not self._process.is_alive():
                break

    def _receive(self, reports: Connection) -> None:
        with reports, suppress(EOFError, OSError):
            while True:
                report = reports.recv()
                if self.state.state == "running":
                    self.state = report
        if self.state.state == "running":
            self.state = ExportState("failed", words=_DIED)


def _work(export: Export, session_path: Path, out: Path, reports: Connection) -> None:
    """In the process."""
    from keypose.tracker.storage.files import load_session

    with suppress(OSError, AttributeError):
        os.nice(NICENESS)
    try:
        session = load_session(session_path)

        def drawn(done: int, of: int) -> None:
            reports.send(ExportState("running", done, of))

        words = export.write(session, session_path, out, drawn)
        reports.send(ExportState("done", words=words))
    except KeyposeError as error:
        reports.send(ExportState("failed", words=str(error)))
    except OSError as error:
        reports.send(ExportState("failed", words=f"{error.strerror or error}."))
    except Exception:  # noqa: BLE001 — a fault of ours, which must be told
        traceback.print_exc()
        reports.send(ExportState("failed", words=_DIED))


def fps_of(value: float | None) -> Fraction | None:
    """Frames a second as a film counts them."""
    return None if value is None else Fraction(str(value)).limit_denominator(100_000)
