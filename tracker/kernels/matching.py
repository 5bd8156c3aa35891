"""Where a template lies in a picture: the least sum of absolute differences.

INITIAL (4): R(a, b) = Σ Σ |I(a + m, b + n) − T(m, n)| over an N × N template and an M × M search
area, sped up by the sequential similarity detection algorithm: a candidate is dropped as soon as
its running sum reaches the least one so far.

Both searches below find the same place. Of equal sums the place nearest to the predicted one wins,
of equally near ones the higher, then the one further left. No pixel costs more than `most`, so that
something that passes before a part does not decide; with 255 a sum is as printed. A pixel that is
UNUSABLE, or lies beyond the picture's border, costs just that: a sum can then only grow, which the
sequential search rests on. Pictures and templates hold int16 numbers, sums are int64.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.kernels import compiled

Grey: TypeAlias = NDArray[np.int16]
Found: TypeAlias = tuple[int, int, int, int]
"""Row and column of the template's upper left pixel, the sum there, and template rows looked at."""

UNUSABLE = 16000
"""Stands for the brightness of an unusable pixel: it is unlike every other."""


@compiled
def find_sequentially(
    picture: Grey,
    template: Grey,
    wanted: Grey,
    rows: NDArray[np.int64],
    row: int,
    column: int,
    around: NDArray[np.int64],
    most: int,
) -> Found:
    """The best place, candidates from the predicted one outwards, each dropped when it can be.

    picture (h, w), UNUSABLE where ignored; template (n, m), wanted (n, m) 1 where its pixels count
    and 0 elsewhere. rows (n,): the order in which a candidate's rows are summed. row, column: the
    predicted place of the template's upper left pixel. around (K, 2): candidates as steps from it
    (rows, columns), nearest first, then by row and column.
    """
    best, best_row, best_column, looked = np.int64(2**62), row, column, 0
    for k in range(around.shape[0]):
        v, u = row + around[k, 0], column + around[k, 1]
        total = np.int64(0)
        for i in range(rows.shape[0]):
            total += _row_sum(picture, template, wanted, rows[i], v, u, most)
            looked += 1
            if total >= best:
                break
        if total < best:
            best, best_row, best_column = total, v, u
    return best_row, best_column, int(best), looked


@compiled
def find_exhaustively(
    picture: Grey,
    template: Grey,
    wanted: Grey,
    row: int,
    column: int,
    reach: int,
    most: int,
) -> Found:
    """The best place within `reach` pixels of (row, column) along both axes, all sums in full."""
    best, best_row, best_column, best_away = np.int64(2**62), row, column, np.int64(0)
    for v in range(row - reach, row + reach + 1):
        for u in range(column - reach, column + reach + 1):
            total = np.int64(0)
            for m in range(template.shape[0]):
                total += _row_sum(picture, template, wanted, m, v, u, most)
            away = np.int64((v - row) ** 2 + (u - column) ** 2)
            if total < best or (total == best and away < best_away):
                best, best_row, best_column, best_away = total, v, u, away
    return best_row, best_column, int(best), template.shape[0] * (2 * reach + 1) ** 2


@compiled
def _row_sum(picture: Grey, template: Grey, wanted: Grey, m: int, v: int, u: int, most: int) -> int:
    """Row m of a template whose upper left pixel lies at row v, column u: its share of the sum."""
    height, width = picture.shape
    y, wide = v + m, template.shape[1]
    total, limit = np.int32(0), np.int32(most)
    first, last = max(0, -u), min(wide, width - u)
    if y < 0 or y >= height or first >= last:
        y, first, last = 0, wide, wide
    for n in range(first):
        total += np.int32(wanted[m, n]) * limit
    # slices, so that the indices need no looking after and the loop vectorises
    seen, ours = picture[y, u + first : u + last], template[m, first:last]
    counts = wanted[m, first:last]
    for n in range(ours.shape[0]):
        miss = np.int32(seen[n]) - np.int32(ours[n])
        total += np.int32(counts[n]) * min(abs(miss), limit)
    for n in range(last, wide):
        total += np.int32(wanted[m, n]) * limit
    return int(total)
