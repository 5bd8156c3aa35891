"""Kill a Keypose that edits at a random moment, and look for what it had acknowledged."""

from __future__ import annotations

import random
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

from keypose.tracker.storage.edit_history import mark_of, without_results
from keypose.tracker.storage.files import journal_path, open_session
from keypose.tracker.storage.journal import read_journal
from tests.app.serving import ROOT

LONGEST_S = 1.5


@dataclass(frozen=True)
class Death:
    """acknowledged: edits that were; lost: those of them that are nowhere to be found; undoable:
    steps that can be taken back afterwards."""

    acknowledged: int
    lost: int
    undoable: int


def kill_once(session_path: Path, seed: int) -> Death:
    """Let it edit for a random while, and count what is lost. Raises when nothing opens."""
    command = [sys.executable, "-m", "tests.app.scribe", str(session_path), str(seed)]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        first = process.stdout.readline().split()
        assert first[:1] == ["opened"], first
        time.sleep(random.Random(seed).random() * LONGEST_S)
        process.kill()
        rest = process.stdout.read()
    reported = [line.split()[1] for line in rest.splitlines(keepends=True) if line.endswith("\n")]
    return _death([first[1], *reported], session_path)


def _death(reported: list[str], session_path: Path) -> Death:
    opened = open_session(session_path)
    found = [
        str(r["mark"]) for r in read_journal(journal_path(session_path)).records if "mark" in r
    ]
    newest = mark_of(without_results(opened.session))
    lost, at = 0, 0
    for mark in reported:  # in their order, looking is no step of its own
        while at < len(found) and found[at] != mark:
            at += 1
        if at == len(found) and mark != newest:
            lost, at = lost + 1, 0
    return Death(len(reported) - 1, lost, len(opened.recovered.moment.history.past))
