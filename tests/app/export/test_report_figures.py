"""The figures of a report: what is counted, how far keyframes are apart, where hatching lies."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from keypose.app.export.report import report as reporting
from keypose.app.export.report.charts import over_time
from keypose.app.export.report.derivatives import Derivatives, derivatives, derivatives_section
from keypose.app.export.report.markup import Html
from keypose.app.export.report.report import head_section, pictures_section, subject_of
from keypose.app.export.report.subject import Subject
from keypose.tracker.formats.recording import Recording
from keypose.tracker.formats.sampling import low_passed
from keypose.tracker.storage.files import load_session, open_video_of, save_session
from keypose.tracker.storage.results import Span
from keypose.tracker.storage.tracks import Tracks, save_result
from keypose.tracker.tracking.result import SegmentResult
from keypose.tracker.video import MissingFrame
from tests.app import surface_cases
from tests.tracker import session_cases as cases


def measured(found: SegmentResult, **arrays: Any) -> SegmentResult:
    """The same with other diagnostics."""
    return replace(found, diagnostics=replace(found.diagnostics, **arrays))


def tiles_of(subject: Subject) -> list[tuple[str, str]]:
    """Figure and words of every tile, markup within the words left out."""
    found = re.findall(r'<div class="tile"><b>(.*?)</b>(.*?)</div>', head_section(subject))
    return [(figure, re.sub("<.*?>", "", words)) for figure, words in found]


def tracked(path: Path, *kinds: cases.Kind) -> Subject:
    """The session with its two segments tracked, judged so."""
    found = []
    for (first, last), kind in zip(((0, 4), (4, 8)), kinds, strict=True):
        found.append(cases.segment(first, last, kind))
    save_session(save_result(load_session(path), path, cases.result(*found)), path)
    return subject_of(load_session(path), path)


def test_tiles_count_verdicts_and_keyframes_and_show_interval_and_lowest_rank(
    session_path: Path,
) -> None:
    subject = tracked(session_path, "good", "lost")
    first, last = subject.fitting[0, 4], subject.fitting[4, 8]
    low = measured(last, rank=np.array([8, -1, 5, 6]))  # −1: not known
    assert tiles_of(replace(subject, fitting={(0, 4): first, (4, 8): low})) == [
        ("1", "Good"),
        ("1", "Lost"),
        ("3", "keyframes"),
        ("4.0", "frames between keyframes"),
        ("5/8", "joint motions visible at the worst frame"),
    ]


@pytest.mark.parametrize(
    ("keys", "expected"),
    [
        ((), [("0", "keyframes")]),
        ((3,), [("1", "keyframes")]),
        (
            (1, 8),
            [("1", "Not tracked"), ("2", "keyframes"), ("7.0", "frames between keyframes")],
        ),
    ],
)
def test_there_is_an_interval_from_two_keyframes_on(
    tmp_path: Path, keys: tuple[int, ...], expected: list[tuple[str, str]]
) -> None:
    path = cases.write_session(tmp_path / "job", keys)
    assert tiles_of(subject_of(load_session(path), path)) == expected


@pytest.mark.parametrize("rank", [0, 1])
def test_a_step_of_which_nothing_is_seen_is_the_lowest_rank(session_path: Path, rank: int) -> None:
    subject = tracked(session_path, "good", "good")
    blind = measured(subject.fitting[0, 4], rank=np.array([8, rank, 8, 8]))
    assert tiles_of(replace(subject, fitting={(0, 4): blind}))[-1] == (
        f"{rank}/8",
        "joint motions visible at the worst frame",
    )


def captions(page: Html) -> list[str]:
    return [
        re.sub("<.*?>", " ", words).strip()
        for words in re.findall(r"<figcaption>(.*?)</figcaption>", page)
    ]


def pictured(path: Path) -> list[str]:
    """The words below the keyframes' pictures."""
    session = load_session(path)
    with open_video_of(session, path) as video:
        return captions(pictures_section(subject_of(session, path, video.info), video))


def test_below_a_keyframes_picture_stands_how_far_it_is_to_the_next(tmp_path: Path) -> None:
    path = cases.write_session(tmp_path / "job", (1, 4, 8))
    words = [" ".join(caption.split()) for caption in pictured(path)]
    assert words == ["1 0.03 s 3 to the next", "4 0.13 s 4 to the next", "8 0.27 s"]


def test_where_the_video_has_lost_a_frame_words_stand_for_its_picture(
    session_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tracked(session_path, "good", "lost")
    session = load_session(session_path)
    with open_video_of(session, session_path) as video:
        subject, whole = subject_of(session, session_path, video.info), video.frame

        def lost(frame: int) -> Any:
            if frame in (2, 4):
                raise MissingFrame(f"Frame {frame} is missing.")
            return whole(frame)

        there = pictures_section(subject, video)
        monkeypatch.setattr(video, "frame", lost)
        gone = pictures_section(subject, video)
    assert (there.count("<img"), gone.count("<img")) == (4, 2)
    assert "has lost" not in there
    assert "The video has lost this frame." in gone
    assert "The video has lost frame 2." in gone
    assert re.search(r"<figcaption><b>Frame 2</b><span>0.07 s</span>.*?Lost", there)
    assert "left out" not in there


def test_after_the_last_keyframe_of_surfaces_it_is_so_far_to_the_end(tmp_path: Path) -> None:
    path = surface_cases.write_session(tmp_path / "arms", 5, (1, 3))
    words = [" ".join(caption.split()) for caption in pictured(path)]
    assert [w.split(" s ", 1)[1] for w in words] == ["2 to the next", "1 to the end"]


def test_what_is_in_doubt_is_shown_at_its_frame_or_in_its_middle_the_lost_first(
    session_path: Path,
) -> None:
    subject = subject_of(load_session(session_path), session_path)

    def looks(*judged: tuple[str, int | None]) -> list[tuple[Span, int]]:
        spans: list[Span] = [(0, 4), (4, 9)]
        tracks = (SimpleNamespace(kind=kind, go=go) for kind, go in judged)
        fitting: Any = dict(zip(spans, tracks, strict=True))
        return reporting._doubtful(replace(subject, fitting=fitting))

    assert looks(("good", None), ("good", 5)) == []
    assert looks(("check", 1), ("lost", 7)) == [((4, 9), 7), ((0, 4), 1)]
    assert looks(("check", None), ("check", None)) == [((0, 4), 2), ((4, 9), 6)]
    assert looks(("check", 0), ("good", 5)) == [((0, 4), 0)]


def test_of_many_keyframes_some_are_shown_evenly_and_the_rest_is_counted(
    session_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert reporting._evenly((3, 5, 9), 3) == (3, 5, 9)
    assert reporting._evenly(tuple(range(0, 50, 10)), 3) == (0, 20, 40)
    assert reporting._evenly(tuple(range(7)), 4) == (0, 2, 4, 6)
    monkeypatch.setattr(reporting, "MOST_PICTURES", 2)
    tracked(session_path, "good", "good")
    session = load_session(session_path)
    with open_video_of(session, session_path) as video:
        page = pictures_section(subject_of(session, session_path, video.info), video)
    assert len(captions(page)) == 2
    assert "1 more keyframes are left out here." in page


# --- the charts


def hatched(observability: list[float], path: Path) -> list[tuple[str, str]]:
    """Place and title of the hatching for one segment that is seen so, step by step."""
    subject = tracked(path, "good", "good")
    values = np.tile(np.array(observability)[:, None], (1, cases.SKELETON.part_count))
    first = measured(subject.fitting[0, 4], observability=values[:4])
    last = measured(subject.fitting[4, 8], observability=values[4:])
    page = over_time(replace(subject, fitting={(0, 4): first, (4, 8): last}))
    row = page.split('class="row lanerow"')[1]
    return re.findall(r'<i class="hidden" style="(.*?)" title="Hidden (.*?)"', row)


SEEN = 0.9
HIDDEN = 0.05


@pytest.mark.parametrize(
    ("steps", "hatching"),
    [
        ([SEEN] * 8, []),
        # a frame is hatched by half a frame to both sides, as far as the chart goes
        ([HIDDEN] * 8, [("left:0.00%;width:100.00%", "0–8")]),
        ([HIDDEN] * 2 + [SEEN] * 6, [("left:0.00%;width:18.75%", "0–1")]),
        ([SEEN] * 2 + [HIDDEN] * 2 + [SEEN] * 4, [("left:31.25%;width:12.50%", "3–3")]),
        ([SEEN] * 6 + [HIDDEN] * 2, [("left:81.25%;width:18.75%", "7–8")]),
    ],
)
def test_hatching_lies_over_the_frames_that_are_hidden(
    session_path: Path, steps: list[float], hatching: list[tuple[str, str]]
) -> None:
    assert hatched(steps, session_path) == hatching


def derived(path: Path) -> tuple[str, list[Derivatives]]:
    """What the report says of derivatives, and its figures."""
    subject = tracked(path, "good", "good")
    return str(derivatives_section(subject)), derivatives(subject)


def test_speeds_are_those_of_the_filtered_motion_and_the_report_says_so(
    session_path: Path,
) -> None:
    words, found = derived(session_path)
    assert (
        "low-pass filtered at 6 Hz (Butterworth, fourth order, without delay, 3 dB down there)"
        in words
    )
    assert "the poses themselves are not filtered" in words
    assert [one.part for one in found] == ["trunk", "right_arm", "left_hand"]
    subject = tracked(session_path, "good", "good")
    times_s = np.array([subject.time_s(frame) for frame in range(9)])
    tracks = Tracks.of(list(subject.fitting.values()), subject.skeleton)
    recording = Recording.of(subject.session, tracks, [], times_s)
    ps = low_passed(recording, 6.0).ps_camera_joint[:, 0]
    rate = recording.frames_per_second
    np.testing.assert_allclose(
        found[0].speed[1:-1], np.linalg.norm(ps[2:] - ps[:-2], axis=-1) * rate / 2
    )
    np.testing.assert_allclose(
        found[0].acceleration[1:-1],
        np.linalg.norm(ps[2:] - 2 * ps[1:-1] + ps[:-2], axis=-1) * rate**2,
    )


def test_where_the_film_is_too_slow_to_be_filtered_the_report_says_why(
    session_path: Path,
) -> None:
    def slower(data: dict[str, Any]) -> None:
        for keyframe in data["keyframes"]:
            keyframe["time_s"] = keyframe["frame"] / 10

    tracked(session_path, "good", "good")
    cases.altered(session_path, slower)
    subject = subject_of(load_session(session_path), session_path)
    words = str(derivatives_section(subject))
    assert "A filter at 6 Hz needs more than 12 frames a second, and this film has 10" in words
