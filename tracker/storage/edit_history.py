"""The journal's records: the edits that led to a document and its history.

    {"base": session, "mark": …}                         where the journal begins
    {"frame", "doc", "kept", "past", "future", "mark"}   one edit, undo or redo
    {"saved": mark}                                      the session file then held this

The first two also have "revision", and "clients" where these changed: see Received.

`doc` are the changes from the document before. `kept` is [first, stop, count]: past[first:stop] and
future[:count] of the history before stay. `past` and `future` are the new steps, each with "doc",
the changes from the document before, and "made", seconds since 1970 where they are known. A mark is
a digest of the document, by which the session file is found in the journal.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from keypose.tracker.errors import SessionError
from keypose.tracker.session.history import History, Step
from keypose.tracker.session.migrate import PRESENT, migrate
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.changes import apply_changes, changes
from keypose.tracker.storage.journal import Record

OUTSIDE = "change made outside"
"""The label of a step that took over a session file changed by another program."""


_NONSENSE = (ValueError, LookupError, TypeError, AttributeError, ArithmeticError, SessionError)
"""Errors from complete lines with wrong content."""


@dataclass(frozen=True)
class Received:
    """Which edits a document holds, so that an edit that is sent twice is made once.

    clients:  of each client, such as a browser's tab, the number of its last edit that is in it.
    revision: another one after every edit; empty where it is not known.
    """

    clients: Mapping[str, int] = field(default_factory=dict)
    revision: str = ""


@dataclass(frozen=True, eq=False)
class Moment:
    """A document, its history, the frame one stood at, and whose edits are in it."""

    doc: Session
    history: History = field(default_factory=History)
    frame: int = 0
    received: Received = field(default_factory=Received)

    def each(self, change: Callable[[Session], Session]) -> Moment:
        """The same with the document of this moment and of every step changed."""

        def steps(before: tuple[Step, ...]) -> tuple[Step, ...]:
            return tuple(replace(step, doc=change(step.doc)) for step in before)

        history = History(steps(self.history.past), steps(self.history.future))
        return replace(self, doc=change(self.doc), history=history)


@dataclass(frozen=True, eq=False)
class Recovered:
    """The state recovered from journal and session file.

    moment: the newest state.  ahead: edits that the session file does not have yet.
    follows: whether the journal can be continued; otherwise a new one begins.
    """

    moment: Moment
    ahead: int
    follows: bool


def mark_of(session: Session) -> str:
    """Equal for equal documents, wherever the video is stored, whatever was tracked, and whenever
    meshes and cameras were exported."""
    left_out: Any = {
        "schema_version": True,
        "views": {"__all__": session.evidence.export_fields},
        "bodies": {"__all__": {"results"}},
    }
    content = session.model_dump_json(exclude=left_out).encode()
    return hashlib.sha256(content).hexdigest()[:16]


def without_results(session: Session) -> Session:
    """The document: what a person decides about the bodies."""
    if all(body.results is None for body in session.bodies):
        return session
    bodies = tuple(body.model_copy(update={"results": None}) for body in session.bodies)
    return session.model_copy(update={"bodies": bodies})


def with_results_of(doc: Session, tracked: Session) -> Session:
    """The document with the results of another state of the session, each of its own body."""
    results_of_body = {body.id: body.results for body in tracked.bodies}
    bodies = tuple(
        body.model_copy(update={"results": results_of_body.get(body.id)}) for body in doc.bodies
    )
    return doc.model_copy(update={"bodies": bodies})


def of_film(moment: Moment, doc: Session) -> Moment:
    """The same with the video where it is now, since both may have been moved, with the motion of
    other bodies, and with the unknown fields, which are no edit."""
    own, now = {"schema_version": doc.schema_version, **(doc.model_extra or {})}, doc.evidence
    return moment.each(
        lambda session: with_results_of(
            session.changed(session.evidence.refreshed_fields(now)).model_copy(update=own), doc
        )
    )


# --- writing


def base_record(moment: Moment) -> Record:
    """The first record of a journal; the records after it hold the history."""
    doc = moment.doc
    return {
        "base": doc.model_dump(mode="json"),
        "frame": moment.frame,
        "mark": mark_of(doc),
        **_received_since(Received(), moment.received),
    }


def edit_record(before: Moment, after: Moment) -> Record:
    """The step from one moment to the next."""
    first, stop = _kept_range(before.history.past, after.history.past)
    future = _common(before.history.future, after.history.future)
    return {
        "frame": after.frame,
        "doc": changes(before.doc, after.doc),
        "kept": [first, stop, future],
        "past": [_step_record(step, before.doc) for step in after.history.past[stop - first :]],
        "future": [_step_record(step, before.doc) for step in after.history.future[future:]],
        "mark": mark_of(after.doc),
        **_received_since(before.received, after.received),
    }


def single_steps(before: Moment, after: Moment) -> Iterator[tuple[Moment, Moment]]:
    """One moment and the next, where several steps were undone or redone at once: a record of them
    all would hold the whole way for every step."""
    done = len(after.history.past)
    last = before
    if after.history.total == before.history.total and abs(done - len(before.history.past)) > 1:
        steps = list(before.history.way_to(before.doc, done))
        if steps and steps[-1][0].doc is after.doc:
            for step, history in steps[:-1]:
                here = Moment(step.doc, history, step.frame, after.received)
                yield last, here
                last = here
    yield last, after


def saved_record(mark: str) -> Record:
    """The session file holds the document of this mark."""
    return {"saved": mark}


def whole_record(moment: Moment) -> Iterator[Record]:
    """The records of a journal with this history and nothing else."""
    past, future = moment.history.past, moment.history.future
    docs = [*(step.doc for step in past), moment.doc]
    frame = past[0].frame if past else moment.frame
    last = Moment(docs[0], frame=frame, received=moment.received)
    yield base_record(last)
    for number, doc in enumerate(docs[1:], start=1):
        frame = past[number].frame if number < len(past) else moment.frame
        here = Moment(doc, History(past[:number]), frame, moment.received)
        yield edit_record(last, here)
        last = here
    if future:
        yield edit_record(last, moment)


# --- reading


def recover(session: Session, records: Sequence[Record]) -> Recovered:
    """The newest state, of the session file as it was read and the journal beside it.

    Edits that only the journal has are restored. Where the file is unknown to the journal, another
    program wrote it: it counts, as one more step, which can be undone.
    """
    doc = without_results(session)
    alone = Recovered(Moment(doc), 0, follows=False)
    try:
        last, marks, saved = _replay(records)
    except _NONSENSE:
        return alone
    if last is None or not is_same_film(last.doc, doc):
        return alone
    mark = mark_of(doc)
    matching = [k for k in range(saved, len(marks)) if mark in marks[k]]
    if matching:
        newest = of_film(last, doc)
        if not _fits_together(newest.doc):
            return alone
        return Recovered(newest, len(marks) - 1 - matching[-1], follows=True)
    last = of_film(last, doc)
    history = last.history.after(last.doc, OUTSIDE, last.frame)
    theirs = replace(last.received, revision="")  # the file has none
    return Recovered(Moment(doc, history, last.frame, theirs), 0, follows=False)


def _fits_together(doc: Session) -> bool:
    """Each change was validated by itself; this checks that all fit together."""
    try:
        Session.model_validate(doc.model_dump())
    except ValueError:
        return False
    return True


def is_same_film(session: Session, other: Session) -> bool:
    """Whether both are about the same video, as far as is known. Meshes may be exported
    again.
    """
    return session.evidence.is_same(other.evidence)


def _replay(records: Sequence[Record]) -> tuple[Moment | None, list[set[str]], int]:
    """The last moment, the marks of all, and which of them the session file was last known to
    hold. A document of an older version has the mark it was given then, and its present one."""
    last: Moment | None = None
    marks: list[set[str]] = []
    saved, is_older = 0, False
    for record in records:
        if "saved" in record:
            matching = [k for k in range(saved, len(marks)) if record["saved"] in marks[k]]
            saved = matching[-1] if matching else saved
            continue
        if "base" in record:
            last, is_older = _base(record), record["base"].get("schema_version") != PRESENT
        elif last is not None:
            last = _next(last, record)
        present = {mark_of(last.doc)} if is_older and last is not None else set()
        marks.append({str(record["mark"]), *present})
    return last, marks, saved


def _base(record: Mapping[str, Any]) -> Moment:
    base = migrate(record["base"], "the journal")
    received = _merge_received(Received(), record)
    return Moment(Session.model_validate(base), frame=int(record["frame"]), received=received)


def _next(before: Moment, record: Mapping[str, Any]) -> Moment:
    first, stop, future = (int(number) for number in record["kept"])
    past = (*before.history.past[first:stop], *_steps(record["past"], before.doc))
    ahead = (*before.history.future[:future], *_steps(record["future"], before.doc))
    doc = apply_changes(before.doc, record["doc"])
    received = _merge_received(before.received, record)
    return Moment(doc, History(past, ahead), int(record["frame"]), received)


# --- clients


def _received_since(before: Received, after: Received) -> Record:
    new = {name: n for name, n in after.clients.items() if before.clients.get(name) != n}
    return {
        **({"clients": new} if new else {}),
        **({"revision": after.revision} if after.revision else {}),
    }


def _merge_received(before: Received, record: Mapping[str, Any]) -> Received:
    new = {str(name): int(n) for name, n in record.get("clients", {}).items()}
    others = {name: n for name, n in before.clients.items() if name not in new}
    return Received({**others, **new}, str(record.get("revision", "")))  # the latest last


# --- steps


def _step_record(step: Step, doc: Session) -> Record:
    where = {} if step.doc is doc else changes(doc, step.doc)
    made = {} if step.made_s is None else {"made": step.made_s}
    return {"label": step.label, "frame": step.frame, "doc": where, **made}


def _steps(records: Sequence[Mapping[str, Any]], doc: Session) -> Iterator[Step]:
    for entry in records:
        doc_there = apply_changes(doc, entry["doc"])
        yield Step(doc_there, str(entry["label"]), int(entry["frame"]), _made(entry.get("made")))


def _made(value: Any) -> float | None:
    """Older journals do not hold when a step was made."""
    is_time = type(value) in (int, float) and math.isfinite(value)
    return float(value) if is_time else None


def _kept_range(before: Sequence[Step], after: Sequence[Step]) -> tuple[int, int]:
    """Which range of the past the new past begins with: the oldest steps may be dropped."""
    if not before or not after:
        return 0, 0
    first = next((k for k, step in enumerate(before) if step.is_same(after[0])), None)
    if first is None:
        return 0, 0
    return first, first + _common(before[first:], after)


def _common(before: Sequence[Step], after: Sequence[Step]) -> int:
    """How many steps both begin with."""
    count = 0
    for step, step_after in zip(before, after, strict=False):
        if not step.is_same(step_after):
            break
        count += 1
    return count
