"""The command line: `keypose COMMAND …`.

Exit codes: 0 done; 1 tracking was lost somewhere, or a session of a batch was not done; 2 the
input cannot be used, said in one sentence on stderr; 70 a fault of Keypose itself, with a
traceback; 130 interrupted, by Ctrl+C or SIGTERM; 141 nobody reads the output any more.
"""

from __future__ import annotations

import argparse
import errno
import io
import os
import sys
import traceback
from collections.abc import Sequence
from contextlib import suppress
from importlib.metadata import version
from typing import NoReturn

from app.cli import (
    batch,
    draft,
    evaluate,
    export,
    film,
    fit,
    hull,
    import_,
    info,
    models,
    open,
    report,
    review,
    schema,
    sheet,
    shot,
    track,
)
from app.cli.interrupts import sigterm_as_ctrl_c
from tracker.errors import KeyposeError

BAD_INPUT = 2
FAULT = 70
INTERRUPTED = 130
NO_READER = 141
DISK_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)

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

    def error(self, message: str) -> NoReturn:
        self.exit(BAD_INPUT, f"{_sentence(f'{self.prog}: {message}')} See {self.prog} --help.\n")


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code; --help and wrong arguments raise SystemExit."""
    if isinstance(sys.stdout, io.TextIOWrapper):  # a file name may hold what a terminal cannot show
        sys.stdout.reconfigure(errors="backslashreplace")
    try:
        arguments = parser().parse_args(argv)
        with sigterm_as_ctrl_c():
            code: int = arguments.run(arguments)
        sys.stdout.flush()
        return code
    except KeyposeError as error:
        print(_sentence(str(error)), file=sys.stderr)
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


def _fault() -> int:
    traceback.print_exc()
    print("This is a fault of Keypose, not of your input.", file=sys.stderr)
    return FAULT


def _drop_output() -> None:
    """What is still buffered would raise once more when the interpreter closes stdout."""
    with suppress(OSError, ValueError):  # where stdout is no file of the system, nothing does
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def parser() -> argparse.ArgumentParser:
    """The grammar of the command line."""
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
    top.set_defaults(run=lambda _: _introduce(top))
    commands = top.add_subparsers(metavar="COMMAND")
    for command in (
        open,
        draft,
        track,
        review,
        fit,
        batch,
        evaluate,
        shot,
        film,
        sheet,
        report,
        export,
        import_,
        hull,
        info,
        models,
        schema,
    ):
        command.add(commands)
    return top


def _introduce(top: argparse.ArgumentParser) -> int:
    """Without a command, what there is."""
    top.print_help()
    return 0


def _sentence(text: str) -> str:
    """The text on one line, without control characters a file name or a field might bring."""
    line = " ".join(text.split())
    line = "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in line)
    return line if line.endswith((".", "?", "!")) else f"{line}."
