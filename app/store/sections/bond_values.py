"""Give the bonds of the posed body as JSON."""

from __future__ import annotations

from typing import Final

import numpy as np

from keypose.app.editor.bonds import apart_m
from keypose.app.editor.state import EditorState
from keypose.app.posing import part_label
from keypose.app.state.app_state import AppState
from keypose.app.store.sections.json_value import Json
from keypose.app.words.bodies import body_names
from keypose.tracker.operations.bonds import MEET_M, keyed_apart
from keypose.tracker.session.bonds import Bond, BondEnd

MOST_FRAMES: Final = 60
"""Of a bond, at which it is looked how far apart its points are."""


def bonds(app_state: AppState) -> Json:
    """Every bond that holds the posed body, with its number among all of the session."""
    edit = app_state.edit
    if edit is None:
        return []
    names, posed = body_names(edit.settled), edit.settled.subject.id
    return [
        {
            "index": index,
            "holder": _end(bond.holder, names),
            "held": _end(bond.held, names),
            "first": bond.first_frame,
            "last": bond.last_frame,
            "moves": bond.moves,
            **_apart(edit, bond),
        }
        for index, bond in enumerate(edit.settled.bonds)
        if posed in bond.bodies
    ]


def _end(end: BondEnd, names: dict[str, str]) -> Json:
    return {
        "body": end.body,
        "name": names[end.body],
        "part": end.part,
        "label": part_label(end.part),
    }


def _apart(edit: EditorState, bond: Bond) -> dict[str, Json]:
    """How far apart its points are at most, as far as they are shown, and where; whether they meet
    there, or keyframes of both keep them apart."""
    count = bond.last_frame - bond.first_frame + 1
    frames = np.linspace(bond.first_frame, bond.last_frame, min(count, MOST_FRAMES)).astype(int)
    keyed = keyed_apart(edit.settled, bond)
    is_keyed = keyed is not None and keyed[1] > MEET_M
    if keyed is not None and is_keyed:
        worst, metres = keyed
    else:
        apart = [apart_m(edit, bond, int(frame)) for frame in frames]
        worst, metres = int(frames[np.argmax(apart)]), max(apart)
    apart_cm = round(100 * metres, 1)
    is_met = apart_cm <= 100 * MEET_M
    return {"apart_cm": apart_cm, "worst": worst, "meet": is_met, "keyed": is_keyed}
