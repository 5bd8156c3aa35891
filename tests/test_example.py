"""The README's example runs, and is the one that lies beside the samples."""

from __future__ import annotations

from pathlib import Path

import pytest

from sample_videos import example

README = Path(__file__).parents[1] / "README.md"


def test_the_example_tracks_the_box(capsys: pytest.CaptureFixture[str]) -> None:
    example.main()
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "segment 0: good"
    assert [line[:8] for line in lines[1:]] == [f"frame {n:2}" for n in range(0, 41, 10)]


def test_the_readme_shows_the_example() -> None:
    code = Path(example.__file__).read_text("utf-8").partition('"""\n\n')[2]
    assert f"```python\n{code}```" in README.read_text("utf-8")
