"""File names that come from elsewhere, made harmless."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterator
from itertools import count

LONGEST_BYTES = 120
"""Of a cleaned name in UTF-8: leaves room for a number and for what a temporary file adds."""

_RESERVED = {"CON", "PRN", "AUX", "NUL"} | {f"{n}{i}" for n in ("COM", "LPT") for i in range(10)}
"""Devices of Windows, whatever the ending."""

_FORBIDDEN = set('<>:"|?*')
"""In names on Windows, and a nuisance in a shell."""


def clean_name(name: str) -> str:
    """The name alone, without any path, that every file system takes.

    Control characters and those that turn the reading direction are dropped, as are dots at the
    beginning, which hide a file; a device's name gets a line before it. What is left of nothing is
    "video".
    """
    last = name.replace("\\", "/").rsplit("/", 1)[-1]
    cleaned = "".join(c for c in unicodedata.normalize("NFC", last) if not _is_unseen(c))
    cleaned = "".join("_" if c in _FORBIDDEN else c for c in cleaned)
    cleaned = " ".join(cleaned.split()).lstrip(". ").rstrip(". ")
    stem, suffix = split(cleaned)
    if stem.split(".")[0].rstrip().upper() in _RESERVED:
        stem = f"_{stem}"
    return _shortened(stem or "video", suffix)


def split(name: str) -> tuple[str, str]:
    """ "jump.mp4" → ("jump", ".mp4"). A long ending is no ending."""
    stem, dot, suffix = name.rpartition(".")
    if not dot or not stem or len(suffix) > 8:
        return name, ""
    return stem, dot + suffix


def numbered(name: str) -> Iterator[str]:
    """ "jump.mp4", "jump 2.mp4", "jump 3.mp4" …"""
    stem, suffix = split(name)
    yield name
    yield from (f"{stem} {number}{suffix}" for number in count(2))


def printable(name: str) -> str:
    """A name as text: bytes that are not UTF-8, and control characters, become a sign."""
    text = name.encode("utf-8", "replace").decode()
    return "".join("\N{REPLACEMENT CHARACTER}" if _is_unseen(c) else c for c in text)


def _is_unseen(character: str) -> bool:
    """Control and format characters, halves of others, and what has no meaning yet."""
    return unicodedata.category(character) in ("Cc", "Cf", "Cs", "Cn", "Co", "Zl", "Zp")


def _shortened(stem: str, suffix: str) -> str:
    room = LONGEST_BYTES - len(suffix.encode())
    cut = stem.encode()[:room].decode("utf-8", "ignore").rstrip(". ")
    return cut + suffix
