"""What the program promises of several bodies, each with the figure that was measured."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from bench.table import Expected, Report


@dataclass(frozen=True)
class Promise:
    """What is wanted and measured, in words, and the figure that is to be at most so much."""

    words: str
    wanted: str
    measured: str
    expected: Expected

    @classmethod
    def at_most(cls, words: str, figure: float, most: float, unit: str = "") -> Promise:
        wanted, measured = f"≤ {most:g} {unit}".rstrip(), f"{figure:.3g} {unit}".rstrip()
        return cls(words, wanted, measured, Expected("", figure, most))

    @classmethod
    def at_least(cls, words: str, count: int, least: int) -> Promise:
        missing = max(least - count, 0)
        return cls(words, f"≥ {least}", str(count), Expected("missing", missing, 0))


def write_promises(report: Report, promises: Iterable[Promise]) -> None:
    """The table of all promises."""
    table = report.table("promises", "wanted", "measured")
    for promise in promises:
        table.row(promise.words, promise.wanted, promise.measured, expected=[promise.expected])
