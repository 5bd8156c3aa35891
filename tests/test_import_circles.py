"""Every file can be read before those that need it: imports lead nowhere in a circle.

Imports for types alone count, and so do those within functions.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from graphlib import CycleError, TopologicalSorter
from pathlib import Path
from typing import TypeAlias

import grimp
import pytest

STATIC = Path(__file__).parents[1] / "static"
SCRIPT_IMPORT = re.compile(r"""\b(?:from|import)\s*\(?\s*["'](\.[^"']+)["']""")
"""A module that a script imports: its values, its types in a comment, or while the page runs."""

Imports: TypeAlias = Mapping[str, set[str]]
"""By the name of a file, the names of those that it imports."""


def python_imports(*packages: str) -> Imports:
    graph = grimp.build_graph(*packages, cache_dir=None)
    return {name: graph.find_modules_directly_imported_by(name) for name in graph.modules}


def script_imports(folder: Path) -> Imports:
    return {str(path): set(_imported_by(path)) for path in folder.resolve().rglob("*.js")}


def _imported_by(path: Path) -> Iterator[str]:
    for name in SCRIPT_IMPORT.findall(path.read_text("utf-8")):
        yield str((path.parent / name).resolve())


def circle(imports: Imports) -> list[str]:
    """The files of one circle, the first one again at the end; empty where there is none."""
    try:
        TopologicalSorter(imports).prepare()
    except CycleError as error:
        return list(error.args[1])
    return []


def test_no_file_of_the_program_or_the_method_is_in_a_circle_of_imports() -> None:
    imports = python_imports("keypose.app", "keypose.tracker")
    assert imports["keypose.app.jobs.job"]
    assert not circle(imports), " is imported by ".join(circle(imports))


def test_no_script_of_the_page_is_in_a_circle_of_imports() -> None:
    imports = script_imports(STATIC)
    assert imports[str(STATIC.resolve() / "page.js")]
    assert not circle(imports), " is imported by ".join(circle(imports))


@pytest.mark.parametrize(
    "last",
    [
        "from ring.first import value",
        "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from ring.first import value",
        "def late():\n    from ring import first",
        "import ring.first",
    ],
)
def test_a_circle_is_found_however_a_file_of_python_imports(
    last: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ring = _written(
        tmp_path / "ring",
        {
            "__init__.py": "",
            "first.py": "import ring.second",
            "second.py": "import ring.third",
            "third.py": "",
        },
    )
    monkeypatch.syspath_prepend(tmp_path)
    assert circle(python_imports("ring")) == []
    (ring / "third.py").write_text(last)
    assert set(circle(python_imports("ring"))) == {"ring.first", "ring.second", "ring.third"}


@pytest.mark.parametrize(
    "last",
    [
        "import { value } from '../first.js';",
        "import {\n  value,\n} from '../first.js';",
        'import "../first.js";',
        "export { value } from '../first.js';",
        "/** @type {import('../first.js').Value} */",
        "const late = () => import('../first.js');",
    ],
)
def test_a_circle_is_found_however_a_script_imports(last: str, tmp_path: Path) -> None:
    folder = _written(
        tmp_path / "page",
        {"first.js": "import './room/second.js';", "room/second.js": "", "alone.js": ""},
    )
    assert circle(script_imports(folder)) == []
    (folder / "room" / "second.js").write_text(last)
    assert {Path(name).name for name in circle(script_imports(folder))} == {"first.js", "second.js"}


def _written(folder: Path, files: Mapping[str, str]) -> Path:
    for name, text in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return folder
