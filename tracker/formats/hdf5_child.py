"""The child process that reads a stranger's HDF5 file, within limits of memory and time.

    python -m keypose.tracker.formats.hdf5_child NAME [INDIVIDUAL]

A damaged file can keep the HDF5 library going for ever, or crash it. The file comes on standard
input; people or a sentence that says why there are none go to standard output, as JSON.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final

from keypose.tracker.errors import ChoiceError, FormatError
from keypose.tracker.formats import deeplabcut, hdf5, sleap
from keypose.tracker.formats.people import People
from keypose.tracker.surface.files.child import limit_memory, limit_time

MEMORY_BYTES: Final = 4 * 2**30
"""Of the child, beyond what it starts with."""
SECONDS: Final = 60
_ROOT: Final = Path(__file__).parents[2]


def people_of_hdf5(file: str, content: bytes, individual: str | None) -> People:
    """The people in an HDF5 file of SLEAP or DeepLabCut; FormatError in one sentence."""
    if find_spec("h5py") is None:
        raise FormatError(
            f"{file} is HDF5, which needs h5py: pip install 'keypose[h5]', or export it as CSV."
        )
    paths = [str(_ROOT), *filter(None, [os.environ.get("PYTHONPATH")])]
    command = [sys.executable, "-P", "-m", "keypose.tracker.formats.hdf5_child", file]
    try:
        done = subprocess.run(
            command if individual is None else [*command, individual],
            input=content, capture_output=True, timeout=SECONDS, check=True,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(paths), "OPENBLAS_NUM_THREADS": "1"},
        )  # fmt: skip
        answer = json.loads(done.stdout)
    except subprocess.TimeoutExpired:
        raise FormatError(f"{file} takes longer than {SECONDS} s to read: use its CSV.") from None
    except (subprocess.CalledProcessError, OSError, ValueError):
        raise FormatError(f"{file} is damaged: copy or export it anew.") from None
    return _people(file, answer)


def _people(file: str, answer: Any) -> People:
    """What the child says; the numbers are checked as those of every file are."""
    if isinstance(answer, dict) and isinstance(answer.get("refused"), str):
        words, choices = answer["refused"][:500], answer.get("individuals")
        if isinstance(choices, list):
            raise ChoiceError(words, "individual", [str(choice) for choice in choices])
        raise FormatError(words)
    try:
        frames = {int(frame): list(persons) for frame, persons in answer["frames"]}
        return People(frames, tuple(map(str, answer["names"])), program=str(answer["program"]))
    except (KeyError, TypeError, ValueError):
        raise FormatError(f"{file} is damaged: copy or export it anew.") from None


def read_here(file: str, content: bytes, individual: str | None) -> People:
    """The same, in this process and without limits; FormatError in one sentence."""
    with hdf5.opened(file, content) as root:
        if sleap.is_analysis(root):
            return sleap.read_analysis(root, individual)
        if deeplabcut.table_name(root) is not None:
            return deeplabcut.read_hdf(root, individual)
    raise FormatError(f"{file} is neither SLEAP's analysis nor a table of DeepLabCut.")


def main() -> None:
    file, individual = sys.argv[1], sys.argv[2] if len(sys.argv) > 2 else None
    content = sys.stdin.buffer.read()
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)  # whatever the library prints must not get into the answer
    limit_memory(MEMORY_BYTES)
    limit_time(SECONDS)
    try:
        people = read_here(file, content, individual)
    except ChoiceError as why:
        json.dump({"refused": str(why), "individuals": why.choices}, answers)
    except FormatError as why:
        json.dump({"refused": str(why)}, answers)
    else:
        frames = list(people.frames.items())
        header = {"names": people.names, "frames": frames, "program": people.program}
        json.dump(header, answers)
    answers.close()


if __name__ == "__main__":
    main()
