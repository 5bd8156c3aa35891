"""Which step a file is, from its name.

mesh_004.ply, mesh_006.ply: the step of mesh_005.ply is there, and missing. Nothing ever shifts.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Final

import numpy as np

from keypose.tracker.errors import SurfaceError
from keypose.tracker.video.folder import natural

_FEWEST_FOR_A_RHYTHM: Final = 4
_MOST_GAPS: Final = 20
"""Steps to every file; where numbers lie farther apart they are no numbers of steps."""


def by_steps(paths: Sequence[Path]) -> tuple[Path | None, ...]:
    """Of every step its file; None where there is none.

    The last number that differs from name to name is the step's. Where all numbers are multiples
    of something apart (every tenth frame was exported), that is one step. Files without a number,
    among files that have one, are no steps; where no file has one the order is the names' own.

    SurfaceError where two files are of one step.
    """
    paths = sorted(paths, key=lambda path: natural(path.name))
    numbers = [[int(digits[-18:]) for digits in re.findall(r"[0-9]+", p.stem)] for p in paths]
    with_number = [k for k, found in enumerate(numbers) if found]
    if len(with_number) < max(2, len(paths) / 2):
        return tuple(paths)
    steps = _varying([numbers[k] for k in with_number])
    files = {step: paths[k] for step, k in zip(steps, with_number, strict=True)}
    if len(files) < len(steps):
        raise _twice([paths[k] for k in with_number], steps)
    first, last = min(steps), max(steps)
    stride = _stride(sorted(steps))
    if (last - first) // stride > _MOST_GAPS * len(steps):
        return tuple(files[step] for step in sorted(files))
    return tuple(files.get(step) for step in range(first, last + 1, stride))


def printable(path: Path) -> str:
    """A file's name as it can be printed on one line, whatever bytes it is made of."""
    name = os.fsencode(path.name).decode("utf-8", "replace")
    return "".join(
        letter if letter.isprintable() else "\N{REPLACEMENT CHARACTER}" for letter in name
    )


def _varying(numbers: list[list[int]]) -> list[int]:
    """Of every name the last number that differs from name to name."""
    if len({len(found) for found in numbers}) == 1:
        for column in reversed(list(zip(*numbers, strict=True))):
            if len(set(column)) > 1:
                return list(column)
    return [found[-1] for found in numbers]


def _stride(steps: list[int]) -> int:
    if len(steps) < _FEWEST_FOR_A_RHYTHM:
        return 1
    return math.gcd(*np.diff(steps).tolist())


def _twice(paths: list[Path], steps: list[int]) -> SurfaceError:
    order = sorted(zip(steps, paths, strict=True), key=lambda pair: pair[0])
    one, other = next((a, b) for (i, a), (j, b) in pairwise(order) if i == j)
    return SurfaceError(
        f'"{printable(one)}" and "{printable(other)}" have the same number: '
        "keep one mesh per time step in the folder."
    )
