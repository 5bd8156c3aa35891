"""Another revision beside this one: its files, and the packages that it brings."""

from __future__ import annotations

import hashlib
import subprocess
import tomllib
import venv
from pathlib import Path

from bench.keeping import ROOT, Absent, kept_folder

LINKED = ("app", "sample_videos", "static", "tracker")
ARCHIVED = (*LINKED, "pyproject.toml")


def checked_out(revision: str) -> Path:
    """A revision in a folder of this user's, as it is there from before; Absent where git has no
    such."""
    named = subprocess.run(
        ["git", "-C", str(ROOT), "rev-parse", "--verify", f"{revision}^{{commit}}"],
        capture_output=True,
        text=True,
        check=False,
    )
    if named.returncode:
        raise Absent(f"the revision {revision!r}")
    tree = kept_folder() / f"at-{named.stdout.strip()[:12]}"
    if not tree.exists():
        archive = subprocess.run(
            ["git", "-C", str(ROOT), "archive", named.stdout.strip(), *ARCHIVED],
            capture_output=True,
            check=True,
        )
        tree.mkdir(parents=True)
        subprocess.run(["tar", "-x", "-C", str(tree)], input=archive.stdout, check=True)
    return linked(tree)


def python_of(tree: Path) -> Path:
    """An interpreter with the packages that a plain installation of a revision brings; made once
    for all that need the same."""
    project = tomllib.loads((tree / "pyproject.toml").read_text(encoding="utf-8"))
    needed: list[str] = project["project"]["dependencies"]
    name = hashlib.sha256("\n".join(sorted(needed)).encode()).hexdigest()[:12]
    folder = kept_folder() / f"packages-{name}"
    python = folder / "bin" / "python"
    if not (folder / "done").exists():
        venv.create(folder, clear=True, with_pip=True)
        subprocess.run([str(python), "-m", "pip", "install", "--quiet", *needed], check=True)
        (folder / "done").touch()
    return python


def linked(tree: Path) -> Path:
    """A tree whose packages are found by their name."""
    names = tree / "build" / "names" / "keypose"
    names.mkdir(parents=True, exist_ok=True)
    for package in LINKED:
        link = names / package
        if not link.exists():
            link.symlink_to(Path("../../..") / package)
    return tree
