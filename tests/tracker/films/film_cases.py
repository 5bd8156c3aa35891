"""One motion as two cameras see it: what a detector says of it, with known truth."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TypeAlias

import numpy as np

from keypose.tracker.body.body import preset
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.films.cameras import joints_of_pose
from keypose.tracker.films.sightings import SIGMA_SHARE, Sightings
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.film_clock import FilmClock, sampled
from keypose.tracker.geometry.rotations import (
    Array,
    apply_transform,
    exp_rotation,
    log_rotation,
    rotation_from_euler,
    transform,
)

BODY = preset("adult_male")
SKELETON = Skeleton.of(BODY)
SHAKES = 0.005
BESIDE = 0.006
"""Of a keypoint from frame to frame, and of a detector's own place of a joint, shares of height."""
DEPTH_M = 0.05


@dataclass(frozen=True, eq=False)
class TwoFilms:
    """Sightings of both films, joints (N, J, 3) in the first camera's base, and the truth."""

    first: Sightings
    film: Sightings
    joints: Array
    T_film_first: Array
    clock: FilmClock


Motion: TypeAlias = Callable[[Skeleton], Trajectory]


@lru_cache(maxsize=8)
def joints_of(motion: Motion) -> Array:
    """(N, J, 3) of a motion that is written before a camera."""
    path = motion(SKELETON)
    frames = range(path.first_frame, path.last_frame + 1)
    return np.stack([joints_of_pose(SKELETON, path.pose(frame)) for frame in frames])


def one_after_another(*motions: Motion) -> Array:
    """(N, J, 3) of several motions, as one who does one after another."""
    return np.concatenate([joints_of(motion) for motion in motions])


def two_films(
    motion: Motion | Array,
    turned_deg: float,
    clock: FilmClock,
    *,
    seed: int = 1,
    focal: float = 1.0,
    in_hand: tuple[bool, bool] = (False, False),
) -> TwoFilms:
    """motion: or joints (N, J, 3).  focal: of the other film's lens, as a multiple of the one it is
    taken to have.  in_hand: whether the first camera, and the other, is held in a hand that follows
    the body."""
    rng = np.random.default_rng(seed)
    joints = motion if isinstance(motion, np.ndarray) else joints_of(motion)
    middle = np.median(joints.reshape(-1, 3), axis=0)
    R = rotation_from_euler(0.05, np.radians(turned_deg), 0.08)
    T = transform(R, middle - R @ middle + np.array([0.3, 0.1, 0.4]))
    count = int((len(joints) - 1 - max(clock.begins, 0.0)) * clock.rate)
    there = sampled(joints, clock.moments_of(np.arange(count))) @ T[:3, :3].T + T[:3, 3]
    first, film = (
        _in_hand(len(p)) if held else None for p, held in zip((joints, there), in_hand, strict=True)
    )
    return TwoFilms(
        _seen(joints, 1.0, rng, first), _seen(there, focal, rng, film), joints, T, clock
    )


def sliced(film: Sightings, rows: slice) -> Sightings:
    """Some frames of what a film shows."""
    return replace(
        film, xy=film.xy[rows], visibility=film.visibility[rows], p_hips=film.p_hips[rows]
    )


def joined(*films: Sightings) -> Sightings:
    """A film that was cut together."""
    parts = {
        name: np.concatenate([getattr(film, name) for film in films])
        for name in ("xy", "visibility", "p_hips")
    }
    return replace(films[0], **parts)


def _in_hand(count: int) -> CameraPath:
    """A camera that turns by some 8° and is carried some 30 cm on its way."""
    along = np.linspace(0.0, 1.0, count)[:, None]
    turns = np.radians(8.0) * np.sin(along * [3.0, 7.0, 5.0] + [0.0, 1.0, 2.0])
    places = 0.3 * np.sin(along * [4.0, 2.0, 3.0])
    turns, places = turns - turns[0], places - places[0]
    return CameraPath.of(exp_rotation(turns), places, 1.0 + 0.2 * along[:, 0])


def _seen(
    joints: Array, focal: float, rng: np.random.Generator, path: CameraPath | None = None
) -> Sightings:
    """What a camera sees of joints in its base."""
    if path is not None:
        joints = apply_transform(path.Ts_camera_world, joints)
    tall = focal * 1.7 / float(np.nanmedian(joints[..., 2]))
    own = rng.normal(0.0, BESIDE * tall, (1, *joints.shape[1:2], 2))
    xy = focal * joints[..., :2] / joints[..., 2:]
    xy = xy + rng.normal(0.0, SHAKES * tall, xy.shape) + own
    hips = joints - joints[:, 6:8].mean(axis=1, keepdims=True)
    hips = hips + rng.normal(0.0, DEPTH_M, hips.shape)
    seen = np.isfinite(xy).all(axis=-1)
    return Sightings(xy, seen.astype(float), SIGMA_SHARE * tall, hips, path)


def turned_apart_deg(T: Array, other: Array) -> float:
    """Between the rotations of two cameras."""
    return float(np.degrees(np.linalg.norm(log_rotation(T[:3, :3] @ other[:3, :3].T))))


def places_apart_m(T: Array, other: Array) -> float:
    """Between the places of two cameras."""
    there, here = (-each[:3, :3].T @ each[:3, 3] for each in (T, other))
    return float(np.linalg.norm(there - here))
