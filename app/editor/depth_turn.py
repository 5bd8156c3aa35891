"""A limb, or the whole body, turned in depth at the present frame."""

from __future__ import annotations

import numpy as np

from keypose.app.editor import actions as do
from keypose.app.editor.posing_edits import with_pose
from keypose.app.editor.refusal import Refused
from keypose.app.editor.shown import shown_pose
from keypose.app.editor.state import EditorState
from keypose.app.posing import part_label
from keypose.tracker.session.schema import Session
from keypose.tracker.solver.depth_turn import depths_m, strays, turned_in_depth, turns_round

LEAST_M = 0.02
"""A limb whose joints lie no farther apart in depth looks the same either way."""
MOST_STRAY = 0.06
"""Share of the body's height by which a joint may leave its place in the picture."""


def turn_in_depth(state: EditorState, action: do.TurnInDepth) -> Session:
    """The part and what hangs on it, or the whole body, the other way round in depth."""
    skeleton, pose = state.skeleton, shown_pose(state).pose
    top = 0 if action.part is None else state.doc.body.index(action.part)
    name = "The body" if top == 0 else part_label(skeleton.body.names[top])
    if np.ptp(depths_m(skeleton, pose, top)) < LEAST_M:
        raise Refused(f"{name} lies across the view: it looks the same either way.")
    camera = state.doc.camera
    turned = turned_in_depth(skeleton, camera, pose, top)
    leaves = top != 0 and strays(skeleton, camera, pose, turned, top) > MOST_STRAY
    if leaves or not turns_round(skeleton, pose, turned, top):
        raise Refused(f"{name} cannot bend the other way. Turn a part further out alone.")
    return with_pose(state, turned, partial=action.partial)
