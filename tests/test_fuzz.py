"""Whatever is done to a file, it is read or refused in one short sentence."""

from __future__ import annotations

from pathlib import Path

from keypose.tracker.apart import read_apart
from tests.fuzzing import fault, kinds, mutant

MUTANTS = 150
MUTANTS_APART = 3


def test_a_mutant_of_any_file_is_read_or_refused_in_one_sentence(tmp_path: Path) -> None:
    found = {}
    for name, kind in kinds(tmp_path).items():
        path = tmp_path / kind.file
        path.write_bytes(kind.content)
        assert fault(kind, path) is None, name
        for seed in range(MUTANTS_APART if kind.apart else MUTANTS):
            path.write_bytes(mutant(kind, seed))
            read = (lambda p, k=kind: read_apart(k.read, p)) if kind.apart else None
            if (wrong := fault(kind, path, read)) is not None:
                found[name, seed] = wrong
    assert not found
