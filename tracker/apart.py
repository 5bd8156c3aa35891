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


def read_apart(reader: Callable[..., T], path: Path, *arguments: Any) -> T:
    """Return what a reader makes of a file; FormatError in one sentence, whatever the file does to
    it.
    """
    with reading_apart(reader) as read:
        return read(path, *arguments)


@contextmanager
def reading_apart(reader: Callable[..., T]) -> Iterator[Callable[..., T]]:
    """The same as a function, to be called once: its child starts while there is other work."""
    from keypose.tracker.scratch import Scratch  # which the child need not load

    with Scratch("read") as folder:
        child = subprocess.Popen(
            # -P: nothing that lies in the present folder may pass for a module.
            [sys.executable, "-P", "-m", __name__, reader.__module__, reader.__qualname__],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
            # A copy that it was ended over goes with the folder; threads take address space.
            env={**os.environ, "TMPDIR": str(folder), "OPENBLAS_NUM_THREADS": "1"},
            start_new_session=True,  # Ctrl+C reaches this program, which then ends it
        )  # fmt: skip
        try:
            yield lambda path, *arguments: _answer(child, path, arguments)
        finally:
            child.kill()
            child.communicate()


def _answer(child: subprocess.Popen[bytes], path: Path, arguments: tuple[Any, ...]) -> Any:
    question = pickle.dumps((MEMORY_BYTES, SECONDS, path, *arguments))
    try:
        answer = from_bytes(child.communicate(question, timeout=PATIENCE_S)[0])
    except (subprocess.TimeoutExpired, NotPlain):
        raise FormatError(died_words(path.name)) from None
    if isinstance(answer, KeyposeError):
        raise answer
    return answer


def died_words(file: str) -> str:
    """Return what is said of a file whose reader ended without a word."""
    return f"{file} is damaged, or needs too much time or memory to be read: export it again."


def main() -> None:
    """Run in the child process."""
    reader: Any = import_module(sys.argv[1])
    for name in sys.argv[2].split("."):
        reader = getattr(reader, name)
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # whatever a library prints must not get into the answer
    warnings.simplefilter("ignore")  # what is wrong with a file is checked, and said in a sentence
    memory, seconds, *arguments = pickle.load(sys.stdin.buffer)
    limit_memory(memory, LARGEST_COPY_BYTES)
    limit_time(seconds)
    try:
        answer = reader(*arguments)
    except KeyposeError as error:
        answer = error
    with answers:
        answers.write(to_bytes(answer))


if __name__ == "__main__":
    main()
