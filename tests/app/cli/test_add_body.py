"""`keypose add-body`: one body more in a session, or less."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from keypose.app.cli.main import main
from keypose.tracker.body.body import preset
from keypose.tracker.body.preset_names import PRESETS
from keypose.tracker.session import Session
from keypose.tracker.session.bodies import TrackedBody, free_id
from keypose.tracker.session.bonds import Bond, BondEnd
from keypose.tracker.session.schema import MOST_BODIES
from keypose.tracker.storage.files import load_session, read_session, save_session
from tests.scenes import sample


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return sample(tmp_path, "box")


def done(path: Path, *words: str | Path) -> int:
    return main(["add-body", str(path), *map(str, words)])


def ids(path: Path) -> dict[str, str]:
    return {body.id: body.body.name for body in load_session(path).bodies}


@pytest.mark.parametrize("name", PRESETS)
def test_every_preset_can_be_added_and_what_is_there_stays(name: str, path: Path) -> None:
    before = load_session(path)
    assert done(path, name) == 0
    after = load_session(path)
    assert after.bodies[0] == before.bodies[0]
    assert after.bodies[1:] == (TrackedBody(id=name, body=preset(name)),)


def test_bodies_of_one_preset_get_ids_of_their_own_and_keep_its_name(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert [done(path, "dog"), done(path, "dog"), done(path, "dog", "--name", "Rex II")] == [0] * 3
    assert ids(path) == {"body": "box", "dog": "dog", "dog-2": "dog", "rex-ii": "dog"}
    words = capsys.readouterr().out
    assert "Added rex-ii (dog), " in words
    assert "Bodies: body (box), dog, dog-2 (dog) and rex-ii (dog); the page shows body." in words


@pytest.mark.parametrize(
    ("wish", "expected"),
    [
        ("Left shoe", "left-shoe"),
        ("Zoë", "zoe"),
        ("球", "body-2"),
        ("body", "body-2"),
        ("x" * 80, "x" * 32),
        ("--", "body-2"),
        ("a/b\\c", "a-b-c"),
    ],
)
def test_an_id_is_made_of_any_name(wish: str, expected: str) -> None:
    assert free_id(wish, (TrackedBody(body=preset("box")),)) == expected
    assert TrackedBody(id=expected, body=preset("box")).id == expected


def test_a_body_of_a_file_is_added(path: Path) -> None:
    racket = preset("cylinder").model_copy(update={"name": "racket"})
    file = path.with_name("racket.json")
    file.write_text(racket.model_dump_json())
    assert done(path, file) == 0
    assert ids(path) == {"body": "box", "racket": "racket"}


def test_a_dry_run_says_the_same_and_writes_nothing(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = path.read_bytes()
    assert done(path, "horse", "--dry-run", "--json") == 0
    facts = json.loads(capsys.readouterr().out)
    assert (facts["added"], facts["bodies"]) == ("horse", {"body": "box", "horse": "horse"})
    assert path.read_bytes() == before


def test_a_body_that_is_removed_goes_with_what_is_its_and_can_be_put_back(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert done(path, "cylinder", "--name", "stick") == 0
    session = load_session(path)
    save_session(
        session.model_copy(
            update={"settings": session.settings.model_copy(update={"left_out": ("box",)})}
        ),
        path,
    )
    before, count = load_session(path), len(session.bodies[0].keyframes)
    capsys.readouterr()
    assert done(path, "--remove", "body") == 0
    words = capsys.readouterr().out
    assert f"Removed body (box): {count} keyframes, 0 drafts and no tracked motion." in words
    assert "Bodies: stick (cylinder)." in words
    assert ids(path) == {"stick": "cylinder"}
    assert load_session(path).settings.left_out == ()
    assert read_session(path.with_name("session.json.previous")) == before


def test_holds_that_go_with_a_body_are_counted_and_a_dry_run_claims_nothing(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert done(path, "cylinder", "--name", "stick") == 0
    session = load_session(path)
    hand, handle = (
        BondEnd(body=body.id, part=body.body.names[0], point_m=(0.0, 0.0, 0.0))
        for body in session.bodies
    )
    bond = Bond(holder=hand, held=handle, first_frame=0, last_frame=4)
    save_session(session.model_copy(update={"bonds": (bond,)}), path)
    before = path.read_bytes()
    went = "stick (cylinder): 0 keyframes, 0 drafts, no tracked motion and 1 hold."
    capsys.readouterr()
    assert done(path, "--remove", "stick", "--dry-run") == 0
    assert capsys.readouterr().out.startswith(f"Would remove {went}\n")
    assert done(path, "--remove", "stick", "--dry-run", "--json") == 0
    assert json.loads(capsys.readouterr().out)["removed_bonds"] == 1
    assert done(path, "dog", "--dry-run") == 0
    assert capsys.readouterr().out.startswith("Would add dog, ")
    assert path.read_bytes() == before
    assert done(path, "--remove", "stick") == 0
    assert capsys.readouterr().out.startswith(f"Removed {went}\n")
    assert load_session(path).bonds == ()


def full(session: Session) -> Session:
    bodies = (
        session.subject.model_copy(update={"id": f"b{number}"}) for number in range(MOST_BODIES)
    )
    return session.model_copy(update={"bodies": tuple(bodies)})


REFUSED = {
    "a preset that there is not": (("unicorn",), "There is no body 'unicorn'; the presets are"),
    "a file that is not there": (("none.json",), "cannot be read"),
    "a file of something else": (("{path}",), "session.json: "),
    "the only body": (("--remove", "box"), "A session needs a body: add another"),
    "a body that is not there": (("--remove", "dog"), "No body is called 'dog'"),
    "both at once": (("dog", "--remove", "body"), "leave out 'dog'"),
    "a name for what goes": (("--name", "x", "--remove", "body"), "leave out --name"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_is_one_sentence_and_changes_nothing(
    case: str, path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    asked, words = REFUSED[case]
    before = path.read_bytes()
    assert done(path, *(word.format(path=path) for word in asked)) == 2
    said = capsys.readouterr().err
    assert words in said
    assert said.count("\n") == 1
    assert path.read_bytes() == before


def test_a_session_has_no_more_bodies_than_its_file_may_have(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    save_session(full(load_session(path)), path)
    assert done(path, "dog") == 2
    assert f"The session has {MOST_BODIES} bodies" in capsys.readouterr().err
    assert done(path, "--remove", "b3") == 0
    assert done(path, "dog") == 0
    assert len(load_session(path).bodies) == MOST_BODIES
