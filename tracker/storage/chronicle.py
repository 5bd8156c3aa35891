"""The journal's records: how a document and its history became what they are.

    {"base": session, "mark": …}                         where the journal begins
    {"frame", "doc", "kept", "past", "future", "mark"}   one edit, undo or redo
    {"saved": mark}                                      the session file then held this

The first two also have "revision", and "clients" where these changed: see Received.

`doc` are the changes from the document before; `kept` tells which steps of the history stay: the
past's first and behind its last, the future's number. `past` and `future` are the steps that are
new, each with where its document is found: "doc", the document before, or changes from it. A mark
is a digest of the document, by which the session file is found in the journal.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from tracker.errors import SessionError
from tracker.session.history import History, Step
from tracker.session.schema import Session
from tracker.session.versions import migrate
from tracker.storage.changes import changed, changes
from tracker.storage.journal import Record

OUTSIDE = "change made outside"
"""What a step is called that brought a session file changed by another program."""


_NONSENSE = (ValueError, LookupError, TypeError, AttributeError, ArithmeticError, SessionError)
"""What whole lines lead to that do not say what they should."""


@dataclass(frozen=True)
class Received:
    """Which edits a document holds, so that none that is sent again is made again.

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

    def each(self, changed: Callable[[Session], Session]) -> Moment:
        """The same with the document, and that of every step, changed."""

        def steps(told: tuple[Step, ...]) -> tuple[Step, ...]:
            return tuple(replace(step, doc=changed(step.doc)) for step in told)

        history = History(steps(self.history.past), steps(self.history.future))
        return replace(self, doc=changed(self.doc), history=history)


@dataclass(frozen=True, eq=False)
class Recovered:
    """What journal and session file together say.

    moment: the newest state.  ahead: edits that the session file does not have yet.
    follows: whether the journal can be gone on with; otherwise it is begun anew.
    """

    moment: Moment
    ahead: int
    follows: bool


def mark_of(session: Session) -> str:
    """Equal for documents that say the same, wherever the video lies and whatever was tracked; and
    whenever meshes and cameras were exported."""
    left_out: Any = {"results": True, "video": {"path"}, "schema_version": True}
    if session.surface is not None:
        left_out |= {"video": {"path", "fingerprint"}, "surface": {"cameras_fingerprint"}}
    content = session.model_dump_json(exclude=left_out).encode()
    return hashlib.sha256(content).hexdigest()[:16]


def without_results(session: Session) -> Session:
    """The document: what a person decides."""
    return session if session.results is None else session.model_copy(update={"results": None})


def of_film(moment: Moment, doc: Session) -> Moment:
    """The same with the video where it lies now, for both may have been moved, and with the fields
    that are not known: they are no edit."""
    told = {"video": doc.video, "schema_version": doc.schema_version, **(doc.model_extra or {})}
    return moment.each(lambda one: _of_cameras(one, doc).model_copy(update=told))


def _of_cameras(one: Session, doc: Session) -> Session:
    """With what is known now of the cameras' file, where both speak of the same."""
    ours, theirs = one.surface, doc.surface
    if ours is None or theirs is None or ours.cameras != theirs.cameras:
        return one
    surface = ours.model_copy(update={"cameras_fingerprint": theirs.cameras_fingerprint})
    return one.model_copy(update={"surface": surface})


# --- writing


def base_record(moment: Moment) -> Record:
    """The beginning of a journal; the history is told by what follows."""
    doc = moment.doc
    return {
        "base": doc.model_dump(mode="json"),
        "frame": moment.frame,
        "mark": mark_of(doc),
        **_received_since(Received(), moment.received),
    }


def edit_record(before: Moment, after: Moment) -> Record:
    """What leads from one moment to the next."""
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


def saved_record(mark: str) -> Record:
    """The session file holds the document of this mark."""
    return {"saved": mark}


def whole_record(moment: Moment) -> Iterator[Record]:
    """A journal that says what there is, and no more."""
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

    What the journal has beyond the file is brought back. Where the file holds what the journal
    does not know, another program wrote it: it counts, as one more step, which can be undone.
    """
    doc = without_results(session)
    alone = Recovered(Moment(doc), 0, follows=False)
    try:
        last, marks, saved = _replayed(records)
    except _NONSENSE:
        return alone
    if last is None or not is_same_film(last.doc, doc):
        return alone
    mark = mark_of(doc)
    known = [k for k in range(saved, len(marks)) if marks[k] == mark]
    if known:
        newest = of_film(last, doc)
        if not _fits_together(newest.doc):
            return alone
        return Recovered(newest, len(marks) - 1 - known[-1], follows=True)
    last = of_film(last, doc)
    history = last.history.after(last.doc, OUTSIDE, last.frame)
    theirs = replace(last.received, revision="")  # whoever wrote the file said none
    return Recovered(Moment(doc, history, last.frame, theirs), 0, follows=False)


def _fits_together(doc: Session) -> bool:
    """Each change was validated by itself; whether all fit together is seen here."""
    try:
        Session.model_validate(doc.model_dump())
    except ValueError:
        return False
    return True


def is_same_film(one: Session, other: Session) -> bool:
    """Whether both are about one video, as far as they tell. Meshes may be exported again."""
    a, b = one.video, other.video
    facts = (a.frame_count, a.width, a.height) == (b.frame_count, b.width, b.height)
    if one.surface is not None and other.surface is not None:
        return facts
    return facts and (a.fingerprint == b.fingerprint or "" in (a.fingerprint, b.fingerprint))


def _replayed(records: Sequence[Record]) -> tuple[Moment | None, list[str], int]:
    """The last moment, the marks of all, and which of them the session file was last known to
    hold."""
    last: Moment | None = None
    marks: list[str] = []
    saved = 0
    for record in records:
        if "saved" in record:
            found = [k for k in range(saved, len(marks)) if marks[k] == record["saved"]]
            saved = found[-1] if found else saved
            continue
        if "base" in record:
            last = _base(record)
        elif last is not None:
            last = _next(last, record)
        marks.append(str(record["mark"]))
    return last, marks, saved


def _base(record: Mapping[str, Any]) -> Moment:
    base = migrate(record["base"], "the journal")
    received = _merge_received(Received(), record)
    return Moment(Session.model_validate(base), frame=int(record["frame"]), received=received)


def _next(before: Moment, record: Mapping[str, Any]) -> Moment:
    first, stop, future = (int(number) for number in record["kept"])
    past = (*before.history.past[first:stop], *_steps(record["past"], before.doc))
    ahead = (*before.history.future[:future], *_steps(record["future"], before.doc))
    doc = changed(before.doc, record["doc"])
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
    return Received({**others, **new}, str(record.get("revision", "")))  # the last heard last


# --- steps


def _step_record(step: Step, doc: Session) -> Record:
    where = {} if step.doc is doc else changes(doc, step.doc)
    return {"label": step.label, "frame": step.frame, "doc": where}


def _steps(told: Sequence[Mapping[str, Any]], doc: Session) -> Iterator[Step]:
    for one in told:
        yield Step(changed(doc, one["doc"]), str(one["label"]), int(one["frame"]))


def _kept_range(before: Sequence[Step], after: Sequence[Step]) -> tuple[int, int]:
    """Which stretch of the past the new past begins with: the oldest steps may be forgotten."""
    if not before or not after:
        return 0, 0
    first = next((k for k, step in enumerate(before) if step is after[0]), None)
    if first is None:
        return 0, 0
    return first, first + _common(before[first:], after)


def _common(before: Sequence[Step], after: Sequence[Step]) -> int:
    """How many steps both begin with."""
    count = 0
    for one, other in zip(before, after, strict=False):
        if one is not other:
            break
        count += 1
    return count
