"""Find what is up: by feet that stand on one level floor, and by how a person stands on them.

A camera is held level by about 3°, and looks down or up by more. Stances show the slope of the
floor as far as they are apart; that a person stands upright shows the rest, along the view less
surely than across it, where a network says how deep joints are. A person leans forward by a few
degrees, most of all on the way, so that this is unknown, too.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.balance import centre_of_mass
from keypose.tracker.body.ground import AHEAD_PART
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.geometry.up import (
    UpEstimate,
    UpEvidence,
    least_off,
    up_of_one,
)
from keypose.tracker.session.pins import Pin
from keypose.tracker.solver.sigmas import (
    FORWARD_LEAN_RAD,
    LEVEL_M,
    ROLL_RAD,
    STANCE_DEPTH,
    TILT_RAD,
    UPRIGHT_ACROSS_RAD,
    UPRIGHT_ALONG_RAD,
    USUAL_FORWARD_RAD,
)
from keypose.tracker.space.pinned import KNEES

MOST_LEAN_RAD: Final = np.radians(45.0)
"""Nobody who stands is farther from what the camera takes for up."""
MOST_BEND_RAD: Final = np.radians(60.0)
"""Somebody whose knees are bent by more sits, or squats, and is not upright over the feet."""
LEVEL_CAMERA: Final = np.array([0.0, -1.0, 0.0])
HELD_LEVEL: Final = UpEvidence.with_covariance(
    LEVEL_CAMERA, np.diag([ROLL_RAD, 1.0, TILT_RAD]) ** 2, "level"
)
"""A camera as people hold it."""
ABOUT_RAD: Final = np.radians(20.0)
"""Of where up is looked for by places that do not show it."""
OF_SCATTER: Final = 5
"""How many places say nothing of how all scatter: three lie in a plane, and the variance of few is
itself unsure (Student)."""
SIDES: Final = ("left", "right")
JOINT_OF: Final = {
    "shoulder": "upper_arm",
    "elbow": "forearm",
    "hip": "thigh",
    "knee": "shin",
    "ankle": "foot",
}
"""Parts that begin at a person's joints."""


def up_from_places(p_world: Array, up_evidence: UpEvidence = HELD_LEVEL) -> UpEstimate:
    """Up by places (N, 3) that lie on one level floor, metres.

    up_evidence: of up. It decides what the places do not show: those along one line show the slope
    along it alone.
    """
    return up_of_one(evidence_of_places(p_world, up_evidence.up), up_evidence)


def evidence_of_places(p_world: Array, up_world: Array) -> UpEvidence:
    """What places (N, 3) on one level floor show of up, metres: the more, the farther they lie
    apart, and the less, the more they scatter about one plane.

    up_world: unit vector (3,) that is about up.
    """
    from_middle = p_world - p_world.mean(axis=0)
    about = np.asarray(up_world, dtype=np.float64)
    # the camera, where the world begins, sees them at depths that are off by a share
    sigma = np.hypot(LEVEL_M, STANCE_DEPTH * abs(float(np.median(p_world @ about))))
    shown = from_middle.T @ from_middle / sigma**2
    up = least_off(shown + np.eye(3) / ABOUT_RAD**2, about / ABOUT_RAD**2, about)
    off = from_middle @ up
    scatter = float(off @ off) / max(len(off) - OF_SCATTER, 1)
    away = np.eye(3) - np.outer(up, up)
    precision = away @ from_middle.T @ from_middle @ away / max(sigma**2, scatter)
    return UpEvidence(up, precision, "feet")


def evidence_of_standing(
    skeleton: Skeleton, motion: Trajectory, stances: Sequence[Pin], lens_spread: float = 0.0
) -> tuple[UpEvidence, ...]:
    """What a person shows of up, by how they are upright over the feet that stand, where they are,
    and by where feet stand; none where none does.

    motion: in the world, metres.  stances: feet that stand still, whole, within it.
    lens_spread: as of `UpEvidence.seen_by_lens`. Depth by a wrong lens tilts the floor, and hardly
    how a person stands on it.
    """
    if not stances:
        return ()
    Ts = motion.transforms(skeleton)
    person = _evidence_of_balance(skeleton, motion, Ts, stances)
    places = np.array([_place(skeleton, Ts, stance, motion.first_frame) for stance in stances])
    if person is None or person.up @ LEVEL_CAMERA < np.cos(MOST_LEAN_RAD):
        return (evidence_of_places(places, LEVEL_CAMERA).seen_by_lens(lens_spread),)
    return person, evidence_of_places(places, person.up).seen_by_lens(lens_spread)


def _evidence_of_balance(
    skeleton: Skeleton, motion: Trajectory, Ts: Array, stances: Sequence[Pin]
) -> UpEvidence | None:
    """What a person shows of up whose weight is over the feet that stand, in the mean; None where
    nobody stands, or the body has no feet and arms. Ts: of the motion."""
    joints = {
        joint: [i for i, name in enumerate(skeleton.body.names) if name.endswith(part)]
        for joint, part in JOINT_OF.items()
    }
    if any(len(pair) != len(SIDES) for pair in joints.values()):
        return None
    carries = np.stack(
        [
            _standing([pin for pin in stances if pin.part == skeleton.body.names[foot]], motion)
            for foot in joints["ankle"]
        ],
        axis=1,
    )
    is_upright = carries.any(axis=1) & (_bend_rad(skeleton, motion) < MOST_BEND_RAD)
    if not is_upright.any():
        return None
    Ts, weight = Ts[is_upright], carries[is_upright] / carries[is_upright].sum(axis=1)[:, None]
    p = {joint: Ts[..., :3, 3][:, pair] for joint, pair in joints.items()}
    lines = centre_of_mass(p) - (weight[:, :, None] * p["ankle"]).sum(axis=1)
    lines = lines / np.linalg.norm(lines, axis=1, keepdims=True)
    ahead = (Ts[:, 0, :3, :3] @ np.array(AHEAD_PART)).mean(axis=0)
    up = lines.mean(axis=0) - USUAL_FORWARD_RAD * ahead
    usual = np.diag([UPRIGHT_ACROSS_RAD, UPRIGHT_ACROSS_RAD, UPRIGHT_ALONG_RAD]) ** 2
    leaning = FORWARD_LEAN_RAD**2 * np.outer(ahead, ahead)
    sways = np.cov(lines.T, bias=True) / len(stances)  # each stance sways by itself
    return UpEvidence.with_covariance(up / np.linalg.norm(up), usual + leaning + sways, "person")


def leaning_rad(skeleton: Skeleton, motion: Trajectory, up_world: Array) -> float:
    """How far the line from feet to shoulders usually is from up; 0 without these."""
    feet, arms = (
        [i for i, name in enumerate(skeleton.body.names) if name.endswith(part)]
        for part in (JOINT_OF["ankle"], JOINT_OF["shoulder"])
    )
    if not feet or not arms:
        return 0.0
    p = motion.transforms(skeleton)[:, :, :3, 3]
    along = p[:, arms].mean(axis=1) - p[:, feet].mean(axis=1)
    usual = np.median(along / np.linalg.norm(along, axis=1, keepdims=True), axis=0)
    return float(np.arccos(np.clip(usual @ up_world / np.linalg.norm(usual), -1.0, 1.0)))


def _standing(stances: Sequence[Pin], motion: Trajectory) -> NDArray[np.bool_]:
    """(N,) True where a foot stands."""
    there = np.zeros(len(motion), dtype=np.bool_)
    for stance in stances:
        there[_rows(stance, motion.first_frame)] = True
    return there


def _bend_rad(skeleton: Skeleton, motion: Trajectory) -> Array:
    """(N,) by how much the less bent of the knees is bent; 0 of a body without."""
    shins = [i for i, name in enumerate(skeleton.body.names) if name in KNEES]
    if not shins:
        return np.zeros(len(motion))
    straight = motion.Rs_parent_part[:, shins, 1, 1]  # of the shin's length along the thigh's
    return np.asarray(np.arccos(np.clip(straight, -1.0, 1.0)).min(axis=1))


def _place(skeleton: Skeleton, Ts: Array, stance: Pin, first_frame: int) -> Array:
    """(3,) where a foot stands: the median of its joint, as drafts turn feet less surely."""
    joint = Ts[_rows(stance, first_frame), skeleton.body.index(stance.part), :3, 3]
    return np.asarray(np.median(joint, axis=0))


def _rows(stance: Pin, first_frame: int) -> slice:
    return slice(stance.first_frame - first_frame, stance.last_frame + 1 - first_frame)
