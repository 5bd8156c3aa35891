"""`keypose completion`: what a shell needs to complete commands, options and file names."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

from keypose.app.cli.arguments import file_name, session_file

_NAMES_A_FILE = (file_name, session_file, Path)


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
