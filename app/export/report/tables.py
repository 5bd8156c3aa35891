"""Write segments, keyframes and the video's facts as tables, with a report's words."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from keypose.app.editor.part_keyframes import keyed_words
from keypose.app.export.report.markup import Child, Html, element
from keypose.app.export.report.subject import Subject
from keypose.app.posing.labels import number_text
from keypose.tracker.errors import listed
from keypose.tracker.session.annotations import Note
from keypose.tracker.session.evidence import ByEvidence, FilmEvidence, SurfaceEvidence, surface_of
from keypose.tracker.session.results import Results
from keypose.tracker.session.schema import Session
from keypose.tracker.session.settings import Weights
from keypose.tracker.storage.results import Span, State
from keypose.tracker.tracking.result import SegmentResult


def figure(value: float, digits: int) -> str:
    """A number, or a dash where there is none."""
    return number_text(value, digits) if math.isfinite(value) else "–"


def best_score(track: SegmentResult) -> float:
    """The score of the pass that was kept; NaN where a file names one that is not there."""
    has_score = 0 <= track.best_pass < len(track.scores)
    return track.scores[track.best_pass] if has_score else math.nan


@dataclass(frozen=True)
class ReportWords:
    """too_few: where there is no segment.  seen_in: what a motion is seen in.  led_by: what leads
    it where it is not.  material: what may not be at hand.  score_heads: of a segment's figures,
    which `scores` makes of its finished result, if there is one.  has_passes: whether its score
    changes from pass to pass.  subject: what was observed.  way: how its motion was found.
    """

    too_few: str
    seen_in: str
    led_by: str
    material: str
    score_heads: tuple[str, ...]
    scores: Callable[[SegmentResult | None], tuple[str, ...]]
    has_passes: bool
    subject: Callable[[Session], str]
    way: Callable[[Session, Results], str]


def words_for(session: Session) -> ReportWords:
    """The words of a session's evidence."""
    return _WORDS.of(session)


def _film_scores(track: SegmentResult | None) -> tuple[str, ...]:
    if track is None:
        return "–", figure(math.nan, 2)
    return str(len(track.scores)), figure(best_score(track), 2)


def _film_subject(session: Session) -> str:
    return f"{session.view.video.width} × {session.view.video.height} pixels"


def _film_way(_session: Session, results: Results) -> str:
    return f"method {results.method}, quality {results.quality}"


def _surface_scores(track: SegmentResult | None) -> tuple[str, ...]:
    """Millimetres between the surfaces and the body's."""
    return (figure(1000 * (math.nan if track is None else best_score(track)), 1),)


def _surface_subject(session: Session) -> str:
    surface = surface_of(session)
    up = surface.up.replace("-", "−").upper()
    return f"observed surfaces in {surface.units}, {up} up"


def _surface_way(session: Session, results: Results) -> str:
    return f"{_WEIGHTS[surface_of(session).weights]}, quality {results.quality}"


_WEIGHTS: Mapping[Weights, str] = {
    "both": "doubts by contact and cameras",
    "contact": "doubts by contact",
    "photo": "doubts by cameras",
    "none": "no doubts",
}

_WORDS = ByEvidence(
    {
        FilmEvidence: ReportWords(
            too_few="Two keyframes make the first segment; there is none yet.",
            seen_in="picture",
            led_by="keyframes",
            material="video",
            score_heads=("Passes", "Least error"),
            scores=_film_scores,
            has_passes=True,
            subject=_film_subject,
            way=_film_way,
        ),
        SurfaceEvidence: ReportWords(
            too_few="One keyframe is enough to fit the body to the surfaces; there is none yet.",
            seen_in="surface",
            led_by="steps before",
            material="surfaces",
            score_heads=("Apart, mm",),
            scores=_surface_scores,
            has_passes=False,
            subject=_surface_subject,
            way=_surface_way,
        ),
    }
)


def segments_table(subject: Subject) -> Html:
    """Every segment with its verdict in words, and how well its motion fits."""
    scores = words_for(subject.session).score_heads
    head = ("Frames", "Time, s", "Length", "Verdict", *scores)
    numbers = tuple(i for i, words in enumerate(head) if words != "Verdict")
    return table(head, [_segment_row(subject, span) for span in subject.spans], numbers)


def keyframes_table(subject: Subject) -> Html:
    """Every keyframe with the interval to the next; below, the frames that the segments cover,
    keyframes and mean interval."""
    head = ("Keyframe", "Frame", "Time, s", "To the next", "Seconds", "Segment after it")
    keys = subject.keys
    rows = [_keyframe_row(subject, i) for i in range(len(keys))]
    foot: list[Child] = []
    if len(keys) > 1:
        first, last = subject.ends
        words = f"{last - first + 1} frames, {len(keys)} keyframes"
        mean = f"mean {number_text(subject.mean_interval, 1)}"
        seconds = subject.time_s(keys[-1]) - subject.time_s(keys[0])
        foot = [
            element("th", words, colspan=3, scope="row"),
            _number(mean),
            _number(figure(seconds / (len(keys) - 1), 2)),
            element("td"),
        ]
    return table(head, rows, (0, 1, 2, 3, 4), foot)


def notes_table(subject: Subject) -> Html:
    """Every note with its frame; of a flag that it is one."""
    rows = [_note_row(subject, note) for note in subject.session.notes]
    return table(("Frame", "Time, s", "Note"), rows, (0, 1))


def part_keyframes(session: Session) -> Html | None:
    """Which limbs were keyed alone, and where; None where none were."""
    if not session.subject.part_keyframes:
        return None
    said = [
        f"{k.frame} ({keyed_words(session.subject.body, k.parts)})"
        for k in session.subject.part_keyframes
    ]
    words = f"Limbs keyed alone, the rest of the body tracked: at {listed(said)}."
    return element("p", words, class_="note")


def table(
    head: Sequence[str],
    rows: list[list[Child]],
    numbers: tuple[int, ...],
    foot: list[Child] | None = None,
) -> Html:
    """A table of rows of cells (td or th); the columns in `numbers` are set to the right."""
    titles = (
        element("th", words, scope="col", class_="num" if i in numbers else None)
        for i, words in enumerate(head)
    )
    return element(
        "table",
        element("thead", element("tr", *titles)),
        element("tbody", *(element("tr", *row) for row in rows)),
        element("tfoot", element("tr", *foot)) if foot else None,
        class_="rows",
    )


def tile(words: str, below: Child) -> Html:
    """One figure in large, and what it is."""
    return element("div", element("b", words), below, class_="tile")


def verdict(state: State, words: str) -> Html:
    """The words of a verdict in its colour."""
    return element("span", words, class_=f"verdict {state}")


def _segment_row(subject: Subject, span: Span) -> list[Child]:
    first, last = span
    times = f"{figure(subject.time_s(first), 2)}–{figure(subject.time_s(last), 2)}"
    return [
        _number(f"{first}–{last}"),
        _number(times),
        _number(str(last - first)),
        element("td", verdict(subject.states[span], subject.words(span))),
        *_scores(subject, span),
    ]


def _scores(subject: Subject, span: Span) -> list[Child]:
    """How well its motion fits, dashes where there is none."""
    track = subject.fitting.get(span)
    segment_result = track if track is not None and track.finished else None
    return [_number(words) for words in words_for(subject.session).scores(segment_result)]


def _keyframe_row(subject: Subject, i: int) -> list[Child]:
    frame, time_s = subject.keys[i], subject.time_s(subject.keys[i])
    steps = seconds = ""
    if i + 1 < len(subject.keys):
        next_ = subject.keys[i + 1]
        steps, seconds = str(next_ - frame), figure(subject.time_s(next_) - time_s, 2)
    span = subject.after(frame)  # of surfaces there is one after the last keyframe too
    said = None if span is None else verdict(subject.states[span], subject.words(span))
    numbers = (str(i + 1), str(frame), figure(time_s, 2), steps, seconds)
    return [*map(_number, numbers), element("td", said)]


def _note_row(subject: Subject, note: Note) -> list[Child]:
    numbers = (str(note.frame), figure(subject.time_s(note.frame), 2))
    words = note.text or element("span", "Flag", class_="quiet")
    return [*map(_number, numbers), element("td", words, class_="words")]


def _number(words: str) -> Html:
    return element("td", words, class_="num")
