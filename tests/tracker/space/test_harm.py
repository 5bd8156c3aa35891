"""What pins do beside what was seen is measured, pin by pin."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import exp_rotation
from keypose.tracker.session.pins import Pin
from keypose.tracker.space.harm import (
    Compared,
    Harm,
    harm_findings,
    harms,
    worst_apart,
    worst_of_each,
)
from tests.rendering.scenes import Scene
from tests.tracker.space.space_cases import standing

SHOWN = standing(61)
LEFT = Pin(part="left_foot", landmarks=("left_heel", "left_toe"), first_frame=20, last_frame=40)
HAND = Pin(part="right_hand", first_frame=20, last_frame=40)


def compared(shown: Scene, solved: Trajectory, height_px: float = 300.0) -> Compared:
    heights = np.full(len(solved), height_px)
    return Compared(shown.skeleton, shown.camera, shown.truth, solved, heights)


def bent(deg: float, rows: slice) -> Trajectory:
    """The left knee bent more."""
    R, p = SHOWN.truth.writable()
    R[rows, SHOWN.skeleton.body.index("left_shin")] @= exp_rotation(np.radians([deg, 0.0, 0.0]))
    return Trajectory(0, R, p)


def aside(px: float, rows: slice) -> Trajectory:
    """The whole body moved in the picture."""
    R, p = SHOWN.truth.writable()
    p[rows, 0] += px / SHOWN.camera.fx * p[rows, 2]
    return Trajectory(0, R, p)


def test_an_unchanged_motion_has_no_harm() -> None:
    for harm in harms(compared(SHOWN, SHOWN.truth), [LEFT, HAND]):
        assert harm.amount == pytest.approx(0.0, abs=1e-6)
        assert not harm.is_much


def test_a_knee_that_a_pin_bends_is_measured_and_that_of_the_other_leg_is_not() -> None:
    found = harms(compared(SHOWN, bent(12.0, slice(None))), [LEFT])
    knee = next(harm for harm in found if harm.kind == "knee")
    assert np.degrees(knee.amount) == pytest.approx(12.0, abs=0.01)
    assert (knee.is_much, knee.is_too_much, knee.part) == (True, False, "left_shin")
    right = LEFT.model_copy(update={"part": "right_foot", "landmarks": ()})
    assert not any(
        harm.is_much for harm in harms(compared(SHOWN, bent(12.0, slice(None))), [right])
    )


def test_much_harm_is_a_finding_of_the_pin_and_little_is_none() -> None:
    (found,) = harm_findings(compared(SHOWN, bent(12.0, slice(None))), [LEFT])
    assert (found.kind, found.part) == ("bent", "left_foot")
    assert np.degrees(found.amount) == pytest.approx(12.0, abs=0.01)
    assert (found.first_frame, found.last_frame) == LEFT.span
    (pulled,) = harm_findings(compared(SHOWN, aside(20.0, slice(None))), [HAND])
    assert (pulled.kind, pulled.part) == ("pulled", "right_hand")
    assert pulled.amount == pytest.approx(20.0, rel=0.15)
    assert not list(harm_findings(compared(SHOWN, bent(6.0, slice(None))), [LEFT, HAND]))


def test_what_single_frames_do_does_not_count_nor_what_lies_outside_a_pin() -> None:
    for rows in (slice(30, 32), slice(0, 19), slice(42, None)):
        found = harms(compared(SHOWN, bent(40.0, rows)), [LEFT])
        assert max(harm.share for harm in found) < 0.1


@pytest.mark.parametrize(("height_px", "allowed"), [(300.0, 8.0), (1500.0, 30.0)])
def test_a_joint_may_move_by_eight_pixels_and_in_large_pictures_by_a_share_of_the_body(
    height_px: float, allowed: float
) -> None:
    for px, much in ((0.8 * allowed, False), (1.2 * allowed, True)):
        moved = compared(SHOWN, aside(px, slice(None)), height_px)
        for pin in (LEFT, HAND):
            seen = next(harm for harm in harms(moved, [pin]) if harm.kind == "picture")
            assert seen.amount == pytest.approx(px, rel=0.1)
            assert seen.is_much == seen.is_too_much == much


def test_the_worst_are_released_first_and_what_lies_beside_them_waits() -> None:
    def at(first: int, share: float, part: str = "left_foot") -> Harm:
        pin = Pin(part=part, first_frame=first, last_frame=first + 10)
        return Harm(pin, "picture", 10 * share, share, part, first)

    found = [at(0, 1.2), at(5, 2.0, "right_foot"), at(5, 1.1, "right_foot"), at(40, 1.3)]
    assert worst_apart(found, 8) == (found[1], found[3])
    assert worst_of_each(found) == (found[1], found[3], found[0])
