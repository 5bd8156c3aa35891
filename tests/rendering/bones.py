"""Rotations of parts from directions of bones: swing from the bone, twist from its neighbours."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d
from scipy.spatial.transform import Rotation

Floats = NDArray[np.float64]

TRUST_IN_A_STRAIGHT_LIMB = 0.15
"""A limb bent by less than about this angle takes its hinge axis from the trunk."""


def unit(vectors: Floats) -> Floats:
    """Vectors (..., 3) at length 1."""
    return np.asarray(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True))


def frame_along(y: Floats, x_hint: Floats) -> Floats:
    """Rotations (N, 3, 3) whose y axis is along y and whose x axis is as near x_hint as can be."""
    y = unit(y)
    x = unit(x_hint - np.sum(x_hint * y, axis=-1, keepdims=True) * y)
    return np.stack([x, y, np.cross(x, y)], axis=-1)


def hinge_axis(upper: Floats, lower: Floats, sign: float, x_trunk: Floats) -> Floats:
    """The axis (N, 3) about which a limb bends; sign 1 for knees, −1 for elbows.

    A straight limb does not say how it would bend: the less it is bent, the more the trunk's x axis
    decides. Smoothed over time, so that the limb does not twist to and fro.
    """
    bend = sign * np.cross(unit(upper), unit(lower))
    axis = bend + TRUST_IN_A_STRAIGHT_LIMB * x_trunk
    return unit(gaussian_filter1d(axis, 2.0, axis=0, mode="nearest"))


def hinge_angle(R_upper: Floats, lower: Floats, sign: float) -> Floats:
    """Angles (N,) about the upper part's x axis that bring its y axis nearest to `lower`."""
    d = np.einsum("nji,nj->ni", R_upper, lower)
    return sign * np.maximum(sign * np.arctan2(d[:, 2], d[:, 1]), 0.0)


def about_x(angles: Floats) -> Floats:
    """Rotations (N, 3, 3) by angles (N,) about x."""
    return Rotation.from_euler("x", angles[:, None]).as_matrix()


def without_z(rotations: Floats) -> Floats:
    """Rotations (N, 3, 3) = Qz Qy Qx with Qz left out: a head that only nods and turns."""
    zyx = Rotation.from_matrix(rotations).as_euler("ZYX")
    zyx[:, 0] = 0.0
    return Rotation.from_euler("ZYX", zyx).as_matrix()
