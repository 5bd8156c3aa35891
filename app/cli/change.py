"""A command that changes a session: under its lock, or only said with --dry-run."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from contextlib import nullcontext
from dataclasses import dataclass

from keypose.app.cli.arguments import note
from keypose.app.cli.json_output import print_json
from keypose.app.document.folder_lock import locked
from keypose.app.words.bodies import body_names, track_again_words
from keypose.tracker.session import Session
from keypose.tracker.storage.files import load_session, save_session
from keypose.tracker.storage.outdated import outdated_beside


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
        before = load_session(path)
        done = change(before, arguments)
        if not arguments.dry_run:
            after = done.after()
            save_session(after, path)
            if outdated := outdated_beside(before, after):
                note(track_again_words([body_names(after)[body_id] for body_id in outdated]))
    if arguments.json:
        written = None if arguments.dry_run else str(path)
        print_json({"event": "finished", "session": written, **done.facts})
        return 0
    for line in done.lines:
        print(line)
    print("Nothing was written." if arguments.dry_run else f"Written: {path}")
    return 0
