"""Commands about one of several bodies of a session, or about each."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from keypose.app.cli.main import main
from keypose.tracker.storage.files import load_session, save_session
from tests.app.bodies_cases import two_tracked
from tests.scenes import SAMPLES

TRUTH = str(SAMPLES / "box" / "truth.npz")


@pytest.fixture(scope="module")
def tracked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return two_tracked(tmp_path_factory.mktemp("two"))


@pytest.fixture
def path(tracked: Path, tmp_path: Path) -> Path:
    shutil.copytree(tracked.parent, tmp_path / "box")
    return tmp_path / "box" / "session.json"


def done(*words: str | Path) -> int:
    return main([str(word) for word in words])


def add_unposed_before(path: Path) -> None:
    """A body without a pose stands before those that are tracked."""
    session = load_session(path)
    unposed = session.bodies[0].model_copy(update={"id": "ahead", "keyframes": (), "results": None})
    save_session(session.model_copy(update={"bodies": (unposed, *session.bodies)}), path)


OF_ONE = {
    "evaluate": ("--reference", TRUTH),
    "reduce": ("--dry-run",),
    "shot": ("--frame", "0", "--out", "{out}.png"),
    "sheet": ("--out", "{out}.png"),
    "film": ("--frames", "0-1", "--out", "{out}.mp4"),
}
OF_ALL_DRAWN = ("shot", "film")
OF_EACH = {
    "review": (),
    "report": ("--out", "{out}.html"),
    "info": (),
    "track": ("--quality", "preview"),
}


@pytest.mark.parametrize("command", [*OF_ONE, *OF_EACH, "stand"])
def test_a_body_that_is_not_there_is_refused_in_one_sentence_that_names_those_that_are(
    command: str, path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    more = [word.format(out=path.parent / "out") for word in {**OF_ONE, **OF_EACH}.get(command, ())]
    before = path.read_bytes()
    assert done(command, path, *more, "--body", "horse") == 2
    words = capsys.readouterr().err
    assert words == "No body is called 'horse': choose by id from body (box) and second (box).\n"
    assert path.read_bytes() == before


def test_a_name_that_two_bodies_have_is_refused(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert done("review", path, "--body", "box") == 2
    assert "2 bodies are called 'box': choose by id" in capsys.readouterr().err


@pytest.mark.parametrize("command", [name for name in OF_ONE if name not in OF_ALL_DRAWN])
def test_a_command_about_one_body_takes_the_first_and_says_so(
    command: str, path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    more = [word.format(out=path.parent / "out") for word in OF_ONE[command]]
    assert done(command, path, *more) == 0
    words = capsys.readouterr().err
    assert "the session has 2 bodies, body (box) and second (box). This is body" in words
    more = [word.format(out=path.parent / "second") for word in OF_ONE[command]]
    assert done(command, path, *more, "--body", "second") == 0
    assert "bodies" not in capsys.readouterr().err


def test_each_body_is_measured_by_its_own_motion(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    off = {}
    for name in ("body", "second"):
        assert done("evaluate", path, "--reference", TRUTH, "--json", "--body", name) == 0
        estimate = json.loads(capsys.readouterr().out)["estimate"]
        off[name] = estimate["distance_m"]["overall"]["mean"]
    assert off["second"] - off["body"] == pytest.approx(0.01, abs=0.004)


def test_the_pictures_of_two_bodies_differ(path: Path) -> None:
    pictures = [path.parent / f"{name}.png" for name in ("body", "second")]
    for picture in pictures:
        assert done("shot", path, "--frame", "0", "--out", picture, "--body", picture.stem) == 0
    assert pictures[0].read_bytes() != pictures[1].read_bytes()


def test_reducing_one_body_leaves_the_rest_of_the_session(path: Path) -> None:
    before = load_session(path)
    assert done("reduce", path, "--every", "6", "--body", "second") == 0
    after = load_session(path)
    assert [body.id for body in after.bodies] == ["body", "second"]
    assert after.bodies[0] == before.bodies[0]
    assert len(after.bodies[1].keyframes) > len(before.bodies[1].keyframes)


def test_a_review_of_several_bodies_lists_each(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert done("review", path) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line for line in lines if line.endswith(":")] == ["body (box):", "second (box):"]
    assert done("review", path, "--json") == 0
    assert list(json.loads(capsys.readouterr().out)["bodies"]) == ["body", "second"]
    assert done("review", path, "--json", "--body", "second") == 0
    assert list(json.loads(capsys.readouterr().out)["bodies"]) == ["second"]


def test_a_report_has_each_body_under_its_name(path: Path) -> None:
    out = path.parent / "report.html"
    assert done("report", path, "--out", out) == 0
    page = out.read_text("utf-8")
    assert "body box, 1 part<" in page
    assert page.index("body (box)</h1>") < page.index("second (box)</h1>")
    assert done("report", path, "--out", out, "--overwrite", "--body", "second") == 0
    assert page.count("<h1") == 2
    assert out.read_text("utf-8").count("<h1") == 1


def test_info_on_a_session_lists_its_bodies(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert done("info", path) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[:2] for line in lines[1:]] == [["body", "box;"], ["second", "box;"]]
    assert done("info", path.parent, "--json", "--body", "second") == 0
    (facts,) = json.loads(capsys.readouterr().out)["bodies"].values()
    assert facts["keyframes"] == [k.frame for k in load_session(path).bodies[1].keyframes]
    film = path.with_name("box.mp4")
    assert done("info", film, "--body", "second") == 2
    assert "--body is for a session" in capsys.readouterr().err


def test_a_body_without_keyframes_is_said_and_the_rest_is_tracked(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    session = load_session(path)
    empty = session.bodies[1].model_copy(update={"keyframes": (), "results": None})
    save_session(session.with_body(empty), path)
    assert done("track", path, "--quality", "preview") == 0
    assert "second was not tracked" in capsys.readouterr().err
    assert done("track", path, "--quality", "preview", "--body", "second") == 2
    assert "no keyframes" in capsys.readouterr().err


LACKING = {
    "track": ((), "has no keyframes; tracking needs two."),
    "sheet": (("--out", "{out}.png"), "has no keyframes to draw."),
    "film": (("--out", "{out}.mp4"), "has no pose to film: set a keyframe first."),
    "shot": (("--frame", "0", "--out", "{out}.png"), "has not been tracked yet: run "),
    "evaluate": (("--reference", TRUTH), "has not been tracked yet: run "),
}


@pytest.mark.parametrize("command", LACKING)
def test_what_a_body_lacks_is_said_of_the_body_and_not_of_its_session(
    command: str, path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    add_unposed_before(path)
    more, words = LACKING[command]
    asked = [word.format(out=path.parent / "out") for word in more]
    assert done(command, path, *asked, "--body", "ahead") == 2
    assert f"Body ahead of session.json {words}" in capsys.readouterr().err


def test_a_review_says_why_there_is_nothing_to_review_of_a_body(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    session = load_session(path)
    second = session.bodies[1].model_copy(update={"results": None})
    save_session(session.with_body(second), path)
    add_unposed_before(path)
    assert done("review", path, "--body", "second") == 0
    assert capsys.readouterr().out == "second (box):\n1 segment needs tracking first.\n"
    assert done("review", path, "--body", "second", "--frames", "0-0") == 0
    assert capsys.readouterr().out == "second (box):\nNot tracked yet.\n"
    assert done("review", path, "--body", "ahead") == 0
    words = "Body ahead of session.json has no keyframes; tracking needs two.\n"
    assert capsys.readouterr().out == f"ahead (box):\n{words}"


def test_following_one_body_on_leaves_the_rest_of_the_session(path: Path) -> None:
    session = load_session(path)
    shorter = session.bodies[1].keyframes[:1]
    second = session.bodies[1].model_copy(update={"keyframes": shorter, "results": None})
    save_session(session.with_body(second), path)
    before = load_session(path)
    assert done("track", path, "--ahead", "forward", "--body", "second") in (0, 1)
    after = load_session(path)
    assert after.bodies[0] == before.bodies[0]
    assert len(after.bodies[1].drafts) > 0


def test_a_copy_of_several_bodies_is_refused_before_anything_is_written(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = path.read_bytes()
    assert done("track", path, "--out", path.parent / "copy", "--static-camera", "yes") == 2
    assert "leave --out away" in capsys.readouterr().err
    assert path.read_bytes() == before
    assert not (path.parent / "copy").exists()


@pytest.mark.parametrize("command", OF_ALL_DRAWN)
def test_a_first_body_without_a_pose_does_not_keep_the_others_from_being_drawn(
    command: str, path: Path
) -> None:
    add_unposed_before(path)
    pictures = []
    for name, asked in (("all", ()), ("alone", ("--body", "body"))):
        more = [word.format(out=path.parent / name) for word in OF_ONE[command]]
        assert done(command, path, *more, *asked) == 0
        pictures.append(Path(more[-1]).read_bytes())
    assert pictures[0] != pictures[1]


def test_a_shot_draws_the_bodies_that_have_a_pose_at_its_frame(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    session = load_session(path)
    first = session.bodies[0].model_copy(
        update={"keyframes": session.bodies[0].keyframes[:1], "results": None}
    )
    save_session(session.with_body(first), path)
    out = path.with_name("out.png")
    assert done("shot", path, "--frame", "1", "--out", out) == 0
    assert done("shot", path, "--frame", "1", "--out", out, "--overwrite", "--body", "body") == 2


@pytest.mark.parametrize(
    ("command", "outdated"),
    [
        (("add-body", "--remove", "second"), True),
        (("reduce", "--body", "second", "--replace-keyframes"), True),
        (("add-body", "ball"), False),
    ],
)
def test_who_else_is_out_of_date_by_a_change_of_one_body_is_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: tuple[str, ...], outdated: bool
) -> None:
    path = two_tracked(tmp_path)
    session = load_session(path)
    nearer = [
        keyframe.model_copy(update={"root_m": (*keyframe.root_m[:2], keyframe.root_m[2] - 0.5)})
        for keyframe in session.bodies[1].keyframes
    ]
    second = session.bodies[1].model_copy(update={"keyframes": tuple(nearer)})
    save_session(session.with_body(second), path)
    assert main(["track", str(path), "--quality", "preview"]) == 0
    capsys.readouterr()
    name, *more = command
    assert main([name, str(path), *more]) == 0
    assert ("Box is out of date by this: track it again." in capsys.readouterr().err) is outdated
