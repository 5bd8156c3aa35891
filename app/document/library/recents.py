"""The sessions opened lately, in one small file of the workspace."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal, Self, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from keypose.app.document.library.files import SESSION_FOLDER
from keypose.tracker.files import read_own
from keypose.tracker.session import SegmentSummary, Session
from keypose.tracker.storage.atomic import make_folder, write_file
from keypose.tracker.storage.files import video_path

MOST = 40
"""Sessions that the start screen lists."""
LARGEST_BYTES = 4 * 2**20
"""Of the file of recent sessions."""

State: TypeAlias = Literal["good", "check", "lost", "outdated", "tracking", "waiting", "none"]
Span: TypeAlias = tuple[int, int, State]
"""(first frame, last frame, state) of a segment."""

Run: TypeAlias = tuple[State, Annotated[int, Field(ge=1)]]
"""(state, frames): the strip of a session from the video's first frame to its last."""


class Recent(BaseModel):
    """A session as the start screen shows it, without opening it.

    source: the video or surfaces that it was begun from, while it has no file of its own.
    """

    model_config = ConfigDict(frozen=True)

    path: str
    name: str
    video: str
    keyframes: int
    frames: int
    middle_frame: int
    strip: tuple[Run, ...]
    opened_at: float
    fingerprint: str = ""
    source: str = ""

    @property
    def is_there(self) -> bool:
        """Whether it can be opened."""
        return Path(self.path).is_file() or bool(self.source and Path(self.source).exists())

    @property
    def id(self) -> str:
        return id_of(self.path)

    @classmethod
    def of(
        cls,
        path: Path,
        session: Session,
        spans: Sequence[Span],
        now_s: float,
        source: Path | None = None,
    ) -> Self:
        """What is remembered of a session in this file, or of one that is begun from a
        source.
        """
        return cls(
            path=str(path.absolute()),
            name=name_of(path, session.title),
            # From a folder that is not there yet no way leads back to the video.
            video=str(video_path(session, path) if source is None else source.absolute()),
            keyframes=len(session.subject.keyframes),
            frames=session.view.video.frame_count,
            middle_frame=middle_frame(session),
            strip=strip_of(spans, session.view.video.frame_count),
            opened_at=now_s,
            # That what may be exported again is another one now is reported on opening.
            fingerprint=session.view.video.fingerprint * session.evidence.is_known_by_fingerprint,
            source="" if source is None else str(source.absolute()),
        )


def id_of(path: str) -> str:
    """What the page calls the session in this file."""
    return hashlib.sha256(path.encode("utf-8", "surrogateescape")).hexdigest()[:16]


def name_of(path: Path, title: str) -> str:
    """What a person calls the session in this file."""
    return title or path.parent.name.removesuffix(SESSION_FOLDER) or path.stem


class _Book(BaseModel):
    recents: tuple[Recent, ...] = ()


def read_recents(file: Path) -> tuple[Recent, ...]:
    """Newest first; a file that cannot be read is as good as none."""
    try:
        return _Book.model_validate_json(read_own(file, LARGEST_BYTES)).recents
    except (OSError, ValidationError):
        return ()


def remember(file: Path, recent: Recent) -> None:
    """Put a session first. KeyposeError in one sentence when the disk refuses."""
    others = (kept_recent for kept_recent in read_recents(file) if kept_recent.path != recent.path)
    book = _Book(recents=(recent, *others)[:MOST])
    make_folder(file.parent)
    write_file(file, book.model_dump_json(indent=1).encode(), overwrite=True)


def rename(file: Path, id: str, name: str) -> None:
    """Let a session have another name, in the place where it stands."""
    changed = tuple(
        recent.model_copy(update={"name": name}) if recent.id == id else recent
        for recent in read_recents(file)
    )
    write_file(file, _Book(recents=changed).model_dump_json(indent=1).encode(), overwrite=True)


def forget(file: Path, id: str) -> None:
    """Leave a session out; its files stay."""
    kept = tuple(recent for recent in read_recents(file) if recent.id != id)
    write_file(file, _Book(recents=kept).model_dump_json(indent=1).encode(), overwrite=True)


def spans_of(session: Session) -> list[Span]:
    """The verdicts that a session file holds."""
    verdict_of_span = {(s.first_frame, s.last_frame): s.verdict.kind for s in _summaries(session)}
    return [
        (first, last, verdict_of_span.get((first, last), "none")) for first, last in session.spans
    ]


def strip_of(spans: Sequence[Span], frame_count: int) -> tuple[Run, ...]:
    """How the video's frames are covered, from the first to the last; equal neighbours
    joined.
    """
    runs: list[Run] = []
    at = 0
    for first, last, state in [*sorted(spans), (frame_count - 1, frame_count - 1, "none")]:
        for run in (("none", first - at), (state, last - first)):
            if run[1] < 1:
                continue
            if runs and runs[-1][0] == run[0]:
                runs[-1] = (runs[-1][0], runs[-1][1] + run[1])
            else:
                runs.append((run[0], run[1]))
        at = max(at, last)
    return tuple(runs)


def middle_frame(session: Session) -> int:
    """The frame of the middle keyframe, or of the middle draft; without any the first."""
    posed = session.subject.keyframes or session.subject.drafts
    return posed[len(posed) // 2].frame if posed else 0


def _summaries(session: Session) -> Sequence[SegmentSummary]:
    return session.subject.results.segments if session.subject.results is not None else ()
