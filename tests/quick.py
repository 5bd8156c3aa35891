"""`python -m tests.quick`: run the tests nearest to what has changed since the branch left main.

As a plugin of pytest it begins no further test once the time is up, and says how many are left.
"""

from __future__ import annotations

import ast
import os
import subprocess
import sys
import time
from collections.abc import Iterable
from dataclasses import dataclass
from functools import partial
from pathlib import Path, PurePosixPath
from posixpath import commonpath

import pytest

ROOT = Path(__file__).parents[1]
BASES = ("main", "origin/main")
"""What a branch began from: the first of these that there is."""

BROWSER = "tests/browser/"
PAGE = "tests/page"
READMES = "tests/test_readmes.py"
MIRRORED = ("app", "bench", "tracker")
"""Folders whose tests lie at the same place under `tests`."""

INSTALLED = ("app", "sample_videos", "static", "tracker")
"""Folders that are imported as packages of `keypose`."""

SECONDS = 40.0
"""A test may begin in this time: with the checks before it that makes less than a minute."""

TIME_IS_UP = "the time of a quick run is up"


@dataclass(frozen=True)
class Choice:
    """Test files, the nearest first, and what is not tested now; paths from the project's root.

    edited: tests that have changed.  own: of changed files, by place and name.  importing: that
    name a changed module.  browser: that need one.  untested: changed files that none of these is
    for.
    """

    edited: tuple[str, ...] = ()
    own: tuple[str, ...] = ()
    importing: tuple[str, ...] = ()
    browser: tuple[str, ...] = ()
    untested: tuple[str, ...] = ()

    @property
    def tests(self) -> tuple[str, ...]:
        return self.edited + self.own + self.importing


def choose(changed: Iterable[str], root: Path = ROOT) -> Choice:
    """What to run for these files."""
    changed = sorted(changed)
    imports = {test: _imported(root / test) for test in _tests(root, "tests", "**/test_*.py")}
    edited = [path for path in changed if path in imports]
    own: list[str] = []
    importing: list[str] = []
    untested: list[str] = []
    for path in changed:
        if path in edited:
            continue
        mirrored = _own_tests(PurePosixPath(path), root)
        module = _module(PurePosixPath(path))
        importers = [test for test, names in imports.items() if module in names]
        own += mirrored
        importing += sorted(importers, key=partial(_distance, path))
        if not mirrored and not importers:
            untested.append(path)
    groups, seen = [], set[str]()
    for group in (edited, own, importing):
        groups.append(tuple(test for test in dict.fromkeys(group) if test not in seen))
        seen.update(group)
    here = [tuple(test for test in group if not test.startswith(BROWSER)) for group in groups]
    browser = tuple(sorted(test for test in seen if test.startswith(BROWSER)))
    return Choice(*here, browser=browser, untested=tuple(untested))


def _own_tests(path: PurePosixPath, root: Path) -> list[str]:
    """By name, or else all, of the first folder upwards that has tests at all.

    The tests of `tracker/fitting/pose/step.py` may be called `tracker/fitting/test_pose.py`.
    """
    if path.suffix == ".md":
        return _tests(root, ".", READMES)
    if path.parts[0] == "static":
        return _tests(root, PAGE, "test_*.py")
    if path.parts[0] == "tests":
        is_helper = path.suffix == ".py" and path.name != "conftest.py"
        return [] if is_helper else _tests(root, str(path.parent), "test_*.py")
    if path.parts[0] not in MIRRORED:
        return _tests(root, "tests", f"test_{path.parts[0]}.py")
    names = [path.stem]
    for folder in path.parents[:-1]:
        place = str("tests" / folder)
        if all_here := _tests(root, place, "test_*.py"):
            named = [found for name in names for found in _tests(root, place, f"test_{name}*.py")]
            return named or all_here
        names.append(folder.name)
    return []


def _distance(path: str, test: str) -> int:
    """Less, the more folders of a file are those of a test."""
    place = path if path.startswith("tests/") else f"tests/{path}"
    return -commonpath((place, test)).count("/")


def _tests(root: Path, folder: str, pattern: str) -> list[str]:
    return sorted(path.relative_to(root).as_posix() for path in (root / folder).glob(pattern))


def _module(path: PurePosixPath) -> str | None:
    """The name it is imported by."""
    if path.suffix != ".py":
        return None
    parts = path.with_suffix("").parts
    parts = parts[:-1] if parts[-1] == "__init__" else parts
    return ".".join(("keypose", *parts) if parts[0] in INSTALLED else parts)


def _imported(path: Path) -> set[str]:
    """Every module that a file may import: of `from a import b` both a and a.b."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Import):
            names.update(each.name for each in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            names.update((node.module, *(f"{node.module}.{each.name}" for each in node.names)))
    return names


def changed_files(root: Path = ROOT) -> tuple[str, list[str]]:
    """What they are compared with, and the files that differ, committed or not, deleted or new.

    CalledProcessError where there is no repository.
    """
    _git(root, "rev-parse", "--git-dir")
    base = next((name for name in BASES if _is_commit(root, name)), "HEAD")
    since = _git(root, "merge-base", base, "HEAD").strip()
    different = _git(root, "diff", "--name-only", "--no-renames", "-z", since)
    new = _git(root, "ls-files", "--others", "--exclude-standard", "-z")
    return base, sorted({name for name in (different + new).split("\0") if name})


def _is_commit(root: Path, name: str) -> bool:
    command = ["git", "rev-parse", "--verify", "--quiet", f"{name}^{{commit}}"]
    return subprocess.run(command, cwd=root, capture_output=True).returncode == 0


def _git(root: Path, *arguments: str) -> str:
    return subprocess.run(
        ["git", *arguments], cwd=root, capture_output=True, text=True, check=True
    ).stdout


def words(choice: Choice, base: str, count: int) -> str:
    """One line: what is run and why, and what is left out."""
    if not count:
        return f"Nothing has changed since {base}: no tests to run."
    kinds = (
        (len(choice.edited), "changed"),
        (len(choice.own), "beside what changed"),
        (len(choice.importing), "that import it"),
    )
    runs = ", ".join(f"{number} {kind}" for number, kind in kinds if number)
    line = f"{_counted(count, 'file')} changed since {base}; test files: {runs or 'none'}."
    browser = [f"{_counted(len(choice.browser), 'browser test file')}"] if choice.browser else []
    if left_out := [*browser, *choice.untested]:
        line += f" Left out: {', '.join(left_out)}."
    return line


def _counted(number: int, noun: str) -> str:
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def main() -> int:
    """pytest's exit code; 2 where there is no repository to compare with."""
    try:
        base, changed = changed_files()
    except (subprocess.CalledProcessError, FileNotFoundError) as error:
        print(f"What has changed is not known ({error}): run make test.", file=sys.stderr)
        return 2
    choice = choose(changed)
    print(words(choice, base, len(changed)), flush=True)
    if not choice.tests:
        return 0
    workers = min(len(choice.tests), os.cpu_count() or 1)
    spread = ["-n", str(workers), "--dist", "loadfile", "--no-loadscope-reorder"]
    command = [sys.executable, "-m", "pytest", "-p", "tests.quick", f"--seconds={SECONDS}"]
    return subprocess.run([*command, *spread, *choice.tests], cwd=ROOT).returncode


# --- as a plugin of pytest

_BEGAN = pytest.StashKey[float]()


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--seconds", type=float, default=SECONDS, help="begin no test after these")


def pytest_configure(config: pytest.Config) -> None:
    config.stash[_BEGAN] = time.monotonic()


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    """Before its fixtures are made."""
    if time.monotonic() - item.config.stash[_BEGAN] >= item.config.getoption("seconds"):
        pytest.skip(TIME_IS_UP)


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    skipped = terminalreporter.stats.get("skipped", [])
    late = sum(TIME_IS_UP in str(report.longrepr) for report in skipped)
    if late:
        seconds = terminalreporter.config.getoption("seconds")
        noun = _counted(late, "test")
        terminalreporter.write_line(f"{noun} left out after {seconds:g} s: make test runs all.")


if __name__ == "__main__":
    sys.exit(main())
