"""The angles of a part over all frames: where somebody posed it as posed, else of the motion."""

from __future__ import annotations

import numpy as np

from keypose.app.editor.shown import counts
from keypose.app.editor.state import EditorState
from keypose.app.posing import angle_curve_deg
from keypose.tracker.geometry.rotations import Array, rotation_from_quaternion
from keypose.tracker.storage.results import rotations

AT_REST = (1.0, 0.0, 0.0, 0.0)


def angle_curve(edit: EditorState, index: int) -> Array:
    """(F, 3) degrees of a part by frame, without jumps; NaN where nothing is known."""
    Rs = rotations(edit.fitting, edit.frame_count, index)
    name = edit.doc.body.names[index]
    keys = [keyframe.frame for keyframe in edit.doc.keyframes]
    if poses := (*edit.doc.keyframes, *(d for d in edit.doc.drafts if counts(edit, d))):
        wxyz = [posed.rotations_wxyz.get(name, AT_REST) for posed in poses]
        Rs[[posed.frame for posed in poses]] = rotation_from_quaternion(wxyz)
    known = np.flatnonzero(np.isfinite(Rs[:, 0, 0]))
    angles = np.full((edit.frame_count, 3), np.nan)
    part = edit.doc.body.parts[index]
    angles[known] = angle_curve_deg(part, Rs[known], np.searchsorted(known, keys))
    return angles
