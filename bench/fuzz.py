"""Mutants of every kind of file that is read: each is read, or refused in one sentence."""

from __future__ import annotations

import tempfile
from collections import Counter
from pathlib import Path

from bench.table import Report
from keypose.tracker.apart import read_apart
from keypose.tracker.limits import limit_memory
from tests.fuzzing import fault, kinds, mutant

MUTANTS = 3000
MUTANTS_APART = 200
"""Of a kind; of one whose library may end the process, each in a child of its own."""
MEMORY_BYTES = 2 * 2**30
"""A reader that takes more is at fault."""


def fuzz(report: Report) -> None:
    """The whole group."""
    limit_memory(MEMORY_BYTES, 2**30)
    table = report.table("mutants of sound files", "mutants", "faults", "worst", wide=("worst",))
    with tempfile.TemporaryDirectory() as folder:
        for name, kind in kinds(Path(folder)).items():
            path, faults = Path(folder) / kind.file, Counter[str]()
            count = MUTANTS_APART if kind.apart else MUTANTS
            for seed in range(count):
                path.write_bytes(mutant(kind, seed))
                read = (lambda p, k=kind: read_apart(k.read, p)) if kind.apart else None
                if found := fault(kind, path, read):
                    faults[found] += 1
            table.row(name, count, faults.total(), (faults.most_common(1) or [("", 0)])[0][0])
            report.expect(f"faults of {name}", faults.total(), 0)
