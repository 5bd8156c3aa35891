"""A command that changes a session: under its lock, or only said with --dry-run."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from contextlib import nullcontext
from dataclasses import dataclass

from keypose.app.cli.json_output import print_json
from keypose.app.document.folder_lock import locked
from keypose.tracker.session import Session
from keypose.tracker.storage.files import load_session, save_session


@dataclass(frozen=True, eq=False)
class Change:
    """What becomes of a session, and what is said of it.

    after: makes the session that is written, with the files beside it.
    lines: for a person.  facts: for --json.
    """

    after: Callable[[], Session]
    lines: tuple[str, ...]
    facts: Mapping[str, object]


def run_change(
    arguments: argparse.Namespace, change: Callable[[Session, argparse.Namespace], Change]
) -> int:
    """Change the session that is named; with --dry-run nothing is written.

    arguments: session, dry_run, json.
    """
    path = arguments.session
    # Reading it reports one that is not there.
    is_held = path.is_file() and not arguments.dry_run
    with locked(path, "close it there first") if is_held else nullcontext():
        done = change(load_session(path), arguments)
        if not arguments.dry_run:
            save_session(done.after(), path)
    if arguments.json:
        written = None if arguments.dry_run else str(path)
        print_json({"event": "finished", "session": written, **done.facts})
        return 0
    for line in done.lines:
        print(line)
    print("Nothing was written." if arguments.dry_run else f"Written: {path}")
    return 0
