"""Reports and contact sheets: whole, true to the session, and safe whatever stands in it."""

from __future__ import annotations

import base64
import re
from dataclasses import dataclass, field, replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from keypose.app.cli.main import main
from keypose.app.editor.advice import suggestion
from keypose.app.export.pictures import STATE_COLOURS, Cell, sheet, sheet_layout
from keypose.app.export.report.charts import over_time, score_chart
from keypose.app.export.report.markup import VOID, Html, element, joined
from keypose.app.export.report.plots import (
    MOST_COLUMNS,
    Scale,
    area,
    curve,
    nice_ticks,
    runs,
    steps,
)
from keypose.app.export.report.report import report_html, segments_table, subject_of, thumbnail
from keypose.app.export.report.tables import keyframes_table
from keypose.app.render.palette import PAPER
from keypose.tracker.session.annotations import Note
from keypose.tracker.session.verdict import Verdict
from keypose.tracker.storage.files import load_session, open_video_of, save_session
from keypose.tracker.storage.fingerprints import setup_hash
from keypose.tracker.storage.tracks import save_result
from tests.app import surface_cases
from tests.app.cli_cases import refused
from tests.app.results_cases import judged
from tests.tracker import session_cases as cases

EVIL = "</title><script>alert(1)</script>\"'&<img src=x onerror=alert(2)>"


@dataclass
class Found(HTMLParser):
    """What a browser would make of a page; unbalanced elements are a failure."""

    open: list[str] = field(default_factory=list)
    tags: list[tuple[str, dict[str, str | None]]] = field(default_factory=list)
    words: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        super().__init__()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open and self.open[-1] != "style":
            self.words.append(data)

    @property
    def text(self) -> str:
        return " ".join(" ".join(self.words).split())


def read(page: bytes | str) -> Found:
    found = Found()
    found.feed(page.decode() if isinstance(page, bytes) else page)
    found.close()
    assert found.open == []
    return found


def report_of(path: Path) -> bytes:
    session = load_session(path)
    with open_video_of(session, path) as video:
        return report_html(session, path, video)


@pytest.fixture
def doubtful_path(session_path: Path) -> Path:
    """Tracked, its second segment lost at frame 6."""
    session = load_session(session_path)
    good, lost = cases.segment(0, 4), cases.segment(4, 8, "lost")
    verdict = Verdict.not_followed(6)
    lost = type(lost)(**{**vars(lost), "verdict": verdict})
    save_session(save_result(session, session_path, cases.result(good, lost)), session_path)
    return session_path


def test_a_report_gives_every_segment_and_keyframe(doubtful_path: Path) -> None:
    text = read(report_of(doubtful_path)).text
    subject = subject_of(load_session(doubtful_path), doubtful_path)
    advice = suggestion(subject.keys, cases.FRAMES, subject.fitting, cases.body().names)
    for words in (
        "2 segments: 1 good, 1 lost.",
        advice.title,
        "Lost. Add a keyframe at 6",
        "9 frames, 3 keyframes",
        "mean 4.0",
        "64 × 48 pixels",
        "best 2.00",
        "Left hand",
        "Left arm",
    ):
        assert words in text
    assert "job" in text


def test_a_report_needs_nothing_from_elsewhere_and_runs_nothing(doubtful_path: Path) -> None:
    page = report_of(doubtful_path)
    found = read(page)
    assert not [tag for tag, _ in found.tags if tag in ("script", "link", "iframe", "object", "a")]
    for _, attributes in found.tags:
        for name, value in attributes.items():
            assert not name.startswith("on")
            if name in ("src", "href", "srcset", "data", "action"):
                assert (value or "").startswith("data:")
    style = page.decode().split("<style>")[1].split("</style>")[0]
    assert "@import" not in style
    assert re.findall(r"url\(.(?!data:)", style) == []
    policies = [a["content"] for tag, a in found.tags if a.get("http-equiv")]
    assert policies == [
        "default-src 'none'; img-src data:; font-src data:; style-src 'unsafe-inline'"
    ]


def test_light_dark_and_paper_have_their_colours(doubtful_path: Path) -> None:
    style = report_of(doubtful_path).decode().split("<style>")[1].split("</style>")[0]
    dark, light = re.findall(r":root ?\{([^}]*)\}", style)[:2]
    assert "--bg1: #191b1f" in dark
    assert "--bg1: #f4f5f7" in light
    assert "@media print, not (prefers-color-scheme: dark){:root" in style.replace("\n", "")
    assert style.count("{") == style.count("}")


def test_names_from_files_stay_words(doubtful_path: Path, tmp_path: Path) -> None:
    session = load_session(doubtful_path)
    body = session.subject.body.model_copy(update={"name": EVIL})
    results = session.subject.results
    assert results is not None
    lost = results.segments[1].model_copy(
        update={"verdict": Verdict(kind="lost", cause="other", text=EVIL)}
    )
    hashed = setup_hash(session.changed({"body": body}))
    segments = (results.segments[0], lost)
    results = results.model_copy(update={"segments": segments, "tracked_for": hashed})
    video = session.view.video.model_copy(update={"path": EVIL.replace("/", "\\")})
    changed = {"body": body, "results": results, "video": video}
    place = tmp_path / "<b onclick=x>'\"&" / "session.json"
    place.parent.mkdir()
    tracks = doubtful_path.parent / results.tracks
    (place.parent / tracks.name).write_bytes(tracks.read_bytes())
    page = report_html(session.changed(changed), place)
    found = read(page)
    assert {tag for tag, _ in found.tags}.isdisjoint({"script", "b onclick=x", "img"})
    assert not [name for _, a in found.tags for name in a if name.startswith("on")]
    assert found.text.count(EVIL) >= 2  # body and verdict
    assert "<b onclick=x>'\"&" in found.text


def test_notes_are_in_the_report_as_they_were_written(session_path: Path) -> None:
    session = load_session(session_path)
    assert "Notes" not in read(report_of(session_path)).words
    notes = (Note(frame=1, text=EVIL), Note(frame=2))
    save_session(session.changed({"notes": notes}), session_path)
    found = read(report_of(session_path))
    assert "Notes" in found.words
    assert EVIL in found.text
    assert "Flag" in found.words
    assert not [tag for tag, _ in found.tags if tag == "script"]


def test_markup_escapes_all_but_markup() -> None:
    assert element("p", "<&>\"'", title="\"'<") == (
        '<p title="&quot;&#x27;&lt;">&lt;&amp;&gt;&quot;&#x27;</p>'
    )
    assert element("p", Html("<b/>"), None, class_=None) == "<p><b/></p>"
    assert joined(["<", element("i", "x")]) == "&lt;<i>x</i>"
    assert element("path", d="M0 0", stroke_width=1.50) == '<path d="M0 0" stroke-width="1.5"/>'
    assert element("p", "a\x00\x1b\ud800b\n") == "<p>a���b\n</p>"
    assert "img" in VOID


def test_a_session_that_is_not_tracked_has_a_report(session_path: Path) -> None:
    text = read(report_of(session_path)).text
    assert "2 segments: 2 not tracked." in text
    assert "2 segments need tracking." in text


@pytest.mark.parametrize("keep", [0, 1])
def test_a_session_with_few_keyframes_has_a_report(session_path: Path, keep: int) -> None:
    cases.altered(session_path, lambda data: data.update(keyframes=data["keyframes"][:keep]))
    text = read(report_of(session_path)).text
    assert "Two keyframes make the first segment" in text


def _key_hand_alone(path: Path) -> None:
    """At frame 6, amid the second segment."""

    def change(data: dict[str, Any]) -> None:
        pose = {**data["keyframes"][1], "frame": 6, "time_s": 6 / 25}
        data["part_keyframes"] = [{**pose, "parts": ["left_hand"]}]

    cases.altered(path, change)


def test_limbs_keyed_alone_are_reported_and_outdate_what_was_tracked(doubtful_path: Path) -> None:
    _key_hand_alone(doubtful_path)
    text = read(report_of(doubtful_path)).text
    assert "Limbs keyed alone, the rest of the body tracked: at 6 (left hand)." in text
    assert "9 frames, 3 keyframes" in text


def test_a_damaged_motion_is_reported_and_the_keyframes_are_shown(doubtful_path: Path) -> None:
    for file in doubtful_path.parent.glob("tracks-*.npz"):
        file.write_bytes(file.read_bytes()[:-50])
    found = read(report_of(doubtful_path))
    assert "is damaged" in found.text
    assert sum(tag == "img" for tag, _ in found.tags) == len(cases.KEYFRAMES)


def test_a_motion_of_other_keyframes_is_reported_to_be_outdated(doubtful_path: Path) -> None:
    cases.altered(doubtful_path, lambda data: data["keyframes"][2].update(root_m=[0.3, -0.05, 3.2]))
    text = read(report_of(doubtful_path)).text
    assert "Outdated" in text
    assert "The tracked motion is out of date" in text


def test_the_pictures_are_the_keyframes_and_the_frame_to_look_at(doubtful_path: Path) -> None:
    found = read(report_of(doubtful_path))
    pictures = [attributes for tag, attributes in found.tags if tag == "img"]
    assert [a["alt"] for a in pictures] == [
        f"Frame {frame} with the body" for frame in (6, *cases.KEYFRAMES)
    ]
    for attributes in pictures:
        kind, content = (attributes["src"] or "").split(",")
        assert kind == "data:image/jpeg;base64"
        decoded = cv2.imdecode(np.frombuffer(base64.b64decode(content), np.uint8), cv2.IMREAD_COLOR)
        assert decoded is not None
        size = (int(attributes["width"] or 0), int(attributes["height"] or 0))
        assert decoded.shape[1::-1] == size


def test_a_thumbnail_is_as_wide_as_asked_for_and_there_is_none_without_a_pose(
    session_path: Path,
) -> None:
    session = load_session(session_path)
    with open_video_of(session, session_path) as video:
        subject = subject_of(session, session_path, video.info)
        small = thumbnail(subject, video, 4, 32)
        assert small is not None
        assert 'width="32" height="24"' in small
        assert thumbnail(subject, video, 3) is None
    assert thumbnail(subject, None, 4) is None


def test_tables_say_times_from_the_keyframes_where_the_video_is_not_at_hand(
    doubtful_path: Path,
) -> None:
    subject = subject_of(load_session(doubtful_path), doubtful_path)
    assert "0.16–0.32" in read(segments_table(subject)).text
    assert read(keyframes_table(subject)).text.endswith("9 frames, 3 keyframes mean 4.0 0.16")
    assert subject.time_s(6) == pytest.approx(0.24)


def test_hidden_stretches_are_hatched_where_they_are(session_path: Path) -> None:
    session = load_session(session_path)
    seen = cases.segment(0, 4)
    observability = seen.diagnostics.observability.copy()
    observability[1:3, 2:] = 0.05  # steps 1 and 2: about frames 1 to 3
    hidden = replace(seen, diagnostics=replace(seen.diagnostics, observability=observability))
    result = cases.result(hidden, cases.segment(4, 8))
    save_session(save_result(session, session_path, result), session_path)
    subject = subject_of(load_session(session_path), session_path)
    found = read(over_time(subject))
    titles = [a["title"] for _, a in found.tags if a.get("class") == "hidden"]
    assert titles == ["Hidden 1–3"]
    assert "Rank of every step, 7 at least of 8 degrees of freedom" in found.text


def test_the_score_chart_marks_the_best_pass_and_skips_what_was_not_scored() -> None:
    track = judged(0, 4)
    track = type(track)(**{**vars(track), "scores": (4.0, np.nan, 1.0, 2.0), "best_pass": 2})
    found = read(score_chart(track))
    assert "Error per pass of segment 0–4: 1: 4, 3: 1, 4: 2" in found.text
    paths = {a["class"]: a["d"] for tag, a in found.tags if tag == "path"}
    assert (paths["dots good"] or "").count("M") == 3
    assert (paths["dots best good"] or "").count("M") == 1
    nothing = type(track)(**{**vars(track), "scores": (np.nan,), "best_pass": 0})
    assert "No pass has an error that is known" in read(score_chart(nothing)).text


@pytest.mark.parametrize("best", [-7, -1, 99])
def test_a_best_pass_that_is_not_there_is_no_figure(doubtful_path: Path, best: int) -> None:
    cases.altered(doubtful_path, lambda data: data["results"]["segments"][0].update(best_pass=best))
    found = read(report_of(doubtful_path))
    paths = [a.get("class") for tag, a in found.tags if tag == "path"]
    assert paths.count("dots good") == paths.count("score good") == 1
    assert "dots best good" not in paths


def test_a_body_of_which_nothing_is_tracked_has_a_report(session_path: Path) -> None:
    session = load_session(session_path)
    parts = tuple(part.model_copy(update={"tracked": ()}) for part in session.subject.body.parts)
    still = session.changed({"body": session.subject.body.model_copy(update={"parts": parts})})
    with open_video_of(session, session_path) as video:
        assert "2 not tracked" in read(report_html(still, session_path, video)).text


def test_a_curve_goes_through_its_values_and_breaks_where_there_are_none() -> None:
    scale = Scale(10, 14, 0.0, 2.0)
    values = np.array([0.0, 1.0, np.nan, 2.0, 5.0])
    assert curve(values, 10, scale) == "M0.0 100.0L250.0 50.0M750.0 0.0L1000.0 0.0"
    assert steps(np.array([1.0, 2.0]), 10, scale) == "M0.0 50.0H250.0L250.0 0.0H500.0"
    assert area(values[:1], 10, scale).endswith("V100Z")
    assert curve(np.full(3, np.nan), 10, scale) == ""


def test_a_long_curve_keeps_its_peaks_in_few_columns() -> None:
    values = np.zeros(200_000)
    values[123_456] = 7.0
    (run,) = runs(values, 0)
    assert len(run) <= MOST_COLUMNS
    assert next(c for c in run if c.high == 7.0).first <= 123_456


def test_ticks_are_round_and_few() -> None:
    assert list(nice_ticks(0, 60, 12)) == [0, 10, 20, 30, 40, 50, 60]
    assert list(nice_ticks(13, 61, 6)) == [20, 30, 40, 50, 60]
    assert len(nice_ticks(0, 99_999_999, 12)) <= 12
    assert list(nice_ticks(3, 3, 12)) == [3]


# == the commands ==


@pytest.mark.parametrize("command", ["report", "sheet"])
def test_a_file_is_written_and_not_overwritten_unless_asked(
    doubtful_path: Path, tmp_path: Path, command: str, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / {"report": "a.html", "sheet": "a.png"}[command]
    arguments: list[str | Path] = [command, doubtful_path, "--out", out]
    assert main([*map(str, arguments), "--json"]) == 0
    assert str(out) in capsys.readouterr().out
    assert "exists already" in refused(capsys, tmp_path, arguments)
    assert main([*map(str, arguments), "--overwrite"]) == 0
    capsys.readouterr()
    wrong = [command, doubtful_path, "--out", tmp_path / "a.txt"]
    assert "must end in" in refused(capsys, tmp_path, wrong)


def test_a_report_without_the_video_says_so(
    doubtful_path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (doubtful_path.parent / "frames").rename(tmp_path / "elsewhere")
    out = tmp_path / "a.html"
    assert main(["report", str(doubtful_path), "--out", str(out)]) == 0
    assert "the video is missing" in capsys.readouterr().err
    found = read(out.read_bytes())
    assert "video not at hand" in found.text
    assert not [tag for tag, _ in found.tags if tag == "img"]


def test_a_sheet_shows_every_keyframe_over_the_colour_of_what_follows(
    doubtful_path: Path, tmp_path: Path
) -> None:
    out = tmp_path / "a.png"
    assert main(["sheet", str(doubtful_path), "--out", str(out), "--columns", "3"]) == 0
    picture = cv2.cvtColor(cv2.imread(str(out)), cv2.COLOR_BGR2RGB)  # type: ignore[arg-type]
    bars = [
        np.nonzero((picture == STATE_COLOURS[state]).all(axis=2).sum(axis=0) >= 3)[0]
        for state in ("good", "lost")
    ]
    assert all(len(bar) > 90 for bar in bars)
    assert bars[0].max() < bars[1].min()
    assert (picture[0, 0] == PAPER).all()


def test_a_sheet_shows_limbs_keyed_alone_between_the_keyframes(
    doubtful_path: Path, tmp_path: Path
) -> None:
    _key_hand_alone(doubtful_path)
    out = tmp_path / "sheet.png"
    assert main(["sheet", str(doubtful_path), "--out", str(out), "--columns", "4"]) == 0
    four = cv2.imread(str(out))
    assert (
        main(["sheet", str(doubtful_path), "--out", str(out), "--columns", "3", "--overwrite"]) == 0
    )
    three = cv2.imread(str(out))
    assert four is not None
    assert three is not None
    assert four.shape[0] < three.shape[0], "four pictures fit into one row of four"


def test_a_sheet_of_one_keyframe_that_the_video_has_lost() -> None:
    cell = Cell(None, 12, float("nan"), None, None)
    picture = sheet([cell], 1, (120, 80))
    assert (picture[10:80, 10:30] == 128).any()


@pytest.mark.parametrize("count", [1, 2, 5, 16, 61, 2000])
@pytest.mark.parametrize("aspect", [0.02, 0.56, 1.78, 50.0])
def test_sheets_of_any_number_and_shape_have_sensible_columns(count: int, aspect: float) -> None:
    columns, (width, height) = sheet_layout(count, aspect)
    assert 1 <= columns <= count
    assert 1 <= width <= 600
    assert 1 <= height <= 600
    rows = -(-count // columns)
    if count > 3 and 0.5 < aspect < 2:
        assert 0.5 < columns * width / (rows * height) < 4
    assert columns * rows * width * height < 60_000_000


def test_a_session_without_keyframes_has_no_sheet(
    session_path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    cases.altered(session_path, lambda data: data.update(keyframes=[]))
    command: list[Any] = ["sheet", session_path, "--out", tmp_path / "a.png"]
    assert "has no keyframes to draw" in refused(capsys, tmp_path, command)


# --- of surfaces


def test_of_surfaces_the_keyframes_foot_counts_all_that_is_fitted(tmp_path: Path) -> None:
    path = surface_cases.write_session(tmp_path / "arms", 5, (0, 2))
    table = keyframes_table(subject_of(load_session(path), path))
    assert read(table).text.endswith("5 frames, 2 keyframes mean 2.0 0.08")


def test_after_the_last_keyframe_of_surfaces_there_is_a_segment_and_no_next_keyframe(
    tmp_path: Path,
) -> None:
    path = surface_cases.write_session(tmp_path / "arms", 5, (0, 2))
    table = keyframes_table(subject_of(load_session(path), path))
    last = table.split("<tr>")[3].split("</tr>")[0]
    cells = re.findall(r"<t[dh][^>]*>(.*?)</t[dh]>", last)
    assert cells[:5] == ["2", "2", "0.08", "", ""]
    assert "Not tracked" in cells[5]


@pytest.mark.parametrize("of_surfaces", [False, True])
def test_a_report_says_the_same_duration_as_the_page(
    session_path: Path, tmp_path: Path, of_surfaces: bool
) -> None:
    """So many frames at a rate last that many divided by it: the last one is shown as well."""
    path = surface_cases.write_session(tmp_path / "arms", 5) if of_surfaces else session_path
    session = load_session(path)
    with open_video_of(session, path) as video:
        seconds = video.info.frame_count / video.info.fps
    assert f"{video.info.frame_count} frames, {seconds:.2f} s" in read(report_of(path)).text
