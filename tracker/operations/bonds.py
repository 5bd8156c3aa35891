"""Where bonds hold points of a body: where its own motion and that of the other body have them."""

from __future__ import annotations

import operator
from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import Array, apply_transform
from keypose.tracker.session.bodies import TrackedBody
from keypose.tracker.session.bonds import Bond, BondEnd
from keypose.tracker.session.schema import Session
from keypose.tracker.space.pinned import HeldPoint

MEET_M: Final = 0.005
"""Points of a bond that are no farther apart meet."""
NEAREST_FRAMES = 1e-6
"""From a keyframe: what is at it does not give way, unless the other does not either."""


def held_points(
    session: Session, bonds: Sequence[Bond], motions: Mapping[str, Trajectory]
) -> list[HeldPoint]:
    """The points of the body that is posed which bonds hold, at the places where both of their ends
    meet.

    bonds: within the frames of all motions.  motions: by the id of their body, without bonds.
    """
    own, points = session.subject, []
    for bond in bonds:
        places = meeting_places(session, bond, motions)
        for end in bond.ends:
            if end.body == own.id:
                part = own.body.index(end.part)
                points.append(HeldPoint(part, end.point_m, bond.first_frame, places))
    return points


def meeting_places(session: Session, bond: Bond, motions: Mapping[str, Trajectory]) -> Array:
    """(n, 3) where both ends of a bond are at each of its frames, camera frame: between them, the
    nearer to one that a keyframe of its body is, or where the one is that is not moved."""
    frames = np.arange(bond.first_frame, bond.last_frame + 1, dtype=np.int64)
    bodies = {body.id: body for body in session.bodies}
    holder, held = (_at(bodies[end.body], end, motions[end.body], frames) for end in bond.ends)
    if bond.moves == "held":
        return holder
    if bond.moves == "holder":
        return held
    free = [_frames_from_keyframes(bodies[end.body], frames) for end in bond.ends]
    share = (free[0] / (free[0] + free[1]))[:, None]
    return np.asarray(holder + share * (held - holder))


def keyed_apart(session: Session, bond: Bond) -> tuple[int, float] | None:
    """The frame, of those at which both bodies of a bond have an exact keyframe, at which its
    points are farthest apart, and how far, metres: they stay so. None where there is no such frame.
    """
    bodies = {body.id: body for body in session.bodies}
    keyframes = [
        {each.frame: each for each in bodies[end.body].keyframes if not each.soft}
        for end in bond.ends
    ]
    skeletons = [Skeleton.of(bodies[end.body].body) for end in bond.ends]
    apart = {}
    for frame in sorted(keyframes[0].keys() & keyframes[1].keys()):
        if bond.first_frame <= frame <= bond.last_frame:
            points = [
                _placed(own[frame].pose(skeleton), skeleton, end)
                for own, skeleton, end in zip(keyframes, skeletons, bond.ends, strict=True)
            ]
            apart[frame] = float(np.linalg.norm(points[0] - points[1]))
    return max(apart.items(), key=operator.itemgetter(1), default=None)


def _placed(pose: Pose, skeleton: Skeleton, end: BondEnd) -> Array:
    """(3,) an end in the camera frame."""
    T = pose_transforms(skeleton, pose)[skeleton.body.index(end.part)]
    return np.asarray(T[:3, :3] @ np.array(end.point_m) + T[:3, 3])


def _at(body: TrackedBody, end: BondEnd, motion: Trajectory, frames: NDArray[np.int64]) -> Array:
    rows = frames - motion.first_frame
    Ts = motion.transforms(Skeleton.of(body.body))[rows, body.body.index(end.part)]
    return apply_transform(Ts, np.array(end.point_m)[None, None])[:, 0]


def _frames_from_keyframes(body: TrackedBody, frames: NDArray[np.int64]) -> Array:
    """(n,) frames to the nearest keyframe that is met exactly."""
    exact = np.array([keyframe.frame for keyframe in body.keyframes if not keyframe.soft])
    if not len(exact):
        return np.full(len(frames), 1.0)
    return np.asarray(np.maximum(np.abs(frames[:, None] - exact).min(axis=1), NEAREST_FRAMES))
