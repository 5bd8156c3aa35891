"""Words for the bodies of a session."""

from __future__ import annotations

from collections.abc import Sequence

from keypose.app.posing import part_label
from keypose.tracker.errors import listed
from keypose.tracker.session.schema import Session


def body_names(doc: Session) -> dict[str, str]:
    """What each body is called, by its id: by a person, else as its kind, with a number where that
    alone would be said of several."""
    kinds = {body.id: body.called or part_label(body.body.name) for body in doc.bodies}
    names: dict[str, str] = {}
    for body_id, kind in kinds.items():
        earlier = list(kinds.values())[: len(names)].count(kind)
        names[body_id] = f"{kind} {earlier + 1}" if earlier else kind
    return names


def name_among_several(doc: Session, body_id: str) -> str:
    """What a body is called; empty where it is the only one."""
    return body_names(doc)[body_id] if len(doc.bodies) > 1 else ""


def after_id(words: str, body_id: str, session: Session) -> str:
    """Words on one body after its id, as commands name it, where the session has several."""
    return f"{body_id}: {words}" if len(session.bodies) > 1 else words


def track_again_words(names: Sequence[str]) -> str:
    """Says that tracked bodies are out of date by a change of another one."""
    are, them = ("is", "it") if len(names) == 1 else ("are", "them")
    return f"{listed(names)} {are} out of date by this: track {them} again."
