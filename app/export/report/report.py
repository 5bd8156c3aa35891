"""The report of one session: what was filmed, what was found, where to look again."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from pathlib import Path

from keypose.app.editor.advice import next_step
from keypose.app.export.report.charts import angle_charts, over_time, score_chart
from keypose.app.export.report.derivatives import derivatives_section
from keypose.app.export.report.gait import CONVENTIONS, clinical_charts, gait_section, legend
from keypose.app.export.report.images import thumbnail
from keypose.app.export.report.markup import Child, Html, element, html_page, joined, logo
from keypose.app.export.report.subject import (
    STATE_WORDS,
    Subject,
    errors_of_films,
    recording_of,
    subject_of,
)
from keypose.app.export.report.tables import (
    keyframes_table,
    notes_table,
    part_keyframes,
    segments_table,
    tile,
    verdict,
    words_for,
)
from keypose.app.posing.labels import number_text
from keypose.app.render.studio import ViewStyle
from keypose.app.words.camera import camera_sentence
from keypose.app.words.films import film_errors_words
from keypose.app.words.review import answers_words
from keypose.tracker.errors import FormatError, readable
from keypose.tracker.review.segments import JudgedSegments
from keypose.tracker.session.bodies import id_and_name
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.results import Span, State
from keypose.tracker.video import Video

__all__ = [
    "Html",
    "Subject",
    "charts_section",
    "element",
    "html_page",
    "joined",
    "pictures_section",
    "report_html",
    "score_chart",
    "segments_table",
    "subject_of",
    "thumbnail",
    "verdict_section",
]

MOST_PICTURES = 48
MOST_DOUBTFUL = 24
MOST_NOTED = 24
MOST_SCORES = 60
"""What a session of hundreds of keyframes shows of each kind; the rest is left out, and says so."""
PART_WORDS = "Each part's turns in its parent's frame, over the frames; dots are the keyframes."


def report_html(
    session: Session, session_path: Path, video: Video | None = None, *, alone: bool = False
) -> bytes:
    """The report as one HTML file, on one body after the other, or on the one that is posed alone;
    without the video it has no pictures."""
    info = None if video is None else video.info
    abouts = [session] if alone else [session.about(body.id) for body in session.bodies]
    subjects = [subject_of(about, session_path, info, alone=alone) for about in abouts]
    several = len(subjects) > 1
    parts = [
        part
        for subject in subjects
        for part in _sections(
            subject, video, id_and_name(subject.session.subject) if several else ""
        )
    ]
    body = joined([*parts, notes_section(subjects[0], video)] if several else parts)
    return html_page(f"{subjects[0].name} – Keypose report", body)


def _sections(subject: Subject, video: Video | None, body: str) -> list[Child]:
    """All on one body.  body: what it is called, where the session has several, whose notes follow
    at the end."""
    return [
        head_section(subject, body),
        verdict_section(subject),
        charts_section(subject),
        motion_sections(subject),
        derivatives_section(subject),
        keyframes_section(subject),
        *([] if body else [notes_section(subject, video)]),
        pictures_section(subject, video),
    ]


def head_section(subject: Subject, body: str = "") -> Html:
    """The name, the facts, and all that was found in a sentence or two.  body: what that is called,
    where the session has several."""
    return element(
        "header",
        element("div", logo(), element("span", "Keypose report"), class_="mark"),
        element("h1", f"{subject.name}: {body}" if body else subject.name),
        element("ul", *(element("li", fact) for fact in _facts(subject)), class_="facts"),
        *(element("p", words, class_="summary") for words in _summary(subject)),
        element("p", _sentence(subject.problem), class_="problem") if subject.problem else None,
        _tiles(subject),
    )


def verdict_section(subject: Subject) -> Html:
    """Every segment with its verdict in words."""
    if not subject.spans:
        few = words_for(subject.session).too_few
        return _section("Verdicts", element("p", few, class_="quiet"))
    return _section("Verdicts", _scrolling(segments_table(subject)))


def charts_section(subject: Subject) -> Html:
    """Rank and observability over time, scores per pass."""
    if not subject.spans:
        return Html("")
    tracks = [track for track in subject.fitting.values() if track.finished]
    of_evidence = words_for(subject.session)
    words = (
        f"Rank counts the motions that the {of_evidence.seen_in} decides at every step. The lanes "
        "show how well it determines each group of parts; where they are hatched it does too "
        f"little, and the motion follows the {of_evidence.led_by}."
    )
    explained = element("p", words, class_="quiet") if tracks else None
    pieces = [_section("Over time", explained, over_time(subject))]
    if tracks and of_evidence.has_passes:
        charts = [score_chart(track) for track in tracks[:MOST_SCORES]]
        words = "The difference of brightness that is left after every pass; lower is better."
        more = _left_out(len(tracks) - len(charts), "segments")
        quiet = element("p", words, more, class_="quiet")
        pieces.append(_section("Error per pass", quiet, element("div", *charts, class_="cols")))
    return joined(pieces)


def motion_sections(subject: Subject) -> Html:
    """Joint angles, a person's by their clinical names, and the gait of one who walks."""
    parts = list(angle_charts(subject))
    if not parts:
        return Html("")
    of_parts = element("div", *parts, class_="cols angles")
    quiet = element("p", PART_WORDS, class_="quiet")
    try:
        recording = recording_of(subject)
    except FormatError:
        recording = None
    clinical = [] if recording is None else clinical_charts(subject, recording)
    if recording is None or not clinical:
        return _section("Joint angles", quiet, of_parts)
    own = element("summary", "The parts' own turns, about the axes that the page has")
    return joined(
        [
            _section(
                "Joint angles",
                element("p", CONVENTIONS, class_="quiet"),
                legend(recording),
                element("div", *clinical, class_="cols clinical"),
                element("details", own, quiet, of_parts),
            ),
            gait_section(subject, recording),
        ]
    )


def keyframes_section(subject: Subject) -> Html:
    """The keyframes and the intervals between them."""
    if not subject.keys:
        return Html("")
    return _section(
        "Keyframes", _scrolling(keyframes_table(subject)), part_keyframes(subject.session)
    )


def notes_section(subject: Subject, video: Video | None) -> Html:
    """What a person wrote at frames, with the pictures of some of them."""
    notes = subject.session.notes
    if not notes:
        return Html("")
    shown = _evenly(tuple(note.frame for note in notes), MOST_NOTED)
    pictures = [_noted_picture(subject, video, frame) for frame in shown] if video else []
    there = [picture for picture in pictures if picture is not None]
    tiles = element("div", *there, class_="tilesheet") if there else None
    return _section("Notes", _scrolling(notes_table(subject)), tiles)


def _noted_picture(subject: Subject, video: Video, frame: int) -> Html | None:
    picture = thumbnail(subject, video, frame)
    if picture is None:
        return None
    caption = element("figcaption", element("b", str(frame)), _seconds(subject, frame))
    return element("figure", picture, caption)


def pictures_section(subject: Subject, video: Video | None) -> Html:
    """What is in doubt, in all four views, and the body at every keyframe."""
    if video is None:
        return Html("")
    doubtful = _doubtful(subject)
    closer = [_closer_look(subject, video, span, go) for span, go in doubtful[:MOST_DOUBTFUL]]
    frames = _evenly(subject.keys, MOST_PICTURES)
    tiles = [_keyframe_picture(subject, video, frame) for frame in frames]
    pieces = (
        [
            _section(
                "Look here",
                element(
                    "p",
                    "One frame of every segment in doubt.",
                    _left_out(len(doubtful) - len(closer), "segments"),
                    class_="quiet",
                ),
                element("div", *closer, class_="wide"),
            )
        ]
        if closer
        else []
    )
    if tiles:
        left = _left_out(len(subject.keys) - len(frames), "keyframes")
        pieces.append(
            _section(
                "Keyframe pictures",
                element("p", left.strip(), class_="quiet") if left else None,
                element("div", *tiles, class_="tilesheet"),
            )
        )
    return joined(pieces)


def _facts(subject: Subject) -> list[str]:
    session, video = subject.session, subject.video
    clip, body = session.view.video, session.subject.body
    words = words_for(session)
    facts = [Path(clip.path).name, words.subject(session)]
    if video is None:
        facts += [f"{clip.frame_count} frames", f"{words.material} not at hand"]
    else:
        stated = session.evidence.fps
        about = "about " if video.variable_rate and stated is None else ""
        rate = stated or video.fps
        # until the last frame has been shown as long as the others, as the page says it
        seconds = subject.time_s(clip.frame_count - 1) + 1 / rate
        facts += [
            f"{clip.frame_count} frames, {number_text(seconds, 2)} s",
            f"{about}{number_text(rate, 2)} frames/s",
        ]
    if session.camera_path is not None and (motion := session.view.camera_motion) is not None:
        facts.append(camera_sentence(motion.kind, motion.path.zooms, None).rstrip(".").lower())
        if motion.unscaled:
            facts.append("the scale of the camera's path is not known")
    parts = f"{len(body.parts)} part{'s' * (len(body.parts) > 1)}"
    facts.append(f"body {readable(body.name)}, {parts}")
    if session.subject.results is not None:
        facts.append(words.way(session, session.subject.results))
    return facts


def _summary(subject: Subject) -> list[str]:
    """The outcome, and what would help most."""
    judged_segments = JudgedSegments.over(subject.session, subject.fitting)
    next_ = next_step(subject.keys, subject.session, subject.fitting, judged_segments)
    advice = f"{_sentence(next_.title)} {_sentence(next_.detail)}".strip()
    if not subject.spans:
        return [advice]
    count_of_state = Counter(subject.states.values())
    counts = ", ".join(
        f"{count_of_state[state]} {words}"
        for state, words in _STATES.items()
        if count_of_state[state]
    )
    count = len(subject.spans)
    outcome = f"{count} segment{'s' if count > 1 else ''}: {counts}."
    if len(subject.keys) < 2:
        return [outcome, advice]
    interval = f"A keyframe every {number_text(subject.mean_interval, 1)} frames on average."
    reviewed = answers_words(
        [each for each in judged_segments.reviewed if judged_segments.counts(each)]
    )
    of_films = film_errors_words(errors_of_films(subject))
    return [f"{outcome} {interval}", advice, *filter(None, (reviewed, of_films))]


_STATES: Mapping[State, str] = {
    "good": "good",
    "check": "to check",
    "lost": "lost",
    "outdated": "outdated",
    "none": "not tracked",
}


def _tiles(subject: Subject) -> Html:
    """The outcome in large figures."""
    count_of_state = Counter(subject.states.values())
    tiles = [
        tile(str(count_of_state[state]), element("span", words, class_=f"verdict {state}"))
        for state, words in STATE_WORDS.items()
        if count_of_state[state]
    ]
    tiles.append(tile(str(len(subject.keys)), "keyframes"))
    if len(subject.keys) > 1:
        tiles.append(tile(number_text(subject.mean_interval, 1), "frames between keyframes"))
    measured = (segment_result.diagnostics.rank for segment_result in subject.fitting.values())
    ranks = [rank[rank >= 0] for rank in measured]
    least = min((int(rank.min()) for rank in ranks if len(rank)), default=None)
    if least is not None:
        tiles.append(
            tile(f"{least}/{subject.dof_count}", "joint motions visible at the worst frame")
        )
    return element("div", *tiles, class_="tiles")


def _doubtful(subject: Subject) -> list[tuple[Span, int]]:
    """Segments to check or lost, the lost ones first, with the frame to look at."""
    doubtful = []
    for span, track in subject.fitting.items():
        if track.kind in ("check", "lost"):
            go = track.go if track.go is not None else sum(span) // 2
            doubtful.append((track.kind != "lost", span, go))
    return [(span, go) for _, span, go in sorted(doubtful)]


def _closer_look(subject: Subject, video: Video, span: Span, go: int) -> Html:
    picture = thumbnail(subject, video, go, 1000, ViewStyle("all"))
    missing = element("p", f"The video has lost frame {go}.", class_="quiet")
    caption = element(
        "figcaption",
        element("b", f"Frame {go}"),
        _seconds(subject, go),
        verdict(subject.states[span], subject.words(span)),
    )
    return element("figure", caption, picture or missing, class_="look")


def _keyframe_picture(subject: Subject, video: Video, frame: int) -> Html:
    after = subject.after(frame)
    words: Child = None
    if after is not None:
        state = subject.states[after]
        far = "next" if after[1] in subject.keys else "end"
        words = verdict(state, f"{after[1] - after[0]} to the {far}")
    picture = thumbnail(subject, video, frame)
    missing = element("p", "The video has lost this frame.", class_="quiet")
    caption = element("figcaption", element("b", str(frame)), _seconds(subject, frame), words)
    return element("figure", picture or missing, caption)


def _seconds(subject: Subject, frame: int) -> Html | None:
    time_s = subject.time_s(frame)
    return element("span", f"{number_text(time_s, 2)} s") if math.isfinite(time_s) else None


def _evenly(frames: tuple[int, ...], most: int) -> tuple[int, ...]:
    """All of them, or so many of them, the first and the last among them."""
    if len(frames) <= most:
        return frames
    return tuple(frames[round(i * (len(frames) - 1) / (most - 1))] for i in range(most))


def _left_out(count: int, rows_name: str) -> str:
    return f" {count} more {rows_name} are left out here." if count > 0 else ""


def _scrolling(table: Html) -> Html:
    """A table that is wider than a small screen scrolls by itself."""
    return element("div", table, class_="scroll")


def _section(title: str, *children: Child) -> Html:
    return element("section", element("h2", title), *children)


def _sentence(words: str) -> str:
    words = words[:1].upper() + words[1:]
    return words if not words or words.endswith((".", "!", "?")) else f"{words}."
