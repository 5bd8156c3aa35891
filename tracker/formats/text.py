"""Read text from elsewhere, with decimal commas and any encoding, and note what is odd."""

from __future__ import annotations

import codecs
import re
from dataclasses import dataclass
from typing import Literal, TypeAlias

Oddity: TypeAlias = Literal[
    "row count",
    "marker count",
    "frames beyond",
    "row per frame",
    "z up at rest",
    "undetermined parts",
    "unplaced joints",
    "poor fit",
    "proportions",
    "flat",
    "lying",
    "starts at",
    "far from keyframes",
    "camera frames",
    "camera from first",
    "camera lens kept",
    "camera upright",
    "camera hanging",
    "camera speed",
    "several animations",
    "background off",
    "background still",
    "film not compared",
]


@dataclass(frozen=True)
class Note:
    """One oddity, with the numbers or names that its sentence needs, in their order."""

    oddity: Oddity
    values: tuple[object, ...] = ()


_MARKS = (
    (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF32_LE, "utf-32"),  # begins as UTF-16 does
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)


def decoded(content: bytes) -> str:
    """Decode text by the mark at its beginning, else as UTF-8.

    What is in another encoding becomes replacement characters: names and numbers that can be known
    are ASCII, or the file is UTF-8.
    """
    encoding = next((name for mark, name in _MARKS if content.startswith(mark)), "utf-8")
    return content.decode(encoding, errors="replace")


def with_decimal_points(text: str) -> str:
    """Write decimal commas as points, in text whose numbers stand apart by blanks or tabs."""
    return re.sub(r"(?<=\d),(?=\d)", ".", text) if "," in text else text
