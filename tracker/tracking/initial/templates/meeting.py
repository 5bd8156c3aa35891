"""Two courses of one point, from the keyframe before and from the one after, made one."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tracker.geometry.rotations import Array
from tracker.tracking.initial.templates.course import Course

AGREED_PX = 6.0
"""How near two courses must come to bear each other out: each slips a little on its way."""
APART_PX = 12.0
"""Where both are borne out and yet lie further apart than this, neither is believed."""
ALONE_FRAMES, ALONE_PX = 3, 0.5
"""How long a course is believed that nothing bears out, and by how much less with every frame."""
LEAST_SIGMA, SLIP_PX, MOST_SLIP = 0.3, 0.02, 0.7
"""Pixels by which any place may be wrong: at first, with every frame further from the keyframe, and
at most."""
DISAGREED = 0.35
"""What their distance says of two courses' mean."""


def combine_courses(forward: Course, backward: Course, offset: Array) -> tuple[Array, Array]:
    """Both courses (2, N, 2), NaN where lost, and (2, N) their sigmas; all in frame order.

    offset: (N, 2) where the second course's point is seen beside the first one's.

    A course is borne out as far as its keyframe's own patch recognises what it follows, or as it
    comes to where the other one is as well; each begins at its own keyframe, and so ends where the
    other begins. What lies before such a frame was most likely right too.
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
    """(N,) how far a course, from its own keyframe on, may be wrong; inf where not believed."""
    frames = np.arange(len(agreed))
    borne_out = np.flatnonzero((agreed | course.known) & np.isfinite(course.uv[:, 0]))
    if not len(borne_out):
        return np.full(len(frames), np.inf)
    alone = np.maximum(frames - borne_out[-1], 0)
    slip = np.minimum(SLIP_PX * frames, MOST_SLIP)
    sigma = np.hypot(np.hypot(course.sigma_px, LEAST_SIGMA), slip + ALONE_PX * alone)
    believed = np.isfinite(course.uv[:, 0]) & (alone <= ALONE_FRAMES)
    return np.where(believed, sigma, np.inf)
