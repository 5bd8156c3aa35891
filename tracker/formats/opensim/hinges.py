"""Express a motion by knees and elbows that are hinges, as OpenSim's full-body models have them.

What knee and elbow do besides bending is done by a turn of the limb above about its length: so
turned, it has the hinge's axis at right angles to the plane in which the limb is bent, and ankle or
wrist are where they were. A limb that is nearly straight does not show that plane and is turned
little; there the ankle moves by what the knee was bent sideways. Hands and feet keep their
direction in space.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from keypose.tracker.body.body import Body
from keypose.tracker.geometry.rotations import Array, exp_rotation, transpose

MISPLACED: Final = np.radians(4.0)
"""How far the lower limb may point beside its direction, a standard deviation."""

TURNED: Final = 0.3
"""The sine of a turn of the upper limb, a standard deviation."""

X, Y = np.eye(3)[:2]

LIMBS: Final = (("upper_arm", "forearm", "hand"), ("thigh", "shin", "foot"))


def with_hinges(body: Body, Rs_parent_part: Array) -> Array:
    """Rs_parent_part (N, P, 3, 3), all known, of a person whose knees bend, and whose elbows
    bend and turn about the forearm's length, and do nothing else.
    """
    Rs = Rs_parent_part.copy()
    for upper, lower, end in LIMBS:
        for side in ("left", "right"):
            i, j, k = (body.index(f"{side}_{part}") for part in (upper, lower, end))
            turn = _about(Y, _turn(Rs[:, j]))
            bent = transpose(turn) @ Rs[:, j]
            hinge = _hinge(bent, turns=lower == "forearm")
            Rs[:, i], Rs[:, j] = Rs[:, i] @ turn, hinge
            Rs[:, k] = transpose(hinge) @ bent @ Rs[:, k]
    return Rs


def _turn(Rs_upper_lower: Array) -> Array:
    """(N,) radians about the upper limb's length y, after which the lower bends about its x."""
    beside, _, back = np.moveaxis(Rs_upper_lower[:, :, 1], -1, 0)  # along the lower limb
    bent = np.hypot(beside, back) / MISPLACED
    plane = 2 * np.arctan2(beside, back)  # doubled: a limb bends either way in one plane
    both = bent**2 * np.exp(1j * plane) + TURNED**-2
    return np.unwrap(np.angle(both) / 2, period=np.pi)


def _hinge(Rs_upper_lower: Array, turns: bool) -> Array:
    """(N, 3, 3) The nearest turns about x and then, where it also turns, about y."""
    _, down, back = np.moveaxis(Rs_upper_lower[:, :, 1], -1, 0)
    bend = _about(X, np.arctan2(back, down))
    left = transpose(bend) @ Rs_upper_lower
    turn = np.arctan2(left[:, 0, 2] - left[:, 2, 0], left[:, 0, 0] + left[:, 2, 2])
    return np.asarray(bend @ _about(Y, turn)) if turns else bend


def _about(axis: Array, angles: Array) -> Array:
    """(N, 3, 3) turns by radians (N,)."""
    return exp_rotation(angles[:, None] * axis)
