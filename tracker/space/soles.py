"""Measure how the soles of a body lie on its floor."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory, runs
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.pins import Pin, pins_within, sole_of
from keypose.tracker.session.schema import Session
from keypose.tracker.solver.posed import BodyPoints
from keypose.tracker.space.result import SpaceResult

AIR_M: Final = 0.03
"""A body whose lowest sole is higher above the floor is in the air."""
HEEL_M = 0.06
TOE_M = 0.04
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
    if session.world.floor_m is None or session.world.up_world is None:
        return None
    up = np.array(session.world.up_world)
    motions = [session.film_camera.motion_to_world(stretch.motion) for stretch in stretches]
    return measured_soles(
        Skeleton.of(session.subject.body),
        motions,
        session.subject.pins,
        up / np.linalg.norm(up),
        session.world.floor_m,
    )


def measured_soles(
    skeleton: Skeleton,
    motions: Sequence[Trajectory],
    pins: Sequence[Pin],
    up_world: Array,
    floor_m: float,
) -> Soles | None:
    """Measure the soles that are pinned on the floor; None without any. up_world: unit vector."""
    on_floor = [pin for pin in pins if pin.floor]
    if not any(pin.holds_sole(skeleton.body) for pin in on_floor):
        return None
    measured: list[Soles] = []
    in_air: list[tuple[int, int]] = []
    for motion in motions:
        held = pins_within(on_floor, (motion.first_frame, motion.last_frame))
        measured += [
            _at_worst(skeleton, motion, pin, up_world, floor_m)
            for pin in held
            if pin.holds_sole(skeleton.body)
        ]
        in_air += _in_air(skeleton, motion, held, up_world, floor_m)
    worst = max(measured, key=lambda soles: abs(soles.off_m), default=None)
    return None if worst is None else replace(worst, in_air=tuple(in_air))


def _at_worst(
    skeleton: Skeleton, motion: Trajectory, pin: Pin, up_world: Array, floor_m: float
) -> Soles:
    off = foot_heights(skeleton, motion, pin, up_world) - floor_m
    row, end = np.unravel_index(int(np.abs(off).argmax()), off.shape)
    return Soles(float(off[row, end]), pin.part, pin.first_frame + int(row), ())


def foot_heights(skeleton: Skeleton, motion: Trajectory, pin: Pin, up_world: Array) -> Array:
    """(n, K) metres along up of the ends of its sole that a pin holds, over its frames."""
    return np.asarray(_ends(skeleton, motion, pin) @ up_world)


def by_contact(
    skeleton: Skeleton, motion: Trajectory, pin: Pin, up_world: Array
) -> tuple[Pin, ...]:
    """The pin of a whole foot as pins of what touches the floor: of the toe alone where the foot
    turns on that, of the heel or the toe alone while it lands or leaves.
    """
    if len(pin.landmarks) < 2:
        return (pin,)
    ends = _ends(skeleton, motion, pin)
    heel, toe = (_strays(ends[:, k]) for k in range(2))
    if heel > HEEL_M and toe < TOE_M:
        return (pin.model_copy(update={"landmarks": pin.landmarks[1:]}),)
    heel_high, toe_high = (ends @ up_world).T
    tipped = toe_high - heel_high
    usual = np.quantile(tipped, 0.5, method="nearest")
    flat = np.abs(tipped - usual) < TIPPED_M
    rows = np.flatnonzero(flat)
    first, last = int(rows[0]), int(rows[-1])
    pieces = ((0, first - 1), (first, last), (last + 1, len(flat) - 1))
    pins = []
    for a, b in pieces:
        held = pin.landmarks
        if (a, b) != (first, last):
            heel_is_up = np.median(tipped[a : b + 1]) < usual if b >= a else False
            held = held[1:] if heel_is_up else held[:1]
        if b - a + 1 >= LEAST_FRAMES or (a, b) == (first, last):
            start = pin.first_frame
            span = {"first_frame": start + a, "last_frame": start + b}
            pins.append(pin.model_copy(update={"landmarks": held, **span}))
    return tuple(pins)


def _ends(skeleton: Skeleton, motion: Trajectory, pin: Pin) -> Array:
    """(n, K, 3) where the landmarks that a pin holds are over its frames."""
    part = skeleton.body.index(pin.part)
    places = [skeleton.body.parts[part].landmarks[name] for name in pin.landmarks]
    points = BodyPoints(skeleton, tuple(((part, place),) for place in places))
    first = motion.first_frame
    rows = slice(pin.first_frame - first, pin.last_frame + 1 - first)
    return points.at(motion.transforms(skeleton)[rows])


def _strays(p: Array) -> float:
    """How far a point (n, 3) strays from its middle place."""
    return float(np.linalg.norm(p - np.median(p, axis=0), axis=-1).max())


def _in_air(
    skeleton: Skeleton, motion: Trajectory, held: Sequence[Pin], up_world: Array, floor_m: float
) -> Iterator[tuple[int, int]]:
    """Runs of frames in which no sole is near the floor, and nothing else is held on it."""
    feet = [
        (i, part.landmarks[name])
        for i, part in enumerate(skeleton.body.parts)
        for name in sole_of(part)
    ]
    points = BodyPoints(skeleton, tuple((foot,) for foot in feet))
    lowest = (points.at(motion.transforms(skeleton)) @ up_world).min(axis=1)
    first, high = motion.first_frame, lowest > floor_m + AIR_M
    for pin in held:
        high[pin.first_frame - first : pin.last_frame + 1 - first] = False
    yield from ((first + a, first + b) for a, b in runs(high))
