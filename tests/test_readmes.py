"""The READMEs name files that are there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from keypose.sample_videos.make_pictures import GALLERY

ROOT = Path(__file__).parents[1]
READMES = [
    *(ROOT / name for name in ("README.md", "CONTRIBUTING.md")),
    *(ROOT / folder / "README.md" for folder in ("app", "tracker", "static", "tests")),
]
LARGEST_GALLERY_BYTES = 600_000
MOST_WORDS = 900  # of the first page a newcomer reads
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


def test_its_gallery_is_what_the_script_makes_and_small() -> None:
    text = (ROOT / "README.md").read_text("utf-8")
    shown = re.findall(r"!\[[^\]]+\]\((sample_videos/walk/gallery/(\w+)\.webp)\)", text)
    assert sorted(name for _, name in shown) == sorted(GALLERY)
    assert sum((ROOT / path).stat().st_size for path, _ in shown) < LARGEST_GALLERY_BYTES


def test_the_first_readme_is_short() -> None:
    assert len((ROOT / "README.md").read_text("utf-8").split()) <= MOST_WORDS
