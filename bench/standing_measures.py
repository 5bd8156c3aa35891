"""What standing on the floor did to a motion whose truth is known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bench.sequences import FPS
from bench.standing_cases import Made
from bench.table import Expected
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory, joined
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.operations.solve_space import solved
from keypose.tracker.session import Session
from keypose.tracker.session.pins import Pin
from keypose.tracker.solver.posed import BodyPoints
from keypose.tracker.space.findings import MOST_PUSH, STILL_M_S2, near_end
from keypose.tracker.space.soles import foot_heights
from keypose.tracker.storage.stretches import stretches

SIDES = ("left", "right")
PLANTED_M_S = 0.08
"""Of what stands."""


@dataclass(frozen=True)
class Effect:
    """soles: spread of pinned heels and toes, cm.  planted: spread of all that truly stand, cm.
    knees, knee: mean and 95th percentile of what a knee is farther off than before, degrees.  px,
    joint: mean farther off, and the joint that got worst, heels and toes left out.  turn,
    turn_before: of a foot in a frame, degrees.  push: a foot's acceleration where pins end as a
    multiple of what was tracked there.  mm, mm_before: joints beside the root.  up: degrees off.
    """

    pins: int
    soles: float
    planted: float
    knees: float
    knee: float
    px: float
    joint: float
    turn: float
    turn_before: float
    push: float
    mm: float
    mm_before: float
    up: float


COLUMNS = (
    "pins",
    "soles cm",
    "planted cm",
    "knees deg",
    "95 % deg",
    "px",
    "joint px",
    "turn deg",
    "before",
    "push",
    "mm",
    "mm before",
    "up deg",
)

MOST_SOLES_CM = 1.5
MOST_KNEE_DEG = 5.0
MOST_PX = 0.3
MOST_JOINT_PX = 8.0
MOST_TURN_DEG = 12.0


def expected(found: Effect) -> list[Expected]:
    """What standing is to do at most; a foot that was tracked to turn faster may go on to."""
    return [
        Expected("soles", found.soles, MOST_SOLES_CM, "cm"),
        Expected("knees", found.knee, MOST_KNEE_DEG, "°"),
        Expected("px", found.px, MOST_PX),
        Expected("joint", found.joint, MOST_JOINT_PX, "px"),
        Expected("turn", found.turn, max(MOST_TURN_DEG, found.turn_before), "°"),
        Expected("push", found.push, MOST_PUSH),
    ]


def motion_of(session: Session, made: Made) -> Trajectory:
    """The motion of a session that stands, in the camera frame."""
    tracked = {span: found.as_tracked for span, found in made.fitting.items()}
    return joined([solved(session, run).motion for run in stretches(session, tracked)])


def tracked_of(made: Made) -> Trajectory:
    return joined([made.fitting[span].trajectory for span in sorted(made.fitting)])


def effect(made: Made, session: Session, motion: Trajectory) -> Effect:
    skeleton, truth, before = made.skeleton, made.truth, tracked_of(made)
    rows = slice(0, len(motion))
    true = Trajectory(0, truth.Rs_parent_part[rows], truth.ps_camera_root[rows])
    up = session.world.up
    world, pins = session.film_camera.motion_to_world(motion), session.subject.pins
    high = [foot_heights(skeleton, world, pin, up).ravel() for pin in pins if pin.floor]
    planted = _planted(made, true)
    ends = soles_points(skeleton).at(world.transforms(skeleton)) @ up
    knees = [knees_deg(skeleton, m) for m in (motion, before, true)]
    worse = np.abs(knees[0] - knees[2]) - np.abs(knees[1] - knees[2])
    seen = [made.camera.project(m.joints(skeleton)) for m in (motion, before, true)]
    off = [np.linalg.norm(uv - seen[2], axis=-1) for uv in seen[:2]]
    mm = [_beside_root(skeleton, m, true) for m in (motion, before)]
    in_world = [session.film_camera.motion_to_world(each) for each in (motion, before)]
    turns = [float(feet_turn(skeleton, each).max()) for each in in_world]
    joints = skeleton.part_count
    return Effect(
        len(pins),
        100 * float(np.ptp(np.concatenate(high))) if high else 0.0,
        100 * _range(ends[planted]),
        float(worse.mean()),
        float(np.quantile(worse, 0.95)),
        float((off[0] - off[1]).mean()),
        float((off[0] - off[1])[:, :joints].max()),
        *turns,
        push(skeleton, world, session.film_camera.motion_to_world(before), pins, FPS),
        mm[0],
        mm[1],
        float(np.degrees(np.arccos(np.clip(up / np.linalg.norm(up) @ made.up, -1, 1)))),
    )


def _range(heights: Array) -> float:
    """From the lowest twentieth to the highest; 0 of none."""
    return float(np.subtract(*np.quantile(heights, (0.95, 0.05)))) if len(heights) else 0.0


def soles_points(skeleton: Skeleton) -> BodyPoints:
    """Heels and toes, of the left foot first."""
    feet = [skeleton.body.index(f"{side}_foot") for side in SIDES]
    return BodyPoints(
        skeleton,
        tuple(((i, p),) for i in feet for p in skeleton.body.parts[i].landmarks.values()),
    )


def _planted(made: Made, true: Trajectory) -> Array:
    """(N, 4) where heels and toes stand in truth."""
    p = soles_points(made.skeleton).at(made.in_world(true).transforms(made.skeleton))
    speed = np.linalg.norm(np.gradient(p, axis=0), axis=-1) * FPS
    high = p @ made.up
    return np.asarray((speed < PLANTED_M_S) & (high < high.min() + 0.01))


def knees_deg(skeleton: Skeleton, motion: Trajectory) -> Array:
    """(N, 2)"""
    p = motion.transforms(skeleton)[..., :3, 3]
    found = []
    for side in SIDES:
        hip, knee, ankle = (
            p[:, skeleton.body.index(f"{side}_{part}")] for part in ("thigh", "shin", "foot")
        )
        u, v = knee - hip, ankle - knee
        cos = (u * v).sum(axis=1) / np.linalg.norm(u, axis=1) / np.linalg.norm(v, axis=1)
        found.append(np.degrees(np.arccos(np.clip(cos, -1, 1))))
    return np.stack(found, axis=1)


def feet_turn(skeleton: Skeleton, motion: Trajectory) -> Array:
    """(N − 1, 2) degrees that each foot turns in a frame."""
    feet = [skeleton.body.index(f"{side}_foot") for side in SIDES]
    R = motion.transforms(skeleton)[:, feet][..., :3, :3]
    step = np.swapaxes(R[:-1], -1, -2) @ R[1:]
    cos = (np.trace(step, axis1=-2, axis2=-1) - 1) / 2
    return np.degrees(np.arccos(np.clip(cos, -1, 1)))


def push(
    skeleton: Skeleton, after: Trajectory, before: Trajectory, pins: Sequence[Pin], rate: float
) -> float:
    """The largest acceleration of a foot near where a pin begins or ends, beside that before."""
    most = [0.0, STILL_M_S2]
    for which, motion in enumerate((after, before)):
        for pin in pins:
            part = skeleton.body.index(pin.part)
            near = [near_end(skeleton, motion, part, end, rate)[1] for end in pin.span]
            most[which] = max(most[which], *(float(each.max(initial=0.0)) for each in near))
    return most[0] / most[1]


def _beside_root(skeleton: Skeleton, motion: Trajectory, true: Trajectory) -> float:
    p, q = (m.joints(skeleton) for m in (motion, true))
    return 1e3 * float(np.linalg.norm((p - p[:, :1]) - (q - q[:, :1]), axis=-1).mean())
