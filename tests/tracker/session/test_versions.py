"""Sessions of every version open, and none is lost by it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from keypose.tracker.errors import SessionError
from keypose.tracker.session.migrate import PRESENT, STEPS
from keypose.tracker.storage.files import load_session, save_session
from tests.tracker import session_cases as cases


def _write(path: Path, **changes: Any) -> bytes:
    save_session(cases.session(), path)
    version = changes.get("schema_version", PRESENT)
    is_flat = version < 4
    data = cases.flat_data(cases.session(), version) if is_flat else json.loads(path.read_bytes())
    data |= changes
    path.write_text(json.dumps(data, indent=2))
    return path.read_bytes()


def test_there_is_a_step_from_every_older_version() -> None:
    assert sorted(STEPS) == list(range(1, PRESENT))


def test_an_older_session_opens_and_stays_as_it_is_until_it_is_saved(tmp_path: Path) -> None:
    path = tmp_path / "session.json"
    content = _write(path, schema_version=1)
    session = load_session(path)
    assert session == cases.session()
    assert path.read_bytes() == content
    assert [file.name for file in tmp_path.iterdir()] == ["session.json"]


@pytest.mark.parametrize(
    ("field", "old", "now"),
    [("initial", "linear", "auto"), ("initial", "both-ways", "auto"), ("quality", "fast", "full")],
)
def test_a_choice_that_is_no_more_means_one_that_there_is(
    tmp_path: Path, field: str, old: str, now: str
) -> None:
    path = tmp_path / "session.json"
    _write(path, settings={field: old})
    assert load_session(path).settings.model_dump()[field] == now


def test_before_an_older_session_is_saved_it_is_kept_for_good(tmp_path: Path) -> None:
    path = tmp_path / "session.json"
    content = _write(path, schema_version=1)
    session = load_session(path)
    for frames in ((0, 8), (0, 4)):
        save_session(cases.session(keyframes=frames), path)
    assert (tmp_path / "session.json.v1").read_bytes() == content
    assert load_session(tmp_path / "session.json.v1") == session
    assert json.loads(path.read_bytes())["schema_version"] == PRESENT


def test_a_newer_session_can_be_looked_at_and_is_never_changed(tmp_path: Path) -> None:
    path = tmp_path / "session.json"
    content = _write(path, schema_version=PRESENT + 1, colour="red")
    session = load_session(path)
    assert session.is_newer
    assert len(session.subject.keyframes) == len(cases.KEYFRAMES)
    with pytest.raises(SessionError, match=r"of a newer Keypose \(version 5\) and is not changed"):
        save_session(session, path)
    with pytest.raises(SessionError, match="newer Keypose"):
        save_session(cases.session(keyframes=(0, 8)), path)
    assert path.read_bytes() == content


def test_fields_that_are_not_known_survive_wherever_they_stand(tmp_path: Path) -> None:
    path = tmp_path / "session.json"
    save_session(cases.session(), path)
    data = json.loads(path.read_bytes())
    data["lab"] = {"subject": 7, "notes": ["ä", None]}
    data["views"][0]["camera"]["serial"] = "A-1"
    data["bodies"][0]["keyframes"][1]["sure"] = 0.5
    data["bodies"][0]["body"]["parts"][2]["mass_kg"] = 2.1
    data["bodies"][0]["body"]["parts"][2]["shape"]["colour"] = "red"
    data["settings"]["gpu"] = False
    path.write_text(json.dumps(data))
    session = load_session(path)
    save_session(session.changed({"up_world": (0.0, -1.0, 0.0)}), path)
    data["world"]["up_world"] = [0.0, -1.0, 0.0]
    assert json.loads(path.read_bytes()) == data


@pytest.mark.parametrize(("was", "becomes"), [(True, ("feet", "set")), (False, ())])
def test_up_that_was_found_from_pinned_feet_is_still_known_to_be(
    tmp_path: Path, was: bool, becomes: tuple[str, ...]
) -> None:
    path = tmp_path / "session.json"
    save_session(cases.session(), path)
    data = json.loads(path.read_bytes())
    data["world"] = {"up_world": [0.0, -1.0, 0.0], "up_from_feet": was}
    path.write_text(json.dumps(data))
    session = load_session(path)
    assert session.world.up_from == becomes
    save_session(session, path)
    assert session.has_up_of_hand
    assert "up_from_feet" not in json.loads(path.read_bytes())["world"]
    data["world"]["up_from_feet"] = "yes"
    path.write_text(json.dumps(data))
    with pytest.raises(SessionError, match="up_from_feet: is neither true nor false"):
        load_session(path)
