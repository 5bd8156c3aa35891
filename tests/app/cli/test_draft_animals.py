"""`keypose draft --body dog`: a network of animals, added by a person, drafts dogs and horses."""

from __future__ import annotations

import hashlib
from pathlib import Path

import pytest

from keypose.app.cli.main import main
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.keypoints.model_files import find_model
from keypose.tracker.storage.files import load_session
from tests.animals.dot_network import dot_network
from tests.animals.walking import Walk, error_share

LENS = ("--field-of-view", "60.35")
"""That of the camera."""


@pytest.fixture(autouse=True)
def _alone(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


def run(*arguments: object) -> int:
    return main([str(argument) for argument in arguments])


def add(folder: Path, *more: str, file: str = "net.onnx", name: str = "paws") -> int:
    content = dot_network()
    path = folder / file
    path.write_bytes(content)
    digest = hashlib.sha256(content).hexdigest()
    return run("models", "add", name, "--from", path, "--sha256", digest, *more)


def draft(film: Path, walk: Walk, out: Path, *more: str) -> int:
    box = ",".join(f"{value:.1f}" for value in walk.box())
    return run("draft", film, "--body", walk.name, "--box", box, *LENS, "--out", out, *more)


@pytest.mark.parametrize("name", ["dog", "horse"])
def test_a_walking_animal_is_drafted_from_the_side(name: str, tmp_path: Path) -> None:
    walk = Walk(name, frames=24)
    assert add(tmp_path, "--animals") == 0
    film, out = walk.film(tmp_path / "film"), tmp_path / "out"
    assert draft(film, walk, out, "--network", "paws") == 0
    session = load_session(out / "session.json")
    skeleton = Skeleton.of(session.subject.body)
    poses = {each.frame: each.pose(skeleton) for each in session.subject.drafts}
    assert len(poses) == walk.frames
    assert error_share(walk, poses, session.subject.body) < 0.06


@pytest.mark.parametrize(
    ("more", "file"), [((), "rtmpose-m_ap10k.onnx"), (("--animals",), "n.onnx")]
)
def test_a_network_of_animals_is_told_by_its_name_or_by_who_adds_it(
    more: tuple[str, ...], file: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert add(tmp_path, *more, file=file) == 0
    assert find_model("paws").of_animals
    assert "It is of animals: it drafts a dog or a horse." in capsys.readouterr().out
    assert run("models") == 0
    assert "17 joints of animals" in capsys.readouterr().out


def test_the_network_that_was_added_drafts_animals_without_being_chosen(tmp_path: Path) -> None:
    walk = Walk("dog", frames=6)
    assert add(tmp_path, "--animals") == 0
    assert draft(walk.film(tmp_path / "film"), walk, tmp_path / "out") == 0
    session = load_session(tmp_path / "out" / "session.json")
    assert session.view.keypoints is not None
    assert session.view.keypoints.source == "paws"


def test_drafts_that_are_accepted_are_tracked(tmp_path: Path) -> None:
    walk = Walk("dog", frames=12)
    assert add(tmp_path, "--animals") == 0
    assert draft(walk.film(tmp_path / "film"), walk, tmp_path / "out", "--accept") == 0
    path = tmp_path / "out" / "session.json"
    assert len(load_session(path).subject.keyframes) >= 2
    assert run("track", path, "--quality", "preview") in (0, 1)
    assert load_session(path).subject.results is not None


def test_without_a_network_of_animals_it_says_how_to_add_one(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    walk = Walk("horse", frames=2)
    assert draft(walk.film(tmp_path / "film"), walk, tmp_path / "out") == 2
    said = capsys.readouterr().err
    assert "add one trained on AP-10K by `keypose models add NAME --from FILE" in said
    assert said.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_an_animal_needs_a_box(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    film = Walk("dog", frames=2).film(tmp_path / "film")
    assert add(tmp_path, "--animals") == 0
    assert run("draft", film, "--body", "dog", "--out", tmp_path / "out") == 2
    assert "An animal is drafted from a box around it" in capsys.readouterr().err


def test_a_box_without_an_animal_is_said_to_be_that(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    film = Walk("dog", frames=2).film(tmp_path / "film")
    assert add(tmp_path, "--animals") == 0
    box = ("--box", "2,2,40,40")
    assert run("draft", film, "--body", "dog", *box, "--out", tmp_path / "out") == 2
    assert "No animal was found at frame 0" in capsys.readouterr().err


def test_a_network_of_animals_drafts_no_person(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    film = Walk("dog", frames=2).film(tmp_path / "film")
    assert add(tmp_path, "--animals") == 0
    asked = ("--box", "200,80,400,300", "--network", "paws", "--out", tmp_path / "out")
    assert run("draft", film, *asked) == 2
    words = "The network 'paws' finds animals: choose another one for a person."
    assert words in capsys.readouterr().err


def test_animals_belongs_to_a_network_that_is_added(capsys: pytest.CaptureFixture[str]) -> None:
    for command in (("models", "--animals"), ("models", "add", "heavy", "--animals")):
        assert run(*command) == 2
        assert "--animals belongs to `keypose models add NAME" in capsys.readouterr().err
