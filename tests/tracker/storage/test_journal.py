"""The journal brings back what the session file lacks, whatever was cut off, damaged or changed."""

from __future__ import annotations

import errno
import os
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from keypose.tracker.errors import SessionError
from keypose.tracker.session import IgnoreMask, Keyframe, Session
from keypose.tracker.session.history import MOST_STEPS, History, Step
from keypose.tracker.storage.changes import apply_changes, changes
from keypose.tracker.storage.edit_history import (
    OUTSIDE,
    Moment,
    Received,
    edit_record,
    mark_of,
    recover,
    saved_record,
    whole_record,
)
from keypose.tracker.storage.files import journal_path, load_session, open_session, save_session
from keypose.tracker.storage.journal import Journal, Read, lines, read_journal
from tests.tracker import session_cases as cases

RECORDS: list[dict[str, Any]] = [{"n": 0}, {"n": 1, "text": "ä\n"}, {"n": 2, "list": [1.5, None]}]


# --- lines


def test_what_was_appended_is_read(tmp_path: Path) -> None:
    journal = Journal(tmp_path / "journal.jsonl", 0)
    for record in RECORDS:
        journal.append([record])
    journal.close()
    found = read_journal(journal.path)
    assert list(found.records) == RECORDS
    assert found.whole
    assert found.size == journal.size == journal.path.stat().st_size


def test_where_there_is_no_journal_nothing_is_read(tmp_path: Path) -> None:
    assert read_journal(tmp_path / "journal.jsonl").records == ()


@given(cut=st.integers(min_value=0, max_value=len(lines(RECORDS))))
def test_a_journal_cut_anywhere_gives_its_whole_lines(
    tmp_path_factory: pytest.TempPathFactory, cut: int
) -> None:
    path = tmp_path_factory.mktemp("cut") / "journal.jsonl"
    path.write_bytes(lines(RECORDS)[:cut])
    found = read_journal(path)
    assert list(found.records) == RECORDS[: len(found.records)]
    assert lines(found.records) == lines(RECORDS)[: found.size]
    ends = [len(lines(RECORDS[:k])) for k in range(len(RECORDS) + 1)]
    assert found.size == max(end for end in ends if end <= cut)


@given(at=st.integers(min_value=0, max_value=len(lines(RECORDS)) - 1), bit=st.integers(0, 7))
def test_a_damaged_line_and_what_follows_it_is_not_read(
    tmp_path_factory: pytest.TempPathFactory, at: int, bit: int
) -> None:
    content = bytearray(lines(RECORDS))
    content[at] ^= 1 << bit
    path = tmp_path_factory.mktemp("damaged") / "journal.jsonl"
    path.write_bytes(content)
    found = read_journal(path)
    whole = sum(len(lines(RECORDS[: k + 1])) <= at for k in range(len(RECORDS)))
    assert list(found.records) == RECORDS[:whole]
    assert found.size < found.length


def test_behind_a_torn_line_one_goes_on_as_if_it_had_not_been(tmp_path: Path) -> None:
    path = tmp_path / "journal.jsonl"
    path.write_bytes(lines(RECORDS[:2]) + lines(RECORDS[2:])[:-5])
    journal = Journal(path, read_journal(path).size)
    journal.append([{"n": 9}])
    assert [record["n"] for record in read_journal(path).records] == [0, 1, 9]


def test_a_full_disk_leaves_the_lines_before_and_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    journal = Journal(tmp_path / "journal.jsonl", 0)
    journal.append(RECORDS[:1])
    write = os.write

    def half(file: int, content: bytes) -> int:
        write(file, content[:7])
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as patch:
        patch.setattr(os, "write", half)
        with pytest.raises(SessionError, match="No space left on device"):
            journal.append(RECORDS[1:])
    assert list(read_journal(journal.path).records) == RECORDS[:1]
    journal.append(RECORDS[1:])
    assert list(read_journal(journal.path).records) == RECORDS


# --- changes


def _poses(*shares: tuple[int, float]) -> tuple[Keyframe, ...]:
    return tuple(
        Keyframe.of(cases.SKELETON, cases.pose(share), frame, frame / 25) for frame, share in shares
    )


def _versions() -> list[Session]:
    start = cases.session()
    mask = IgnoreMask(polygon=((0, 0), (9, 0), (9, 9)), first_frame=0, last_frame=3)
    arm = start.subject.body.parts[1].model_copy(update={"joint_m": (-0.3, -0.2, 0.0)})
    parts = (start.subject.body.parts[0], arm, *start.subject.body.parts[2:])
    longer = start.subject.body.model_copy(update={"parts": parts})
    turned = start.settings.model_copy(update={"method": "paper", "passes": 3})
    wide = start.view.camera.model_copy(update={"fx": 50.0})
    return [
        start,
        start.changed({"keyframes": _poses((0, 0.1), (4, 0.7), (8, 1.0))}),
        start.changed({"keyframes": _poses((0, 0.1), (8, 1.0)), "camera": wide}),
        start.changed({"drafts": _poses((2, 0.3)), "ignore_masks": (mask,)}),
        start.changed({"body": longer, "up_world": (0.0, -1.0, 0.1)}),
        start.changed({"settings": turned, "keyframes": ()}),
    ]


VERSIONS = _versions()
NUMBERS = st.integers(0, len(VERSIONS) - 1)


@given(one=NUMBERS, other=NUMBERS)
def test_changes_make_one_session_of_any_other(one: int, other: int) -> None:
    before, after = VERSIONS[one], VERSIONS[other]
    reported = changes(before, after)
    assert apply_changes(before, reported) == after
    assert (reported == {}) == (one == other)


def test_an_edit_of_one_keyframe_gives_one_keyframe() -> None:
    frames = tuple((frame, frame / 10) for frame in range(9))
    start = cases.session().changed({"keyframes": _poses(*frames)})
    edited = (*start.subject.keyframes[:5], *_poses((5, 0.9)), *start.subject.keyframes[6:])
    reported = changes(start, start.changed({"keyframes": edited}))
    assert [keyframe["frame"] for keyframe in reported["keyframes"]["set"]] == [5]
    assert reported["keyframes"]["drop"] == []


@pytest.mark.parametrize(
    "reported",
    [{"colour": 1}, {"keyframes": 1}, {"keyframes": {"set": [{}]}}, {"camera": {"width": -1}}],
)
def test_what_is_no_change_is_refused(reported: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=r".+"):
        apply_changes(VERSIONS[0], reported)


# --- what journal and file say together


Edits = st.lists(st.one_of(NUMBERS, st.sampled_from(["undo", "redo"])), max_size=12)


def _moments(edits: list[Any]) -> list[Moment]:
    """What a person does, one moment after another."""
    moments = [Moment(VERSIONS[0])]
    for number, edit in enumerate(edits):
        now = moments[-1]
        if edit in ("undo", "redo"):
            found = getattr(now.history, edit)(now.doc)
            if found is not None:
                step, history = found
                moments.append(Moment(step.doc, history, step.frame))
        else:
            history = now.history.after(now.doc, f"edit {number}", number)
            moments.append(Moment(VERSIONS[edit].model_copy(), history, number))
    return moments


def _records(moments: list[Moment]) -> list[dict[str, Any]]:
    pairs = pairwise(moments)
    return [*whole_record(moments[0]), *(edit_record(a, b) for a, b in pairs)]


def _on_disk(records: list[dict[str, Any]], folder: Path) -> list[dict[str, Any]]:
    """As they come back from a file."""
    path = folder / "journal.jsonl"
    path.write_bytes(lines(records))
    return list(read_journal(path).records)


def _agree(one: Moment, other: Moment) -> None:
    assert one.doc == other.doc
    for mine, theirs in (
        (one.history.past, other.history.past),
        (one.history.future, other.history.future),
    ):
        assert [(s.label, s.frame) for s in mine] == [(s.label, s.frame) for s in theirs]
        assert all(a.doc == b.doc for a, b in zip(mine, theirs, strict=True))


def _received() -> list[Moment]:
    """Edits of two clients, and one of none."""
    moments = _moments([0, 1, 2])
    reported = (
        Received(),
        Received({"one": 3}, "one:3"),
        Received({"one": 3, "two": 1}, "two:1"),
        Received({"two": 1, "one": 7}, "of nobody"),
    )
    return [replace(m, received=r) for m, r in zip(moments, reported, strict=True)]


def test_whose_edits_a_document_holds_comes_back_also_when_the_journal_is_begun_anew() -> None:
    moments = _received()
    newest = moments[-1]
    for records in (_records(moments), list(whole_record(newest))):
        for file in (newest.doc, moments[0].doc):
            found = recover(file, records).moment.received
            assert found == newest.received


def test_what_another_program_wrote_is_no_revision_of_a_client() -> None:
    moments = _received()
    mask = IgnoreMask(polygon=((1, 1), (7, 1), (7, 7)), first_frame=1, last_frame=2)
    theirs = VERSIONS[0].changed({"ignore_masks": (mask,)})
    found = recover(theirs, _records(moments)).moment.received
    assert found == Received(moments[-1].received.clients, "")


def test_a_journal_that_names_no_clients_is_read_as_ever() -> None:
    records = _records(_moments([0, 1]))
    assert not any("clients" in record or "revision" in record for record in records)
    assert recover(VERSIONS[1], records).moment.received == Received()


@given(edits=Edits, data=st.data())
def test_whatever_moment_the_file_holds_the_newest_and_its_whole_history_come_back(
    tmp_path_factory: pytest.TempPathFactory, edits: list[Any], data: st.DataObject
) -> None:
    moments = _moments(edits)
    records = _on_disk(_records(moments), tmp_path_factory.mktemp("j"))
    at = data.draw(st.integers(0, len(moments) - 1))
    found = recover(moments[at].doc, records)
    assert found.follows
    assert found.ahead <= len(moments) - 1 - at
    _agree(found.moment, moments[-1])


@given(edits=Edits)
def test_a_journal_begun_anew_says_the_same(
    tmp_path_factory: pytest.TempPathFactory, edits: list[Any]
) -> None:
    last = _moments(edits)[-1]
    records = _on_disk(list(whole_record(last)), tmp_path_factory.mktemp("j"))
    found = recover(last.doc, records)
    _agree(found.moment, last)
    assert found.ahead == 0


def test_steps_that_were_forgotten_are_forgotten_in_the_journal() -> None:
    now = Moment(VERSIONS[0])
    records = _records([now])
    for number in range(MOST_STEPS + 3):
        history = now.history.after(now.doc, str(number), 0)
        after = Moment(VERSIONS[1 + number % 2], history)
        records.append(edit_record(now, after))
        now = after
    found = recover(now.doc, records)
    assert len(found.moment.history.past) == MOST_STEPS
    assert found.moment.history.past[0].label == "3"


def test_a_file_another_program_changed_counts_and_can_be_undone() -> None:
    moments = _moments([1, 2])
    found = recover(VERSIONS[4], _records(moments))
    assert found.moment.doc == VERSIONS[4]
    assert not found.follows
    step = found.moment.history.past[-1]
    assert step.label == OUTSIDE
    assert step.doc == moments[-1].doc
    assert len(found.moment.history.past) == 3


def test_an_older_file_put_back_by_a_person_counts() -> None:
    moments = _moments([1, 2])
    records = [*_records(moments), saved_record(mark_of(moments[-1].doc))]
    found = recover(moments[1].doc, records)
    assert found.moment.doc == moments[1].doc
    assert found.moment.history.past[-1].label == OUTSIDE


def test_the_journal_of_another_film_is_not_followed() -> None:
    other = VERSIONS[0].view.video.model_copy(update={"frame_count": 12})
    doc = VERSIONS[0].changed({"video": other})
    found = recover(doc, _records(_moments([1, 2])))
    assert found.moment.doc is doc
    assert found.moment.history.past == ()


def test_a_moved_video_is_where_the_file_says_for_every_step() -> None:
    moments = _moments([1, 2, "undo"])
    there = moments[-1].doc.view.video.model_copy(update={"path": "elsewhere/frames"})
    found = recover(moments[-1].doc.changed({"video": there}), _records(moments))
    assert found.follows
    history = found.moment.history
    docs = [found.moment.doc, *(step.doc for step in (*history.past, *history.future))]
    assert {doc.view.video.path for doc in docs} == {"elsewhere/frames"}


NONSENSE: dict[str, dict[str, Any]] = {
    "no base": {"frame": 0, "doc": {}, "kept": [0, 0, 0], "past": [], "future": [], "mark": "x"},
    "a base that is none": {"base": {"video": 3}, "frame": 0, "mark": "x"},
    "steps that are not there": {
        "frame": 0,
        "doc": 3,
        "kept": "all",
        "past": 1,
        "future": 2,
        "mark": 0,
    },
    "nothing": {},
}


@pytest.mark.parametrize("kind", NONSENSE)
def test_a_journal_of_nonsense_is_as_good_as_none(kind: str) -> None:
    found = recover(VERSIONS[1], [NONSENSE[kind]])
    assert found.moment.doc == VERSIONS[1]
    assert not found.follows


def test_results_stay_with_what_the_journal_brings_back(tmp_path: Path) -> None:
    path = cases.write_session(tmp_path)
    session = load_session(path)
    moved = session.changed({"keyframes": session.subject.keyframes[:2]})
    history = History((Step(session, "Delete keyframe 8", 8),))
    journal = Journal(journal_path(path), 0)
    journal.append(_records([Moment(session), Moment(moved, history, 8)]))
    found = open_session(path)
    assert found.recovered.ahead == 1
    assert found.session.subject.keyframes == moved.subject.keyframes
    assert found.session.subject.results == session.subject.results
    save_session(found.session, path)
    assert open_session(path).recovered.ahead == 0


def test_a_session_saved_anew_while_it_is_read_is_read_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The file of before and the journal of after would look as if another program wrote it."""
    path = tmp_path / "session.json"
    before, after = VERSIONS[0], VERSIONS[1]
    save_session(before, path)
    journal = Journal(journal_path(path), 0)
    journal.append(_records([Moment(before), Moment(after, History((Step(before, "edit", 0),)))]))
    saves = [after]

    def read_after_saving(journal_file: Path) -> Read:
        for session in saves:
            save_session(session, path)
            journal.append([saved_record(mark_of(session))])
        saves.clear()
        return read_journal(journal_file)

    monkeypatch.setattr("keypose.tracker.storage.files.read_journal", read_after_saving)
    found = open_session(path)
    assert found.session == after
    assert found.recovered.follows


def test_every_session_file_has_a_journal_of_its_own(tmp_path: Path) -> None:
    assert journal_path(tmp_path / "session.json").name == "journal.jsonl"
    assert journal_path(tmp_path / "take2.json").name == "take2.journal.jsonl"


def test_the_mark_gives_documents_apart_and_nothing_else() -> None:
    marks = {mark_of(session) for session in VERSIONS}
    assert len(marks) == len(VERSIONS)
    there = VERSIONS[0].view.video.model_copy(update={"path": "x"})
    assert mark_of(VERSIONS[0].changed({"video": there})) == mark_of(VERSIONS[0])
