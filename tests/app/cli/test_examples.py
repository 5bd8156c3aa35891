"""The examples that --help shows are commands that work."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from keypose.app.cli.main import grammar, main

NAMES = sorted(grammar()[1])


def examples(name: str) -> list[list[str]]:
    """Its lines of examples, as the words after `keypose`."""
    shown = grammar()[1][name].format_help().partition("\nexamples:\n")[2]
    lines = re.findall(r"^  keypose (.+)$", shown, re.MULTILINE)
    return [shlex.split(line.partition(" > ")[0]) for line in lines]


@pytest.mark.parametrize("name", NAMES)
def test_every_example_is_in_the_grammar_of_its_command(name: str) -> None:
    found = examples(name)
    assert any(words[0] == name for words in found)
    top, _ = grammar()
    for words in found:
        arguments, further = top.parse_known_args(words)
        assert further == []
        assert arguments.run in NAMES


@pytest.mark.parametrize(
    "name", ["completion", "config", "export", "info", "models", "reduce", "report", "review",
             "schema", "sheet", "shot"],
)  # fmt: skip
def test_the_first_example_runs_beside_a_tracked_session(
    name: str, tracked_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tracked_path.parent
    monkeypatch.chdir(folder)
    (folder / "jump.mp4").symlink_to(folder / "frames")
    (folder / "jump.keypose").symlink_to(folder)
    words = [re.sub(r"^40$", "4", word) for word in examples(name)[0]]  # it has nine frames
    assert main(words) == 0
    if "--out" in words:
        assert (folder / words[words.index("--out") + 1]).exists()
