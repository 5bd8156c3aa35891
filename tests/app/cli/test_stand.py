"""`keypose stand`: the tracked motion with its feet on the floor, in the session's file."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from keypose.app.cli.main import main
from keypose.app.document.folder_lock import locked
from keypose.app.jobs import find_up
from keypose.tracker.body.body import preset
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import exp_rotation
from keypose.tracker.operations.stand import in_standing_order
from keypose.tracker.session import Session
from keypose.tracker.session.bodies import TrackedBody
from keypose.tracker.session.keyframe import Keyframe
from keypose.tracker.session.settings import TrackSettings
from keypose.tracker.space.soles import soles_of
from keypose.tracker.storage.files import load_session, save_session
from keypose.tracker.storage.results import Results, load_results, save_results
from tests.scenes import sample
from tests.tracker.operations.standing_cases import lines, results_of, session_of, walk, wandering

SHOWN, UP = walk()
MOTION = wandering(SHOWN.truth)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """Somebody who strides, tracked, with a film of as many frames."""
    path = sample(tmp_path)
    video = load_session(path).view.video
    last = 60
    given = session_of(SHOWN, MOTION, video=video)
    given = given.changed(
        {"keyframes": tuple(k for k in given.subject.keyframes if k.frame <= last)}
    )
    save_session(save_results(given, path, results_of(given, MOTION)), path)
    return path


def test_feet_stand_and_what_changed_and_is_left_is_printed(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["stand", str(path)]) == 0
    words = capsys.readouterr().out
    saved = load_session(path)
    assert f"{len(saved.subject.pins)} pins on the floor" in words
    assert "3 keyframes give way in depth" in words
    assert "by how the person stands" in words
    assert "Legs moved by up to" in words
    assert "Soles within 0." in words or "Soles within 1." in words
    assert saved.world.floor_m is not None
    assert saved.world.up_world is not None
    results = load_results(saved, path)
    assert results.unsolved(saved) == []
    assert results.space(saved)


@pytest.mark.parametrize("has_film", [True, False])
def test_lines_are_looked_for_beside_up_that_is_set_and_no_film_is_needed_for_it(
    path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    has_film: bool,
) -> None:
    x, y, z = UP.tolist()
    settings = TrackSettings(smooth=True, static_camera=True)
    given = load_session(path).changed({"up_world": (x, y, z), "settings": settings})
    save_session(save_results(given, path, results_of(given, MOTION)), path)
    leaning = lines(exp_rotation(np.radians([20.0, 0.0, 0.0])) @ UP)
    monkeypatch.setattr(find_up, "upright_lines", lambda *_: leaning)
    if not has_film:
        (path.parent / load_session(path).view.video.path).unlink()
    assert main(["stand", str(path), "--dry-run", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["up_from"] == ["set"]
    assert [one["from"] for one in said["up_apart"]] == (["lines"] if has_film else [])


def test_a_dry_run_says_the_same_and_writes_nothing(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = path.read_bytes()
    assert main(["stand", str(path), "--dry-run", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert path.read_bytes() == before
    assert said["pins_on_floor"] == said["pins_taken"] > 2
    assert said["softened"] == [0, 30, 60]
    assert abs(said["soles_off_m"]) < 0.015
    assert {"moves_px", "bends_rad"} & set(said["pins"][0])
    kept, released = (
        {(pin["part"], *pin["frames"]) for pin in said[name]} for name in ("pins", "released")
    )
    assert len(kept) == said["pins_on_floor"]
    assert not kept & released
    assert said["tilted_rad"] < 0.05
    assert said["unscaled"] == []
    assert said["session"] is None


def test_the_film_is_looked_at_only_for_what_is_up(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    x, y, z = UP.tolist()
    session = load_session(path)
    save_session(session.changed({"up_world": (x, y, z)}), path)
    path.with_name(session.view.video.path).unlink()
    assert main(["stand", str(path)]) == 0
    assert "The camera looks" not in capsys.readouterr().out


def test_a_dry_run_does_not_mind_that_the_session_is_open_and_no_session_leaves_nothing(
    path: Path,
) -> None:
    with locked(path, "close it there first"):
        assert main(["stand", str(path)]) == 2
        assert main(["stand", str(path), "--dry-run"]) == 0
    folder = path.parent.parent / "empty"
    folder.mkdir()
    assert main(["stand", str(folder / "session.json")]) == 2
    assert not list(folder.iterdir())


def as_preview(path: Path) -> None:
    session = load_session(path)
    results = Results()
    for segment in load_results(session, path).fitting(session).values():
        results = results.with_result(replace(segment.as_tracked, quality="preview"))
    save_session(save_results(session.changed({"results": None}), path, results), path)


def with_other(**update: Any) -> Callable[[Path], None]:
    def change(path: Path) -> None:
        session = load_session(path)
        changes = {name: made(session) for name, made in update.items()}
        save_session(session.changed(changes), path)

    return change


def all_moved(session: Session) -> tuple[Keyframe, ...]:
    return tuple(
        keyframe.model_copy(update={"root_m": tuple(x + 0.01 for x in keyframe.root_m)})
        for keyframe in session.subject.keyframes
    )


OUTDATED: dict[str, tuple[Callable[[Path], None], str]] = {
    "another setting": (
        with_other(settings=lambda s: s.settings.model_copy(update={"cues": ("keypoints",)})),
        "have changed",
    ),
    "another lens": (
        with_other(camera=lambda s: s.view.camera.zoomed(1.01)),
        "body, camera or ignore masks have changed",
    ),
    "keyframes that moved": (
        with_other(keyframes=all_moved),
        "keyframes were set, changed or removed at frames 0, 30, 60",
    ),
}


def refusal_of(path: Path, capsys: pytest.CaptureFixture[str]) -> str:
    before = path.read_bytes()
    assert main(["stand", str(path)]) == 2
    assert path.read_bytes() == before
    return capsys.readouterr().err


@pytest.mark.parametrize("case", OUTDATED)
def test_what_is_out_of_date_is_not_called_untracked(
    path: Path, case: str, capsys: pytest.CaptureFixture[str]
) -> None:
    change, reason = OUTDATED[case]
    change(path)
    words = refusal_of(path, capsys)
    assert words.startswith("The tracked motion is out of date (")
    assert reason in words
    assert words.endswith("): track it again first.\n")


def test_a_preview_is_to_be_tracked_in_full(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    as_preview(path)
    words = "The motion was tracked as a preview: track it in full first.\n"
    assert refusal_of(path, capsys) == words


def test_what_is_not_tracked_is_refused_in_one_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = sample(tmp_path)
    save_session(load_session(path).changed({"results": None}), path)
    assert main(["stand", str(path)]) == 2
    assert capsys.readouterr().err == "Nothing is tracked yet: track the motion first.\n"


@pytest.fixture
def three(path: Path) -> Path:
    """Two who stride side by side, tracked, and a box."""
    session, aside = load_session(path), np.array([0.6, -0.04, 0.0])
    moved = Trajectory(0, MOTION.Rs_parent_part, MOTION.ps_camera_root + aside)
    there = session_of(SHOWN, moved, video=session.view.video)
    keyframes = tuple(k for k in there.subject.keyframes if k.frame <= 60)
    there = there.changed({"keyframes": keyframes})
    second = there.subject.model_copy(update={"id": "second"})
    box = TrackedBody(id="crate", body=preset("box"))
    whole = session.model_copy(update={"bodies": (session.subject, second, box)})
    for body_id, motion in (("body", MOTION), ("second", moved)):
        about = whole.about(body_id)
        whole = save_results(about, path, results_of(about, motion)).about("body")
    save_session(whole, path)
    return path


def test_who_walks_farthest_stands_first_and_else_the_order_stays(three: Path) -> None:
    session = load_session(three)
    fittings = {
        body_id: load_results(session.about(body_id), three).fitting(session.about(body_id))
        for body_id in ("body", "second")
    }
    assert in_standing_order(session, fittings) == ["body", "second"]
    begun = dict(list(fittings["body"].items())[:1])
    assert in_standing_order(session, {**fittings, "body": begun}) == ["second", "body"]
    assert in_standing_order(session, {**fittings, "body": {}}) == ["second", "body"]


def test_several_bodies_stand_on_one_floor_and_what_has_no_feet_is_said(
    three: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["stand", str(three)]) == 0
    said = capsys.readouterr()
    assert "crate: The body 'box' has no feet with heel and toe. It was not stood" in said.err
    assert [line for line in said.out.splitlines() if line.endswith(":")] == [
        "body (adult_male):",
        "second (adult_male):",
    ]
    saved = load_session(three)
    assert saved.world.floor_m is not None
    assert "set" not in saved.world.up_from
    for name in ("body", "second"):
        about = saved.about(name)
        results = load_results(about, three)
        soles = soles_of(about, results.space(about))
        assert about.subject.pins
        assert results.unsolved(about) == []
        assert soles is not None
        assert abs(soles.off_m or 0.0) < 0.03  # the second was tracked 4 cm above


def test_one_body_that_stands_takes_the_motion_of_the_rest_into_its_world(three: Path) -> None:
    before = load_session(three)
    assert main(["stand", str(three), "--body", "second"]) == 0
    saved = load_session(three)
    first = saved.about("body")
    assert first.subject.keyframes == before.bodies[0].keyframes
    assert first.subject.pins == ()
    assert load_results(first, three).unsolved(first) == []
    assert saved.bodies[1].pins
    assert saved.world.floor_m is not None


def test_a_body_that_is_asked_for_and_cannot_stand_is_refused(
    three: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = three.read_bytes()
    assert main(["stand", str(three), "--body", "crate"]) == 2
    assert "crate: The body 'box' has no feet with heel and toe" in capsys.readouterr().err
    assert three.read_bytes() == before


def test_why_no_body_stands_is_said_of_each(
    three: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    session = load_session(three)
    bodies = tuple(body.model_copy(update={"results": None}) for body in session.bodies)
    save_session(session.model_copy(update={"bodies": bodies}), three)
    assert main(["stand", str(three)]) == 2
    assert capsys.readouterr().err == (
        "body: Nothing is tracked yet: track the motion first. second: Nothing is tracked yet: "
        "track the motion first. crate: The body 'box' has no feet with heel and toe.\n"
    )
