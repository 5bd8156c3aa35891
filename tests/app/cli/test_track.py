"""`keypose track`: what it writes, what it tells on the way, what Ctrl+C leaves."""

from __future__ import annotations

import json
import signal
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from threading import Event
from typing import Any

import pytest

from keypose.app.cli import follow
from keypose.app.cli.main import main
from keypose.app.document.folder_lock import NAME
from keypose.tracker.errors import VideoError
from keypose.tracker.session import Session
from keypose.tracker.storage.files import load_session, save_session
from keypose.tracker.storage.outdated import outdated_words
from keypose.tracker.storage.tracks import load_trajectory
from tests.app.cli_cases import everything_in, refused, tracker
from tests.app.document.test_folder_lock import holder
from tests.app.jobs.job_cases import segment_done, segments
from tests.tracker import session_cases as cases


def test_tracking_writes_beside_the_session(session_path: Path) -> None:
    before = load_session(session_path)
    assert main(["track", str(session_path)]) == 0
    session = load_session(session_path)
    assert session.subject.results is not None
    assert load_trajectory(session, session_path).last_frame == 8
    assert session.changed({"results": None}) == before
    names = {path.name for path in session_path.parent.iterdir()}
    written = {"session.json", "session.json.previous", session.subject.results.tracks}
    assert names == {"frames", NAME, *written}


def test_tracking_into_a_folder_leaves_the_session_as_it_is(
    session_path: Path, tmp_path: Path
) -> None:
    before = everything_in(session_path.parent)
    assert main(["track", str(session_path), "--out", str(tmp_path / "new" / "try")]) == 0
    assert everything_in(session_path.parent) == before
    moved = tmp_path / "new" / "try" / "session.json"
    session = load_session(moved)
    assert session.view.video.path == "../../job/frames"
    assert load_trajectory(session, moved).last_frame == 8
    assert main(["shot", str(moved), "--frame", "2", "--out", str(tmp_path / "a.png")]) == 0


def test_an_absolute_path_of_the_video_stays(session_path: Path, tmp_path: Path) -> None:
    frames = str(session_path.parent / "frames")
    cases.altered(session_path, lambda data: data["video"].update(path=frames))
    assert main(["track", str(session_path), "--out", str(tmp_path / "try")]) == 0
    assert load_session(tmp_path / "try" / "session.json").view.video.path == frames


def test_a_session_that_is_open_in_the_page_is_left_alone_and_a_copy_offered(
    session_path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder, copy = session_path.parent, tmp_path / "copy"
    with holder(folder) as page:
        sentence = refused(capsys, folder, ["track", session_path])
        assert f"is open in another Keypose (pid {page.pid})" in sentence
        assert "--out DIR" in sentence
        assert main(["track", str(session_path), "--out", str(copy)]) == 0
    with holder(copy):
        capsys.readouterr()
        again: list[str | Path] = ["track", session_path, "--out", copy, "--overwrite"]
        assert "choose another --out" in refused(capsys, copy, again)
    assert main(["track", str(session_path)]) == 0


@pytest.mark.parametrize(
    ("frames", "spans"),
    [("5-6", [(4, 8)]), ("4-9", [(4, 8)]), ("4-4", [(0, 4), (4, 8)]), ("3-5", [(0, 4), (4, 8)])],
)
def test_only_segments_between_two_frames_are_tracked(
    session_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    frames: str,
    spans: list[tuple[int, int]],
) -> None:
    monkeypatch.setattr(follow, "rerun", tracker(("good",) * len(spans)))
    assert main(["track", str(session_path), "--frames", frames, "--json"]) == 0
    assert json.loads(capsys.readouterr().out.splitlines()[-1])["segments_of"] == len(spans)
    results = load_session(session_path).subject.results
    assert results is not None
    assert [(one.first_frame, one.last_frame) for one in results.segments] == spans


def test_frames_without_a_segment_are_refused(
    session_path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    beyond: list[str | Path] = ["track", session_path, "--frames", "20-30"]
    words = "No segment reaches between frames 20 and 30: they go from 0 to 8."
    assert words in refused(capsys, tmp_path, beyond)
    ahead: list[str | Path] = ["track", session_path, "--frames", "0-4", "--ahead", "forward"]
    assert "--frames is for segments" in refused(capsys, tmp_path, ahead)


def test_method_and_quality_are_of_this_run_only(session_path: Path) -> None:
    command = ["track", str(session_path), "--method", "paper", "--quality", "preview"]
    assert main(command) == 0
    session = load_session(session_path)
    assert session.subject.results is not None
    assert (session.subject.results.method, session.subject.results.quality) == ("paper", "preview")
    assert (session.settings.method, session.settings.quality) == ("keypose", "full")


def test_a_camera_that_was_found_to_stand_still_is_said_and_may_be_undone(
    session_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    cases.altered(session_path, lambda data: data["settings"].update(static_camera=None))
    cases.altered(session_path, lambda data: data["video"].update(stands_still=True))
    assert main(["track", str(session_path)]) == 0
    assert "The camera stands still: found by itself." in capsys.readouterr().err
    assert main(["track", str(session_path), "--static-camera", "no"]) == 0
    assert "found by itself" not in capsys.readouterr().err
    assert load_session(session_path).settings.static_camera is None


def test_the_start_and_what_is_left_out_are_of_this_run_only(
    session_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[Session] = []

    def track(session: Session, *given: Any, **more: Any) -> Iterator[Any]:
        asked.append(session)
        yield from tracker()(session, *given, **more)

    monkeypatch.setattr(follow, "rerun", track)
    before = load_session(session_path).settings
    parts = load_session(session_path).subject.body.names
    command = ["track", str(session_path), "--initial", "templates"]
    assert main([*command, "--leave-out", parts[0], "--leave-out", parts[-1]]) == 0
    assert asked[0].settings.initial == "templates"
    assert asked[0].settings.left_out == (parts[0], parts[-1])
    assert load_session(session_path).settings == before
    assert main(["track", str(session_path)]) == 0
    assert asked[1].settings == before
    assert main(["track", str(session_path), "--cues", "keypoints, brightness"]) == 0
    assert asked[2].settings.cues == ("brightness", "keypoints")
    assert main(["track", str(session_path), "--cues", "brightness"]) == 0
    assert asked[3].settings.cues == ("brightness",)
    assert main(["track", str(session_path), "--cues", "silhouette,brightness"]) == 0
    assert asked[4].settings.cues == ("brightness", "silhouette")


def test_that_settings_of_one_run_make_the_motion_out_of_date_is_said(
    session_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(follow, "rerun", tracker())
    silhouettes = ["--static-camera", "yes", "--cues", "brightness,silhouette"]
    for more, own in ((silhouettes, "static camera"), (["--quality", "preview"], "")):
        assert main(["track", str(session_path), *more]) == 0
        words = f"the session keeps its own {own}: for these the motion is out of date already"
        assert (words in capsys.readouterr().err) == bool(own), more


@pytest.mark.parametrize("still", ["yes", "no"])
def test_that_a_camera_that_moves_shows_no_silhouette_is_reported_once_it_is_asked_for(
    still: str,
    session_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(follow, "rerun", tracker())
    command = ["track", str(session_path), "--static-camera", still]
    assert main([*command, "--cues", "brightness,silhouette"]) == 0
    assert ("the silhouette is left out" in capsys.readouterr().err) == (still == "no")
    assert main([*command, "--cues", "brightness"]) == 0
    assert "silhouette" not in capsys.readouterr().err


def test_a_silhouette_alone_is_refused_since_it_finds_no_motion(
    session_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = refused(capsys, session_path.parent, ["track", session_path, "--cues", "silhouette"])
    assert "add brightness or keypoints" in words


@pytest.mark.parametrize("cues", ["", "shadow", "brightness,"])
def test_a_cue_that_is_none_is_refused_with_those_there_are(
    cues: str, session_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = refused(capsys, session_path.parent, ["track", session_path, "--cues", cues])
    assert "choose from brightness, keypoints" in words


def test_what_could_not_be_done_as_wished_is_reported_of_its_segment(
    session_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    note = "left hand lost at frame 5: interpolated instead"

    def track(*given: Any, **more: Any) -> Iterator[Any]:
        for report in tracker()(*given, **more):
            for result in segments([report]):
                notes = (note,) if result.first == 4 else ()
                report = segment_done(1, replace(result, notes=notes))
            yield report

    monkeypatch.setattr(follow, "rerun", track)
    assert main(["track", str(session_path)]) == 0
    lines = capsys.readouterr().out.splitlines()
    (place,) = [i for i, line in enumerate(lines) if note in line]
    assert lines[place - 1].startswith("frames 4–8")
    assert main(["track", str(session_path), "--json"]) == 0
    events = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    finished = [e["notes"] for e in events if e["event"] == "segment_finished"]
    assert finished == [[], [note]]
    assert [segment["notes"] for segment in events[-1]["segments"]] == [[], [note]]


def test_leaving_out_a_part_that_is_not_there_names_those_that_are(
    session_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = session_path.parent
    sentence = refused(capsys, folder, ["track", session_path, "--leave-out", "third_hand"])
    assert "no part 'third_hand'" in sentence
    assert load_session(session_path).subject.body.names[0] in sentence


def test_an_unknown_start_is_refused_with_those_that_are_known(
    session_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sentence = refused(capsys, session_path.parent, ["track", session_path, "--initial", "magic"])
    assert "templates" in sentence


def test_edits_made_while_tracking_are_kept(
    session_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def track(*given: Any, **more: Any) -> Iterator[Any]:
        yield from tracker()(*given, **more)
        edited = load_session(session_path)
        save_session(edited.changed({"keyframes": edited.subject.keyframes[:2]}), session_path)

    monkeypatch.setattr(follow, "rerun", track)
    assert main(["track", str(session_path)]) == 0
    session = load_session(session_path)
    assert len(session.subject.keyframes) == 2
    assert session.subject.results is not None


def test_a_lost_segment_gives_exit_code_1(
    session_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(follow, "rerun", tracker(("good", "lost")))
    assert main(["track", str(session_path)]) == 1
    assert "frames 4–8: lost: add a keyframe near 2" in capsys.readouterr().out
    assert load_session(session_path).subject.results is not None


def test_ctrl_c_keeps_the_finished_segments(
    session_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(follow, "rerun", tracker(stop_after=1))
    assert main(["track", str(session_path)]) == 130
    assert load_trajectory(load_session(session_path), session_path).last_frame == 4
    assert "Interrupted: 1 of 2 segments are kept." in capsys.readouterr().err


def test_the_first_ctrl_c_asks_the_tracker_for_all_it_has_finished(
    session_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def track(*given: Any, stop: Event, **more: Any) -> Iterator[Any]:
        assert not stop.is_set()
        signal.raise_signal(signal.SIGINT)
        assert stop.is_set()
        yield from tracker()(*given, stop=stop, **more)  # finished while it came to rest

    monkeypatch.setattr(follow, "rerun", track)
    before = signal.getsignal(signal.SIGINT)
    assert main(["track", str(session_path)]) == 130
    assert signal.getsignal(signal.SIGINT) is before
    assert load_trajectory(load_session(session_path), session_path).last_frame == 8


def test_sigterm_keeps_what_is_finished_as_ctrl_c_does(
    session_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def track(*given: Any, stop: Event, **more: Any) -> Iterator[Any]:
        signal.raise_signal(signal.SIGTERM)
        assert stop.is_set()
        yield from tracker()(*given, stop=stop, **more)

    monkeypatch.setattr(follow, "rerun", track)
    before = signal.getsignal(signal.SIGTERM)
    assert main(["track", str(session_path)]) == 130
    assert signal.getsignal(signal.SIGTERM) is before
    assert load_trajectory(load_session(session_path), session_path).last_frame == 8


def test_sigterm_is_handled_where_ctrl_c_is_ignored(
    session_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(follow, "rerun", tracker(stop_after=1, number=signal.SIGTERM))
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        assert main(["track", str(session_path)]) == 130
    finally:
        signal.signal(signal.SIGINT, before)
    assert load_trajectory(load_session(session_path), session_path).last_frame == 4


def test_a_second_ctrl_c_ends_the_run_at_once_and_keeps_what_was_reported(
    session_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(follow, "rerun", tracker(stop_after=1, stops=2))
    before = signal.getsignal(signal.SIGINT)
    assert main(["track", str(session_path)]) == 130
    assert signal.getsignal(signal.SIGINT) is before
    assert load_trajectory(load_session(session_path), session_path).last_frame == 4


def test_whoever_ignores_ctrl_c_goes_on_ignoring_it(
    session_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def track(*given: Any, stop: Event, **more: Any) -> Iterator[Any]:
        signal.raise_signal(signal.SIGINT)
        assert not stop.is_set()
        yield from tracker()(*given, stop=stop, **more)

    monkeypatch.setattr(follow, "rerun", track)
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        assert main(["track", str(session_path)]) == 0
        assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGINT, before)


def test_an_error_midway_is_reported_after_the_finished_segments_are_written(
    session_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    broken = tracker(stop_after=1, error=VideoError("Frame 6 is gone."))
    monkeypatch.setattr(follow, "rerun", broken)
    assert main(["track", str(session_path), "--json"]) == 2
    out, err = capsys.readouterr()
    assert err == "Frame 6 is gone.\n"
    assert json.loads(out.splitlines()[-1])["error"] == "Frame 6 is gone."
    assert load_trajectory(load_session(session_path), session_path).last_frame == 4


def test_an_error_before_the_first_segment_changes_nothing(
    session_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    broken = tracker(stop_after=0, error=VideoError("Frame 1 is gone."))
    monkeypatch.setattr(follow, "rerun", broken)
    assert "Frame 1 is gone." in refused(capsys, session_path.parent, ["track", session_path])


def test_what_changed_while_tracking_leaves_the_results_out_of_date(
    session_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def track(*given: Any, **more: Any) -> Iterator[Any]:
        cases.altered(session_path, lambda data: data["camera"].update(fx=70.0))
        yield from tracker()(*given, **more)

    monkeypatch.setattr(follow, "rerun", track)
    assert main(["track", str(session_path)]) == 0
    session = load_session(session_path)
    assert session.view.camera.fx == 70.0
    words = outdated_words(session, load_trajectory(session, session_path))
    assert words is not None
    assert "camera" in words


@pytest.mark.parametrize("at_terminal", [True, False])
def test_only_a_terminal_gets_a_hint_what_to_do_next(
    session_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    at_terminal: bool,
) -> None:
    monkeypatch.setattr(sys.stdout, "isatty", lambda: at_terminal)
    assert main(["track", str(session_path)]) == 0
    out = capsys.readouterr().out
    assert (f"Next: keypose shot {session_path}" in out) == at_terminal


def test_ctrl_c_before_the_first_segment_changes_nothing(
    session_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = everything_in(session_path.parent)
    monkeypatch.setattr(follow, "rerun", tracker(stop_after=0))
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
