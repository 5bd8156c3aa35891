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
    """Every bond that holds the posed body, with its number among all of the session; its frames
    follow a gesture under way."""
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
            **_apart(edit, bond, names),
        }
        for index, bond in enumerate(edit.doc.bonds)
        if posed in bond.bodies
    ]


def _end(end: BondEnd, names: dict[str, str]) -> Json:
    return {
        "body": end.body,
        "name": names[end.body],
        "part": end.part,
        "label": part_label(end.part),
    }


def _apart(edit: EditorState, bond: Bond, names: dict[str, str]) -> dict[str, Json]:
    """How far apart its points are at most, as far as they are shown, and where; whether they meet
    there, and why not: "keyed" where keyframes of both keep them apart, "unposed" with the name of
    a body without a keyframe, "tracked" where both are up to date, else "untracked"."""
    keyed = keyed_apart(edit.settled, bond)
    worst, metres = keyed if keyed is not None and keyed[1] > MEET_M else _farthest(edit, bond)
    bodies = {body.id: body for body in edit.settled.bodies}
    unposed = [names[body] for body in bond.bodies if not bodies[body].keyframes]
    if keyed is not None and keyed[1] > MEET_M:
        cause = "keyed"
    elif unposed:
        cause = "unposed"
    else:
        is_tracked = all(_is_up_to_date(edit.about(body), worst) for body in bond.bodies)
        cause = "tracked" if is_tracked else "untracked"
    apart_cm = round(100 * metres, 1)
    return {
        "apart_cm": apart_cm,
        "worst": worst,
        "meet": apart_cm <= 100 * MEET_M,
        "cause": cause,
        "unposed": unposed[0] if unposed else None,
    }


def _farthest(edit: EditorState, bond: Bond) -> tuple[int, float]:
    """The frame at which the points of a bond are shown farthest apart, and how far, metres."""
    count = bond.last_frame - bond.first_frame + 1
    frames = np.linspace(bond.first_frame, bond.last_frame, min(count, MOST_FRAMES)).astype(int)
    apart = [apart_m(edit, bond, int(frame)) for frame in frames]
    return int(frames[np.argmax(apart)]), max(apart)


def _is_up_to_date(alone: EditorState, frame: int) -> bool:
    """Whether a body is tracked at a frame, and its motion solved for in space there."""
    unsolved = alone.results.unsolved(alone.settled)
    is_solved = not any(run.span[0] <= frame <= run.span[1] for run in unsolved)
    return is_solved and alone.tracked(frame) is not None
