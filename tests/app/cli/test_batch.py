"""`keypose batch`: what it tells and leaves behind, how it goes on after an interruption."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from keypose.app.cli import many as command
from keypose.app.cli.main import main
from keypose.app.jobs.batch.journal import FOLDER
from keypose.app.jobs.batch.pool import News, WorkerDied
from keypose.app.jobs.batch.report import NAME
from keypose.app.jobs.batch.task import PlaceToReview, SegmentSummary, Step, Summary, Task
from keypose.tracker import warm
from keypose.tracker.errors import FormatError
from keypose.tracker.storage.files import load_session
from tests.app.cli_cases import refused
from tests.app.full_disks import fill
from tests.app.jobs.batch.batch_cases import Befalls, Here, write_sessions
from tests.app.serving import ROOT
from tests.tracker import session_cases as cases

Capture = pytest.CaptureFixture[str]


@pytest.fixture
def sessions(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[Path]:
    """Three sessions; the work is done in this process."""
    monkeypatch.setattr(warm, "is_warm", lambda *parts: True)
    meeting(monkeypatch, lambda number, task: None)
    return write_sessions(tmp_path / "all", "a", "b", "c")


def meeting(monkeypatch: pytest.MonkeyPatch, befalls: Befalls) -> list[Here]:
    """From now on tasks meet this; the pools that are made."""
    made: list[Here] = []

    def make(processes: int) -> Here:
        made.append(Here(processes, befalls))
        return made[-1]

    monkeypatch.setattr(command, "LocalPool", make)
    return made


def root(sessions: list[Path]) -> Path:
    return sessions[0].parents[1]


def batch(*arguments: str | Path) -> int:
    return main(["batch", *(str(a) for a in arguments)])


def events(capsys: Capture) -> list[dict[str, Any]]:
    out = capsys.readouterr().out
    return [json.loads(line, parse_constant=pytest.fail) for line in out.splitlines()]


def test_all_sessions_of_a_folder_are_tracked_and_reported_of(
    sessions: list[Path], capsys: Capture
) -> None:
    assert batch(root(sessions)) == 0
    assert all(load_session(path).subject.results is not None for path in sessions)
    out, err = capsys.readouterr()
    lines = out.splitlines()
    assert lines[0].split() == ["session", "outcome", "good", "check", "lost", "s"]
    assert [line.split()[:2] for line in lines[1:4]] == [[n, "tracked"] for n in "abc"]
    assert lines[4].startswith("3 of 3 sessions done in ")
    assert lines[5] == f"Written: {root(sessions) / NAME}"
    reported = err.splitlines()
    assert [line for line in reported if "begun" in line] == ["a: begun", "b: begun", "c: begun"]
    assert reported[-1].startswith("c: tracked, ")
    assert reported[-1].endswith("(3 of 3)")


def test_the_report_lists_every_session_by_name(sessions: list[Path]) -> None:
    cases.altered(sessions[1], lambda data: data["video"].update(path="<gone>.mp4"))
    odd = sessions[2].parent.rename(root(sessions) / "<b>c & d")
    assert batch(root(sessions)) == 1
    page = (root(sessions) / NAME).read_text("utf-8")
    assert "&lt;b&gt;c &amp; d" in page
    assert str(odd) not in page
    assert "&lt;gone&gt;.mp4" in page
    sections = page.split('<section id="session-')[1:]
    assert ["<img" in section for section in sections] == [True, True, False]
    assert "2 of 3 sessions done" in page


def test_a_second_batch_exchanges_the_report_and_no_other_file(
    sessions: list[Path], capsys: Capture
) -> None:
    assert batch(root(sessions)) == 0
    assert batch(root(sessions)) == 0
    (root(sessions) / NAME).write_text("mine")
    capsys.readouterr()
    assert "not of a batch" in refused(capsys, root(sessions), ["batch", root(sessions)])


def test_json_is_lines_of_events_and_a_summary(sessions: list[Path], capsys: Capture) -> None:
    assert batch(*sessions[:2], "--json") == 0
    reported = events(capsys)
    first, last = (str(path) for path in sessions[:2])
    assert reported[0] == {"event": "batch_started", "sessions": [first, last], "done_before": 0}
    assert reported[1] == {"event": "session_started", "session": first, "again": False}
    kinds = [event["event"] for event in reported if event.get("session") == first]
    assert kinds.count("segment_finished") == 2
    assert kinds[-1] == "session_finished"
    finished = reported[-1]
    assert finished["event"] == "finished"
    assert [s["session"] for s in finished["sessions"]] == [first, last]
    assert finished["not_done"] == finished["lost"] == []
    assert finished["report"] == str(root(sessions) / NAME)


def test_only_outdated_leaves_alone_what_fits(sessions: list[Path], capsys: Capture) -> None:
    assert batch(root(sessions)) == 0
    cases.altered(sessions[1], lambda data: data["camera"].update(fx=61.0))
    before = [sessions[i].read_bytes() for i in (0, 2)]
    capsys.readouterr()
    assert batch(root(sessions), "--only", "outdated", "--json") == 0
    states = [s["state"] for s in events(capsys)[-1]["sessions"]]
    assert states == ["kept", "tracked", "kept"]
    assert [sessions[i].read_bytes() for i in (0, 2)] == before


def test_what_goes_wrong_with_one_does_not_stop_the_others(
    sessions: list[Path], monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    sessions[0].write_text('{"schema_version": 1, "video"')
    gone = (1, WorkerDied("Its worker is gone"))
    meeting(monkeypatch, lambda number, task: gone if number == 1 else None)
    assert batch(root(sessions), "--json") == 1
    reported = events(capsys)[-1]
    assert [s["state"] for s in reported["sessions"]] == ["failed", "failed", "tracked"]
    assert "not JSON" in reported["sessions"][0]["words"]
    assert reported["sessions"][1]["words"] == "Its worker is gone, twice."
    assert reported["not_done"] == [str(path) for path in sessions[:2]]


def test_a_lost_segment_gives_exit_code_1(
    sessions: list[Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    lost = Summary(
        "", "tracked", segments=(SegmentSummary(0, 4, "lost", "lost", "full", fresh=True),)
    )
    meeting(monkeypatch, lambda number, task: (number, lost))
    assert batch(root(sessions)) == 1


def test_places_to_look_at_say_whose_they_are_where_a_session_has_several_bodies(
    sessions: list[Path], monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    several = (
        PlaceToReview(12, "Head", "9 px", "hidden", body="second"),
        PlaceToReview(3, "Left foot", "7 px", "hidden", body="body"),
    )
    only = (PlaceToReview(5, "Neck", "6 px", "hidden"),)
    summaries = [Summary("", "tracked", notes=("Stood.",), places=of) for of in (several, only, ())]
    meeting(monkeypatch, lambda number, task: (number, summaries[number]))
    assert batch(root(sessions)) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line for line in lines if line.startswith("    frame")] == [
        "    frame 12 of second: Head, 9 px, hidden",
        "    frame 3 of body: Left foot, 7 px, hidden",
        "    frame 5: Neck, 6 px, hidden",
    ]
    page = (root(sessions) / NAME).read_text("utf-8")
    assert "<td>12</td><td>second</td><td>Head</td>" in page.replace("\n", "")
    assert page.count("<th>Body</th>") == 1


def interrupted_after(count: int, by: signal.Signals = signal.SIGINT) -> Befalls:
    """A signal comes while the session of this number is at work."""

    def befalls(number: int, task: Task) -> News | None:
        if number < count:
            return None
        signal.raise_signal(by)
        return number, Summary(str(task.session), "interrupted")

    return befalls


@pytest.mark.parametrize("by", [signal.SIGINT, signal.SIGTERM], ids=lambda n: n.name)
def test_after_an_interruption_the_same_command_goes_on_with_what_was_not_done(
    by: signal.Signals, sessions: list[Path], monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    before = signal.getsignal(by)
    made = meeting(monkeypatch, interrupted_after(1, by))
    assert batch(root(sessions), "--workers", "1") == 130
    assert signal.getsignal(by) is before
    assert made[0].closed
    assert "run the same command to continue" in capsys.readouterr().err
    assert not (root(sessions) / NAME).exists()
    meeting(monkeypatch, lambda number, task: None)
    assert batch(root(sessions), "--workers", "2") == 0
    out, err = capsys.readouterr()
    assert "Continuing the interrupted batch: 1 of 3 are done." in err
    outcomes = [line[len("session") :][:12].strip() for line in out.splitlines()[1:4]]
    assert outcomes == ["up to date", "tracked", "tracked"]
    assert batch(root(sessions), "--json") == 0
    reported = events(capsys)
    assert reported[0]["done_before"] == 0
    assert {s["state"] for s in reported[-1]["sessions"]} == {"tracked"}


def test_a_session_changed_after_an_interruption_is_tracked_though_it_had_been(
    sessions: list[Path], monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    meeting(monkeypatch, interrupted_after(2))
    assert batch(root(sessions)) == 130
    cases.altered(sessions[1], lambda data: data["camera"].update(fx=61.0))
    meeting(monkeypatch, lambda number, task: None)
    capsys.readouterr()
    assert batch(root(sessions), "--json") == 0
    states = [s["state"] for s in events(capsys)[-1]["sessions"]]
    assert states == ["kept", "tracked", "tracked"]


def test_other_options_begin_another_batch(
    sessions: list[Path], monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    meeting(monkeypatch, interrupted_after(2))
    assert batch(root(sessions)) == 130
    meeting(monkeypatch, lambda number, task: None)
    capsys.readouterr()
    assert batch(root(sessions), "--quality", "preview", "--json") == 0
    assert events(capsys)[0]["done_before"] == 0


def test_a_second_ctrl_c_ends_the_batch_at_once(
    sessions: list[Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    def befalls(number: int, task: Task) -> News | None:
        for _ in range(2):
            signal.raise_signal(signal.SIGINT)
        return number, Step(50)

    made = meeting(monkeypatch, befalls)
    assert batch(root(sessions)) == 130
    assert made[0].closed


def test_killed_midway_it_leaves_no_worker_in_the_way_and_goes_on_when_started_again(
    tmp_path: Path,
) -> None:
    paths = write_sessions(tmp_path, "a", "b", "c")
    command = [
        sys.executable,
        "-m",
        "keypose.app",
        "batch",
        str(tmp_path),
        "--json",
        "--workers",
        "1",
    ]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True) as first:
        assert first.stdout is not None
        for line in first.stdout:
            if json.loads(line)["event"] == "session_finished":
                first.kill()
                break
    again = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    reported = [json.loads(line) for line in again.stdout.splitlines()]
    assert reported[0]["done_before"] >= 1
    states = [s["state"] for s in reported[-1]["sessions"]]
    assert states[0] == "kept"
    assert set(states) <= {"kept", "tracked"}
    assert all(load_session(path).subject.results is not None for path in paths)


def test_exported_files_that_are_there_are_not_exchanged_unless_asked(
    sessions: list[Path], tmp_path: Path, capsys: Capture
) -> None:
    out = tmp_path / "out"
    (out / "b").mkdir(parents=True)
    mine = out / "b" / "motion.glb"
    mine.write_text("mine")
    command: list[str | Path] = ["batch", root(sessions), "--export", "bvh,glb", "--out", out]
    assert f"{str(mine)!r} exists already" in refused(capsys, root(sessions), command)
    assert main([*(str(a) for a in command), "--overwrite"]) == 0
    for name in "abc":
        assert (out / name / "motion.bvh").read_bytes().startswith(b"HIERARCHY")
        assert (out / name / "motion.glb").read_bytes().startswith(b"glTF")
    assert (out / NAME).is_file()
    assert not (root(sessions) / NAME).exists()
    assert not (root(sessions) / FOLDER).exists()


def test_after_an_interruption_the_batch_s_own_files_are_in_nobody_s_way(
    sessions: list[Path], monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    meeting(monkeypatch, interrupted_after(2))
    assert batch(root(sessions), "--export", "bvh") == 130
    assert (sessions[0].parent / "motion.bvh").is_file()
    meeting(monkeypatch, lambda number, task: None)
    assert batch(root(sessions), "--export", "bvh") == 0
    capsys.readouterr()
    command: list[str | Path] = ["batch", root(sessions), "--export", "bvh"]
    assert "exists already" in refused(capsys, sessions[0].parent, command)


def test_processes_and_threads_share_out_the_workers(
    sessions: list[Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    made = meeting(monkeypatch, lambda number, task: None)
    assert batch(root(sessions), "--workers", "7") == 0
    assert made[0].processes == 3
    assert {task.threads for _, task in made[0].given} == {2}


def test_a_terminal_gets_a_bar_for_the_whole_and_one_for_each_session(
    sessions: list[Path], monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    assert batch(root(sessions)) == 0
    err = capsys.readouterr().err
    assert "3/3" in err
    assert all(f"{name}: tracked" in err for name in "abc")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "PATH"),
        (["gone"], "no session file"),
        (["empty"], "There is no session in the folder"),
        ([".", "--workers", "0"], "not a whole number from 1"),
        ([".", "--only", "good"], "invalid choice"),
        ([".", "--export", "bvh,dae"], "There is no format 'dae'"),
        ([".", "--out", "a/session.json/x"], "cannot be written to"),
        ([".", "--workers", "2", "--scheduler", "127.0.0.1:1"], "has its own workers"),
        ([".", "--scheduler", "nonsense"], "cannot be reached"),
    ],
)
def test_wrong_arguments_are_one_sentence(
    sessions: list[Path],
    monkeypatch: pytest.MonkeyPatch,
    capsys: Capture,
    arguments: list[str | Path],
    words: str,
) -> None:
    monkeypatch.chdir(root(sessions))
    (root(sessions) / "empty").mkdir()
    assert words in refused(capsys, sessions[0].parent, ["batch", *arguments])


def test_a_full_disk_fails_the_sessions_with_a_sentence_each_and_the_table_is_there(
    small_disk: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    monkeypatch.setattr(warm, "is_warm", lambda *parts: True)
    meeting(monkeypatch, lambda number, task: None)
    write_sessions(small_disk / "all", "a", "b")
    fill(small_disk / "ballast")
    assert batch(small_disk / "all") == 1
    out, err = capsys.readouterr()
    assert [line.split()[:2] for line in out.splitlines()[1:3]] == [
        ["a", "failed"],
        ["b", "failed"],
    ]
    assert out.count("No space left on device") == 2
    assert "Traceback" not in err
    assert err.splitlines()[-1].endswith("cannot be written: No space left on device.")
    (small_disk / "ballast").unlink()
    assert batch(small_disk / "all") == 0


def test_a_report_that_cannot_be_written_is_reported_after_the_table(
    sessions: list[Path], monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    def full(*_: object, **__: object) -> None:
        raise FormatError("The report cannot be written: No space left on device.")

    monkeypatch.setattr(command, "write_file", full)
    assert batch(root(sessions)) == 2
    out, err = capsys.readouterr()
    assert "3 of 3 sessions done" in out
    assert err.splitlines()[-1] == "The report cannot be written: No space left on device."


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no /dev/full")
def test_output_that_goes_to_a_full_disk_ends_in_a_sentence() -> None:
    run = "import sys; from keypose.app.cli.main import main; sys.exit(main())"
    command = [sys.executable, "-c", run, "schema", "body"]
    with Path("/dev/full").open("wb") as full:
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, cwd=ROOT)
    assert done.returncode == 2
    assert done.stderr == "The output cannot be written: No space left on device.\n"
