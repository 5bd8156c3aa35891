"""A small move of the pointer is a small move of the body: dense sweeps of every handle."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest

from keypose.app.posing import BodyHandle, Held, drag, handle_named, handles
from keypose.app.posing.holding import NONE_HELD
from keypose.tracker.body.body import Body
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import log_rotation, transpose
from tests.app.posing.posing_cases import (
    DOG,
    PERSON,
    VIEWS,
    Floats,
    as_sent,
    gesture,
    points,
    sights,
    standing,
    tumbling,
    walking,
)

STEP_M = 0.03
FAR_M = 0.6
CLOSE_M = 2e-5
"""Pointer positions as near to each other as this must give the same pose but for JUMP."""
JUMP = math.radians(12)

WAYS_DEG = dict(zip(VIEWS, 2 * [(15, 190), (100, 280)], strict=True))
"""Directions of a drag in a view's picture."""

CASES = [
    ("standing", PERSON, standing(PERSON)),
    ("walking", PERSON, walking()),
    ("tumbling", PERSON, tumbling()),
    ("dog", DOG, standing(DOG)),
]


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize(("body", "pose"), [case[1:] for case in CASES], ids=[c[0] for c in CASES])
def test_nothing_jumps_anywhere_along_a_drag(body: Body, pose: Pose, view: str) -> None:
    one_side = [h for h in handles(body) if h.kind != "root" and not h.name.startswith("right")]
    for limits_on in (True, False):
        for handle in one_side:
            for degrees in WAYS_DEG[view]:
                worst = largest_jump(drawn(body, pose, handle, view, degrees, limits_on))
                assert worst < JUMP, (handle.name, degrees, limits_on, math.degrees(worst))


@pytest.mark.parametrize("degrees", [65, 110, 125])
def test_a_head_whose_neck_bends_ever_nearer_keeps_its_depth_without_a_jump(degrees: float) -> None:
    head = handle_named(DOG, "head")
    assert largest_jump(drawn(DOG, standing(DOG), head, "front", degrees, False)) < JUMP


def drawn(
    body: Body, pose: Pose, handle: BodyHandle, view: str, degrees: float, limits_on: bool,
    held: Held = NONE_HELD,
) -> Callable[[float], Floats]:  # fmt: skip
    """All rotations (P, 3, 3) after a drag of so many metres into one direction."""
    sight, skeleton = sights()[view], Skeleton.of(body)
    p = points(body, pose)[handle.anchor]
    start = sight.project(p)
    way = np.array([math.cos(math.radians(degrees)), math.sin(math.radians(degrees))])
    way = way / sight.metres_per_unit(p)

    def at(metres: float) -> Floats:
        sent = gesture(view, as_sent(handle), start, start + metres * way)
        posed = drag(body, pose, sent, sights(), limits_on=limits_on, held=held)
        return np.asarray(pose_transforms(skeleton, posed.pose)[:, :3, :3])

    return at


def largest_jump(at: Callable[[float], Floats]) -> float:
    """The largest change, radians, between places CLOSE_M apart: wherever more changes than JUMP,
    looked at ever closer."""
    places = [float(place) for place in np.arange(0, FAR_M, STEP_M)]
    left = list(pairwise((place, at(place)) for place in places))
    worst = 0.0
    while left:
        (a, A), (b, B) = left.pop()
        if apart(A, B) <= JUMP:
            continue
        if b - a <= CLOSE_M:
            worst = max(worst, apart(A, B))
            continue
        middle = (a + b) / 2
        M = at(middle)
        left += [((a, A), (middle, M)), ((middle, M), (b, B))]
    return worst


def apart(one: Floats, other: Floats) -> float:
    return float(np.linalg.norm(log_rotation(transpose(one) @ other), axis=-1).max())
