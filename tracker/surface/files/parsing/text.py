"""Numbers written as text."""

from __future__ import annotations

import warnings

import numpy as np

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.surface.files.parsing.raw import Refused


def numbers(text: bytes) -> Array:
    """All the numbers of a text, blanks between them. Refused where there is anything else."""
    if not text.strip():
        return np.empty(0)
    with warnings.catch_warnings():
        # numpy warns where it met something that is no number, and gives what came before it.
        warnings.simplefilter("error")
        try:
            return np.fromstring(text, sep=" ")
        except (DeprecationWarning, ValueError) as error:
            raise Refused(
                "holds something else where numbers should be: export it again."
            ) from error


def table(lines: list[bytes], least: int) -> Array:
    """(rows, columns) of lines with equally many numbers, at least so many.

    Where lines differ in length, their first `least` columns. Refused where one is too short.
    """
    flat = numbers(b" ".join(lines))
    width = len(lines[0].split()) if lines else least
    if width >= least and flat.size == width * len(lines) and _all_as_wide(lines, width):
        return flat.reshape(len(lines), width)
    rows = [line.split(None, least)[:least] for line in lines]
    if min(map(len, rows), default=least) < least:
        raise Refused(f"has a vertex with fewer than {least} numbers: export it again.")
    return numbers(b" ".join(b" ".join(row) for row in rows)).reshape(len(rows), least)


def _all_as_wide(lines: list[bytes], width: int) -> bool:
    return all(len(line.split()) == width for line in lines)
