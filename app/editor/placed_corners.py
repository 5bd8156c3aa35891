"""Which corners of boxes were put in their places, for as long as the pose is the one they led to.

Undo, redo and a walk along the film come back to such a pose, and with it to its corners; a pose
that was changed in another way has none.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from keypose.app.editor.shown import shown_pose
from keypose.app.editor.state import EditorState
from keypose.app.posing import PlacedCorner
from keypose.tracker.body.pose import Pose
from keypose.tracker.geometry.camera import Camera

REMEMBERED = 100
_SAME = 1e-9


@dataclass(frozen=True, eq=False)
class PosedByCorners:
    """The pose of a frame, seen by a camera, that some corners led to."""

    frame: int
    pose: Pose
    camera: Camera
    corners: tuple[PlacedCorner, ...]


def corners_placed(state: EditorState) -> tuple[PlacedCorner, ...]:
    """Those placed at the present frame, the last one last."""
    readout = state.stroke.readout if state.stroke else None
    if readout is not None:
        return readout.corners
    pose = shown_pose(state).pose if state.posed_by_corners else None
    for one in reversed(state.posed_by_corners):
        if one.frame == state.frame and one.camera == state.doc.camera and _is_same(one.pose, pose):
            return one.corners
    return ()


def with_corners(state: EditorState, corners: tuple[PlacedCorner, ...]) -> EditorState:
    """The same with the present pose known as the one that these corners led to."""
    if not corners:
        return state
    new = PosedByCorners(state.frame, shown_pose(state).pose, state.doc.camera, corners)
    return replace(state, posed_by_corners=(*state.posed_by_corners, new)[-REMEMBERED:])


def _is_same(one: Pose, other: Pose | None) -> bool:
    if other is None or one.Rs_parent_part.shape != other.Rs_parent_part.shape:
        return False
    turned = np.abs(one.Rs_parent_part - other.Rs_parent_part).max()
    return bool(max(turned, np.abs(one.p_camera_root - other.p_camera_root).max()) < _SAME)
