"""Two thousand spoilt sessions: opened, or refused in one sentence; never changed."""

from __future__ import annotations

import json
import random
import re
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from keypose.tracker.errors import SessionError
from keypose.tracker.session.history import History, Step
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.edit_history import Moment, edit_record, whole_record
from keypose.tracker.storage.files import journal_path, load_session, open_session, session_json
from keypose.tracker.storage.journal import lines
from tests.tracker import session_cases as cases

MUTANTS = 2000
ODD: tuple[Any, ...] = (
    None, True, -1, 0, 1.5, 1e308, -1e-308, 10**30, "", "x", "\x00", "\ud800", "../../etc/passwd",
    [], {}, [[]], {"a": {}}, [None] * 50, "9" * 400, float("nan"), float("inf"),
)  # fmt: skip


def _places(value: Any, at: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    yield at
    if isinstance(value, dict | list):
        for key, one in value.items() if isinstance(value, dict) else enumerate(value):
            yield from _places(one, (*at, key))


def _structural(session: bytes, chance: random.Random) -> bytes:
    """A value is exchanged, dropped, doubled or moved."""
    data = json.loads(session)
    for _ in range(chance.randint(1, 3)):
        place = chance.choice([p for p in _places(data) if p])
        holder = data
        for key in place[:-1]:
            holder = holder[key]
        kind = chance.randrange(4)
        if kind == 0:
            del holder[place[-1]]
        elif kind == 1 and isinstance(holder, list):
            holder.append(holder[place[-1]])
        elif kind == 2 and isinstance(holder, dict):
            holder[str(chance.choice(ODD))[:9]] = holder[place[-1]]
        else:
            holder[place[-1]] = chance.choice(ODD)
    return json.dumps(data).encode("utf-8", "surrogatepass")


def _bytewise(content: bytes, chance: random.Random) -> bytes:
    """Bytes flip, go missing or come twice."""
    spoilt = bytearray(content)
    for _ in range(chance.randint(1, 6)):
        at = chance.randrange(len(spoilt))
        kind = chance.randrange(4)
        if kind == 0:
            spoilt[at] ^= 1 << chance.randrange(8)
        elif kind == 1:
            del spoilt[at : at + chance.randint(1, 200)]
        elif kind == 2:
            spoilt[at:at] = spoilt[at : at + chance.randint(1, 200)]
        else:
            del spoilt[at + 1 :]
    return bytes(spoilt)


Spoil = Callable[[bytes, random.Random], bytes]


@pytest.mark.parametrize("spoil", [_structural, _bytewise])
def test_spoilt_sessions_are_opened_or_refused_in_one_sentence_and_never_changed(
    tmp_path: Path, spoil: Spoil
) -> None:
    content = session_json(cases.session())
    path = tmp_path / "session.json"
    opened = 0
    for seed in range(MUTANTS // 2):
        spoilt = spoil(content, random.Random(seed))
        path.write_bytes(spoilt)
        words = _refusal(path)
        opened += words is None
        assert words is None or re.fullmatch(r"session\.json[^\n]+", words)
        assert path.read_bytes() == spoilt
    assert 0 < opened < MUTANTS // 2
    assert [file.name for file in tmp_path.iterdir()] == ["session.json"]


def _refusal(path: Path) -> str | None:
    """Why a session is refused; None when it opens."""
    try:
        load_session(path)
    except SessionError as error:
        return str(error)
    return None


def test_beside_a_spoilt_journal_a_session_opens_as_it_stands_or_as_it_was_left(
    tmp_path: Path,
) -> None:
    start = cases.session()
    docs = [start, cases.session(keyframes=(0, 4)), cases.session(keyframes=(0, 8))]
    moments = [Moment(docs[0])]
    for doc in docs[1:]:
        before = moments[-1]
        past = (*before.history.past, Step(before.doc, "edit", 0))
        moments.append(Moment(doc, History(past)))
    records = [*whole_record(moments[0]), *map(edit_record, moments, moments[1:])]
    path = tmp_path / "session.json"
    path.write_bytes(session_json(start))
    known = {session_json(doc) for doc in docs}
    for seed in range(300):
        journal_path(path).write_bytes(_bytewise(lines(records), random.Random(seed)))
        spoilt = journal_path(path).read_bytes()
        found = open_session(path)
        assert session_json(found.session) in known
        assert journal_path(path).read_bytes() == spoilt


@pytest.mark.parametrize("seed", range(40))
def test_a_journal_whose_lines_are_whole_but_say_nonsense_harms_nothing(
    tmp_path: Path, seed: int
) -> None:
    start = cases.session()
    after = Moment(cases.session(keyframes=(0, 4)), History((Step(start, "edit", 0),)))
    records = [*whole_record(Moment(start)), edit_record(Moment(start), after)]
    chance = random.Random(seed)
    spoilt = [_structural(json.dumps(record).encode(), chance) for record in records]
    path = tmp_path / "session.json"
    path.write_bytes(session_json(start))
    journal_path(path).write_bytes(
        b"".join(b"%08x %s\n" % (zlib.crc32(text), text) for text in spoilt)
    )
    opened = open_session(path)
    assert isinstance(opened.session, Session)
    assert Session.model_validate(opened.session.model_dump()) == opened.session
