"""What is up, by where feet stand and by how a person stands on them."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.pins import Pin
from keypose.tracker.space.contacts import proposed_pins
from keypose.tracker.space.level import up_from_places, up_from_standing
from tests.rendering.scenes import Scene, scene

CAMERA_UP = np.array([0.0, -1.0, 0.0])


def floor_places(up: Array, seed: int, *, spread_m: tuple[float, float]) -> Array:
    """Places on a floor 1.6 m below the camera, 6 m away, with a centimetre of noise."""
    rng = np.random.default_rng(seed)
    across = np.cross(up, [0.0, 0.0, 1.0])
    across /= np.linalg.norm(across)
    along = np.cross(across, up)
    steps = rng.uniform(-1, 1, (12, 2)) * spread_m
    middle = -1.6 * up + 6.0 * np.array([0.0, 0.0, 1.0])
    return middle + steps @ np.stack([across, along]) + rng.normal(0, 0.01, (12, 3))


def angle_deg(a: Array, b: Array) -> float:
    return float(np.degrees(np.arccos(np.clip(a @ b, -1, 1))))


@pytest.mark.parametrize("seed", range(5))
def test_places_all_over_a_floor_give_up(seed: int) -> None:
    lean = Rotation.from_euler("xz", [4.0, -3.0], degrees=True).apply(CAMERA_UP)
    found = up_from_places(floor_places(lean, seed, spread_m=(2.0, 2.0)), CAMERA_UP)
    assert angle_deg(found, lean) < 0.5


def test_places_in_one_line_give_the_slope_along_it_alone() -> None:
    lean = Rotation.from_euler("z", 3.0, degrees=True).apply(CAMERA_UP)
    found = up_from_places(floor_places(lean, 1, spread_m=(2.5, 0.0)), CAMERA_UP)
    assert angle_deg(found, lean) < 0.6


def test_one_place_leaves_up_as_it_is_known() -> None:
    np.testing.assert_allclose(up_from_places(np.ones((1, 3)), CAMERA_UP), CAMERA_UP)


# --- how a person stands


def turned(shown: Scene, tilt_deg: float, roll_deg: float) -> tuple[Trajectory, Array]:
    """A motion before a camera that looks down and leans, and what is up there."""
    R = Rotation.from_euler("zx", [roll_deg, tilt_deg], degrees=True).as_matrix()
    Rs, ps = shown.truth.writable()
    middle = ps.mean(axis=0)
    Rs[:, 0], ps = R @ Rs[:, 0], (ps - middle) @ R.T + middle
    return Trajectory(0, Rs, ps), R @ CAMERA_UP


@pytest.mark.parametrize(("tilt", "roll"), [(0.0, 0.0), (12.0, 0.0), (-8.0, 3.0), (20.0, -4.0)])
def test_a_person_who_walks_shows_how_the_camera_tilts(tilt: float, roll: float) -> None:
    shown = scene("stride")
    motion, up = turned(shown, tilt, roll)
    stances = [
        pin for pin in proposed_pins(shown.skeleton, motion, 30.0, None) if pin.landmarks[1:]
    ]
    found = up_from_standing(shown.skeleton, motion, stances)
    assert found is not None
    assert angle_deg(found, up) < 4
    assert angle_deg(found, CAMERA_UP) > tilt / 2 - 2


def test_of_somebody_who_never_stands_nothing_is_said() -> None:
    shown = scene("stride")
    assert up_from_standing(shown.skeleton, shown.truth, ()) is None


def test_of_somebody_who_lies_nothing_is_said() -> None:
    shown = scene("stride")
    motion, _ = turned(shown, 80.0, 0.0)
    pin = Pin(part="left_foot", landmarks=("left_heel", "left_toe"), first_frame=0, last_frame=9)
    assert up_from_standing(shown.skeleton, motion, (pin,)) is None


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
    assert up_from_standing(shown.skeleton, sits, stances) is None
