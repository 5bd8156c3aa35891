"""Directions and turns of single 3-vectors, lean enough for every move of a pointer."""

from __future__ import annotations

import math

import numpy as np

from keypose.tracker.geometry.rotations import Array


def cross(a: Array, b: Array) -> Array:
    """a × b of two 3-vectors; several times quicker than NumPy's, which is made for stacks."""
    ax, ay, az = a.tolist()
    bx, by, bz = b.tolist()
    return np.array([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])


def length(a: Array) -> float:
    """|a|."""
    return math.sqrt(float(a @ a))


def unit(a: Array) -> Array:
    """a / |a|; a itself where it has no length."""
    size = length(a)
    return a / size if size > 0 else a


def across(a: Array, axis: Array) -> Array:
    """The part of `a` at right angles to a unit axis."""
    return np.asarray(a - (a @ axis) * axis)


def any_across(axis: Array) -> Array:
    """Some unit vector at right angles to a unit axis."""
    least_axis = np.zeros(3)
    least_axis[int(np.argmin(np.abs(axis)))] = 1.0
    return unit(across(least_axis, axis))


def turn(axis: Array, angle_rad: float) -> Array:
    """The rotation matrix about a unit axis."""
    x, y, z = axis.tolist()
    c, s = math.cos(angle_rad), math.sin(angle_rad)
    k = 2.0 * math.sin(angle_rad / 2) ** 2
    return np.array(
        [
            [c + x * x * k, x * y * k - z * s, x * z * k + y * s],
            [y * x * k + z * s, c + y * y * k, y * z * k - x * s],
            [z * x * k - y * s, z * y * k + x * s, c + z * z * k],
        ]
    )


def least_turn(start: Array, end: Array) -> Array:
    """The smallest rotation that takes one unit vector to another.

    Opposite vectors have no smallest one; then it is a half turn about some axis across.
    """
    axis, cosine = cross(start, end), float(start @ end)
    size = length(axis)
    if size < 1e-14:
        return np.eye(3) if cosine > 0 else turn(any_across(start), math.pi)
    return turn(axis / size, math.atan2(size, cosine))


def signed_angle(start: Array, end: Array, axis: Array) -> float:
    """The angle about a unit axis from one vector to another, as both are seen along it."""
    return math.atan2(float(cross(start, end) @ axis), float(across(start, axis) @ end))


def wrapped(angle_rad: float) -> float:
    """The same direction as an angle in (−pi, pi]."""
    return math.atan2(math.sin(angle_rad), math.cos(angle_rad))


def smooth_step(share: float) -> float:
    """0 up to 0, 1 from 1 on, level at both."""
    share = min(max(share, 0.0), 1.0)
    return share * share * (3.0 - 2.0 * share)
