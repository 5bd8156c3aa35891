"""The part of a picture that the network looks at: a square, turned so that the body is upright."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Final

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.pose import Pose, joint_names, joint_positions, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import KeypointError
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array

MARGIN: Final = 1.25
"""Side of the square over the diameter of the circle around the body, as it was trained."""

SMALLEST_BOX_PX: Final = 2.0
"""Side of a box around somebody, pixels."""
LEAST_DEPTH_M: Final = 0.05
"""Depth of a joint that can be seen."""
_HIPS = ("left_thigh", "right_thigh")
_SHOULDERS = ("left_upper_arm", "right_upper_arm")

SAME_BOX_IOU: Final = 0.8
"""Boxes that overlap by more, as the intersection over the union, are around one person."""

Box = tuple[float, float, float, float]
"""Left, top, right and bottom in pixels."""


def require_apart(boxes: Sequence[Box], frame: int) -> None:
    """KeypointError when two of the boxes on a frame are around the same person."""
    if any(_iou(*pair) > SAME_BOX_IOU for pair in combinations(boxes, 2)):
        raise around_the_same(frame)


def around_the_same(frame: int) -> KeypointError:
    """What is said of two boxes that lead to one person."""
    return KeypointError(
        f"Two boxes at frame {frame} are around the same person, or one is around somebody who has "
        "a body already: draw one box around each, or choose a frame in which nobody is hidden."
    )


def _iou(box: Box, box_beside: Box) -> float:
    """The intersection of two boxes over their union."""
    ranges = [np.sort(np.reshape(each, (2, 2)), axis=0) for each in (box, box_beside)]
    low, high = np.maximum(ranges[0][0], ranges[1][0]), np.minimum(ranges[0][1], ranges[1][1])
    shared = float(np.prod(np.clip(high - low, 0.0, None)))
    union = sum(float(np.prod(each[1] - each[0])) for each in ranges) - shared
    return shared / union if union > 0 else 0.0


@dataclass(frozen=True)
class Region:
    """A turned square of the picture.

    x, y: its centre in pixels.  side: in pixels.
    turn_rad: how far the body's upward direction is turned from the picture's, clockwise.
    """

    x: float
    y: float
    side: float
    turn_rad: float = 0.0

    @classmethod
    def of_box(cls, box: Box, width: int, height: int) -> Region:
        """Around a box that was drawn on a picture of this size; its corners in any order.

        KeypointError when the box has no size or lies outside the picture.
        """
        if not np.isfinite(box).all():
            raise KeypointError("The box around the person has a corner that is no number.")
        left, right = sorted((box[0], box[2]))
        top, bottom = sorted((box[1], box[3]))
        if min(right - left, bottom - top) < SMALLEST_BOX_PX:
            raise KeypointError("The box around the person has no size: draw it around the body.")
        if right < 0 or bottom < 0 or left > width - 1 or top > height - 1:
            raise KeypointError(
                f"The box around the person lies outside the picture of {width} × {height} pixels."
            )
        return cls._around(left, top, right, bottom)

    @classmethod
    def of_pose(cls, skeleton: Skeleton, pose: Pose, camera: Camera) -> Region:
        """Around all joints and landmarks of a posed body, as the camera filmed them.

        KeypointError when the whole body is behind the camera.
        """
        p = joint_positions(skeleton, pose_transforms(skeleton, pose))
        in_front = p[:, 2] > LEAST_DEPTH_M
        if not in_front.any():
            raise KeypointError("The posed body is behind the camera.")
        uv = np.full((len(p), 2), np.nan)
        uv[in_front] = camera.project(p[in_front])
        return cls.of_joints(uv, _upward(joint_names(skeleton), uv))

    @classmethod
    def of_joints(cls, uv: Array, upward: Array | None = None) -> Region:
        """Around pixels (J, 2), NaN where unknown.

        upward: (2,) direction in the picture from hips to shoulders; None where unknown.
        """
        turn = 0.0 if upward is None else float(np.arctan2(upward[0], -upward[1]))
        upright = _turn(-turn)
        upright_uv = (uv @ upright.T)[np.isfinite(uv).all(axis=1)]
        low, high = upright_uv.min(axis=0), upright_uv.max(axis=0)
        around = cls._around(*low.tolist(), *high.tolist())
        x, y = upright.T @ (around.x, around.y)
        return cls(float(x), float(y), around.side, turn)

    @classmethod
    def of_circle(cls, middle: Array, rim: Array) -> Region:
        """Around the circle about the middle of the hips (2,) through a point above the head (2,),
        as the network gives both."""
        d = np.asarray(rim, dtype=float) - middle
        side = 2 * MARGIN * float(np.hypot(*d))
        return cls(float(middle[0]), float(middle[1]), side, float(np.arctan2(d[0], -d[1])))

    @classmethod
    def _around(cls, left: float, top: float, right: float, bottom: float) -> Region:
        side = MARGIN * max(right - left, bottom - top, SMALLEST_BOX_PX)
        return cls((left + right) / 2, (top + bottom) / 2, side)

    @property
    def R_picture_body(self) -> Array:
        """(2, 2) from directions in the square to directions in the picture."""
        return _turn(self.turn_rad)

    def to_picture(self, width: int, height: int | None = None) -> Array:
        """(2, 3) affine map to pixels of the picture from those of the square, drawn with so many a
        side. Drawn as a rectangle, the square is widened: its side is the shorter one.

        The square's corners are the outer corners of its pixels, whose centres are at integers.
        """
        size = np.array([width, height or width])
        A = self.side / size.min() * self.R_picture_body
        return np.column_stack([A, np.array([self.x, self.y]) - A @ ((size - 1) / 2)])

    def rounded(self, parts: int) -> Region:
        """Round to whole parts of its size, so many of them: what is looked at from nearly the same
        place is seen as before. Of a power of two; rounded to fewer parts, it stays with more.
        """
        side = float(2 ** (np.round(np.log2(self.side) * parts) / parts))
        step = side / parts
        x, y = (float(np.round(value / step) * step) for value in (self.x, self.y))
        turn = float(np.round(self.turn_rad * parts) / parts)
        return Region(x, y, side, turn)

    def is_within(self, width: int, height: int) -> bool:
        """Whether the network can look there: in the picture, of a usable size."""
        numbers = (self.x, self.y, self.side, self.turn_rad)
        if not np.isfinite(numbers).all() or not 8 <= self.side <= 8 * max(width, height):
            return False
        return -0.5 <= self.x <= width - 0.5 and -0.5 <= self.y <= height - 0.5

    def distance(self, region: Region) -> float:
        """How far two regions differ: 0 where equal, 1 where one lies a side away, or is
        e times as large. Turns are not compared."""
        apart = np.hypot(self.x - region.x, self.y - region.y) / np.sqrt(self.side * region.side)
        return float(max(apart, abs(np.log(self.side / region.side))))


def _turn(angle_rad: float) -> NDArray[np.float64]:
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    return np.array([[c, -s], [s, c]])


def _upward(names: tuple[str, ...], uv: Array) -> Array | None:
    """The direction from the hips to the shoulders; None for a body without them, or seen
    along its trunk.
    """
    if not set(_HIPS + _SHOULDERS) <= set(names):
        return None
    hips, shoulders = (uv[[names.index(n) for n in pair]].mean(0) for pair in (_HIPS, _SHOULDERS))
    upward = shoulders - hips
    size = np.hypot(*np.nanmax(uv, axis=0) - np.nanmin(uv, axis=0))
    return upward if np.hypot(*upward) > 0.1 * size else None
