"""The report of a batch: one page with the outcome in a table, then every session by itself."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from keypose.app.export.report.images import embedded
from keypose.app.export.report.markup import Child, Html, element, joined, logo
from keypose.app.export.report.report import (
    Subject,
    html_page,
    score_chart,
    segments_table,
    subject_of,
    thumbnail,
)
from keypose.app.jobs.batch.task import PlaceToReview, Summary
from keypose.tracker.errors import KeyposeError
from keypose.tracker.files import read_head, read_own
from keypose.tracker.session import Session
from keypose.tracker.session.verdict import VERDICT_KINDS, WORST_FIRST
from keypose.tracker.storage.files import load_session, open_video_of
from keypose.tracker.tracking.result import SegmentResult
from keypose.tracker.video import Video

NAME = "batch-report.html"
TITLE = "Keypose batch report"
MOST_CHARTS = 12
MOST_PICTURES = 3
"""Of one session; its own report shows all."""
LARGEST_PICTURE_BYTES = 2**22
"""Of a picture that a session's own folder holds."""
APART = "margin-top: 16px"
MARK = f"<title>{TITLE}</title>".encode()
MARK_WITHIN = 4096
"""Bytes from the beginning in which a page says that it is such a report."""

STATES: Mapping[str, tuple[str, str]] = {
    "tracked": ("good", "Tracked"),
    "kept": ("good", "Up to date"),
    "failed": ("lost", "Failed"),
    "open": ("outdated", "Open elsewhere"),
    "interrupted": ("outdated", "Interrupted"),
}
"""Of every outcome, the colour of its word and the word."""


@dataclass(frozen=True)
class Entry:
    """One session of the batch by the name it goes by."""

    name: str
    summary: Summary


def batch_html(entries: Sequence[Entry], seconds: float) -> bytes:
    """The page. Sessions are read as they lie on disk; one that cannot be read has its sentence."""
    body = joined(
        [
            _head(entries, seconds),
            element("section", element("h2", "Sessions"), _outcomes(entries)),
            *(_session(number, entry) for number, entry in enumerate(entries)),
        ]
    )
    return html_page(TITLE, body)


def is_report(path: Path) -> bool:
    """Whether an earlier batch has written this file, so that it may be exchanged."""
    try:
        return MARK in read_head(path, MARK_WITHIN)
    except OSError:
        return False


def _head(entries: Sequence[Entry], seconds: float) -> Html:
    summaries = [entry.summary for entry in entries]
    done = sum(summary.is_done for summary in summaries)
    tiles = [
        _tile(str(count), element("span", kind.capitalize(), class_=f"verdict {kind}"))
        for kind in VERDICT_KINDS
        if (count := sum(summary.count(kind) for summary in summaries))
    ]
    tiles.append(_tile(f"{seconds:.0f}", "seconds"))
    of = f"{len(entries)} session{'s' if len(entries) > 1 else ''}"
    return element(
        "header",
        element("div", logo(), element("span", TITLE), class_="mark"),
        element("h1", f"{done} of {of} done"),
        element("div", *tiles, class_="tiles"),
    )


def _tile(figure: str, words: Child) -> Html:
    return element("div", element("b", figure), words, class_="tile")


def _outcomes(entries: Sequence[Entry]) -> Html:
    titles = ("Session", "Outcome", "Good", "Check", "Lost", "Seconds", "")
    numbers = titles[2:6]
    head = (element("th", t, class_="num" if t in numbers else None) for t in titles)
    rows = [_outcome(number, entry) for number, entry in enumerate(entries)]
    table = element(
        "table",
        element("thead", element("tr", *head)),
        element("tbody", *rows),
        class_="rows",
    )
    return element("div", table, class_="scroll")


def _outcome(number: int, entry: Entry) -> Html:
    summary = entry.summary
    counts = (str(summary.count(kind)) for kind in VERDICT_KINDS)
    figures = (element("td", f, class_="num") for f in (*counts, f"{summary.seconds:.1f}"))
    link = element("a", entry.name, href=f"#session-{number}", style="color: inherit")
    return element(
        "tr",
        element("td", link),
        element("td", _state(summary)),
        *figures,
        element("td", summary.words),
    )


def _state(summary: Summary) -> Html:
    colour, words = STATES[summary.state]
    return element("span", words, class_=f"verdict {colour}")


def _session(number: int, entry: Entry) -> Html:
    summary = entry.summary
    pieces: list[Child] = [element("h2", entry.name), _facts(summary)]
    if summary.words:
        pieces.append(element("p", summary.words, class_="problem"))
    pieces += _decided(summary)
    with suppress(KeyposeError):
        pieces += _found(Path(summary.session))
    return element("section", *pieces, id=f"session-{number}")


def _decided(summary: Summary) -> list[Child]:
    """What was decided of a film that nobody looked at, whom it shows, and where to look."""
    pieces: list[Child] = []
    if summary.person is not None:
        pieces.append(_person(Path(summary.person)))
    if summary.notes:
        notes = (element("li", words) for words in summary.notes)
        pieces.append(element("ul", *notes, style=f"{APART}; margin-bottom: 16px"))
    if not summary.places:
        return pieces
    has_several = any(place.body is not None for place in summary.places)
    titles = ("Frame", *(("Body",) if has_several else ()), "Part", "Expected error", "Reason")
    head = (element("th", t) for t in titles)
    rows = (element("tr", *(element("td", t) for t in _cells(p))) for p in summary.places)
    table = element(
        "table",
        element("thead", element("tr", *head)),
        element("tbody", *rows),
        class_="rows",
    )
    review = element("div", table, class_="scroll", style="margin-bottom: 16px")
    return [*pieces, element("h3", "To review"), review]


def _cells(place: PlaceToReview) -> tuple[str, ...]:
    body = () if place.body is None else (place.body,)
    return str(place.frame), *body, place.part, place.size, place.reason


def _person(path: Path) -> Html | None:
    """The frame with the box that was taken; None where the picture is gone or none."""
    try:
        content = np.frombuffer(read_own(path, LARGEST_PICTURE_BYTES), np.uint8)
    except OSError:
        return None
    picture = cv2.imdecode(content, cv2.IMREAD_COLOR)
    if picture is None:
        return None
    picture = cv2.cvtColor(picture, cv2.COLOR_BGR2RGB)
    words = "The person who was drafted"
    caption = element("figcaption", element("b", words))
    return element("figure", embedded(np.asarray(picture, np.uint8), words), caption)


def _facts(summary: Summary) -> Html:
    facts = [_state(summary), summary.session]
    if summary.exported:
        names = ", ".join(Path(name).name for name in summary.exported)
        facts.append(f"{names} in {Path(summary.exported[0]).parent}")
    return element("ul", *(element("li", fact) for fact in facts), class_="facts")


def _found(path: Path) -> list[Child]:
    """What a session on disk shows; KeyposeError when it cannot be read."""
    session = load_session(path)
    try:
        video = open_video_of(session, path)
    except KeyposeError:
        return _shown(session, path, None)
    with video:
        return _shown(session, path, video)


def _shown(session: Session, path: Path, video: Video | None) -> list[Child]:
    subject = subject_of(session, path, None if video is None else video.info)
    pieces: list[Child] = []
    if subject.problem:
        pieces.append(element("p", subject.problem, class_="problem"))
    if subject.spans:
        pieces.append(element("div", segments_table(subject), class_="scroll"))
    pictures = [_picture(subject, video, frame) for frame in _worth_a_look(subject)]
    pieces.append(element("div", *pictures, class_="tilesheet", style=APART))
    charts = [score_chart(track) for track in list(subject.fitting.values())[:MOST_CHARTS]]
    pieces.append(element("div", *charts, class_="cols", style=APART))
    return pieces


def _picture(subject: Subject, video: Video | None, frame: int) -> Html | None:
    picture = thumbnail(subject, video, frame)
    if picture is None:
        return None
    return element("figure", picture, element("figcaption", element("b", f"Frame {frame}")))


def _worth_a_look(subject: Subject) -> list[int]:
    """The frames that verdicts name, the lost ones first; the middle of the motion without any."""
    fitting = list(subject.fitting.values())
    named = [t for kind in WORST_FIRST if kind != "good" for t in fitting if t.kind == kind]
    tracks = named or fitting[len(fitting) // 2 :][:1]
    return [_frame_of(track) for track in tracks[:MOST_PICTURES]]


def _frame_of(track: SegmentResult) -> int:
    return track.go if track.go is not None else (track.first + track.last) // 2
