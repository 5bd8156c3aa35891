"""Turn landmarks in space so that the person stands over their feet, where up is known.

A network that sees one person in a picture takes the camera for more level than it is: bodies come
out leaning toward a camera that looks down, or away from it, by some degrees throughout a film. A
person who stands, walks or bends is in balance in the mean, which says by how much.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from keypose.tracker.body.balance import MASSES, centre_of_mass, support
from keypose.tracker.fitting.draft.first_poses import landmark_axes
from keypose.tracker.fitting.draft.observed import SIDES, Observed, place_of, unit
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, exp_rotation
from keypose.tracker.keypoints.keypoints import JOINTS

LOWEST_M: Final = 0.4
"""Whoever has their middle nearer to the floor does not stand."""
STANDING: Final = 0.5
"""Share of the frames in which a person has to stand."""
MOST_RAD: Final = np.radians(20.0)


def balanced(observed: Observed, camera: Camera, up_camera: Array) -> Observed:
    """Turn p_hips about the level axis across the view, all frames alike. camera: ideal.

    up_camera: (3,), or (N, 3) of a camera that turns.
    """
    lean_rad, axes = _leans(observed, camera, up_camera)
    known_lean_rad = lean_rad[np.isfinite(lean_rad)]
    if len(known_lean_rad) == 0 or len(known_lean_rad) < STANDING * observed.usable.sum():
        return observed
    by = -float(np.clip(np.median(known_lean_rad), -MOST_RAD, MOST_RAD))
    R = exp_rotation(by * axes)
    return replace(observed, p_hips=np.einsum("nij,nkj->nki", R, observed.p_hips))


def _leans(observed: Observed, camera: Camera, up_camera: Array) -> tuple[Array, Array]:
    """(N,) radians by which the middle of the body is behind its feet, seen from the camera, NaN
    where nobody stands; (N, 3) the level axis across the view, in the axes of the landmarks."""
    leans, axes = np.full(len(observed), np.nan), np.zeros((len(observed), 3))
    hips = [place_of(side, "hip") for side in SIDES]
    ups = np.broadcast_to(up_camera, (len(observed), 3))
    for n in np.flatnonzero(observed.usable):
        p = observed.p_hips[n, : len(JOINTS)]
        if not (np.isfinite(p).all() and observed.known[n, hips].all()):
            continue
        up = landmark_axes(camera, observed.uv[n], observed.known[n]).T @ ups[n]
        axis = unit(np.cross(up, (0.0, 0.0, 1.0)))
        axes[n] = axis
        middle = centre_of_mass({joint: p[_both(joint)] for joint in MASSES})
        feet = support(p[_both("ankle")], up)
        high = float((middle - feet) @ up)
        if high > LOWEST_M:
            leans[n] = np.arctan2((middle - feet) @ np.cross(axis, up), high)
    return leans, axes


def _both(joint: str) -> list[int]:
    return [place_of(side, joint) for side in SIDES]
