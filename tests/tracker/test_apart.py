"""A file that harms its reader harms a child process, and is told in one sentence."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest

from keypose.tracker import apart
from keypose.tracker.apart import read_apart
from keypose.tracker.errors import ChoiceError, FormatError
from keypose.tracker.formats.keypoint_files import read_people
from tests.tracker.formats import animals
from tests.tracker.formats.test_reading_animals import NAMES, UV

HARM = {
    "leaves": "import os; os._exit(0)",
    "crashes": "import os; os.abort()",
    "never ends": "while True: pass",
    "hoards": "bytearray(2**40)",
    "raises what it should not": "raise RecursionError",
    "answers what cannot be sent": "held = lambda: 1",
    "answers with a program": (
        "import os\n"
        "for number in range(3, 30):\n"
        "    try: os.write(number, b'cos\\n_exit\\n(I9\\ntR.')\n"
        "    except OSError: continue\n"
        "os._exit(0)"
    ),
}
"""What a damaged file may make of its reader: here the file is the reader's own code."""


@pytest.mark.parametrize("harm", HARM)
def test_a_reader_that_comes_to_harm_is_one_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, harm: str
) -> None:
    monkeypatch.setattr(apart, "SECONDS", 1)
    path = tmp_path / "walk.c3d"
    path.write_text(HARM[harm])
    with pytest.raises(FormatError) as refused:
        read_apart(runpy.run_path, path)
    assert str(refused.value) == (
        "walk.c3d is damaged, or needs too much time or memory to be read: export it again."
    )


def test_what_a_reader_leaves_behind_goes_with_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    path = tmp_path / "walk.c3d"
    path.write_text("import os, tempfile; tempfile.mkdtemp(); os._exit(0)")
    with pytest.raises(FormatError):
        read_apart(runpy.run_path, path)
    assert list(tmp_path.iterdir()) == [path]


def test_what_a_reader_refuses_is_said_as_it_says_it(tmp_path: Path) -> None:
    path = animals.sleap_csv(tmp_path / "s.csv", NAMES, UV, tracks=["rat", "mouse"])
    with pytest.raises(ChoiceError) as several:
        read_apart(read_people, path, None)
    assert several.value.choices == ("rat", "mouse")
    assert read_apart(read_people, path, "mouse") == read_people(path, "mouse")
