"""What `make quick` runs is what is nearest to a change."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.quick import ROOT, Choice, changed_files, choose, words

TREE = {
    "tests/app/cli/test_open.py": "import keypose.app.store.ahead, tests.app.store.shared",
    "tests/app/store/test_ahead.py": "from keypose.app.store import ahead",
    "tests/app/store/test_ahead_again.py": "import numpy as np",
    "tests/app/store/shared.py": "",
    "tests/app/store/test_tabs.py": (
        "from keypose.app.store.ahead import Ahead\nfrom tests.app.store import shared"
    ),
    "tests/app/serving.py": "",
    "tests/bench/test_up.py": "import bench.up",
    "tests/browser/test_tabs.py": "from tests.app.serving import Keypose",
    "tests/page/test_modules.py": "import keypose.static",
    "tests/page/edits.test.js": "",
    "tests/test_examples.py": "",
    "tests/test_readmes.py": "",
    "tests/tracker/fitting/test_pose.py": "",
    "tests/tracker/fitting/test_sizes.py": "def test():\n    from tests.app import serving",
    "tests/tracker/video/cases/film.json": "",
    "tests/tracker/video/test_video.py": "",
}

PLACE = "tests/app/store/test_"


@pytest.fixture
def root(tmp_path: Path) -> Path:
    """A project with these tests."""
    for name, text in TREE.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return tmp_path


@pytest.mark.parametrize(
    ("changed", "choice"),
    [
        # By its name, and whoever imports it, the nearest first; none twice.
        (
            "app/store/ahead.py",
            Choice(
                own=(f"{PLACE}ahead.py", f"{PLACE}ahead_again.py"),
                importing=(f"{PLACE}tabs.py", "tests/app/cli/test_open.py"),
            ),
        ),
        # Without tests of its name: those of its folder.
        (
            "app/store/other.py",
            Choice(own=(f"{PLACE}ahead.py", f"{PLACE}ahead_again.py", f"{PLACE}tabs.py")),
        ),
        # Of a package that has a test file instead of a folder.
        ("tracker/fitting/pose/step.py", Choice(own=("tests/tracker/fitting/test_pose.py",))),
        ("tracker/video/models/net.bin", Choice(own=("tests/tracker/video/test_video.py",))),
        ("examples/1_track.py", Choice(own=("tests/test_examples.py",))),
        ("bench/up.py", Choice(own=("tests/bench/test_up.py",))),
        ("static/store/edits.js", Choice(own=("tests/page/test_modules.py",))),
        ("static/__init__.py", Choice(own=("tests/page/test_modules.py",))),
        ("tests/page/edits.test.js", Choice(own=("tests/page/test_modules.py",))),
        (f"{PLACE}tabs.py", Choice(edited=(f"{PLACE}tabs.py",))),
        # What tests share is tested by who imports it, the nearest first, but never in a browser.
        (
            "tests/app/store/shared.py",
            Choice(importing=(f"{PLACE}tabs.py", "tests/app/cli/test_open.py")),
        ),
        (
            "tests/app/serving.py",
            Choice(
                importing=("tests/tracker/fitting/test_sizes.py",),
                browser=("tests/browser/test_tabs.py",),
            ),
        ),
        ("tests/browser/test_tabs.py", Choice(browser=("tests/browser/test_tabs.py",))),
        ("tests/tracker/video/conftest.py", Choice(own=("tests/tracker/video/test_video.py",))),
        # A deleted test has nothing left to run; nor has what no test is about.
        ("tests/app/test_gone.py", Choice(untested=("tests/app/test_gone.py",))),
        ("app/README.md", Choice(own=("tests/test_readmes.py",))),
        ("Makefile", Choice(untested=("Makefile",))),
        ("tracker/deep/er/lens.py", Choice(untested=("tracker/deep/er/lens.py",))),
    ],
)
def test_a_change_is_tested_by_its_own_tests_and_by_those_that_import_it(
    root: Path, changed: str, choice: Choice
) -> None:
    assert choose([changed], root) == choice


def test_a_test_that_several_changes_ask_for_runs_once(root: Path) -> None:
    changed = ["app/store/ahead.py", "app/store/other.py", f"{PLACE}tabs.py"]
    own = (f"{PLACE}tabs.py", f"{PLACE}ahead.py", f"{PLACE}ahead_again.py")
    assert choose(changed, root).tests == (*own, "tests/app/cli/test_open.py")


def test_one_line_says_what_is_run_and_what_is_left_out() -> None:
    choice = Choice(own=("a", "b"), importing=("c",), browser=("d",), untested=("LICENSE",))
    assert words(choice, "main", 3) == (
        "3 files changed since main; test files: 2 beside what changed, 1 that import it."
        " Left out: 1 browser test file, LICENSE."
    )
    assert words(Choice(untested=("LICENSE",)), "main", 1) == (
        "1 file changed since main; test files: none. Left out: LICENSE."
    )
    assert words(Choice(), "main", 0) == "Nothing has changed since main: no tests to run."


def git(root: Path, *arguments: str) -> None:
    settings = ("user.name=Test", "user.email=test@localhost", "commit.gpgsign=false")
    chosen = [word for setting in settings for word in ("-c", setting)]
    subprocess.run(["git", *chosen, *arguments], cwd=root, check=True, capture_output=True)


@pytest.mark.skipif(shutil.which("git") is None, reason="There is no git on this computer.")
def test_changed_is_what_differs_from_where_the_branch_began_committed_or_not(
    tmp_path: Path,
) -> None:
    git(tmp_path, "init", "--initial-branch=main")
    for name in ("kept", "deleted", "edited", "old name"):
        (tmp_path / name).write_text(f"{name}\n")
    (tmp_path / ".gitignore").write_text("ignored\n")
    git(tmp_path, "add", ".")
    git(tmp_path, "commit", "--message=begin")
    git(tmp_path, "switch", "--create=branch")
    (tmp_path / "committed").write_text("1")
    git(tmp_path, "mv", "old name", "new näme")
    git(tmp_path, "add", ".")
    git(tmp_path, "commit", "--message=of the branch")
    git(tmp_path, "switch", "main")
    (tmp_path / "of main").write_text("1")
    git(tmp_path, "add", ".")
    git(tmp_path, "commit", "--message=of main")
    git(tmp_path, "switch", "branch")
    (tmp_path / "edited").write_text("2")
    (tmp_path / "deleted").unlink()
    for name in ("untracked", "ignored"):
        (tmp_path / name).write_text("1")
    different = ["committed", "deleted", "edited", "new näme", "old name", "untracked"]
    assert changed_files(tmp_path) == ("main", different)
    git(tmp_path, "branch", "--move", "main", "trunk")
    assert changed_files(tmp_path) == ("HEAD", ["deleted", "edited", "untracked"])


def test_once_the_time_is_up_no_test_begins_and_the_last_line_says_how_many_are_left(
    tmp_path: Path,
) -> None:
    test = tmp_path / "test_it.py"
    test.write_text("def test_one(): assert False\ndef test_two(): assert False\n")
    command = [sys.executable, "-m", "pytest", "-p", "tests.quick", "--seconds=0", "-n1"]
    ran = subprocess.run(
        [*command, "-p", "no:cacheprovider", str(test)], cwd=ROOT, capture_output=True, text=True
    )
    assert ran.returncode == 0, ran.stdout + ran.stderr
    assert "2 tests left out after 0 s: make test runs all." in ran.stdout
