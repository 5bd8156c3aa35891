"""The command line: `keypose COMMAND …`.

Exit codes: 0 done; 1 tracking was lost somewhere, or a session of a batch was not done; 2 the
input cannot be used, said in one sentence on stderr; 70 a fault of Keypose itself, with a
traceback; 130 interrupted, by Ctrl+C or SIGTERM; 141 nobody reads the output any more.
"""

from __future__ import annotations

import argparse
import errno
import gc
import io
import os
import sys
import traceback
from collections.abc import Mapping, Sequence
from contextlib import suppress
from difflib import get_close_matches
from importlib import import_module
from importlib.metadata import version
from types import ModuleType
from typing import NoReturn

from keypose.app.cli.arguments import COMMANDS
from keypose.app.cli.exit_codes import BAD_INPUT, FAULT, INTERRUPTED, NO_READER
from keypose.app.cli.long_work import sigterm_as_ctrl_c
from keypose.tracker.errors import ChoiceError, KeyposeError

DISK_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)

THREADS = {"OPENBLAS_NUM_THREADS": "1", "OPENCV_FOR_THREADS_NUM": "1"}
"""Of NumPy and OpenCV in this process and those it starts, unless somebody has chosen other
numbers; read when they are loaded. Of matrices and pictures as small as a body's, several threads
wait for each other, which takes up to ten times the processor time of a product. OpenCV's wait by
spinning: a track by brightness took 1.3 to 1.45 times the processor time, and 0.92 to 1.05 times
the clock."""

_EXAMPLES = """\
examples:
  keypose info jump.mp4
  keypose track jump/session.json
  keypose batch recordings --only outdated
  keypose shot jump/session.json --frame 40 --view all --out frame40.png
  keypose export jump/session.json --format bvh --out motion
"""


class _Parser(argparse.ArgumentParser):
    """Says what is wrong in one sentence instead of a page of usage."""

    def options(self) -> list[str]:
        """The names of its options, as they are typed."""
        return [name for name in self._option_string_actions if name.startswith("--")]

    def error(self, message: str) -> NoReturn:
        self.exit(BAD_INPUT, f"{_sentence(f'{self.prog}: {message}')} See {self.prog} --help.\n")


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code; --help and wrong arguments raise SystemExit."""
    for name, count in THREADS.items():
        os.environ.setdefault(name, count)
    if isinstance(sys.stdout, io.TextIOWrapper):  # a file name may hold what a terminal cannot show
        sys.stdout.reconfigure(errors="backslashreplace")
    try:
        arguments = _parsed(sys.argv[1:] if argv is None else list(argv))
        with sigterm_as_ctrl_c():
            code = _run(arguments)
        sys.stdout.flush()
        return code
    except KeyposeError as error:
        remedy = f" Choose with --{error.option}." if isinstance(error, ChoiceError) else ""
        print(_sentence(str(error)) + remedy, file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        return INTERRUPTED
    except BrokenPipeError:
        _drop_output()
        return NO_READER
    except OSError as error:
        if error.errno not in DISK_FULL:
            return _fault()
        _drop_output()
        print(f"The output cannot be written: {error.strerror}.", file=sys.stderr)
        return BAD_INPUT
    except Exception:  # noqa: BLE001 — printed in full, with a code of its own
        return _fault()


def _parsed(argv: list[str]) -> argparse.Namespace:
    """The arguments; a name that is not known is refused with the nearest one that is."""
    command_name = next((word for word in argv if not word.startswith("-")), None)
    top, commands = grammar(command_name or "none")
    if command_name is None:
        return top.parse_args(argv)
    if command_name not in commands:
        is_there = os.path.exists(command_name)  # noqa: PTH110 — Path's raises for some names
        meant = f"; did you mean `keypose open {command_name}`?" if is_there else ""
        top.error(
            f"there is no command {command_name!r}{meant or _nearest(command_name, list(commands))}"
        )
    _require_known_options(argv[argv.index(command_name) + 1 :], commands[command_name])
    arguments, further = top.parse_known_args(argv)
    if further:
        commands[command_name].error(f"there is one argument too many, {further[0]!r}")
    return arguments


def _require_known_options(words: list[str], command: _Parser) -> None:
    """Checked before the parser sees them, which would rather miss an argument that is required."""
    for word in words:
        name = word.split("=")[0]
        if name == "--":
            return
        if name.startswith("--") and not any(
            option.startswith(name) for option in command.options()
        ):
            command.error(f"there is no option {name!r}{_nearest(name, command.options())}")


def _nearest(word: str, choices: list[str]) -> str:
    """What was meant, where it can be guessed."""
    near = get_close_matches(word, choices, n=1)
    return f"; did you mean {near[0]}?" if near else ""


def _fault() -> int:
    traceback.print_exc()
    print("This is an error in Keypose, not in your input.", file=sys.stderr)
    return FAULT


def _drop_output() -> None:
    """Drop what is still buffered, which would raise once more when the interpreter
    closes stdout.
    """
    with suppress(OSError, ValueError):  # where stdout is no file of the system, nothing does
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def grammar(*asked: str) -> tuple[_Parser, Mapping[str, _Parser]]:
    """The grammar of the command line, and those of its commands by name; of those that are not
    asked for, where some are, the names alone."""
    top = _Parser(
        prog="keypose",
        description="3D motion from ordinary video: pose a body at a few frames, the tracker "
        "finds the rest.",
        epilog=_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    top.add_argument(
        "--version", action="version", version=f"keypose {version('keypose')}", help="print it"
    )
    top.set_defaults(run=None, introduce=top.print_help)
    commands = top.add_subparsers(metavar="COMMAND")
    for name, (room, summary) in COMMANDS.items():
        if asked and name not in asked:
            commands.add_parser(name, help=summary)
        else:
            declared = import_module(f"keypose.app.cli.grammar.{room}")
            getattr(declared, f"add_{name.replace('-', '_')}")(commands)
    commands.choices["completion"].set_defaults(grammar=grammar)
    return top, commands.choices


def _run(arguments: argparse.Namespace) -> int:
    """Do what is asked for; without a command, say what there is."""
    if arguments.run is None:
        arguments.introduce()
        return 0
    name = "import_" if arguments.run == "import" else arguments.run.replace("-", "_")
    code: int = _loaded(f"keypose.app.cli.{name}").run(arguments)
    return code


def _loaded(name: str) -> ModuleType:
    """The module of a command. What it loads is no garbage: to look through it takes a tenth of the
    time, and is left out from then on."""
    if name in sys.modules:
        return sys.modules[name]
    gc.disable()
    module = import_module(name)
    gc.freeze()
    gc.enable()
    return module


def _sentence(text: str) -> str:
    """The text on one line, without control characters a file name or a field might bring."""
    line = " ".join(text.split())
    line = "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in line)
    return line if line.endswith((".", "?", "!")) else f"{line}."
