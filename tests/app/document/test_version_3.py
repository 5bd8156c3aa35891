"""A session of the version before, whose fields stood side by side, opens with all that it has.

The files beside this one are as that version wrote them: the sample's box, tracked, and a journal
with two edits that the session's file lacks.
"""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from keypose.tracker.session.migrate import PRESENT
from keypose.tracker.storage.edit_history import Moment, base_record, edit_record
from keypose.tracker.storage.files import journal_path, open_session, save_session
from keypose.tracker.storage.journal import lines
from keypose.tracker.storage.outdated import outdated_words
from keypose.tracker.storage.results import load_results, segment_keys
from keypose.tracker.storage.tracks import load_trajectory
from tests.scenes import SAMPLES
from tests.tracker.session_cases import written

HERE = Path(__file__).parent / "version_3"


@pytest.fixture
def path(tmp_path: Path) -> Path:
    shutil.copytree(HERE, tmp_path / "old")
    shutil.copy(SAMPLES / "box" / "box.mp4", tmp_path / "old")
    return tmp_path / "old" / "session.json"


def test_the_edits_that_only_its_journal_has_come_back_and_can_be_undone(path: Path) -> None:
    found = open_session(path)
    assert (found.problem, found.recovered.ahead, found.recovered.follows) == ("", 2, True)
    assert found.session.world.up_world == (0.0, -1.0, 0.0)
    assert [note.text for note in found.session.notes] == ["a note"]
    past = found.recovered.moment.history.past
    assert [step.label for step in past] == ["set the camera level", "write the note at 3"]
    assert past[0].doc.world.up_world is None


def test_its_motion_is_the_one_that_would_be_tracked_today(path: Path) -> None:
    session = open_session(path).session
    assert session.subject.results is not None
    keys = [segment.key for segment in session.subject.results.segments]
    assert keys == list(segment_keys(session).values())
    assert outdated_words(session, load_trajectory(session, path)) is None
    assert list(load_results(session, path).fitting(session)) == [(0, 40)]


def test_saved_again_it_says_the_same_and_is_kept_as_it_was(path: Path) -> None:
    content, session = path.read_bytes(), open_session(path).session
    save_session(session, path)
    assert written(path)["schema_version"] == PRESENT
    assert open_session(path).session == session
    assert path.with_name("session.json.v3").read_bytes() == content


def test_its_journal_is_continued(path: Path) -> None:
    moment = open_session(path).recovered.moment
    after = Moment(moment.doc.with_up(None), moment.history, moment.frame)
    with journal_path(path).open("ab") as journal:
        journal.write(lines([edit_record(moment, after)]))
    found = open_session(path)
    assert (found.recovered.ahead, found.session.world.up_world) == (3, None)
    assert base_record(after)["base"]["schema_version"] == PRESENT
