"""What a batch remembers over an interruption, however rude."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from keypose.app.jobs.batch.journal import FOLDER, NAME, Journal
from keypose.tracker.errors import SessionError

ASKED = {"quality": "full", "export": ("bvh", "glb")}
ONE = Path("/one/session.json")
TWO = Path("/odd\udcff/session.json")


@contextmanager
def journal(folder: Path, **asked: object) -> Iterator[Journal]:
    opened = Journal(folder, {**ASKED, **asked})
    try:
        yield opened
    finally:
        opened.close()


def test_what_was_done_before_an_interruption_is_known_after_it(tmp_path: Path) -> None:
    with journal(tmp_path) as first:
        assert not first.done
        for session in (ONE, TWO):
            first.begin(session)
        first.finish(TWO)
    with journal(tmp_path) as second:
        assert second.begun == {str(ONE), str(TWO)}
        assert second.done == {str(TWO)}
        second.finish(ONE)
    with journal(tmp_path) as third:
        assert third.done == {str(ONE), str(TWO)}


def test_after_the_end_a_batch_begins_anew(tmp_path: Path) -> None:
    with journal(tmp_path) as first:
        first.finish(ONE)
        first.end()
    with journal(tmp_path) as second:
        assert not second.done


def test_another_batch_in_the_same_folder_begins_anew(tmp_path: Path) -> None:
    with journal(tmp_path) as first:
        first.finish(ONE)
    with journal(tmp_path, quality="preview") as second:
        assert not second.done
        second.begin(ONE)
    with journal(tmp_path) as third:
        assert not third.done


def test_a_batch_that_never_began_leaves_what_another_has_done(tmp_path: Path) -> None:
    with journal(tmp_path) as first:
        first.finish(ONE)
    with journal(tmp_path, quality="preview"):
        pass
    with journal(tmp_path) as third:
        assert third.done == {str(ONE)}


@pytest.mark.parametrize("cut", range(1, 12))
def test_a_line_that_was_cut_off_costs_that_line_alone(tmp_path: Path, cut: int) -> None:
    with journal(tmp_path) as first:
        first.finish(ONE)
        first.finish(TWO)
    path = tmp_path / FOLDER / NAME
    path.write_bytes(path.read_bytes()[:-cut])
    with journal(tmp_path) as second:
        assert str(ONE) in second.done
        second.finish(Path("/three"))
    with journal(tmp_path) as third:
        assert {str(ONE), "/three"} <= third.done


def test_a_damaged_journal_is_as_none(tmp_path: Path) -> None:
    (tmp_path / FOLDER).mkdir()
    (tmp_path / FOLDER / NAME).write_bytes(b"\xff\x00 [1]\n[2]\n7")
    with journal(tmp_path) as found:
        assert not found.done


_HOLD = """
import sys
from pathlib import Path
from keypose.app.jobs.batch.journal import Journal
Journal(Path(sys.argv[1]), {})
print("held", flush=True)
sys.stdin.read()
"""


def test_one_batch_at_a_time_has_a_folder(tmp_path: Path) -> None:
    with subprocess.Popen(
        [sys.executable, "-c", _HOLD, str(tmp_path)],
        cwd=Path(__file__).parents[4],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == "held\n"
        with pytest.raises(SessionError, match=f"another Keypose \\(pid {other.pid}\\)"):
            Journal(tmp_path, ASKED)
        other.kill()
    with journal(tmp_path):
        pass
