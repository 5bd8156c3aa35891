"""Reading files of strangers in a child process, within limits of memory and time.

    python -P -m keypose.tracker.apart MODULE NAME

A damaged file can crash the library that reads it, keep it going for ever, or make it take all
memory. The child is told which reader, and on standard input, pickled, with which arguments. It
answers with what was read, or with the error that says in one sentence why there is nothing: as
plain facts, for a file that has taken hold of its reader may answer anything.
"""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any, Final, TypeVar

from keypose.tracker.errors import FormatError, KeyposeError
from keypose.tracker.limits import limit_memory, limit_time
from keypose.tracker.plain import NotPlain, from_bytes, to_bytes

T = TypeVar("T")

MEMORY_BYTES: Final = 4 * 2**30
"""Of the child, beyond what it starts with."""
SECONDS: Final = 60
"""Of a processor."""
PATIENCE_S: Final = 600
"""Of the clock: a disk may be slow."""
LARGEST_COPY_BYTES: Final = 96 * 2**20
"""Of a file that the child may write: the library that reads C3D needs a copy."""


def died_words(file: str) -> str:
    """What is said of a file whose reader ended without a word."""
    return f"{file} is damaged, or needs too much time or memory to be read: export it again."


def _damaged(path: Path) -> KeyposeError:
    return FormatError(died_words(path.name))


@dataclass(frozen=True)
class Terms:
    """What a reader may do. died: the error where it ended without a word, of the file's path.
    written_bytes: of each file that it may write."""

    died: Callable[[Path], KeyposeError] = _damaged
    written_bytes: int = LARGEST_COPY_BYTES


READING: Final = Terms()


def read_apart(reader: Callable[..., T], path: Path, *arguments: Any, terms: Terms = READING) -> T:
    """What a reader makes of a file; the error of `terms`, by itself FormatError, in one
    sentence, whatever the file does to it.
    """
    with reading_apart(reader, terms) as read:
        return read(path, *arguments)


@contextmanager
def reading_apart(reader: Callable[..., T], terms: Terms = READING) -> Iterator[Callable[..., T]]:
    """The same as a function, to be called once: its child starts while there is other work."""
    from keypose.tracker.scratch import Scratch  # which the child need not load

    with Scratch("read") as folder:
        child = subprocess.Popen(
            # -P: nothing that lies in the present folder may pass for a module.
            [sys.executable, "-P", "-m", __name__, reader.__module__, reader.__qualname__],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            # A copy that it was ended over goes with the folder; threads take address space.
            env={**os.environ, "TMPDIR": str(folder), "OPENBLAS_NUM_THREADS": "1"},
            start_new_session=True,  # Ctrl+C reaches this program, which then ends it
        )
        try:
            yield lambda path, *arguments: _answer(child, path, arguments, terms)
        finally:
            child.kill()
            child.communicate()


def _answer(
    child: subprocess.Popen[bytes], path: Path, arguments: tuple[Any, ...], terms: Terms
) -> Any:
    limits = MEMORY_BYTES, terms.written_bytes, SECONDS
    question = pickle.dumps((*limits, path, *arguments))
    try:
        answer = from_bytes(child.communicate(question, timeout=PATIENCE_S)[0])
    except (subprocess.TimeoutExpired, NotPlain):
        raise terms.died(path) from None
    if isinstance(answer, KeyposeError):
        raise answer
    return answer


def main() -> None:
    """Run in the child process."""
    reader: Any = import_module(sys.argv[1])
    for name in sys.argv[2].split("."):
        reader = getattr(reader, name)
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # whatever a library prints must not get into the answer
    warnings.simplefilter("ignore")  # what is wrong with a file is checked, and said in a sentence
    memory, written, seconds, *arguments = pickle.load(sys.stdin.buffer)
    limit_memory(memory, written)
    limit_time(seconds)
    try:
        answer = reader(*arguments)
    except KeyposeError as error:
        answer = error
    with answers:
        answers.write(to_bytes(answer))


if __name__ == "__main__":
    main()
