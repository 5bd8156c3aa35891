"""What is odd about a file and was read all the same."""

from __future__ import annotations

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
]


@dataclass(frozen=True)
class Note:
    """One oddity, with the numbers or names that its sentence needs, in their order."""

    oddity: Oddity
    values: tuple[object, ...] = ()
