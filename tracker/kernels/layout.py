"""What the loops are given: named tuples of plain arrays.

S surface points, P parts, D degrees of freedom.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

STEPS = 128
"""Of a grey level in prepared pictures, which are int16: 255 of them fit, and so do gradients. Half
the memory of single precision, read as quickly, and 60 times finer than a camera's own steps."""


class BodyArrays(NamedTuple):
    """A body and the points laid on its surface, sorted by part.

    parents (P,) int64 · joints (P, 3) · dof_part, dof_turns, dof_axis (D,) int64 ·
    deeper (D, D) int64: of two degrees of freedom on one chain the part further from the root,
    −1 where neither hangs below the other · points, normals (S, 3) float32 in the part's frame ·
    starts (P + 1,) int64: part i's points are starts[i] to starts[i + 1] · least (P,) float32: what
    a pixel has to be for a part's points to be followed from it, USABLE or TARGET_ONLY.
    """

    parents: NDArray[np.int64]
    joints: NDArray[np.float64]
    dof_part: NDArray[np.int64]
    dof_turns: NDArray[np.int64]
    dof_axis: NDArray[np.int64]
    deeper: NDArray[np.int64]
    points: NDArray[np.float32]
    normals: NDArray[np.float32]
    starts: NDArray[np.int64]
    least: NDArray[np.float32]


class Articulation(NamedTuple):
    """A body's parts and how its poses move: parents (P,) int64 · joints (P, 3) · dof_part,
    dof_turns, dof_axis (D,) int64."""

    parents: NDArray[np.int64]
    joints: NDArray[np.float64]
    dof_part: NDArray[np.int64]
    dof_turns: NDArray[np.int64]
    dof_axis: NDArray[np.int64]


class Places(NamedTuple):
    """J places on a body, each the mean of some of K points.

    starts (J + 1,) int64: place j's points are starts[j] to starts[j + 1] · parts (K,) int64,
    points (K, 3) in their frames · dof_starts (J + 1,), dofs (L,) int64: which degrees of freedom
    move place j, in order · moves (K, D) bool: which move a point.
    """

    starts: NDArray[np.int64]
    parts: NDArray[np.int64]
    points: NDArray[np.float64]
    dof_starts: NDArray[np.int64]
    dofs: NDArray[np.int64]
    moves: NDArray[np.bool_]


class JointRanges(NamedTuple):
    """The joint limits of a body.

    low, high (P, 3) of x, y, z, radians · bounded (P,) bool: whether one of them is finite · twist
    (P,) int64: where a part's twist is among K, −1 where it has no limits · twist_low, twist_high
    (K,) · R_rest (K, 3, 3) · allowed (P, 4): what may lie outside, signed · sigma, onset: radians ·
    least_cos, least_determined: so much at least slopes are divided by · dof_starts (P + 1,) int64:
    the degrees of freedom of each part.
    """

    low: NDArray[np.float64]
    high: NDArray[np.float64]
    bounded: NDArray[np.bool_]
    twist: NDArray[np.int64]
    twist_low: NDArray[np.float64]
    twist_high: NDArray[np.float64]
    R_rest: NDArray[np.float64]
    allowed: NDArray[np.float64]
    sigma: float
    onset: float
    least_cos: float
    least_determined: float
    dof_starts: NDArray[np.int64]


class Lens(NamedTuple):
    """A pinhole without distortion. With `perspective` 0 every point is divided by `distance`.

    left, top: the pixel of the whole picture at which the arrays of its window begin; the lens's
    own pixels are those of the whole picture. What lies beyond the window is beyond the picture.
    """

    fx: float
    fy: float
    cx: float
    cy: float
    perspective: int
    distance: float
    left: int = 0
    top: int = 0


class Visibility(NamedTuple):
    """When a surface point counts as seen.

    cell: side of the occlusion buffer's cells, pixels (at least 1.5 times the points' spacing).
    facing: smallest cosine between a point's normal and the direction to the camera.
    tolerance: metres a point may lie behind the nearest foreign part of its cell.
    """

    cell: int
    facing: float
    tolerance: float


class Prior(NamedTuple):
    """How a motion is held to its prediction.

    precision (D,): 1/σ² of each degree of freedom, radians or metres.
    information: how many independent observations one surface point stands for.
    """

    precision: NDArray[np.float64]
    information: float


class ComparedBody(NamedTuple):
    """A body and the points by which two of its motions are compared, sorted by part.

    parents (P,) int64 · joints (P, 3) · points (M, 3) in their parts' frames · starts (P + 1,)
    int64: part i's points are starts[i] to starts[i + 1] · interpolated (P,) bool: the parts whose
    rotation is interpolated, the root with its position; the others move as they do.
    """

    parents: NDArray[np.int64]
    joints: NDArray[np.float64]
    points: NDArray[np.float64]
    starts: NDArray[np.int64]
    interpolated: NDArray[np.bool_]


class DenseMotion(NamedTuple):
    """A pose for every frame, and where it has the points of a `ComparedBody`.

    Rs (N, P, 3, 3) in the parents' frames · ps (N, 3) of the root · points (N, M, 3), all metres in
    the world · known (N,) bool: where there is a pose · Ts_camera_world (N, 4, 4) · zoom (N,): the
    focal length as a multiple of the lens's.
    """

    Rs: NDArray[np.float64]
    ps: NDArray[np.float64]
    points: NDArray[np.float64]
    known: NDArray[np.bool_]
    Ts_camera_world: NDArray[np.float64]
    zoom: NDArray[np.float64]


class Limits(NamedTuple):
    """By what misses are divided, and how large they may be.

    metres, pixels: of 1 in space and in the picture; infinite where that does not count.
    largest: the largest squared miss that is within limits; infinite where all are.
    """

    metres: float
    pixels: float
    largest: float


class IntervalWork(NamedTuple):
    """What comparing intervals of a motion writes to.

    turns (P, 3) · HR (P, 3, 3), Ho (P, 3): parts as placed · scratch (2, 3, 3) · vector (3,) ·
    way (P,) int64 · witness (2,) int64: frame and part that were off last · give_up (1,) bool.
    """

    turns: NDArray[np.float64]
    HR: NDArray[np.float64]
    Ho: NDArray[np.float64]
    scratch: NDArray[np.float64]
    vector: NDArray[np.float64]
    way: NDArray[np.int64]
    witness: NDArray[np.int64]
    give_up: NDArray[np.bool_]
