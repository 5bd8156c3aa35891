"""What is beyond reach: the nearest place that a limb can reach, on the way of the drag."""

from __future__ import annotations

import math

import numpy as np

from keypose.app.posing.moving import Aim
from keypose.app.posing.pointer_view import PointerView
from keypose.app.posing.swinging import in_level, keeps_level
from keypose.app.posing.vectors import length, unit
from keypose.tracker.geometry.rotations import Array


def within_reach(
    view: PointerView,
    goal: Aim,
    centre: Array,
    nearest_m: float,
    farthest_m: float,
    p_before: Array,
) -> Array:
    """(3,) the goal, or the nearest place to it whose distance from the centre can be.

    A drag in the plane of the view keeps its depth while it can. Where it cannot, the place stays
    under the pointer and its depth gives way; past the outline of what can be reached it sticks to
    that. A drag along a line stays on the line while it can.
    """
    away = length(goal.p_camera - centre)
    if nearest_m <= away <= farthest_m:
        return goal.p_camera
    radius = farthest_m if away > farthest_m else nearest_m
    if goal.line is not None:
        found = _on_line(goal.line, goal.p_camera, p_before, centre, radius)
    else:
        if away < nearest_m:
            return _pushed_out(view, goal, centre, radius)
        if keeps_level(view, p_before - centre, radius):
            return in_level(view, goal, centre, radius, p_before)
        found = _under_pointer(view, goal, centre, radius)
    return np.asarray(centre + radius * unit(found - centre))


def _under_pointer(view: PointerView, goal: Aim, centre: Array, radius: float) -> Array:
    """(3,) where the line of sight meets the sphere, on the side, near or far, of the goal."""
    origin, ray = view.ray(goal.at)
    foot = origin + float((centre - origin) @ ray) * ray
    gap = length(foot - centre)
    if gap >= radius:
        return np.asarray(foot)
    sign = math.copysign(1.0, float((goal.p_camera - centre) @ ray))
    return np.asarray(foot + sign * math.sqrt(radius**2 - gap**2) * ray)


def _pushed_out(view: PointerView, goal: Aim, centre: Array, radius: float) -> Array:
    """(3,) the goal pushed straight nearer or farther, whichever it is of the centre, until it
    leaves the sphere around it."""
    way = goal.p_camera - centre
    height = float(way @ view.away)
    beside = way - height * view.away
    depth = math.sqrt(radius**2 - float(beside @ beside))
    return np.asarray(centre + beside + math.copysign(depth, height) * view.away)


def _on_line(direction: Array, place: Array, before: Array, centre: Array, radius: float) -> Array:
    """(3,) the nearest of the two points in which the line cuts the sphere, seen from `place`.

    Inside an inner sphere it is the one on the side where the drag began.
    """
    foot = place + float((centre - place) @ direction) * direction
    gap = length(foot - centre)
    if gap >= radius:
        return np.asarray(foot)
    inside = length(place - centre) < radius
    way = (before if inside else place) - foot
    sign = math.copysign(1.0, float(way @ direction))
    return np.asarray(foot + sign * math.sqrt(radius**2 - gap**2) * direction)
