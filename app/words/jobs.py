"""Word what a job is called, how far it is, and how it ended."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Literal, TypeAlias

from keypose.tracker.session.verdict import VERDICT_KINDS
from keypose.tracker.storage.results import Span
from keypose.tracker.tracking.result import SegmentResult

Ending: TypeAlias = Literal["done", "cancelled", "failed"]


SHORT_S = 20.0
"""Work of less time is not worth to say how long it takes."""


def about_words(seconds: float) -> str:
    """ "about 4 minutes"; empty where it is short."""
    if seconds < SHORT_S:
        return ""
    if seconds < 55.0:
        return f"about {10 * round(seconds / 10)} seconds"
    minutes = round(seconds / 60)
    if minutes < 90:
        return f"about {minutes} minute{'s' if minutes > 1 else ''}"
    return f"about {seconds / 3600:.1f} hours"


def spans_text(spans: Sequence[Span]) -> str:
    """ "39–61" when the segments follow one another, else how many there are."""
    if all(before[1] == after[0] for before, after in pairwise(spans)):
        return f"{spans[0][0]}–{spans[-1][1]}"
    return f"{len(spans)} segments"


def bodies_words(results_of_body: Mapping[str, Sequence[SegmentResult | None]]) -> str:
    """Such as "Anna: 3 to check; Ball: 1 good, 3 to check", by their names."""
    return "; ".join(
        f"{name}: {closing_words('done', segment_results)}"
        for name, segment_results in results_of_body.items()
    )


def closing_words(state: Ending, segment_results: Sequence[SegmentResult | None]) -> str:
    """What is there of the segments that were to be tracked, now that it is over."""
    tracks = [track for track in segment_results if track is not None]
    kinds = [track.kind for track in tracks]
    if state == "cancelled" and any(track.missing for track in tracks):
        return "finished frames are kept; Fit continues from there"
    if state == "cancelled":
        return "finished segments are kept" if any(kinds) else "no segment finished"
    counts = ((kind, kinds.count(kind)) for kind in VERDICT_KINDS)
    names = {"check": "to check"}
    return ", ".join(f"{count} {names.get(kind, kind)}" for kind, count in counts if count)
