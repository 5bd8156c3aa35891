"""What is not plausible in space, as JSON."""

from __future__ import annotations

from typing import Final

from keypose.app.editor.floor_edits import uneven_feet_m
from keypose.app.editor.judged import Judged
from keypose.app.editor.space_words import pin_sentence, space_sentence
from keypose.app.editor.state import EditorState
from keypose.app.store.sections.json_value import Json
from keypose.app.store.state import AppState
from keypose.tracker.session.results import SpaceFinding

_REMEDIES: Final = {
    "slides": "pin",
    "off_floor": "pin",
    "below_floor": "floor",
    "keyframe_depth": "soften",
    "mirrored": "turn",
    "twisted": "untwist",
    "leans": "",
    "shakes": "smooth",
}
_WEIGHTS: Final = {"slides": 20.0, "off_floor": 20.0, "below_floor": 20.0, "keyframe_depth": 15.0,
                   "mirrored": 20.0, "twisted": 3.0, "leans": 3.0, "shakes": 0.1}  # fmt: skip
"""What makes findings of different kinds comparable: of 5 cm, of 20°, of 10 m/s² each about 1."""


def space(app_state: AppState) -> Json:
    """What is wrong with the motion in space: sentence, part, frames, frame to go to, and what
    mends it with one press; the worst first."""
    edit = app_state.edit
    if edit is None:
        return []
    weighted: list[tuple[float, Json]] = []
    known = Judged.of(edit.settled, edit.results)
    for stretch in edit.results.space(edit.settled):
        waiting = (found for found in stretch.findings if not _is_accepted(known, found))
        weighted += [(_weight(found), _finding(found)) for found in waiting]
        for pin in stretch.pins:
            if pin.keyframe is not None:
                row = {
                    "kind": "pin", "words": pin_sentence(pin), "part": pin.part,
                    "first": pin.first_frame, "last": pin.last_frame, "go": pin.keyframe,
                    "remedy": "soften", "keyframes": sorted({pin.keyframe, *pin.others}),
                    "cm": round(100 * pin.off_m, 1),
                }  # fmt: skip
                weighted.append((_WEIGHTS["slides"] * pin.off_m, row))
    rows = [row for _, row in sorted(weighted, key=lambda one: -one[0])]
    is_known = edit.results.space(edit.settled)
    share = edit.settled.depth_share
    rise_m = uneven_feet_m(edit) if is_known else None
    first = [] if rise_m is None else [_guessed_up(edit, rise_m)]
    last = [_guessed_lens(edit, share)] if is_known and share is not None else []
    return [*first, *rows, *last]


def _guessed_up(edit: EditorState, rise_m: float) -> Json:
    """Feet that climb since nobody knows how the camera tilts: what else is found rests on it."""
    pins = edit.settled.pins
    return {
        "kind": "up",
        "words": f"Pinned feet differ by {100 * rise_m:.0f} cm in height: the camera’s tilt is a "
        "guess.",
        "part": pins[0].part,
        "first": pins[0].first_frame,
        "last": pins[-1].last_frame,
        "go": pins[0].first_frame,
        "remedy": "level",
    }


def _is_accepted(known: Judged, found: SpaceFinding) -> bool:
    """Whether a person has said that the foot is right where it leaves the floor, or the limb as it
    points."""
    asked = found.kind in ("off_floor", "mirrored")
    answered = known.answer(found.part, found.go) if asked else None
    return answered is not None and answered.answer == "accepted"


def _guessed_lens(edit: EditorState, share: float) -> Json:
    """Depth that rests on a lens nobody knows."""
    return {
        "kind": "lens",
        "words": f"Depth rests on a guessed lens. Distances may be off by {100 * share:.0f} %.",
        "part": edit.settled.body.names[0],
        "first": edit.keys[0],
        "last": edit.keys[-1],
        "go": edit.keys[0],
        "remedy": "lens",
    }


def _weight(found: SpaceFinding) -> float:
    return _WEIGHTS[found.kind] * abs(found.amount)


def _finding(found: SpaceFinding) -> Json:
    return {
        "kind": found.kind,
        "words": space_sentence(found),
        "part": found.part,
        "first": found.first_frame,
        "last": found.last_frame,
        "go": found.go,
        "remedy": _REMEDIES[found.kind],
    }
