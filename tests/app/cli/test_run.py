"""`keypose run`: from films to motion without a hand, and what it says of what it decided."""

from __future__ import annotations

import json
import re
import shutil
from dataclasses import replace
from pathlib import Path
from threading import Event
from typing import Any

import pytest

from keypose import sample_videos
from keypose.app.cli import many
from keypose.app.cli.main import main
from keypose.app.jobs import film_session
from keypose.app.jobs.batch import make_session
from keypose.app.jobs.batch.run_one import run_task
from keypose.app.jobs.batch.task import Step, Task
from keypose.app.orders.film import FilmOrder, FilmToDraft
from keypose.app.orders.tracking import TrackOrder
from keypose.tracker.body.modify import height
from keypose.tracker.keypoints import find_people
from keypose.tracker.session.annotations import DraftRest, FrameRun
from keypose.tracker.storage.files import load_session, save_session
from keypose.tracker.storage.results import load_results
from tests.app.cli_cases import refused
from tests.app.jobs.batch.batch_cases import Here, write_sessions
from tests.app.serving import Keypose, Visitor

SAMPLES = Path(sample_videos.__file__).parent
FULL = TrackOrder()
FRAMES = (0, 24)
Capture = pytest.CaptureFixture[str]


@pytest.fixture(autouse=True)
def _in_this_process(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(many, "LocalPool", Here)


@pytest.fixture
def film(tmp_path: Path) -> Path:
    path = tmp_path / "jump.mp4"
    shutil.copy(SAMPLES / "balance" / "balance.mp4", path)
    return path


def run(*arguments: str | Path) -> int:
    return main(["run", *map(str, arguments)])


def task(film: Path, session: Path, **said: Any) -> Task:
    order = FilmOrder(frames=FRAMES, **said)
    return Task(session, FULL, missing_only=True, film=FilmToDraft(film, order), stand=True)


def test_a_film_becomes_a_motion_on_its_floor_and_files_from_an_empty_folder(
    film: Path, tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(find_people, "FRAMES", 2)
    (tmp_path / "empty").mkdir()
    monkeypatch.chdir(tmp_path / "empty")
    assert run(film, "--frames", "0-24", "--out", "motion", "--export", "bvh") == 0
    folder = Path("motion/jump.keypose")
    session = load_session(folder / "session.json")
    assert len(session.subject.keyframes) >= 2
    assert all(keyframe.soft for keyframe in session.subject.keyframes)
    assert session.subject.keyframes[-1].frame == 24
    assert list(load_results(session, folder / "session.json").fitting(session)) == list(
        session.spans
    )
    assert session.world.floor_m is not None
    assert {path.name for path in folder.iterdir()} >= {"motion.bvh", "person.jpg"}
    out, err = capsys.readouterr()
    assert re.search(r"^jump +tracked +\d", out, re.M)
    for words in (
        "One person found: --box ",
        "The person is taken to be 176 cm tall (--height says otherwise)",
        "Drafts accepted as approximate keyframes: 0, ",
        "Soles within",
    ):
        assert words in out
    assert "jump: looking for the person" in err
    assert "jump: standing on the floor" in err
    report = Path("motion/batch-report.html").read_text("utf-8")
    assert "The person who was drafted" in report
    assert "Soles within" in report


BOX = (99.0, 161.0, 409.0, 658.0)
BOX_FRAME = 20


def by_the_page(film: Path) -> Path:
    """The acts of somebody who looks at nothing: up by its lines, a draft from the box, every place
    of it confirmed, tracked, stood on the floor."""
    keypose = Keypose(str(film), "--workspace", str(film.parent / "workspace"))
    try:
        visitor = Visitor(keypose)

        def do(title: str, **action: Any) -> None:
            visitor.do(**action)
            visitor.until(lambda: visitor.seen["job"]["title"].startswith(title))
            visitor.until(lambda: visitor.seen["job"]["state"] in ("idle", "done"))

        do("Looking", do="find_up")
        do("Drafting", do="draft", frame=BOX_FRAME, box=BOX, first=FRAMES[0], last=FRAMES[1])
        for place in visitor.seen["review"]["places"]:
            visitor.do(do="accept_place", frame=place["frame"], part=place["part"])
        do("Tracking", do="track", what="all")
        do("Standing", do="stand")
        visitor.until(lambda: visitor.seen["floor"]["soles"])
        visitor.leave()
    finally:
        code, words = keypose.end()
    assert code == 0, words
    return film.with_suffix(".keypose") / "session.json"


def test_the_same_acts_in_the_page_write_the_same_bytes(film: Path, tmp_path: Path) -> None:
    here = tmp_path / "here"
    here.mkdir()
    shutil.copy(film, here)
    named = {"box": BOX, "frame": BOX_FRAME}
    path = here / "jump.keypose" / "session.json"
    summary = run_task(task(here / "jump.mp4", path, **named), lambda step: None, Event())
    assert summary.state == "tracked"
    page = by_the_page(film)
    ours, theirs = load_session(path), load_session(page)
    assert ours.subject.keyframes == theirs.subject.keyframes
    assert path.read_bytes() == page.read_bytes()
    results = ours.subject.results
    assert results is not None
    assert (
        path.with_name(results.tracks).read_bytes() == page.with_name(results.tracks).read_bytes()
    )


def test_what_was_interrupted_goes_on_and_comes_out_as_if_it_had_not_been(
    film: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    whole, again = (tmp_path / name / "session.json" for name in ("whole", "again"))
    named = {"box": BOX, "frame": 0}
    run_task(task(film, whole, **named), lambda step: None, Event())
    for stage in ("draft", "track"):
        stop = Event()

        def leave(step: Step, stop: Event = stop, stage: str = stage) -> None:
            if step.stage == stage and step.percent > 60:
                stop.set()

        left = run_task(task(film, again, **named), leave, stop)
        assert left.state == "interrupted"
    done = run_task(task(film, again, **named), lambda step: None, Event())
    assert done.state == "tracked"
    assert again.read_bytes() == whole.read_bytes()
    kept = run_task(task(film, again, **named), lambda step: None, Event())
    assert kept.state == "kept"
    assert again.read_bytes() == whole.read_bytes()
    assert kept.notes == done.notes


def test_a_film_that_fails_ends_with_its_reason_and_the_others_go_on(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    films = tmp_path / "films"
    films.mkdir()
    for sample in ("balance", "box", "walk"):
        shutil.copy(SAMPLES / sample / f"{sample}.mp4", films)
    (films / "notes.txt").write_text("no film")
    (films / "broken.mp4").write_bytes(b"no film either")
    monkeypatch.setattr(find_people, "FRAMES", 1)
    out = tmp_path / "out"
    assert run(films, "--frames", "20-28", "--quality", "preview", "--stand", "no", "--json",
               "--out", out) == 1  # fmt: skip
    events = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    ended = {Path(row["session"]).parent.name: row for row in events[-1]["sessions"]}
    assert {name: row["state"] for name, row in ended.items()} == {
        "balance.keypose": "tracked", "box.keypose": "failed", "broken.keypose": "failed",
        "walk.keypose": "failed",
    }  # fmt: skip
    assert "No person was found" in ended["box.keypose"]["words"]
    assert "2 people are to be seen" in ended["walk.keypose"]["words"]
    assert "broken.mp4" in ended["broken.keypose"]["words"]
    assert load_session(out / "balance.keypose" / "session.json").world.floor_m is None
    assert {event.get("stage") for event in events} >= {"person", "draft", "track"}
    assert [path.name for path in out.glob("*.keypose")] == ["balance.keypose"]


def test_a_batch_takes_the_films_of_a_table_beside_saved_sessions(
    film: Path, tmp_path: Path, capsys: Capture
) -> None:
    rows = ["film;box;frame;frames;height", f"{film.name};99 161 409 658;0;0-8;179"]
    (tmp_path / "films.csv").write_text("\n".join(rows))
    (saved,) = write_sessions(tmp_path / "saved", "a")
    out = tmp_path / "out"
    batch = ["batch", tmp_path / "films.csv", saved, "--out", out, "--export", "trc"]
    assert main([str(word) for word in batch]) in (0, 1)
    session = load_session(out / "jump.keypose" / "session.json")
    assert height(session.subject.body) == pytest.approx(1.79)
    assert session.world.floor_m is not None
    assert (out / "jump.keypose" / "motion.trc").is_file()
    assert load_session(saved).subject.results is not None
    assert "2 of 2 sessions done" in capsys.readouterr().out
    (out / "saved" / "a" / "motion.trc").unlink()
    assert main([str(word) for word in batch]) in (0, 1)
    assert re.search(r"^jump +up to date", capsys.readouterr().out, re.M)


def begun_by_hand(film: Path, folder: Path) -> Path:
    """A session with one keyframe, that nobody asked a program for."""
    path = folder / "jump.keypose" / "session.json"
    path.parent.mkdir(parents=True)
    with film_session.opened_film(FilmToDraft(film)) as video:
        session = film_session.begun_session(FilmToDraft(film), video, path)
    save_session(session, path)
    return path


REFUSED: dict[str, tuple[tuple[str, ...], str]] = {
    "a film that is not there": (("gone.mp4",), "There is no film 'gone.mp4'"),
    "a folder without films": (("empty",), "There is no film in the folder 'empty'"),
    "one box for two films": (
        ("jump.mp4", "other.mp4", "--box", "1,1,9,9"),
        "--box is for one film",
    ),
    "options of exports without one": (("jump.mp4", "--rig", "smpl"), "--export"),
    "two lenses": (("jump.mp4", "--lens", "26", "--field-of-view", "60"), "mean the same"),
    "a height in metres": (("jump.mp4", "--height", "1.8"), "not a number from 40 to 260"),
    "a box and everyone": (("jump.mp4", "--box", "1,1,9,9", "--everyone"), "give one of them"),
    "a box of words": (("jump.mp4", "--box", "him"), "is not a box"),
}


@pytest.mark.parametrize("wrong", REFUSED)
def test_what_cannot_be_run_is_said_in_one_sentence(
    film: Path, tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch, wrong: str
) -> None:
    more, words = REFUSED[wrong]
    shutil.copy(film, tmp_path / "other.mp4")
    (tmp_path / "empty").mkdir()
    monkeypatch.chdir(tmp_path)
    assert words in refused(capsys, tmp_path, ["run", *more, "--out", tmp_path / "out"])


def test_a_session_that_was_begun_otherwise_is_left_as_it_is(film: Path, tmp_path: Path) -> None:
    path = begun_by_hand(film, tmp_path)
    before = path.read_bytes()
    said = run_task(task(film, path), lambda step: None, Event())
    assert "begun by hand" in said.words
    plain = Task(path, missing_only=True, film=FilmToDraft(film), stand=True)
    assert "no keyframes" in run_task(plain, lambda step: None, Event()).words
    assert path.read_bytes() == before


def test_other_options_for_a_session_that_is_there_are_refused_unless_it_is_begun_anew(
    film: Path, tmp_path: Path
) -> None:
    path, nothing = tmp_path / "jump.keypose" / "session.json", Event()
    one = FilmToDraft(film, FilmOrder(box=BOX, frames=(0, 8)))
    other = FilmToDraft(film, FilmOrder(box=BOX, frames=(0, 9)))
    order = TrackOrder(quality="preview")
    assert run_task(Task(path, order, film=one), lambda step: None, nothing).is_done
    before = path.read_bytes()
    words = run_task(Task(path, order, film=other), lambda step: None, nothing).words
    assert "was made with other options" in words
    assert path.read_bytes() == before
    assert run_task(Task(path, order, film=other, anew=True), lambda step: None, nothing).is_done
    assert load_session(path).subject.keyframes[-1].frame == 9
    assert path.with_name("session.json.previous").is_file()


def made(film: Path, path: Path, **how: Any) -> None:
    """A session of nine frames, by a run that nobody interrupted."""
    short = FilmToDraft(film, FilmOrder(box=BOX, frames=(0, 8)))
    order = TrackOrder(quality="preview")
    assert run_task(Task(path, order, film=short, **how), lambda step: None, Event()).is_done


def test_what_a_person_posed_is_not_drafted_over(film: Path, tmp_path: Path) -> None:
    path = tmp_path / "jump.keypose" / "session.json"
    made(film, path)
    session = load_session(path)
    assert session.subject.drafted is not None
    first = session.subject.keyframes[0].model_copy(update={"root_m": (0.5, 0.0, 4.0)})
    left = DraftRest(frame=0, box=BOX, frames=(FrameRun(first_frame=5, last_frame=8),))
    drafted = session.subject.drafted.model_copy(update={"rest": left})
    keyframes = (first, *session.subject.keyframes[1:])
    save_session(session.changed({"keyframes": keyframes, "drafted": drafted}), path)
    made(film, path)
    assert load_session(path).subject.keyframes == keyframes


def test_a_run_that_begins_anew_keeps_what_was_there_and_does_so_also_when_it_is_interrupted(
    film: Path, tmp_path: Path
) -> None:
    path = begun_by_hand(film, tmp_path)
    path.with_name("journal.jsonl").write_text("{}")
    before, stop = path.read_bytes(), Event()
    stop.set()
    named = FilmToDraft(film, FilmOrder(frames=(0, 8)))
    anew = Task(path, TrackOrder(quality="preview"), film=named, anew=True)
    assert run_task(anew, lambda step: None, stop).state == "interrupted"
    (aside,) = path.parent.glob("session.theirs-*.json")
    assert aside.read_bytes() == before
    assert not path.with_name("journal.jsonl").exists()
    made(film, path)
    assert load_session(path).subject.keyframes


def test_what_was_decided_is_said_again_by_the_next_run(film: Path, tmp_path: Path) -> None:
    path = tmp_path / "jump.keypose" / "session.json"
    said = [run_task(task(film, path, box=BOX), lambda step: None, Event()) for _ in range(2)]
    assert said[0].notes == said[1].notes
    assert any("Soles within" in words for words in said[1].notes)
    left = replace(task(film, path, box=BOX), stand=False)
    notes = run_task(left, lambda step: None, Event()).notes
    assert notes[-1] == "It was stood on the floor before, and stays so."


RECORDS = {
    "{}": "is damaged",
    '{"asked": {}, "frame": 0, "box": [0, 0, 1e999, 9]}': "made with other options",
    '{"asked": ASKED, "frame": 0, "box": [0, 0, NaN, 9]}': "is no number",
    '{"asked": ASKED, "frame": 900, "box": [0, 0, 9, 9]}': "must be one of those to draft",
}


@pytest.mark.parametrize("record", RECORDS)
def test_a_record_that_cannot_be_true_is_said(film: Path, tmp_path: Path, record: str) -> None:
    path = begun_by_hand(film, tmp_path)
    asked = json.dumps({"order.frames": str(FRAMES)})
    path.with_name(make_session.RECORD).write_text(record.replace("ASKED", asked))
    before = path.read_bytes()
    said = run_task(task(film, path), lambda step: None, Event())
    assert RECORDS[record] in said.words
    assert path.read_bytes() == before


def test_a_run_that_is_done_is_done_again_at_once_and_exports_anew(
    film: Path, tmp_path: Path, capsys: Capture
) -> None:
    how = ("--frames", "0-8", "--box", "99,161,409,658", "--quality", "preview", "--stand", "no")
    for outcome in ("tracked", "up to date"):
        assert run(film, *how, "--export", "csv", "--out", tmp_path / "out") == 0
        assert re.search(rf"^jump +{outcome} ", capsys.readouterr().out, re.M)
