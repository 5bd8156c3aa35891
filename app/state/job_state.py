"""What the worker is doing, as the page shows it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

from keypose.tracker.session.verdict import Kind as VerdictKind

Kind: TypeAlias = Literal[
    "track", "fit", "draft", "ahead", "reduce", "space", "drafts", "camera", "film"
]


@dataclass(frozen=True)
class JobState:
    """What the worker is doing, in words; seconds_left is None when nobody can know.

    kind: a "fit", a solve in "space", or one of "drafts" does not know how far it is.
    worst: the verdict of its worst segment, once it has tracked some.
    """

    state: Literal["idle", "running", "done", "cancelled", "failed"] = "idle"
    title: str = ""
    words: str = ""
    percent: float = 0.0
    seconds_left: float | None = None
    kind: Kind = "track"
    worst: VerdictKind | None = None
