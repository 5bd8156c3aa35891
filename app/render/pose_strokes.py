"""A body in a few strokes: one for every part, round at its ends and as wide as the part.

They make a small picture of a pose that needs neither the body nor a video to be drawn.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from pydantic import FiniteFloat

from keypose.app.render.painting import form_of
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array

SIZE = 100.0
"""The strokes' field is so many units wide and high."""

SideLetter: TypeAlias = Literal["L", "R", "C"]
_LETTERS: dict[str, SideLetter] = {"left": "L", "right": "R", "middle": "C"}


@dataclass(frozen=True)
class PoseStroke:
    """From (x0, y0) to (x1, y1), `width` across, in a field of SIZE × SIZE, y down."""

    side: SideLetter
    x0: FiniteFloat
    y0: FiniteFloat
    x1: FiniteFloat
    y1: FiniteFloat
    width: FiniteFloat


def pose_strokes(skeleton: Skeleton, pose: Pose) -> tuple[PoseStroke, ...]:
    """The parts as the camera's axes see them from far away, those behind first."""
    form = form_of(skeleton)
    p_camera = form.mesh.posed(pose_transforms(skeleton, pose))
    xy = p_camera[:, :2]
    low, high = xy.min(axis=0), xy.max(axis=0)
    scale = SIZE / max(float((high - low).max()), 1e-6)
    field = (xy - (low + high) / 2) * scale + SIZE / 2
    parts = [field[form.mesh.vertex_part == i] for i in range(skeleton.part_count)]
    depth = [p_camera[form.mesh.vertex_part == i, 2].mean() for i in range(skeleton.part_count)]
    order = np.argsort(depth)[::-1]
    return tuple(_stroke(_LETTERS[form.sides[i]], parts[i]) for i in order)


def _stroke(side: SideLetter, xy: Array) -> PoseStroke:
    """The capsule about some points (N, 2): along their longest extent."""
    middle = (xy.min(axis=0) + xy.max(axis=0)) / 2
    _, _, axes = np.linalg.svd(xy - middle, full_matrices=False)
    along, across = (xy - middle) @ axes[0], (xy - middle) @ axes[1]
    width = float(np.ptp(across))
    first, last = float(along.min()) + width / 2, float(along.max()) - width / 2
    if first > last:
        first = last = (first + last) / 2
    shift = axes[1] * (across.min() + across.max()) / 2
    (x0, y0), (x1, y1) = (middle + shift + axes[0] * end for end in (first, last))
    return PoseStroke(side, *(round(float(v), 1) for v in (x0, y0, x1, y1, width)))
