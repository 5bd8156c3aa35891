"""`keypose track`: what it writes, what it tells on the way, what Ctrl+C leaves."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from app.cli import main
from app.commands import follow
from tests.app.cli_cases import everything_in, tracker
from tests.tracker import session_cases as cases
from tracker.session.files import load_session, save_session
from tracker.session.tracking import track_session
from tracker.session.tracks import load_trajectory
from tracker.track import (
    SegmentFinished,
    TrackFinished,
)
from tracker.video import Video


def test_tracking_writes_beside_the_session(session_path: Path) -> None:
    before = load_session(session_path)
    assert main(["track", str(session_path)]) == 0
    session = load_session(session_path)
    assert session.results is not None
    assert load_trajectory(session, session_path).last_frame == 8
    assert session.model_copy(update={"results": None}) == before
    names = {path.name for path in session_path.parent.iterdir()}
    assert names == {"frames", "session.json", "session.json.previous", session.results.tracks}


def test_tracking_into_a_folder_leaves_the_session_as_it_is(
    session_path: Path, tmp_path: Path
) -> None:
    before = everything_in(session_path.parent)
    assert main(["track", str(session_path), "--out", str(tmp_path / "new" / "try")]) == 0
    assert everything_in(session_path.parent) == before
    moved = tmp_path / "new" / "try" / "session.json"
    session = load_session(moved)
    assert session.video.path == "../../job/frames"
    assert load_trajectory(session, moved).last_frame == 8
    assert main(["shot", str(moved), "--frame", "2", "--out", str(tmp_path / "a.png")]) == 0


def test_an_absolute_path_of_the_video_stays(session_path: Path, tmp_path: Path) -> None:
    frames = str(session_path.parent / "frames")
    cases.altered(session_path, lambda data: data["video"].update(path=frames))
    assert main(["track", str(session_path), "--out", str(tmp_path / "try")]) == 0
    assert load_session(tmp_path / "try" / "session.json").video.path == frames


def test_method_and_quality_are_of_this_run_only(session_path: Path) -> None:
    command = ["track", str(session_path), "--method", "paper", "--quality", "preview"]
    assert main(command) == 0
    session = load_session(session_path)
    assert session.results is not None
    assert (session.results.method, session.results.quality) == ("paper", "preview")
    assert (session.settings.method, session.settings.quality) == ("keypose", "fast")


def test_edits_made_while_tracking_are_kept(
    session_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def track(*given: Any, **more: Any) -> Iterator[Any]:
        yield from tracker()(*given, **more)
        edited = load_session(session_path)
        save_session(edited.model_copy(update={"keyframes": edited.keyframes[:2]}), session_path)

    def late(*given: Any, **more: Any) -> Iterator[Any]:
        events = list(track(*given, **more))
        yield from events

    monkeypatch.setattr(follow, "track_session", late)
    assert main(["track", str(session_path)]) == 0
    session = load_session(session_path)
    assert len(session.keyframes) == 2
    assert session.results is not None


def test_a_lost_segment_gives_exit_code_1(
    session_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(follow, "track_session", tracker(("good", "lost")))
    assert main(["track", str(session_path)]) == 1
    assert "frames 4–8: lost: add a keyframe near 2" in capsys.readouterr().out
    assert load_session(session_path).results is not None


def test_ctrl_c_keeps_the_finished_segments(
    session_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(follow, "track_session", tracker(stop_after=1))
    assert main(["track", str(session_path)]) == 130
    assert load_trajectory(load_session(session_path), session_path).last_frame == 4
    assert "Interrupted: 1 of 2 segments are kept." in capsys.readouterr().err


def test_ctrl_c_before_the_first_segment_changes_nothing(
    session_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = everything_in(session_path.parent)
    monkeypatch.setattr(follow, "track_session", tracker(stop_after=0))
    assert main(["track", str(session_path)]) == 130
    assert everything_in(session_path.parent) == before


def test_a_log_gets_one_line_per_segment(
    session_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    main(["track", str(session_path)])
    out, err = capsys.readouterr()
    assert err.splitlines() == [
        "segment 1 of 2, frames 0–4: good",
        "segment 2 of 2, frames 4–8: good",
    ]
    assert out.splitlines()[:2] == ["frames 0–4: good", "frames 4–8: good"]


def test_a_terminal_gets_a_bar(
    session_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    assert main(["track", str(session_path)]) == 0
    assert "8/8" in capsys.readouterr().err


def test_json_of_tracking_is_lines_of_events_and_a_summary(
    session_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["track", str(session_path), "--json"]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    events = [json.loads(line, parse_constant=pytest.fail) for line in out.splitlines()]
    segment = ["segment_started", "pass_finished", "segment_finished"]
    assert [event["event"] for event in events] == [*segment, *segment, "finished"]
    assert events[-1]["session"] == str(session_path)
    assert Path(events[-1]["tracks"]).is_file()
    assert [s["verdict"] for s in events[-1]["segments"]] == ["good", "good"]
    assert events[-1]["segments"][0]["scores"] == [3.0, 2.0, None]


def test_the_real_tracker_follows_the_contract(session_path: Path) -> None:
    with Video.open(session_path.parent / "frames") as video:
        events = list(track_session(load_session(session_path), video))
    assert isinstance(events[-1], TrackFinished)
    assert [s.trajectory.first_frame for s in events[-1].result.segments] == [0, 4]
    finished = [event for event in events if isinstance(event, SegmentFinished)]
    assert sorted(event.index for event in finished) == [0, 1]
