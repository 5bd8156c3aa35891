"""How far off each part is expected to be, as JSON."""

from __future__ import annotations

from typing import Final

from keypose.app.editor.judged import Judged
from keypose.app.editor.problems import problem_of
from keypose.app.editor.segment_evidence import best_row, part_errors_px
from keypose.app.store.sections.json_value import Json
from keypose.app.store.state import AppState
from keypose.tracker.tracking.result import SegmentResult

MOST: Final = 5
"""Parts of a segment that are listed."""


def errors(app_state: AppState) -> Json:
    """The parts of every segment with the largest expected errors, each where it is large, the
    worst first: in pixels of the video, and in centimetres unless the lens is a guess."""
    edit = app_state.edit
    if edit is None:
        return []
    known = Judged.of(edit.settled, edit.results)
    return [
        {"first": track.first, **worst}
        for track in known.tracks.values()
        for worst in _worst_parts(known, track)
    ]


def _worst_parts(known: Judged, track: SegmentResult) -> list[dict[str, Json]]:
    """Up to MOST parts of one segment, of those of which anything is known. The part that the
    segment's problem is about stands with the problem's frame."""
    errors = part_errors_px(track)
    if errors is None:
        return []
    last = len(errors) - 1
    found = problem_of(known, track)
    listed = []
    for part, largest in enumerate(errors.max(axis=0)):
        if largest < 0:
            continue
        row = best_row(track, part, 0, last)
        if found is not None and known.name(part) == found.part and found.px is not None:
            row = found.frame - track.first
        listed.append((float(errors[row, part]), part, row))
    listed.sort(key=lambda one: -one[0])
    return [_row(known, track, *one) for one in listed[:MOST]]


def _row(known: Judged, track: SegmentResult, px: float, part: int, row: int) -> dict[str, Json]:
    name, frame = known.parts[part], track.first + row
    scale = known.px_per_m(track, frame, name)
    cm = None if scale is None or known.guessed else round(100 * px / scale, 2)
    return {"part": name, "frame": frame, "px": round(px, 2), "cm": cm}
