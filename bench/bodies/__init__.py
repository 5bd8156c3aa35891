"""Several bodies in one film: who passes, who is looked at, what meets, and what it costs."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

from bench.bodies.bonds import bonds
from bench.bodies.cost import cost
from bench.bodies.crossing import crossing
from bench.bodies.film_of_two import film_of_two
from bench.bodies.floor import floor
from bench.bodies.promises import write_promises
from bench.keeping import Absent
from bench.table import Report


def bodies(report: Report) -> None:
    """The figures of two bodies, and at the end what the program promises beside them."""
    promises = crossing(report)
    try:
        with TemporaryDirectory() as folder:
            promises += film_of_two(report, Path(folder))
    except Absent as absent:
        report.note(f"the film of two persons is left out: {absent} is not here")
    promises += [*bonds(report), *floor(report), *cost(report)]
    write_promises(report, promises)
