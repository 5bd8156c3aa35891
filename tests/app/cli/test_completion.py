"""Completion as the shells do it, from what `keypose completion` prints."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from keypose.app.cli.main import grammar, main

BASH = """\
source "$1"; shift
COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); COMP_LINE="$*"; COMP_POINT=${#COMP_LINE}
function=$(complete -p keypose | sed 's/.*-F \\([^ ]*\\).*/\\1/')
$function keypose "${COMP_WORDS[COMP_CWORD]}" "${COMP_WORDS[COMP_CWORD - 1]}"
printf '%s\\n' "${COMPREPLY[@]}"
"""
FISH = 'source $argv[1]; complete -C "$argv[2..]"'
ZSH = "fpath=($1 $fpath); autoload -U compinit; compinit -u -D; print ${_comps[keypose]}"


def script(shell: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> Path:
    """What the command prints for a shell, in a file."""
    if shutil.which(shell) is None:
        pytest.skip(f"{shell} is not installed")
    assert main(["completion", shell]) == 0
    path = folder / f"completion.{shell}"
    path.write_text(capsys.readouterr().out)
    return path


def answer(folder: Path, *command: str | Path) -> list[str]:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True)
    return done.stdout.splitlines()


def test_bash_completes_commands_options_values_and_files(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = script("bash", tmp_path, capsys)
    (tmp_path / "jump.mp4").touch()

    def after(*words: str) -> list[str]:
        return answer(tmp_path, "bash", "-c", BASH, "bash", path, "keypose", *words)

    assert after("tr") == ["track"]
    assert set(after("")) == set(grammar()[1])
    assert after("track", "--qual") == ["--quality"]
    assert after("track", "--quality", "") == ["full", "preview"]
    assert after("open", "ju") == ["jump.mp4"]


def test_fish_completes_the_same(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = script("fish", tmp_path, capsys)

    def after(words: str) -> list[str]:
        lines = answer(tmp_path, "fish", "--no-config", "-c", FISH, path, f"keypose {words}")
        return [line.split("\t")[0] for line in lines if line]

    assert "track" in after("tr")
    assert after("track --qual") == ["--quality"]
    assert sorted(after("track --quality ")) == ["full", "preview"]


def test_zsh_takes_its_completion_for_the_command(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    script("zsh", tmp_path, capsys).rename(tmp_path / "_keypose")
    assert answer(tmp_path, "zsh", "-n", "_keypose") == []
    assert answer(tmp_path, "zsh", "-f", "-c", ZSH, "zsh", tmp_path) == ["_keypose"]
