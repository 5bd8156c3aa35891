"""`keypose add-body`: one body more, or less, in a session."""

from __future__ import annotations

import argparse
from pathlib import Path

from keypose.app.cli.change import Change, run_change
from keypose.app.document.defaults import read_defaults
from keypose.tracker.body.body import Body, load_body, preset
from keypose.tracker.errors import FormatError, listed
from keypose.tracker.session import Session
from keypose.tracker.session.bodies import TrackedBody, bodies_words, id_and_name


def run(arguments: argparse.Namespace) -> int:
    if arguments.remove is not None:
        for option in ("preset", "name"):
            if getattr(arguments, option) is not None:
                shown = "--name" if option == "name" else repr(arguments.preset)
                raise FormatError(f"--remove takes a body away: leave out {shown}.")
        return run_change(arguments, _removed)
    return run_change(arguments, _added)


def _added(session: Session, arguments: argparse.Namespace) -> Change:
    body = _body(arguments.preset)
    after, added = session.with_new_body(body, arguments.name or body.name)
    verb = "Would add" if arguments.dry_run else "Added"
    lines = (
        f"{verb} {id_and_name(added)}, {_counted(len(body.parts), 'part')}, not posed yet.",
        _bodies_line(after),
    )
    return Change(lambda: after, lines, {"added": added.id, **_facts(after)})


def _body(named: str | None) -> Body:
    """A preset by its name, that of `keypose config` where none is named, or a body's file."""
    if named is not None and named.lower().endswith(".json"):
        return load_body(Path(named).expanduser())
    return preset(read_defaults().body if named is None else named)


def _removed(session: Session, arguments: argparse.Namespace) -> Change:
    gone = session.about_called(arguments.remove).subject
    after = session.without_body(gone.id)
    holds = len(session.bonds) - len(after.bonds)
    verb = "Would remove" if arguments.dry_run else "Removed"
    lines = (f"{verb} {id_and_name(gone)}: {_held(gone, holds)}.", _bodies_line(after))
    facts = {"removed": gone.id, "removed_bonds": holds, **_facts(after)}
    return Change(lambda: after, lines, facts)


def _held(body: TrackedBody, holds: int) -> str:
    """What goes with a body, and how many of its holds, where it has any."""
    parts = [
        _counted(len(body.keyframes), "keyframe"),
        _counted(len(body.drafts), "draft"),
        "its tracked motion" if body.results is not None else "no tracked motion",
    ]
    return listed([*parts, *([_counted(holds, "hold")] if holds else [])])


def _bodies_line(session: Session) -> str:
    shown = f"; the page shows {session.subject.id}" if len(session.bodies) > 1 else ""
    return f"Bodies: {bodies_words(session.bodies)}{shown}."


def _facts(session: Session) -> dict[str, object]:
    return {"bodies": {body.id: body.body.name for body in session.bodies}}


def _counted(number: int, word: str) -> str:
    return f"{number} {word}{'s' * (number != 1)}"
