"""Figures beside what is expected of them: printed as they come, kept for benchmarks.json."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, is_dataclass
from typing import Any

NAME_WIDTH = 31
CELL_WIDTH = 12
WIDE = 24


@dataclass(frozen=True)
class Expected:
    """A figure and the most it should be."""

    what: str
    figure: float
    most: float
    unit: str = ""

    @property
    def ok(self) -> bool:
        return bool(self.figure <= self.most)

    def __str__(self) -> str:
        words = f"{self.what} {self.figure:.3g} ≤ {self.most:.3g} {self.unit}".rstrip()
        return f"{words} {'ok' if self.ok else 'SHORT'}"


@dataclass(frozen=True)
class Pair:
    """Two figures of one thing, such as mean and median, printed with a stroke between."""

    first: float
    second: float
    names: tuple[str, str]
    digits: int = 2

    def __str__(self) -> str:
        return f"{self.first:.{self.digits}f}/{self.second:.{self.digits}f}"


@dataclass(eq=False)
class Table:
    """Rows under one heading."""

    title: str
    columns: tuple[str, ...]
    wide: tuple[str, ...] = ()
    rows: list[dict[str, Any]] = field(default_factory=list)

    def line(self, name: str, cells: Sequence[Any]) -> str:
        """A name and cells, set below the heading."""
        widths = [WIDE if column in self.wide else CELL_WIDTH for column in self.columns]
        shown = (f"{_shown(cell):>{w}}" for cell, w in zip(cells, widths, strict=True))
        return f"{name:<{NAME_WIDTH}}{''.join(shown)}"

    def row(self, name: str, *cells: Any, expected: Sequence[Expected] = ()) -> None:
        """Print and keep one row; its cells in the order of the columns."""
        words = "; ".join(str(e) for e in expected)
        print(f"{self.line(name, cells)}  {words}".rstrip(), flush=True)
        kept = {c: _kept(cell) for c, cell in zip(self.columns, cells, strict=True)}
        self.rows.append({"name": name, **kept, "expected": [_kept(e) for e in expected]})


class Report:
    """What one group of benchmarks found."""

    def __init__(self, group: str) -> None:
        self.group = group
        self.tables: list[Table] = []
        self.expected: list[Expected] = []
        self.notes: list[str] = []
        print(f"\n=== {group}", flush=True)

    def table(self, title: str, *columns: str, wide: tuple[str, ...] = ()) -> Table:
        """A new table, some of its columns wide; its heading is printed at once."""
        table = Table(title, columns, wide)
        print(f"\n{title}\n{table.line('', columns)}", flush=True)
        self.tables.append(table)
        return table

    def expect(self, what: str, figure: float, most: float, unit: str = "") -> None:
        """A figure on a line of its own, beside the most it should be."""
        self.expected.append(Expected(what, figure, most, unit))
        print(self.expected[-1], flush=True)

    def note(self, words: str) -> None:
        """A remark."""
        self.notes.append(words)
        print(words, flush=True)

    @property
    def short(self) -> int:
        """How many figures fall short of what is expected."""
        rows = (e for table in self.tables for row in table.rows for e in row["expected"])
        return sum(not e["ok"] for e in rows) + sum(not e.ok for e in self.expected)

    def as_json(self) -> dict[str, Any]:
        """All of it as plain data."""
        return {
            "tables": [{"title": t.title, "rows": t.rows} for t in self.tables],
            "expected": [_kept(e) for e in self.expected],
            "notes": self.notes,
            "short": self.short,
        }


def _shown(cell: Any) -> str:
    return f"{cell:.3g}" if isinstance(cell, float) else str(cell)


def _kept(cell: Any) -> Any:
    if isinstance(cell, Expected):
        return {**{k: _kept(v) for k, v in asdict(cell).items()}, "ok": cell.ok}
    if isinstance(cell, Pair):
        return dict(zip(cell.names, (_kept(cell.first), _kept(cell.second)), strict=True))
    if is_dataclass(cell) and not isinstance(cell, type):
        return asdict(cell)
    if isinstance(cell, float):
        return float(cell) if math.isfinite(cell) else None
    return cell
