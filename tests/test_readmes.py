"""The READMEs name files that are there."""

from __future__ import annotations

import ast
import re
import sys
import tomllib
from importlib.util import find_spec
from itertools import pairwise
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from keypose.app.cli.arguments import COMMANDS
from keypose.app.export.motion_formats import FORMATS
from keypose.sample_videos.__main__ import SCRIPTS
from keypose.sample_videos.make_pictures import GALLERY

ROOT = Path(__file__).parents[1]
READMES = [
    *(ROOT / name for name in ("README.md", "ARCHITECTURE.md", "CONTRIBUTING.md")),
    *(ROOT / folder / "README.md" for folder in ("app", "tracker", "static", "tests")),
    ROOT / "tracker" / "camera_motion" / "README.md",
    *sorted((ROOT / "docs").glob("*.md")),
]
LARGEST_GALLERY_BYTES = 600_000
MOST_WORDS = 980  # of the first page a newcomer reads, the table of its accuracy among them
NAMED = re.compile(r"`([\w./-]+\.(?:py|js|css))`|\]\(([\w./-]+?)(?:#[\w-]*)?\)")


def test_files_are_recognised_where_they_are_named() -> None:
    named = {one or other for one, other in NAMED.findall("`a/b.py` and [it](../c.md#there)")}
    assert named == {"a/b.py", "../c.md"}


@pytest.mark.parametrize("readme", READMES, ids=lambda path: str(path.relative_to(ROOT)))
def test_every_file_it_names_is_in_the_project(readme: Path) -> None:
    named = {one or other for one, other in NAMED.findall(readme.read_text("utf-8"))}
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


@pytest.mark.parametrize("top", ["app", "tracker"])
def test_its_map_names_every_package_with_the_first_sentence_of_what_it_is(top: str) -> None:
    rooms = dict(
        re.findall(r"^- `([\w./]+)`: (.+)$", (ROOT / top / "README.md").read_text("utf-8"), re.M)
    )
    packages = {
        f"{path.parent.relative_to(ROOT / top)}/": path
        for path in (ROOT / top).rglob("__init__.py")
        if path.parent != ROOT / top
    }
    modules = {name: ROOT / top / name for name in rooms if name.endswith(".py")}
    assert rooms == {name: _first_sentence(path) for name, path in (packages | modules).items()}


def test_the_one_of_the_cameras_motion_has_a_place_for_each_of_its_files() -> None:
    package = ROOT / "tracker" / "camera_motion"
    named = set(re.findall(r"`(\w+\.py)`", (package / "README.md").read_text("utf-8")))
    files = {path.name for path in package.glob("*.py")} - {"__init__.py"}
    assert files - named == set()


def _first_sentence(path: Path) -> str:
    words = " ".join((ast.get_docstring(ast.parse(path.read_text("utf-8"))) or "").split())
    return words.split(". ")[0].removesuffix(".") + "."


def test_its_gallery_is_what_the_script_makes_and_small() -> None:
    text = (ROOT / "README.md").read_text("utf-8")
    shown = re.findall(r"!\[[^\]]+\]\((sample_videos/walk/gallery/(\w+)\.webp)\)", text)
    assert sorted(name for _, name in shown) == sorted(GALLERY)
    assert sum((ROOT / path).stat().st_size for path, _ in shown) < LARGEST_GALLERY_BYTES


def test_the_first_readme_is_short() -> None:
    assert len((ROOT / "README.md").read_text("utf-8").split()) <= MOST_WORDS


def test_its_commands_are_those_that_there_are() -> None:
    text = (ROOT / "app" / "README.md").read_text("utf-8")
    listed = dict(re.findall(r"^\| `([a-z-]+)` \| (.+) \|$", text, re.M))
    assert listed == {name: summary for name, (_, summary) in COMMANDS.items()}


def test_every_export_is_named_where_it_is_said_what_opens_them() -> None:
    text = (ROOT / "docs" / "exports.md").read_text("utf-8")
    assert [name for name in FORMATS if f"`{name}`" not in text] == []


def test_the_library_of_an_export_is_an_extra_and_there_for_developers() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    developers, *extras = (
        {Requirement(line).name for line in project["optional-dependencies"].get(name, ())}
        for name in ("dev", *FORMATS)
    )
    needed = {kind.library[0] for kind in FORMATS.values() if kind.library}
    assert needed <= developers & set().union(*extras)


def test_the_road_through_the_code_names_what_is_defined_there() -> None:
    text = (ROOT / "ARCHITECTURE.md").read_text("utf-8")
    road = re.findall(r"^\| \d+ \| `([\w./]+)` `(\w+)` \|", text, re.M)
    assert len(road) >= 10
    defined = r"^\s*(?:export )?(?:async )?(?:def|class|function) {}\b"
    absent = [
        (file, name)
        for file, name in road
        if not re.search(defined.format(name), (ROOT / file).read_text("utf-8"), re.M)
    ]
    assert absent == []


def test_the_commands_to_develop_with_name_what_there_is() -> None:
    text = (ROOT / "ARCHITECTURE.md").read_text("utf-8").partition("## Developing")[2]
    commands = re.findall(r"^\| .* \| `([^`]+)` \|$", text, re.M)
    assert len(commands) >= 8
    for command in commands:
        words = command.replace('"', "").split()
        assert all((ROOT / word).exists() for word in words if "/" in word and word[0] not in ".o")
        tools = [word.removeprefix(".venv/bin/") for word in words if word.startswith(".venv/bin/")]
        assert all((Path(sys.executable).parent / tool).exists() for tool in tools)
        modules = [after for before, after in pairwise(words) if before == "-m"]
        assert all(find_spec(name) for name in modules if name.isidentifier() or "." in name)
        sought = [after for before, after in pairwise(words) if before == "-k"]
        assert all(name in (ROOT / words[words.index("-k") - 1]).read_text() for name in sought)


def test_the_command_for_all_samples_runs_every_script_that_makes_one() -> None:
    scripts = {path.stem for path in (ROOT / "sample_videos").glob("make_*.py")}
    assert sorted(SCRIPTS) == sorted(scripts)
