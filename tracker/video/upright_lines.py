"""Find what is up by the upright lines of a picture: walls, doors, poles, trees.

Lines that are upright in the world meet, in the picture, where the vertical points to. Each segment
votes for the directions that its plane through the camera contains; the one with most length behind
it is refined over all that agree.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.geometry.up import UpEvidence

LEAST_SHARE: Final = 0.04
"""A segment is at least so long, a share of the picture's height."""
STEEP_DEG: Final = 35.0
"""Farther from the picture's own vertical a line is hardly an upright one."""
END_PX = 2.0
MOST_OFF_RAD = 0.03
LEAST_OFF_RAD = 0.006
"""How far the end of a segment is off, and what its direction is off by, at most and at least."""
AGREES: Final = 2.0
"""So many of these a segment may be off."""
MOST_TILT_RAD = np.radians(50.0)
MOST_ROLL_RAD = np.radians(20.0)
"""How far from level a camera is looked for."""
ONE_THING_RAD: Final = np.radians(0.7)
"""As seen from the camera, segments this near to each other may lie along one upright thing."""
APART: Final = 0.02
"""Sine of the angle between the planes of two segments that say where they meet."""
TRIES = 1500
ROUNDS = 5
BAR_SPREAD: Final = 3.0
"""Standard deviation of the grey levels of a bar at the picture's side, at most."""
BAR_PX: Final = 4.0
"""Nearer to a bar's edge a line is that edge."""
LEAST_SIGMA_DEG: Final = 0.5
"""Of what is up, however many lines agree: walls and doors lean, lenses bend. Of three films whose
cameras were calibrated it is 0.6–1.0° off, of which the lines alone would tell 0.4–0.8°."""
MOST_SIGMA_RAD: Final = np.radians(2.5)
"""Lines that tell less are not taken alone where nobody looks at them."""
LEAST_AGREEING = 0.4
LEAST_THINGS = 7
"""The share of all length that has to agree, and along how many things: lines that lean this way
and that agree on six by chance; seven films of walls and windows show eight and more."""


@dataclass(frozen=True, eq=False)
class UprightLines:
    """Upright lines that agree, and the up that they show.

    alone: up by the lens as it is taken.  share: of the length of all steep lines that agrees.
    lens_spread: the standard deviation of the focal length as a share of it, where it is a guess:
    a tilt is off with it.  ends: (K, 2, 2) of the lines that agree, pixels.
    """

    alone: UpEvidence
    share: float
    lens_spread: float = 0.0
    ends: Array = field(default_factory=lambda: np.zeros((0, 2, 2)))

    @property
    def up_camera(self) -> Array:
        """Unit vector (3,)."""
        return self.alone.up

    @property
    def evidence(self) -> UpEvidence:
        """Up with the doubt of the lens, too."""
        return self.alone.seen_by_lens(self.lens_spread)

    @property
    def is_sure(self) -> bool:
        """Whether they are good enough to be taken alone where nobody looks at them: up that is 10°
        off harms drafts more than up that is unknown. Beside a motion they count by their
        deviation. A lens that is a guess tilts all that is seen by it alike, and does not count."""
        return bool(self.alone.sigma_rad <= MOST_SIGMA_RAD)


def up_from_lines(
    pictures: Sequence[NDArray[np.uint8]], camera: Camera, focal_spread: float = 0.0
) -> UprightLines | None:
    """What is up in a camera that stands still, by some of its pictures, (H, W, 3) or grey; None
    where few lines agree.

    camera: with its distortion.  focal_spread: the share by which its focal length may be off,
        and a tilt with it.
    """
    ends = np.concatenate([_steep_segments(picture) for picture in pictures])
    normals = _planes(ends, camera)
    is_finite = np.isfinite(normals).all(axis=1)
    ends, normals = ends[is_finite], normals[is_finite]
    if len(ends) < LEAST_THINGS:
        return None
    length = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=-1)
    sigma = np.clip(END_PX / length, LEAST_OFF_RAD, MOST_OFF_RAD)
    up = _most_voted(normals, length, sigma)
    if up is None:
        return None
    for _ in range(ROUNDS):
        agrees = _agreement(normals, up, sigma)
        counts = agrees * _alone(normals, up, agrees)
        weight = counts / sigma**2
        precisions, ways = np.linalg.eigh((normals * weight[:, None]).T @ normals)
        up = _upward(ways[:, 0])
    agreeing = _agreement(normals, up, sigma) > 0
    share = float(length[agreeing].sum() / length.sum())
    if share < LEAST_AGREEING or counts.sum() < LEAST_THINGS or not _is_usual(up):
        return None
    precisions = np.maximum(precisions[1:], np.finfo(float).tiny)
    least = np.radians(LEAST_SIGMA_DEG) ** 2 * np.eye(3)
    covariance = least + (ways[:, 1:] / precisions) @ ways[:, 1:].T
    alone = UpEvidence.with_covariance(up, covariance, "lines")
    return UprightLines(alone, share, focal_spread, ends[agreeing])


def _alone(normals: Array, up: Array, agrees: Array) -> Array:
    """(K,) for each segment one over how many lie along one upright thing with it, itself among
    them: both edges of a post, one post in several pictures. They err alike, and count as one."""
    across = np.linalg.svd(up[None])[2][1:]
    x, y = across @ normals.T
    heading = np.arctan2(y, x)
    apart = np.abs(np.angle(np.exp(2j * (heading[:, None] - heading)))) / 2
    return np.asarray(1 / np.maximum((apart < ONE_THING_RAD) @ agrees, 1.0))


def up_from_segments(ends: Array, camera: Camera) -> Array | None:
    """Unit vector (3,) up, by two upright lines (2, 2 ends, 2) in pixels of the film; None where
    they do not say: they are one line, or do not go up."""
    normals = _planes(np.asarray(ends, dtype=np.float64), camera)
    up: Array = np.cross(normals[0], normals[1])
    if not np.isfinite(up).all() or np.linalg.norm(up) < APART:
        return None
    up = _upward(up / np.linalg.norm(up))
    leans_rad = float(np.arccos(min(1.0, -up[1])))
    return np.asarray(up) if leans_rad < MOST_TILT_RAD + MOST_ROLL_RAD else None


def _steep_segments(picture: NDArray[np.uint8]) -> Array:
    """(K, 2, 2) both ends, pixels."""
    grey = picture if picture.ndim == 2 else cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY)
    segments = cv2.createLineSegmentDetector(cv2.LSD_REFINE_STD).detect(grey)[0]
    if segments is None:
        return np.zeros((0, 2, 2))
    ends = np.asarray(segments, dtype=np.float64).reshape(-1, 2, 2)
    across, along = np.abs(ends[:, 1] - ends[:, 0]).T
    is_steep = np.degrees(np.arctan2(across, along)) < STEEP_DEG
    is_long = np.hypot(across, along) > LEAST_SHARE * grey.shape[0]
    is_edge = np.zeros(len(ends), np.bool_)
    for edge in _bar_edges(np.asarray(grey, dtype=np.uint8)):
        is_edge |= (np.abs(ends[..., 0] - edge) < BAR_PX).all(axis=1)
    return np.asarray(ends[is_steep & is_long & ~is_edge])


def _bar_edges(grey: NDArray[np.uint8]) -> list[int]:
    """Columns at which bars end that a film of another shape has at its sides."""
    width, edges = grey.shape[1], []
    for picture in (grey, grey[:, ::-1]):
        is_flat = picture.std(axis=0) < BAR_SPREAD
        is_flat &= np.abs(picture.mean(axis=0) - picture[:, 0].mean()) < BAR_SPREAD
        bar = width if is_flat.all() else int(np.argmin(is_flat))
        if 0 < bar < width:
            edges.append(bar if picture is grey else width - bar)
    return edges


def _planes(ends: Array, camera: Camera) -> Array:
    """(K, 3) unit normals of the planes through the camera's centre and each segment; NaN where the
    lens shows nothing, or both ends are one. A telephoto camera counts as its long lens."""
    lens = camera.model_copy(update={"projection": "perspective", "telephoto_distance_m": None})
    rays = lens.back_project(ends, 1.0)
    normals = np.cross(rays[:, 0], rays[:, 1])
    size = np.linalg.norm(normals, axis=-1, keepdims=True)
    return np.asarray(normals / np.where(size > 0, size, np.nan))


def _most_voted(normals: Array, length: Array, sigma: Array) -> Array | None:
    """The direction in which two segments meet and with which most length agrees."""
    rng = np.random.default_rng(0)
    pairs = rng.choice(len(normals), (TRIES, 2), p=length / length.sum())
    meeting = np.cross(normals[pairs[:, 0]], normals[pairs[:, 1]])
    size = np.linalg.norm(meeting, axis=-1)
    candidates = [_upward(v / s) for v, s in zip(meeting, size, strict=True) if s > APART]
    usual = [up for up in candidates if _is_usual(up)]
    votes = [float(length @ _agreement(normals, up, sigma)) for up in usual]
    return usual[int(np.argmax(votes))] if usual else None


def _agreement(normals: Array, up: Array, sigma: Array) -> Array:
    """(K,) 1 for a segment through the direction, falling to 0 for one that is off."""
    off = np.abs(normals @ up) / sigma
    return np.asarray(np.maximum(0.0, 1.0 - (off / AGREES) ** 2))


def _upward(direction: Array) -> Array:
    return np.asarray(-direction if direction[1] > 0 else direction)


def _is_usual(up: Array) -> bool:
    return bool(abs(np.arcsin(up[2])) < MOST_TILT_RAD and abs(np.arcsin(up[0])) < MOST_ROLL_RAD)
