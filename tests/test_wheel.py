"""The wheel holds all that the program reads, and nothing else."""

from __future__ import annotations

import shutil
import subprocess
import sys
import tomllib
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("setuptools", minversion="77")

ROOT = Path(__file__).parents[1]
FOLDERS = ("app", "sample_videos", "static", "tracker")
SAMPLES = ROOT / "sample_videos"
SHOWN = {"arms_page.jpg", "walk/page.jpg", "walk/film.webp"} | {
    path.relative_to(SAMPLES).as_posix() for path in (SAMPLES / "walk" / "gallery").iterdir()
}
"""Pictures of READMEs, which the wheel leaves out."""
MOST_BYTES = 28e6
LICENCES = {
    "Apache License": "Apache-2.0",
    "BSD 3-Clause": "BSD-3-Clause",
    "CC0 1.0": "CC0-1.0",
    "SIL Open Font License, Version 1.1": "OFL-1.1",
}
"""What is granted, by words of its text."""


def sources() -> set[str]:
    """The files of the folders that ship, but for what the interpreter keeps beside them."""
    return {
        path.relative_to(ROOT).as_posix()
        for folder in FOLDERS
        for path in (ROOT / folder).rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Iterator[zipfile.ZipFile]:
    source, out = tmp_path_factory.mktemp("source"), tmp_path_factory.mktemp("wheel")
    for folder in FOLDERS:
        ignored = shutil.ignore_patterns("__pycache__")
        shutil.copytree(ROOT / folder, source / folder, ignore=ignored)
    for name in ("pyproject.toml", "setup.py", "README.md", "LICENSE"):
        shutil.copyfile(ROOT / name, source / name)
    left = source / "build" / "lib" / "keypose" / "app"
    left.mkdir(parents=True)
    (left / "deleted_since.py").touch()
    build = "import sys; from setuptools.build_meta import build_wheel; build_wheel(sys.argv[1])"
    command = [sys.executable, "-W", "error", "-c", build, str(out)]
    subprocess.run(command, cwd=source, check=True, capture_output=True)
    (path,) = out.glob("*.whl")
    assert path.stat().st_size < MOST_BYTES
    with zipfile.ZipFile(path) as file:
        yield file


def test_it_holds_every_file_but_the_pictures_of_readmes(wheel: zipfile.ZipFile) -> None:
    names = {name.removeprefix("keypose/") for name in wheel.namelist()}
    shown = {f"sample_videos/{name}" for name in SHOWN}
    assert {name for name in names if ".dist-info/" not in name} == sources() - shown


def test_it_holds_nothing_of_an_earlier_build(wheel: zipfile.ZipFile) -> None:
    assert not [name for name in wheel.namelist() if "deleted_since" in name]


def test_it_takes_no_name_that_it_does_not_say(wheel: zipfile.ZipFile) -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    named = {name.split(".")[0] for name in project["tool"]["setuptools"]["packages"]}
    tops = {name.split("/")[0] for name in wheel.namelist() if ".dist-info/" not in name}
    assert tops == named


def test_it_brings_the_command_and_the_licences(wheel: zipfile.ZipFile) -> None:
    (info,) = {name.split("/")[0] for name in wheel.namelist() if ".dist-info/" in name}
    assert "keypose = " in wheel.read(f"{info}/entry_points.txt").decode()
    named = {"LICENSE", *(name for name in sources() if Path(name).name in ("LICENSE", "NOTICE"))}
    inside = {name for name in wheel.namelist() if f"{info}/licenses/" in name}
    assert inside == {f"{info}/licenses/{name}" for name in named}
    texts = [wheel.read(name).decode() for name in inside]
    texts += [(ROOT / name).read_text("utf-8") for name in sources() if name.endswith("README.md")]
    (line,) = (
        line
        for line in wheel.read(f"{info}/METADATA").decode().splitlines()
        if line.startswith("License-Expression: ")
    )
    granted = {licence for words, licence in LICENCES.items() if any(words in t for t in texts)}
    assert set(line.partition(": ")[2].split(" AND ")) == granted == set(LICENCES.values())
