"""Whatever is done to a file, it is read or refused in one short sentence."""

from __future__ import annotations

from pathlib import Path

from keypose.app.export.recognising import ENDINGS
from keypose.tracker.apart import read_apart
from keypose.tracker.formats.keypoint_files import KEYPOINT_READERS
from keypose.tracker.formats.reading import MOTION_READERS
from keypose.tracker.formats.reading_camera import CAMERA_READERS
from tests.fuzzing import fault, kinds, mutant

MUTANTS = 150
MUTANTS_APART = 3
REFUSED = {".pkl", ".pickle", ".slp"}
"""Endings whose files are refused, whatever they hold."""


def readers_of(ending: str) -> set[object]:
    """What reads files of an ending as a motion, keypoints or a camera."""
    _, motion = MOTION_READERS.get(ending, ("", None))
    return {motion, KEYPOINT_READERS.get(ending), CAMERA_READERS.get(ending)} - {None}


def test_every_reader_of_what_can_be_imported_has_a_file_to_change(tmp_path: Path) -> None:
    endings = {Path(kind.file).suffix for kind in kinds(tmp_path).values()}
    tried = set().union(*map(readers_of, endings))
    assert {ending for ending in ENDINGS if readers_of(ending) - tried} == REFUSED


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
