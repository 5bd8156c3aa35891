"""Two courses of one point, from the keyframe before and from the one after, combined."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.tracking.initial.templates.follow_point import Course

AGREED_PX = 6.0
"""How near two courses must come to confirm each other: each slips a little on its way."""
APART_PX = 12.0
"""Where both are confirmed and yet lie further apart than this, neither is used."""
ALONE_FRAMES, ALONE_PX = 3, 0.5
"""How many frames an unconfirmed course is used, and the sigma added with every frame."""
LEAST_SIGMA, SLIP_PX, MOST_SLIP = 0.3, 0.02, 0.7
"""Pixels by which any place may be wrong: at first, with every frame further from the keyframe, and
at most."""
DISAGREED = 0.35
"""Share of two courses' distance in their sigma."""


def combine_courses(forward: Course, backward: Course, offset: Array) -> tuple[Array, Array]:
    """Both courses (2, N, 2), NaN where lost, and (2, N) their sigmas; all in frame order.

    offset: (N, 2) where the second course's point is seen beside the first one's.

    A course is confirmed where its keyframe's own patch recognises the point, or where the other
    course agrees; each begins at its own keyframe, and so ends where the other begins. What lies
    before a confirmed frame was most likely right too.
    """
    gap = np.nan_to_num(backward.uv - forward.uv - offset, nan=np.inf)  # also where one is missing
    apart = np.hypot(gap[:, 0], gap[:, 1])
    agreed = apart <= AGREED_PX
    sigma = np.stack([
        _sigmas(forward, agreed), _sigmas(backward.reversed(), agreed[::-1])[::-1]
    ])  # fmt: skip
    two = np.isfinite(sigma).all(axis=0)
    sigma = np.hypot(sigma, np.where(two, DISAGREED * np.where(two, apart, 0.0), 0.0))
    sigma[:, two & (apart > APART_PX)] = np.inf
    uv = np.where(np.isfinite(sigma)[..., None], np.stack([forward.uv, backward.uv]), np.nan)
    return uv, sigma


def _sigmas(course: Course, agreed: NDArray[np.bool_]) -> Array:
    """(N,) how far a course, from its own keyframe on, may be wrong; inf where not used."""
    frames = np.arange(len(agreed))
    confirmed = np.flatnonzero((agreed | course.known) & np.isfinite(course.uv[:, 0]))
    if not len(confirmed):
        return np.full(len(frames), np.inf)
    alone = np.maximum(frames - confirmed[-1], 0)
    slip = np.minimum(SLIP_PX * frames, MOST_SLIP)
    sigma = np.hypot(np.hypot(course.sigma_px, LEAST_SIGMA), slip + ALONE_PX * alone)
    trusted = np.isfinite(course.uv[:, 0]) & (alone <= ALONE_FRAMES)
    return np.where(trusted, sigma, np.inf)
