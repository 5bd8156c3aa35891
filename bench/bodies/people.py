"""The bodies that are rendered: two who pass each other, a handshake, a stick in a hand, and two on
one floor."""

from __future__ import annotations

from typing import Final

import numpy as np

from bench.bodies.film import Actor
from bench.standing_cases import AWAY_M, TILT_RAD, Steps, moved, standing_man, walk
from keypose.tracker.body.body import preset
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import (
    Array,
    apply_transform,
    exp_rotation,
    rotation_from_euler,
    transform,
)
from tests.rendering.angles import Angles, wave
from tests.rendering.motions import FPS, GROUND_Y_M, crossing, speech

FRAMES: Final = 73
WALK_BEGINS: Final = 40
"""The frame of the written walk at which the film begins: they meet in its middle."""
FAR_M: Final = 5.9
NEAR_M: Final = 4.9
"""Distances of the one behind, which is that of the written walk, and of the one before them."""
SPEAKER_M: Final = 5.0
"""Distance of the written speech."""
ASIDE_M: Final = 0.2
"""By which who speaks stands to the right of the middle."""
ROOT_M: Final = 0.95
"""Height of the waist of those who shake hands."""
WALKER_M: Final = -0.5
STANDING_M: Final = 0.7
"""Of two on one floor, by which they are to the right of the middle."""
SHAKES_HZ: Final = 1.2
HAND: Final = "right_hand"
PALM_M: Final = (0.014, 0.09, 0.0)
"""A place on the palm, in the hand's frame."""
STICK: Final = "cylinder"
HANDLE_M: Final = (0.0, 0.1, 0.05)
"""A place on the stick's side near its end, in its own frame."""


def passing_by() -> tuple[Actor, Actor]:
    """Who walks to the left, and who walks to the right before them."""
    far, near = preset("adult_male"), preset("adult_female")
    turned = _moved(_walk(near.name), _half_turn(0.0, (FAR_M + NEAR_M) / 2))
    return Actor("far", far, _walk(far.name), 0), Actor("near", near, turned, 1)


def speaking_before() -> tuple[Actor, Actor]:
    """Who walks to the left, and who stands before them and speaks."""
    far, near = preset("adult_male"), preset("adult_female")
    aside = transform(np.eye(3), np.array([ASIDE_M, 0.0, NEAR_M - SPEAKER_M]))
    spoken = _moved(speech(Skeleton.of(near), FRAMES), aside)
    return Actor("far", far, _walk(far.name), 0), Actor("near", near, spoken, 1)


def handshake() -> tuple[Actor, Actor]:
    """Two who shake hands: the second as the first turned about an upright line through the palms,
    which stay on that line."""
    body = preset("adult_male")
    skeleton = Skeleton.of(body)
    seconds = np.arange(FRAMES) / FPS
    angles = Angles(skeleton, FRAMES)
    angles.turn("waist", y=-np.pi / 2 + 0.05 * wave(seconds, 0.3))
    angles.turn("chest", 0.05 + 0.03 * wave(seconds, 0.4))
    angles.turn("head", 0.06 * wave(seconds, 0.5), 0.1 * wave(seconds, 0.3))
    angles.turn("right_upper_arm", -0.65 + 0.10 * wave(seconds, SHAKES_HZ), 0.0, 0.05)
    angles.turn("right_forearm", -0.75 + 0.16 * wave(seconds, SHAKES_HZ, 0.4))
    angles.turn("left_upper_arm", 0.08 * wave(seconds, 0.6), 0.0, -0.1)
    angles.turn("left_forearm", -0.3)
    motion = angles.trajectory((0.0, GROUND_Y_M - ROOT_M, NEAR_M))
    palm = palm_path(skeleton, motion)
    aside = palm - palm.mean(axis=0)
    aside[:, 1] = 0.0
    first = Trajectory(0, motion.Rs_parent_part, motion.ps_camera_root - aside)
    x, _, z = palm.mean(axis=0).tolist()
    middle = transform(np.eye(3), np.array([-x, 0.0, 0.0]))
    left, right = (_moved(each, middle) for each in (first, _moved(first, _half_turn(x, z))))
    return Actor("left", body, left, 0), Actor("right", body, right, 1)


def grip() -> tuple[Actor, Actor]:
    """Who speaks with a stick in the hand, and the stick."""
    body, stick = preset("adult_male"), preset(STICK)
    skeleton = Skeleton.of(body)
    spoken = speech(skeleton, FRAMES)
    turned = rotation_from_euler(0.0, 0.0, np.pi / 2)
    in_hand = transform(turned, np.array(PALM_M) - turned @ HANDLE_M)
    Ts = spoken.transforms(skeleton)[:, body.index(HAND)] @ in_hand
    held = Trajectory(0, Ts[:, None, :3, :3], Ts[:, :3, 3])
    return Actor("person", body, spoken, 0), Actor("stick", stick, held, 1)


def on_one_floor() -> tuple[Actor, Actor]:
    """Who walks and who stands, their feet exactly on it, before a camera that looks down."""
    man, woman = preset("adult_male"), preset("adult_female")
    walks = _on_floor(man.name, walk(), WALKER_M)
    stands = _on_floor(woman.name, standing_man(), STANDING_M)
    return Actor("walks", man, walks, 0), Actor("stands", woman, stands, 1)


def _on_floor(name: str, steps: Steps, x_m: float) -> Trajectory:
    level = moved(Skeleton.of(preset(name)), steps)
    motion = Trajectory(0, level.Rs_parent_part[:FRAMES], level.ps_camera_root[:FRAMES])
    down = exp_rotation(np.array([TILT_RAD, 0.0, 0.0]))
    return _moved(motion, transform(down, np.array([x_m, 0.0, AWAY_M])))


def palm_path(skeleton: Skeleton, motion: Trajectory) -> Array:
    """(N, 3) where the right palm is in a motion, camera frame."""
    return place_path(skeleton, motion, HAND, PALM_M)


def place_path(
    skeleton: Skeleton, motion: Trajectory, part: str, place_m: tuple[float, float, float]
) -> Array:
    """(N, 3) where a place on a part is in a motion, camera frame."""
    Ts = motion.transforms(skeleton)[:, skeleton.body.index(part)]
    return np.asarray(apply_transform(Ts, np.array(place_m)[None, None])[:, 0])


def _walk(name: str) -> Trajectory:
    whole = crossing(Skeleton.of(preset(name)))
    rows = slice(WALK_BEGINS, WALK_BEGINS + FRAMES)
    return Trajectory(0, whole.Rs_parent_part[rows], whole.ps_camera_root[rows])


def _moved(motion: Trajectory, T: Array) -> Trajectory:
    return motion.carried(np.broadcast_to(T, (len(motion), 4, 4)))


def _half_turn(x_m: float, z_m: float) -> Array:
    """(4, 4) half a turn about an upright line."""
    return transform(rotation_from_euler(0.0, np.pi, 0.0), np.array([2 * x_m, 0.0, 2 * z_m]))
