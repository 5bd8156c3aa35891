"""What the code's own table counts, in a tree made for it."""

from __future__ import annotations

import pytest

from bench.house import ROWS, Tree

SOURCE = """
HALF = 0.5
LEAST_PX = 3
\"\"\"Pixels.\"\"\"
LOST, KEPT = 1, 2
ANGLE = 7  # degrees


def way(found):
    \"\"\"Return what was found.\"\"\"
    for one in found:
        matrix = np.linalg.solve(*one)
    pair = matrix, found
    return carried(*pair)  # fmt: skip
"""
TREE = Tree(
    {
        "app/one.py": "from keypose.app.two import name",
        "app/two.py": "if TYPE_CHECKING:\n    from keypose.app.one import name",
        "app/three.py": "from keypose.app import one",
        "app/room/__init__.py": "from keypose.app.room.four import name",
        "app/room/four.py": "from keypose.app.room import name",
        "app/editor/known.py": "class KnownMotion:\n    results: Results = None",
        "app/editor/state.py": "class EditorState:\n    motion: KnownMotion = None",
        "tracker/keypoints/source.py": SOURCE,
        "tests/tracker/keypoints/test_source.py": "\n" * 28,
        "static/page.js": "x" * 121 + "\n" + "y" * 120,
        "README.md": "two words",
    }
)


@pytest.mark.parametrize(
    ("row", "count"),
    [
        ("conversions camera – world", 1),
        ("files that solve outside solver", 1),
        ("holders of the known motion", 1),
        ("files in circles of imports", 4),
        ("variables with vague names", 2),
        ("docstrings that begin: Return", 1),
        ("constants without a word", 1),
        ("constants that share a line", 2),
        ("fmt: " + "skip", 1),
        ("script lines over 120", 1),
        ("calls that unpack what was packed", 1),
        ("test lines a line, keypoints", 2.0),
        ("words of READMEs", 2),
    ],
)
def test_each_row_of_the_code_s_own_table_counts_what_it_says(row: str, count: float) -> None:
    assert ROWS[row](TREE) == count
