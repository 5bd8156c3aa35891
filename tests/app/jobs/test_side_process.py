"""One work in a process of its own: it reports, it is cancelled, and whatever it does to itself is
said in a sentence."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

from keypose.app.jobs.side_process import Progress, SideProcess
from keypose.tracker.errors import FormatError
from keypose.tracker.limits import limit_memory
from tests.app.serving import LONGEST_S, ROOT

DIED = "It ended without a word."


@dataclass(frozen=True)
class Counting:
    died: str = DIED

    def do(self, progress: Progress) -> str:
        progress(1, 2)
        return "counted"


@dataclass(frozen=True)
class Refusing:
    died: str = DIED

    def do(self, progress: Progress) -> None:
        raise FormatError("It is no such file.")


@dataclass(frozen=True)
class Leaving:
    """As a library that crashes."""

    died: str = DIED

    def do(self, progress: Progress) -> None:
        os._exit(11)


@dataclass(frozen=True)
class Hoarding:
    """As a file that claims more than there is."""

    died: str = DIED

    def do(self, progress: Progress) -> None:
        limit_memory(64 * 2**20)
        bytearray(2**31)


@dataclass(frozen=True)
class Waiting:
    died: str = DIED

    def do(self, progress: Progress) -> None:
        progress(1, 2)
        time.sleep(3600)


def test_what_comes_of_it_comes_back() -> None:
    state = SideProcess(Counting()).wait()
    assert (state.state, state.result) == ("done", "counted")


def test_a_file_that_is_at_fault_is_reported_in_its_sentence() -> None:
    state = SideProcess(Refusing()).wait()
    assert (state.state, state.words) == ("failed", "It is no such file.")


def test_one_that_crashes_or_wants_all_memory_harms_itself_alone() -> None:
    for work in (Leaving(), Hoarding()):
        state = SideProcess(work).wait()
        assert (state.state, state.words) == ("failed", DIED)


def test_it_is_cancelled_whatever_it_is_doing() -> None:
    process = SideProcess(Waiting())
    process.cancel()
    assert process.wait().state == "cancelled"


ENDS_UNSEEN = """
import os, sys
from tests.app.jobs.test_side_process import SideProcess, Waiting
if __name__ == "__main__":
    side = SideProcess(Waiting())
    while side.state.done == 0:
        pass
    print("begun", flush=True)
    os.kill(os.getpid(), 9)
"""


def test_it_ends_with_a_parent_that_was_killed(tmp_path: Path) -> None:
    program = tmp_path / "ends.py"
    program.write_text(ENDS_UNSEEN)
    # It has the parent's output, too: that ends only once both have.
    done = subprocess.run(
        [sys.executable, str(program)], env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True, timeout=LONGEST_S,
    )  # fmt: skip
    assert done.stdout == b"begun\n"
