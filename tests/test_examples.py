"""The examples do what they say, each alone in an empty folder; the README shows the first."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from keypose import tracker

ROOT = Path(tracker.__file__).parents[1]
EXAMPLES = ROOT / "examples"
README = ROOT / "README.md"
FONTS = Path.home() / ".cache" / "matplotlib"  # nothing but caches is written outside


def run(name: str, folder: Path) -> list[str]:
    """The lines that an example prints, run as a person runs it, in this folder."""
    own = {"PYTHONPATH": str(ROOT), "PYTHONUTF8": "1", "MPLCONFIGDIR": str(FONTS)}
    command = [sys.executable, str(EXAMPLES / name)]
    done = subprocess.run(
        command,
        cwd=folder,
        env={**os.environ, **own},
        capture_output=True,
        encoding="utf-8",
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


def files_in(folder: Path) -> set[str]:
    return {str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file()}


def test_example_1_tracks_the_box_and_reads_where_it_went(tmp_path: Path) -> None:
    first, *frames = run("1_track_a_session.py", tmp_path)
    assert first == "segment 0: good"
    assert [line[:8] for line in frames] == [f"frame {n:2}" for n in range(0, 41, 10)]


def test_example_2_tracks_a_leg_of_its_own_and_saves_it(tmp_path: Path) -> None:
    lines = run("2_a_body_of_your_own.py", tmp_path)
    message = [re.fullmatch(r"frame (\d+): the knee is bent by (\d+)°", line) for line in lines]
    bends = {int(match[1]): int(match[2]) for match in message if match}
    truth = {24: 16, 28: 14, 32: 7, 36: 6, 40: 8, 44: 18, 48: 42}  # of the rendered figure
    assert bends == pytest.approx(truth, abs=5)
    saved = tracker.load_session(tmp_path / "out" / "leg" / "session.json")
    assert saved.subject.body.names == ("thigh", "shin")
    assert saved.subject.results is not None


def test_example_3_plots_the_knees_of_a_filmed_man(tmp_path: Path) -> None:
    *_, last = run("3_read_and_plot_a_motion.py", tmp_path)
    assert re.fullmatch(r"The right knee bends by up to 6\d°: out/knees/knees.png", last)
    plot = (tmp_path / "out" / "knees" / "knees.png").read_bytes()
    assert plot.startswith(b"\x89PNG")


def test_example_4_shows_what_came_of_every_recording(tmp_path: Path) -> None:
    lines = run("4_batch.py", tmp_path)
    states = [line for line in lines if not line.startswith(" ")]
    assert states == ["box: tracked", "person: tracked"]
    assert lines[1:3] == ["  frames 0–40: good", "  box/motion.bvh"]
    left = files_in(tmp_path / "out" / "recordings")
    assert {"batch-report.html", "box/motion.bvh", "person/motion.bvh"} <= left


def test_every_example_is_short_and_says_first_what_it_shows_and_how_it_is_run() -> None:
    names = sorted(path.name for path in EXAMPLES.glob("*.py"))
    assert [name[:2] for name in names] == ["1_", "2_", "3_", "4_"]
    for name in names:
        lines = (EXAMPLES / name).read_text("utf-8").splitlines()
        assert len(lines) <= 40, name
        assert f"`python examples/{name}`" in lines[0]
        assert f"examples/{name}" in README.read_text("utf-8")


def test_the_readme_shows_the_first_example() -> None:
    code = (EXAMPLES / "1_track_a_session.py").read_text("utf-8").partition('"""\n\n')[2]
    assert f"```python\n{code}```" in README.read_text("utf-8")
