"""A desk to try edits at: the sample session without its video."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from keypose.app.editor.actions import ACTIONS
from keypose.app.editor.motion import angles_at
from keypose.app.editor.shown import shown_pose
from keypose.app.editor.state import EditorState
from keypose.app.editor.update import update
from keypose.app.posing import opening_pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.storage.files import load_session

SAMPLE = Path(__file__).resolve().parents[3] / "sample_videos" / "person" / "session.json"


@cache  # it is never changed: every edit makes another
def desk(*, keyframes: bool = True) -> EditorState:
    """The sample with its keyframes at 0, 24, 48 and 72, or without any."""
    session = load_session(SAMPLE)
    if not keyframes:
        session = session.changed({"keyframes": ()})
    return EditorState(
        doc=session,
        skeleton=Skeleton.of(session.subject.body),
        file_times_s=np.arange(session.view.video.frame_count) / 30,
        opening=opening_pose(session.subject.body, session.view.camera, (0.0, -1.0, 0.0)),
    )


def after(state: EditorState, *messages: dict[str, Any]) -> EditorState:
    """The state after messages as a page sends them."""
    for message in messages:
        state = update(state, ACTIONS.validate_python(message))  # type: ignore[arg-type]
    return state


def angles(state: EditorState, part: str) -> Array:
    """A part's angles at the present frame, degrees."""
    return np.array(angles_at(state, shown_pose(state).pose)[part])
