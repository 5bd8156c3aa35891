"""The ways of a body's feet through space, and the floor under them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from keypose.app.editor.motion import known_motion, settled_skeleton
from keypose.app.editor.pointer_views import up_of
from keypose.app.editor.shown import shown_pose
from keypose.app.editor.state import EditorState
from keypose.app.posing import handles
from keypose.app.posing.labels import kind_of
from keypose.tracker.body.body import Body
from keypose.tracker.body.ground import floor_height, lowest_heights
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array

MOST_MOMENTS = 1000
SOLE_M = 0.015
"""What of a foot at rest counts as its sole: so much above its lowest point."""
MOST_ENDS = 4


@dataclass(frozen=True, eq=False)
class FeetPaths:
    """floor_m: metres along up from the camera's centre.  frames: (N,) ascending, none where no
    pose is known.  paths: of every foot, or of every limb's end where a body has no feet, by the
    name of its part: (N, 3) camera frame, metres."""

    floor_m: float
    frames: NDArray[np.int64]
    paths: dict[str, Array]


def feet_paths(edit: EditorState) -> FeetPaths:
    """Of all that is known of the motion; the floor as it was set, or guessed from the motion."""
    floor_m = edit.settled.floor_m
    skeleton, up = settled_skeleton(edit), up_of(edit.settled)
    motion = known_motion(edit, MOST_MOMENTS)
    if motion is None:
        Ts = pose_transforms(edit.skeleton, shown_pose(edit).pose)[None]
        floor = floor_height(floor_m, lowest_heights(edit.skeleton, Ts, up))
        return FeetPaths(floor, np.zeros(0, dtype=np.int64), {})
    Ts = motion.Ts_camera_part
    paths = {}
    for part, p_part in _soles(skeleton).items():
        T = Ts[:, skeleton.body.index(part)]
        paths[part] = T[:, :3, :3] @ p_part + T[:, :3, 3]
    floor = floor_height(floor_m, lowest_heights(skeleton, Ts, up))
    return FeetPaths(floor, motion.frames, paths)


def _soles(skeleton: Skeleton) -> dict[str, Array]:
    """The middle (3,) of every foot's sole, or the tip of every limb, in its part's frame."""
    body = skeleton.body
    feet = [name for name in body.names if kind_of(name) == "foot"]
    if not feet:
        return {part: _tip(body, part) for part in _ends(body)}
    at_rest = pose_transforms(skeleton, Pose.rest(skeleton, (0.0, 0.0, 0.0)))
    return {part: _sole(body, part, at_rest) for part in feet}


def _sole(body: Body, part: str, Ts_at_rest: Array) -> Array:
    i = body.index(part)
    vertices = body.parts[i].shape.mesh().vertices
    down = vertices @ Ts_at_rest[i, :3, :3].T[:, 1]
    return np.asarray(vertices[down > down.max() - SOLE_M].mean(axis=0))


def _ends(body: Body) -> list[str]:
    """The last parts of limbs; the root where there is no limb."""
    found = [handle.limb[-1] for handle in handles(body) if handle.kind == "end"]
    return found[:MOST_ENDS] or [body.names[0]]


def _tip(body: Body, part: str) -> Array:
    """The far end of a part along its length."""
    vertices = body.parts[body.index(part)].shape.mesh().vertices
    far = vertices[np.abs(vertices[:, 1]) > np.abs(vertices[:, 1]).max() - SOLE_M]
    return np.asarray(far.mean(axis=0))
