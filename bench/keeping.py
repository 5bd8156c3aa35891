"""Where a benchmark keeps what takes long to make, and how it knows that it is still the same."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

ROOT = Path(__file__).parents[1]
DATA = ROOT.parent / "shared" / "data"


class Absent(Exception):
    """Material that a benchmark needs is not here; the text names it."""


def data_folder(name: str) -> Path:
    """A folder of real material; Absent when it is not here."""
    if not (DATA / name / "meta.json").is_file():
        raise Absent(f"the data folder {name!r} beside the checkout")
    return DATA / name


def kept_folder() -> Path:
    """This user's folder for what may be made again."""
    base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    place = base / "keypose" / "bench"
    place.mkdir(parents=True, exist_ok=True)
    return place


def digest(*contents: bytes | Path) -> str:
    """A short name for these contents; a folder stands for the Python and JSON files in it."""
    whole = hashlib.sha256()
    for content in contents:
        for piece in _pieces(content):
            whole.update(hashlib.sha256(piece).digest())
    return whole.hexdigest()[:16]


def _pieces(content: bytes | Path) -> list[bytes]:
    if isinstance(content, bytes):
        return [content]
    if content.is_dir():
        files = sorted(p for p in content.rglob("*") if p.suffix in (".py", ".json"))
        return [p.read_bytes() for p in files if not p.name.startswith("test_")]
    return [content.read_bytes()]


def place_for(name: str, key: str, suffix: str) -> Path:
    """Where something of this name is kept; files of the name with other keys are removed."""
    place = kept_folder() / f"{name}-{key}{suffix}"
    for other in kept_folder().glob(f"{name}-{'?' * len(key)}{suffix}"):
        if other != place:
            other.unlink(missing_ok=True)
    return place
