"""Limbs of filmed people on their marks: which is worst, where it belongs, how far it is off."""

from __future__ import annotations

import numpy as np

from bench.clips import Clip, place
from bench.measures import marks_between
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.solver.least_squares import Criteria, Damping, least_squares
from keypose.tracker.solver.one_pose import OnePose
from keypose.tracker.solver.pose_terms import PointsInPicture, PosePrior
from keypose.tracker.solver.posed import BodyPoints
from keypose.tracker.tracking.parts.limb_keyframes import turning
from keypose.tracker.tracking.segment import NEAREST_M

LIMBS = {
    f"{side} {limb}": tuple(f"{side}_{part}" for part in parts)
    for limb, parts in (
        ("arm", ("upper_arm", "forearm", "hand")),
        ("leg", ("thigh", "shin", "foot")),
    )
    for side in ("left", "right")
}
MARK_PX = 1.0
TURN_RAD = np.radians(30.0)
"""Standard deviations of a limb laid on its marks: of these, and of its turns from where it was."""


def on_marks(
    shown: Clip, skeleton: Skeleton, pose: Pose, frame: int, limb: tuple[str, ...]
) -> Pose:
    """Lay a limb of a pose on its marks."""
    body = skeleton.body
    parts = [body.index(name) for name in limb]
    free = turning(skeleton, tuple(parts))
    known = shown.marks[frame]
    names = [n for n in known if place(body, n)[0][0] in parts[1:] and len(place(body, n)) == 1]
    ideal = shown.camera.without_distortion()
    uv = ideal.project(shown.camera.back_project(np.array([known[name] for name in names]), 1.0))
    points = BodyPoints(free, tuple(place(body, name) for name in names))
    terms = (
        PointsInPicture(points, ideal, uv, np.full(len(names), 1 / MARK_PX), NEAREST_M),
        PosePrior.of(pose, np.full(free.dof_count, TURN_RAD**-2.0)),
    )
    many = Criteria(most_steps=60, longest_step=0.3, settled=1e-6, damping=Damping(most=1e6))
    return least_squares(OnePose(free, terms), pose, many).state


def errors(
    shown: Clip,
    skeleton: Skeleton,
    motion: Trajectory,
    keyframes: tuple[int, ...],
    limb: tuple[str, ...],
) -> tuple[list[float], list[float]]:
    """Measure pixels at the marks of a limb, without its first joint, and at all others."""
    body = skeleton.body
    own: list[float] = []
    rest: list[float] = []
    for mark in marks_between(shown, skeleton, motion, keyframes):
        part = body.names[place(body, mark.joint)[0][0]]
        (own if part in limb[1:] else rest).append(mark.px)
    return own, rest


def worst(
    shown: Clip, skeleton: Skeleton, motion: Trajectory, ends: tuple[int, int]
) -> tuple[str, int]:
    """Find the limb whose marks are worst, and its worst frame of those with two marks."""
    body, found = skeleton.body, {}
    marks = marks_between(shown, skeleton, motion, ends)
    for name, limb in LIMBS.items():
        own = [m for m in marks if body.names[place(body, m.joint)[0][0]] in limb[1:]]
        by_frame = {m.frame: [o.px for o in own if o.frame == m.frame] for m in own}
        whole = {frame: float(np.mean(px)) for frame, px in by_frame.items() if len(px) > 1}
        if len(whole) > 1:
            found[name] = (float(np.mean(list(whole.values()))), max(whole, key=whole.__getitem__))
    name = max(found, key=lambda limb: found[limb][0])
    return name, found[name][1]
