"""The READMEs name files that are there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
READMES = [
    *(ROOT / name for name in ("README.md", "CONTRIBUTING.md")),
    *(ROOT / folder / "README.md" for folder in ("app", "tracker", "static", "tests")),
]
NAMED = re.compile(r"`([\w./-]+\.(?:py|js|css))`|\]\(([\w./-]+?)(?:#[\w-]*)?\)")


@pytest.mark.parametrize("readme", READMES, ids=lambda path: str(path.relative_to(ROOT)))
def test_every_file_it_names_is_in_the_project(readme: Path) -> None:
    named = {one or other for one, other in NAMED.findall(readme.read_text("utf-8"))}
    assert named
    places = (
        readme.parent,
        ROOT,
        *(ROOT / name for name in ("app", "tracker", "static", "examples")),
    )
    sources = [path for place in ("app", "tracker", "static", "tests") for path in
               (ROOT / place).rglob("*.*") if "node_modules" not in path.parts]  # fmt: skip
    absent = [
        name
        for name in sorted(named)
        if not any((place / name).exists() for place in places)
        and not any(path.as_posix().endswith(f"/{name}") for path in sources)
    ]
    assert absent == []
