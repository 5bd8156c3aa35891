"""One bone: a part swung about its joint so that a point of it comes under the pointer."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from keypose.app.posing.moving import Aim
from keypose.app.posing.pointer_view import PointerView
from keypose.app.posing.vectors import across, any_across, least_turn, length, smooth_step, unit
from keypose.tracker.geometry.rotations import Array

LEAN = math.radians(50.0)
"""How far the direction that a limb's turns are counted from may lie from where it points."""

CHANGED_M = 0.05
"""A point on the wrong side, near or far, changes to the other over a drag of this length."""

_LEVEL = 0.2
"""Radii within which a point lies about as far away as its joint, on neither side for good."""

_TOP = 0.93
"""Radii above which a circle of a sphere is too small to be dragged along."""

_CLEAR = 0.2
"""How clearly a direction must lead nearer or farther to decide the side."""


@dataclass(frozen=True, eq=False)
class Swing:
    """Swings a limb from one direction to others without needless turning about itself.

    Directions (3,) are unit vectors. Every field of such swings has one direction into which it
    cannot reach steadily: the opposite of `middle`. It is placed where the limb is least likely to
    go, which for an arm that hangs down is backward and up, not straight up.
    """

    start: Array
    middle: Array

    @classmethod
    def of(cls, start: Array, resting: Array, within: Array | None = None) -> Swing:
        """Prepare a limb that points to `start` and whose range has its middle at `resting`.

        within: a direction across `start`. Swings in the plane of both keep that plane.
        """
        side = across(resting, start) if within is None else across(within, start)
        side = unit(side) if length(side) > 1e-9 else any_across(start)
        up, along = float(resting @ side), float(resting @ start)
        lean = math.atan2(up, along) * min(1.0, math.hypot(up, along) / 0.3)
        lean = min(max(lean, -LEAN), LEAN)
        return cls(start, math.cos(lean) * start + math.sin(lean) * side)

    def to(self, end: Array, start: Array | None = None) -> Array:
        """(3, 3) the rotation from `start` (another near it, if given) to `end`."""
        first = self.start if start is None else start
        return np.asarray(least_turn(self.middle, end) @ least_turn(first, self.middle))


def on_sphere(
    view: PointerView, goal: Aim, centre: Array, radius: float, p_before: Array, resting: Array
) -> Array:
    """(3,) the point of a sphere to which a point of it, at p_before, is dragged.

    On the picture it lies under the pointer, on the side, near or far, where it was; a point about
    as far away as the centre goes to the side of `resting`, the middle of the limb's range. Past
    the sphere's outline it is the nearest point of that. In the small views it stays in its plane
    of the view, see `in_level`: whether it does follows from where it was before the drag, so that
    it holds while a neck that bends makes the sphere smaller. Along a line it is the point toward
    which the line leads.
    """
    if goal.line is not None:
        return np.asarray(centre + radius * unit(goal.p_camera - centre))
    if keeps_level(view, p_before - centre, length(p_before - centre)):
        return in_level(view, goal, centre, radius, p_before)
    away = view.ray_through(p_before)
    drawn = length(view.at_depth(goal.at, p_before) - p_before)
    share = farness(float((p_before - centre) @ away) / radius, float(resting @ away), drawn)
    return under_pointer(view, goal.at, centre, radius, share)


def under_pointer(
    view: PointerView, at: Array, centre: Array, radius: float, share: float
) -> Array:
    """(3,) the point of a sphere that is seen at `at`, or past its outline the nearest of that.

    share: see `farness`.
    """
    origin, ray = view.ray(at)
    foot = origin + float((centre - origin) @ ray) * ray - centre
    beside = length(foot)
    if beside >= radius:
        return np.asarray(centre + radius / beside * foot)
    from_centre = foot + share * math.sqrt(radius**2 - beside**2) * ray
    return np.asarray(centre + radius * unit(from_centre))


def keeps_level(view: PointerView, offset: Array, radius: float) -> bool:
    """Whether a drag in this view leaves the depth of a point alone, which lies `offset` (3,)
    from the centre of its sphere.

    Each small view is there to set what the others do not show. Not on the picture, nor where so
    little of the sphere is at that depth that nothing could move.
    """
    return view.camera is None and abs(float(offset @ view.away)) <= _TOP * radius


def in_level(view: PointerView, goal: Aim, centre: Array, radius: float, p_before: Array) -> Array:
    """(3,) the point of the sphere at the depth of p_before nearest to the goal; where the sphere
    does not reach that depth, the point nearest to it."""
    height = float((p_before - centre) @ view.away)
    height = min(max(height, -radius), radius)
    middle = centre + height * view.away
    beside = across(goal.p_camera - middle, view.away)
    beside = beside if length(beside) > 1e-9 else across(p_before - middle, view.away)
    return np.asarray(middle + math.sqrt(radius**2 - height**2) * unit(beside))


def farness(
    was: float, toward: float, drawn_m: float, level: float = _LEVEL, changed_m: float = CHANGED_M
) -> float:
    """1 for the far side of a sphere, −1 for the near one; between while a level point changes
    sides.

    was: how far beyond the centre the point was, in radii; `level` is level.  toward: the same of
    the direction to whose side a level point goes.  drawn_m: how far the point is drawn; it has
    changed sides at `changed_m`.
    """
    sign = math.copysign(1.0, was)
    if abs(was) > level or toward * sign > -_CLEAR:
        return sign
    return sign * (1.0 - 2.0 * smooth_step(drawn_m / changed_m))
