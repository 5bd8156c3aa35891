"""`keypose completion`: what a shell needs to complete commands, options and file names."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

from keypose.app.cli.arguments import Subcommands, add_command, file_name, session_file

_EXAMPLES = """\
  keypose completion bash > ~/.local/share/bash-completion/completions/keypose
  keypose completion zsh > ~/.zfunc/_keypose
  keypose completion fish > ~/.config/fish/completions/keypose.fish
"""
_NAMES_A_FILE = (file_name, session_file, Path)


def add(commands: Subcommands) -> None:
    """The command's `grammar` is to be set to what makes the parser that is to be completed."""
    details = (
        "Written to the file of the examples, it works in the next shell, without starting Python. "
        "zsh looks into ~/.zfunc where ~/.zshrc says `fpath+=~/.zfunc` before `compinit`."
    )
    command = add_command(commands, "completion", run, details, _EXAMPLES)
    command.add_argument("shell", choices=("bash", "zsh", "fish"), help="which shell")


def run(arguments: argparse.Namespace) -> int:
    import shtab

    top: argparse.ArgumentParser = arguments.grammar()[0]
    for action in _actions(top):
        if action.type in _NAMES_A_FILE:
            is_folder = action.metavar in ("DIR", "FOLDER")
            action.complete = shtab.DIRECTORY if is_folder else shtab.FILE  # type: ignore[attr-defined]
    print(shtab.complete(top, arguments.shell))
    return 0


def _actions(parser: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    """Yield the actions of a parser and of its commands."""
    for action in parser._actions:  # argparse has no other way to ask
        yield action
        if isinstance(action, argparse._SubParsersAction):
            for command in action.choices.values():
                yield from _actions(command)
