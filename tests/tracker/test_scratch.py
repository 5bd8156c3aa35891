"""What a killed process leaves behind goes at the next start; what is in use stays."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from keypose.tracker.scratch import LOCK, Scratch, sweep_scratch

HOLDS = """
import sys, tempfile
tempfile.tempdir = sys.argv[1]
from keypose.tracker.scratch import Scratch
held = Scratch("export")
(held.path / "film.part").touch()
print(held.path, flush=True)
sys.stdin.read()
"""


@pytest.mark.skipif(not hasattr(os, "getuid") or os.getuid() != 0, reason="only root gives away")
def test_folders_of_other_users_stay(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    theirs = tmp_path / "keypose-export-1"
    theirs.mkdir()
    (theirs / LOCK).touch()
    os.chown(theirs, 65534, 65534)
    sweep_scratch()
    assert theirs.is_dir()


def test_folders_of_the_killed_go_and_those_in_use_and_of_others_stay(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    (tmp_path / "keypose-notes").mkdir()
    (tmp_path / "keypose-link").symlink_to(tmp_path / "keypose-notes")
    command = [sys.executable, "-c", HOLDS, str(tmp_path)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        theirs = Path(process.stdout.readline().decode().strip())
        with Scratch("import") as ours:
            sweep_scratch()
            assert ours.is_dir()
            assert (theirs / "film.part").exists()
            process.kill()
            process.wait()
            sweep_scratch()
            assert ours.is_dir()
        assert not theirs.exists()
    assert {path.name for path in tmp_path.iterdir()} == {"keypose-notes", "keypose-link"}
