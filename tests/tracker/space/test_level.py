"""What is up, by where feet stand and by how a person stands on them."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.geometry.up import UpEvidence, combined
from keypose.tracker.session.pins import Pin
from keypose.tracker.space.contacts import proposed_pins
from keypose.tracker.space.level import (
    HELD_LEVEL,
    evidence_of_places,
    evidence_of_standing,
    up_from_places,
)
from tests.rendering.scenes import Scene, scene

CAMERA_UP = np.array([0.0, -1.0, 0.0])
LEANING = UpEvidence.of(CAMERA_UP, np.radians(5.0), "set")


def floor_places(up: Array, seed: int, *, spread_m: tuple[float, float]) -> Array:
    """Places on a floor 1.6 m below the camera, 6 m away, with a centimetre of noise."""
    rng = np.random.default_rng(seed)
    across = np.cross(up, [0.0, 0.0, 1.0])
    across /= np.linalg.norm(across)
    along = np.cross(across, up)
    steps = rng.uniform(-1, 1, (12, 2)) * spread_m
    middle = -1.6 * up + 6.0 * np.array([0.0, 0.0, 1.0])
    return middle + steps @ np.stack([across, along]) + rng.normal(0, 0.01, (12, 3))


def tilted_up(tilt_deg: float, roll_deg: float) -> Array:
    """Up before a camera that looks down and leans by so much."""
    turn = Rotation.from_euler("zx", [roll_deg, tilt_deg], degrees=True)
    return np.asarray(turn.apply(CAMERA_UP))


def angle_deg(a: Array, b: Array) -> float:
    return float(np.degrees(np.arccos(np.clip(a @ b, -1, 1))))


@pytest.mark.parametrize("seed", range(5))
def test_places_all_over_a_floor_give_up(seed: int) -> None:
    lean = Rotation.from_euler("xz", [4.0, -3.0], degrees=True).apply(CAMERA_UP)
    found = up_from_places(floor_places(lean, seed, spread_m=(2.0, 2.0)), LEANING)
    assert angle_deg(found.up, lean) < 0.5


def test_places_in_one_line_give_the_slope_along_it_alone() -> None:
    lean = Rotation.from_euler("z", 3.0, degrees=True).apply(CAMERA_UP)
    found = up_from_places(floor_places(lean, 1, spread_m=(2.5, 0.0)), LEANING)
    assert angle_deg(found.up, lean) < 0.6


def test_one_place_leaves_up_as_it_is_known() -> None:
    np.testing.assert_allclose(up_from_places(np.ones((1, 3)), LEANING).up, CAMERA_UP)


def test_two_steps_side_by_side_say_nothing_of_a_tilt_that_nobody_knows() -> None:
    steps = np.array([[0.0, 1.5, 6.0], [1.0, 1.5, 6.0]])
    found = up_from_places(steps)
    assert found.sigma_rad > np.radians(15)
    assert found.sigma_along(np.array([1.0, 0.0, 0.0])) < np.radians(3)
    assert up_from_places(steps, LEANING).sigma_rad == pytest.approx(np.radians(5), rel=0.05)


@pytest.mark.parametrize(
    ("spread_m", "noise_m", "most_deg"),
    [((2.0, 2.0), 0.01, 3.0), ((0.5, 0.5), 0.01, 12.0), ((2.0, 2.0), 0.25, 15.0)],
)
def test_stances_show_up_the_surer_the_farther_apart_and_the_less_they_scatter(
    spread_m: tuple[float, float], noise_m: float, most_deg: float
) -> None:
    lean, inside, offs = tilted_up(7.0, 2.0), 0, []
    for seed in range(20):
        places = floor_places(lean, seed, spread_m=spread_m)
        places += np.random.default_rng(seed + 99).normal(0, noise_m, places.shape)
        found = evidence_of_places(places, CAMERA_UP)
        inside += abs((found.up - lean)[2]) < 2 * found.sigma_along(np.array([0.0, 0.0, 1.0]))
        offs.append(2 * np.degrees(found.sigma_rad))
    assert inside >= 18
    assert np.median(offs) < most_deg
    assert np.median(offs) > most_deg / 4


def test_stances_in_one_line_say_nothing_of_the_slope_beside_it() -> None:
    found = evidence_of_places(floor_places(CAMERA_UP, 1, spread_m=(2.5, 0.0)), CAMERA_UP)
    along, beside = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
    assert found.sigma_along(along) < np.radians(3.0)
    assert found.sigma_along(beside) > np.radians(30.0)


# --- how a person stands


def turned(shown: Scene, tilt_deg: float, roll_deg: float) -> tuple[Trajectory, Array]:
    """A motion before a camera that looks down and leans, and what is up there."""
    R = Rotation.from_euler("zx", [roll_deg, tilt_deg], degrees=True).as_matrix()
    Rs, ps = shown.truth.writable()
    middle = ps.mean(axis=0)
    Rs[:, 0], ps = R @ Rs[:, 0], (ps - middle) @ R.T + middle
    return Trajectory(0, Rs, ps), R @ CAMERA_UP


def sources(evidence: Iterable[UpEvidence]) -> set[str]:
    return {one.source for one in evidence}


TILTS = [(0.0, 0.0), (12.0, 0.0), (-8.0, 3.0), (20.0, -4.0), (5.0, 18.0), (30.0, 0.0)]


@pytest.mark.parametrize(("tilt", "roll"), TILTS)
def test_a_person_who_walks_shows_how_the_camera_tilts(tilt: float, roll: float) -> None:
    shown = scene("stride")
    motion, up = turned(shown, tilt, roll)
    stances = [
        pin for pin in proposed_pins(shown.skeleton, motion, 30.0, None) if pin.landmarks[1:]
    ]
    found = combined(evidence_of_standing(shown.skeleton, motion, stances), HELD_LEVEL)
    assert found is not None
    assert angle_deg(found.up, up) < min(4, 2 * np.degrees(found.sigma_rad))


def test_of_somebody_who_never_stands_nothing_is_said() -> None:
    shown = scene("stride")
    assert evidence_of_standing(shown.skeleton, shown.truth, ()) == ()


def test_of_somebody_who_lies_nothing_is_said() -> None:
    shown = scene("stride")
    motion, _ = turned(shown, 80.0, 0.0)
    pin = Pin(part="left_foot", landmarks=("left_heel", "left_toe"), first_frame=0, last_frame=9)
    assert sources(evidence_of_standing(shown.skeleton, motion, (pin,))) == {"feet"}


def test_somebody_who_sits_does_not_tell_what_is_up() -> None:
    shown = scene("speech").cut(0, 30)
    Rs, ps = shown.truth.writable()
    for side in ("left", "right"):
        thigh, shin = (shown.skeleton.body.index(f"{side}_{part}") for part in ("thigh", "shin"))
        Rs[:, thigh] = Rotation.from_euler("x", -80, degrees=True).as_matrix()
        Rs[:, shin] = Rotation.from_euler("x", 80, degrees=True).as_matrix()
    sits = Trajectory(0, Rs, ps)
    stances = [pin for pin in proposed_pins(shown.skeleton, sits, 30.0, None) if pin.landmarks[1:]]
    assert stances
    assert sources(evidence_of_standing(shown.skeleton, sits, stances)) == {"feet"}
