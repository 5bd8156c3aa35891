"""Measure how the soles of a body lie on its floor."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.pins import Pin, sole_of
from keypose.tracker.session.schema import Session
from keypose.tracker.solver.posed import BodyPoints
from keypose.tracker.space.result import SpaceResult

AIR_M: Final = 0.03
"""A body whose lowest sole is higher above the floor is in the air."""
HEEL_M, TOE_M = 0.06, 0.04
"""How far the heel of a foot that turns on its toe moves at least, and the toe at most."""
TIPPED_M: Final = 0.05
"""A foot whose toe is so much higher or lower beside its heel than usual in its stance lands or
leaves."""
LEAST_FRAMES: Final = 3
"""A shorter contact of heel or toe alone is none."""


@dataclass(frozen=True, eq=False)
class Soles:
    """How soles lie on the floor.

    off_m: the greatest height of a pinned sole above or below the floor, signed; part, frame: whose
    and where.  in_air: first and last of the runs of frames in which nothing touches the floor.
    """

    off_m: float
    part: str
    frame: int
    in_air: tuple[tuple[int, int], ...]


def soles_of(session: Session, stretches: Sequence[SpaceResult]) -> Soles | None:
    """Measure how the pinned soles lie on the session's floor; None without any."""
    if session.floor_m is None or session.up_camera is None:
        return None
    skeleton, up = Skeleton.of(session.body), np.array(session.up_camera)
    found = []
    for stretch in stretches:
        motion = stretch.motion
        span = motion.first_frame, motion.last_frame
        pins = [
            pin for pin in session.pins if span[0] <= pin.first_frame <= pin.last_frame <= span[1]
        ]
        measured = measured_soles(skeleton, motion, pins, up / np.linalg.norm(up), session.floor_m)
        found += [measured] if measured else []
    if not found:
        return None
    worst = max(found, key=lambda soles: abs(soles.off_m))
    in_air = tuple(run for soles in found for run in soles.in_air)
    return replace(worst, in_air=in_air)


def measured_soles(
    skeleton: Skeleton, motion: Trajectory, pins: Sequence[Pin], up_camera: Array, floor_m: float
) -> Soles | None:
    """Measure the pins on the floor; None without any. pins: within the motion."""
    worst: tuple[float, Pin, int] | None = None
    for pin in pins:
        if not pin.floor:
            continue
        off = foot_heights(skeleton, motion, pin, up_camera) - floor_m
        row, _ = np.unravel_index(int(np.abs(off).argmax()), off.shape)
        most = float(off.flat[int(np.abs(off).argmax())])
        if worst is None or abs(most) > abs(worst[0]):
            worst = most, pin, pin.first_frame + int(row)
    if worst is None:
        return None
    off_m, pin, frame = worst
    in_air = tuple(_in_air(skeleton, motion, up_camera, floor_m))
    return Soles(off_m, pin.part, frame, in_air)


def foot_heights(skeleton: Skeleton, motion: Trajectory, pin: Pin, up_camera: Array) -> Array:
    """(n, K) metres along up of the ends of its sole that a pin holds, over its frames."""
    part = skeleton.body.parts[skeleton.body.index(pin.part)]
    ends = pin.landmarks or sole_of(part)
    return np.asarray(_ends(skeleton, motion, pin, ends) @ up_camera)


def by_contact(
    skeleton: Skeleton, motion: Trajectory, pin: Pin, up_camera: Array
) -> tuple[Pin, ...]:
    """The pin of a whole foot as pins of what touches the floor: of the toe alone where the foot
    turns on that, of the heel or the toe alone while it lands or leaves.
    """
    if len(pin.landmarks) < 2:
        return (pin,)
    ends = _ends(skeleton, motion, pin, pin.landmarks)
    heel, toe = (_strays(ends[:, k]) for k in range(2))
    if heel > HEEL_M and toe < TOE_M:
        return (pin.model_copy(update={"landmarks": pin.landmarks[1:]}),)
    heel_high, toe_high = (ends @ up_camera).T
    tipped = toe_high - heel_high
    flat = np.abs(tipped - np.median(tipped)) < TIPPED_M
    rows = np.flatnonzero(flat)
    first, last = int(rows[0]), int(rows[-1])
    pieces = ((0, first - 1), (first, last), (last + 1, len(flat) - 1))
    found = []
    for a, b in pieces:
        held = pin.landmarks
        if (a, b) != (first, last):
            heel_is_up = np.median(tipped[a : b + 1]) < np.median(tipped) if b >= a else False
            held = held[1:] if heel_is_up else held[:1]
        if b - a + 1 >= LEAST_FRAMES or (a, b) == (first, last):
            start = pin.first_frame
            span = {"first_frame": start + a, "last_frame": start + b}
            found.append(pin.model_copy(update={"landmarks": held, **span}))
    return tuple(found)


def _ends(skeleton: Skeleton, motion: Trajectory, pin: Pin, ends: Sequence[str]) -> Array:
    """(n, K, 3) where landmarks of a pin's part are over its frames."""
    part = skeleton.body.index(pin.part)
    places = [skeleton.body.parts[part].landmarks[name] for name in ends]
    points = BodyPoints(skeleton, tuple(((part, place),) for place in places))
    first = motion.first_frame
    rows = slice(pin.first_frame - first, pin.last_frame + 1 - first)
    return points.at(motion.transforms(skeleton)[rows])


def _strays(p: Array) -> float:
    """How far a point (n, 3) strays from its middle place."""
    return float(np.linalg.norm(p - np.median(p, axis=0), axis=-1).max())


def _in_air(
    skeleton: Skeleton, motion: Trajectory, up_camera: Array, floor_m: float
) -> Iterator[tuple[int, int]]:
    feet = [(i, part.landmarks[name]) for i, part in enumerate(skeleton.body.parts)
            for name in sole_of(part)]  # fmt: skip
    points = BodyPoints(skeleton, tuple((foot,) for foot in feet))
    lowest = (points.at(motion.transforms(skeleton)) @ up_camera).min(axis=1)
    yield from _runs(lowest > floor_m + AIR_M, motion.first_frame)


def _runs(there: NDArray[np.bool_], first_frame: int) -> Iterator[tuple[int, int]]:
    edges = np.flatnonzero(np.diff(np.concatenate([[False], there, [False]]).astype(int)))
    yield from ((first_frame + int(a), first_frame + int(b) - 1) for a, b in edges.reshape(-1, 2))
