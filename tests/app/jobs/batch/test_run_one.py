"""One session of a batch: tracked as it stands, written beside itself, never in anybody's way."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from threading import Event
from typing import Any

import pytest

from keypose.app.cli.main import main
from keypose.app.export.motion_formats import FORMATS, formats_of
from keypose.app.jobs.batch import run_one
from keypose.app.jobs.batch.run_one import export_of, places, run_task
from keypose.app.jobs.batch.task import Step, Summary, Task
from keypose.app.jobs.job import Report
from keypose.app.jobs.rerun import rerun
from keypose.app.orders.motion import MotionOrder
from keypose.app.orders.tracking import TrackOrder
from keypose.tracker.errors import FormatError
from keypose.tracker.storage.files import load_session, save_session
from keypose.tracker.storage.results import load_results
from tests.app.bodies_cases import of_two
from tests.app.document.test_folder_lock import holder
from tests.app.jobs.batch.batch_cases import write_sessions
from tests.app.jobs.job_cases import segments
from tests.tracker import session_cases as cases


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return write_sessions(tmp_path, "job")[0]


def done(path: Path, stop: Event | None = None, **how: Any) -> tuple[Summary, list[Step]]:
    steps: list[Step] = []
    return run_task(Task(path, **how), steps.append, stop or Event()), steps


def fresh(summary: Summary) -> list[bool]:
    return [stretch.fresh for stretch in summary.segments]


def test_every_segment_is_tracked_and_reported(path: Path) -> None:
    before = load_session(path)
    summary, steps = done(path)
    after = load_session(path)
    assert (summary.state, fresh(summary)) == ("tracked", [True, True])
    assert after.changed({"results": None}) == before
    assert list(load_results(after, path).fitting(after)) == [(0, 4), (4, 8)]
    assert summary.tracks == (after.subject.results and after.subject.results.tracks)
    assert [step.percent for step in steps] == sorted(step.percent for step in steps)
    assert steps[-1].percent == 100
    assert sum(step.segment is not None for step in steps) == 2


def test_every_body_is_tracked_and_what_became_of_each_is_said(path: Path) -> None:
    save_session(of_two(load_session(path)), path)
    summary, steps = done(path)
    assert (summary.state, summary.notes) == (
        "tracked",
        (
            "body (small): 2 check of 2 segments.",
            "second (small): 2 check of 2 segments.",
        ),
    )
    assert [segment.body for segment in summary.segments] == ["body", "body", "second", "second"]
    assert (summary.count("check"), fresh(summary)) == (4, [True] * 4)
    assert sum(step.segment is not None for step in steps) == 4
    assert [body.results is not None for body in load_session(path).bodies] == [True, True]
    assert done(path, missing_only=True)[0].state == "kept"


def test_bodies_are_tracked_where_the_first_has_no_keyframes(path: Path) -> None:
    session = of_two(load_session(path))
    save_session(session.with_body(session.bodies[0].model_copy(update={"keyframes": ()})), path)
    summary, _ = done(path)
    assert summary.state == "tracked"
    assert [segment.body for segment in summary.segments] == ["second", "second"]
    assert summary.notes[0] == "body (small): not tracked."


def test_what_is_tracked_of_a_further_body_alone_counts_as_tracked(path: Path) -> None:
    save_session(of_two(load_session(path)), path)
    done(path)
    session = load_session(path)
    save_session(session.with_body(session.bodies[1].model_copy(update={"results": None})), path)
    summary, _ = done(path, missing_only=True)
    assert (summary.state, fresh(summary)) == ("tracked", [False, False, True, True])


def test_with_all_results_fitting_nothing_is_left_to_do(path: Path) -> None:
    done(path)
    before = {file: file.read_bytes() for file in path.parent.glob("*.*")}
    summary, steps = done(path, missing_only=True)
    assert (summary.state, fresh(summary), steps) == ("kept", [False, False], [])
    assert {file: file.read_bytes() for file in path.parent.glob("*.*")} == before


def test_only_what_a_change_made_outdated_is_tracked_and_comes_out_as_if_all_were(
    path: Path,
) -> None:
    done(path)
    cases.altered(path, lambda data: data["keyframes"][2]["root_m"].__setitem__(2, 3.1))
    summary, _ = done(path, missing_only=True)
    assert (summary.state, fresh(summary)) == ("tracked", [False, True])
    mended = path.read_bytes()
    assert fresh(done(path)[0]) == [True, True]
    assert path.read_bytes() == mended


def test_a_lower_quality_does_not_fit_where_a_higher_one_is_asked_for(path: Path) -> None:
    done(path, order=TrackOrder(quality="preview"))
    assert done(path, missing_only=True, order=TrackOrder(quality="full"))[0].state == "tracked"
    assert done(path, missing_only=True, order=TrackOrder(quality="preview"))[0].state == "kept"


def test_a_damaged_or_missing_tracks_file_is_tracked_again(path: Path) -> None:
    name = done(path)[0].tracks
    assert name is not None
    tracks = path.with_name(name)
    content = tracks.read_bytes()
    for damage in (lambda: tracks.write_bytes(b"no archive"), tracks.unlink):
        damage()
        assert done(path, missing_only=True)[0].state == "tracked"
        assert tracks.read_bytes() == content


def test_the_method_is_of_this_run_only(path: Path) -> None:
    summary, _ = done(path, order=TrackOrder(method="paper"))
    session = load_session(path)
    assert summary.state == "tracked"
    assert session.subject.results is not None
    assert (session.subject.results.method, session.settings.method) == ("paper", "keypose")


def test_what_a_person_edits_meanwhile_stays_and_is_reported(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def edited(*given: Any, **more: Any) -> Iterator[Any]:
        yield from rerun(*given, **more)
        session = load_session(path)
        save_session(session.changed({"keyframes": session.subject.keyframes[:2]}), path)
        cases.altered(path, lambda data: data["camera"].update(fx=61.0))

    monkeypatch.setattr(run_one, "rerun", edited)
    summary, _ = done(path)
    session = load_session(path)
    assert (len(session.subject.keyframes), session.view.camera.fx) == (2, 61.0)
    assert summary.state == "tracked"
    assert "Edited while it was tracked" in summary.words
    assert load_results(session, path).fitting(session) == {}


def test_a_session_that_another_keypose_has_open_is_left_alone(path: Path) -> None:
    before = path.read_bytes()
    with holder(path.parent) as other:
        summary, _ = done(path)
    words = f"Open in another Keypose (pid {other.pid}): left alone."
    assert (summary.state, summary.words) == ("open", words)
    assert path.read_bytes() == before


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda data: data["video"].update(path="gone.mp4"), "is missing"),
        (lambda data: data.update(keyframes=data["keyframes"][:1]), "one keyframe"),
        (lambda data: data["camera"].update(fx="wide"), "camera.fx"),
        (lambda data: data.update(schema_version=99), "a newer Keypose"),
    ],
)
def test_what_cannot_be_tracked_fails_in_a_sentence(path: Path, change: Any, words: str) -> None:
    cases.altered(path, change)
    before = path.read_bytes()
    summary, _ = done(path)
    assert summary.state == "failed"
    assert words in summary.words
    assert path.read_bytes() == before


def test_a_fault_of_the_program_fails_its_session_and_is_logged(
    path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    def broken(*_: object, **__: object) -> Iterator[Any]:
        raise ZeroDivisionError

    monkeypatch.setattr(run_one, "rerun", broken)
    summary, _ = done(path)
    assert summary.words == "Keypose ran into an internal error (ZeroDivisionError)."
    assert "Traceback" in capfd.readouterr().err


def test_stopped_midway_the_finished_segments_are_kept_beside_those_that_still_fit(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    done(path, order=TrackOrder(quality="preview"))
    stop = Event()

    def told(*given: Any, **more: Any) -> Iterator[Report]:
        for report in rerun(*given, **more):
            if segments([report]):
                stop.set()
            yield report

    monkeypatch.setattr(run_one, "rerun", told)
    summary, _ = done(path, stop, order=TrackOrder(quality="full"))
    assert summary.state == "interrupted"
    assert [(s.first, s.quality) for s in summary.segments] == [(0, "full"), (4, "preview")]


def test_motion_is_written_in_every_format_where_it_was_said_to_be(
    path: Path, tmp_path: Path
) -> None:
    formats = formats_of("csv, BVH,glb,bvh")
    assert formats == ("bvh", "glb", "csv")
    take = path.with_name("take2.json")
    path.rename(take)
    order = MotionOrder(fps=Fraction(10), from_zero=True)
    export = export_of(take, tmp_path, tmp_path / "out", formats, order)
    summary, _ = done(take, export=export)
    assert [Path(name) for name in summary.exported] == places(export)
    names = ["motion.bvh", "motion.glb", *FORMATS["csv"].names]
    folder = tmp_path / "out" / "job"
    assert sorted(folder.iterdir()) == sorted(folder / f"take2-{name}" for name in names)
    options = ("--format", "bvh,glb,csv", "--fps", "10", "--from-zero")
    assert main(["export", str(take), *options, "--out", str(tmp_path / "alone")]) == 0
    alone = {path.name: path.read_bytes() for path in (tmp_path / "alone").iterdir()}
    assert {
        path.name.removeprefix("take2-"): path.read_bytes() for path in folder.iterdir()
    } == alone


def test_without_a_folder_of_their_own_files_go_beside_the_session(tmp_path: Path) -> None:
    export = export_of(tmp_path / "a" / "session.json", tmp_path, None, ("bvh",))
    assert places(export) == [tmp_path / "a" / "motion.bvh"]


@pytest.mark.parametrize("text", ["", "dae", "bvh,,glb", "bvh;glb"])
def test_a_format_that_is_none_is_refused(text: str) -> None:
    with pytest.raises(FormatError, match="choose from bvh, glb"):
        formats_of(text)
