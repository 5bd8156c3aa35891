"""Where a dragged point goes: along the picture, in depth, along one axis; and the root with it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from keypose.app.posing.gesture import Gesture, GestureContext, Posed, Readout
from keypose.app.posing.labels import number_text
from keypose.app.posing.pointer_view import PointerView
from keypose.app.posing.vectors import length, unit
from keypose.tracker.body.pose import Pose
from keypose.tracker.geometry.rotations import Array

STEP_M = 0.01
"""The steps that snapping takes."""

NEAREST_M = 0.3
"""No nearer to the camera than this can anything be dragged."""

FARTHEST_M = 100.0

RISE_TO_E = 0.6
"""Share of the picture's height that the pointer rises to make the body's distance e times."""

MOST_E = 6.0

_SEEN_ALONG = 0.15
"""Sine of the angle to the line of sight under which an axis is too short to be followed."""


@dataclass(frozen=True, eq=False)
class Aim:
    """Where a dragged point should go.

    p_camera: (3,) the place, in the camera frame.
    at:       (2,) where that is seen, for a drag in the plane of the view; then depth is only
              kept as far as the limb allows, and the pointer counts.
    line:     (3,) the unit direction of a drag along a line (depth, or one axis), else None.
    """

    p_camera: Array
    at: Array
    line: Array | None


def aim(view: PointerView, p_camera: Array, gesture: Gesture) -> Aim:
    """Where the gesture drags a point that it took hold of."""
    if gesture.axis is not None:
        direction = np.eye(3)["xyz".index(gesture.axis)]
        return _along(view, p_camera, direction, _on_axis(view, p_camera, direction, gesture))
    if gesture.depth and view.is_other_films:
        sight = unit(p_camera)
        return _along(view, p_camera, sight, _on_axis(view, p_camera, sight, gesture))
    if gesture.depth:
        direction = view.ray_through(p_camera)
        return _along(
            view, p_camera, direction, _stepped(_upward(view, p_camera, gesture), gesture)
        )
    start = view.project(p_camera)
    scale = view.metres_per_unit(p_camera)
    steps = [gesture.at[k] - gesture.from_[k] for k in range(2)]
    if gesture.snap:
        steps = [round(step * scale / STEP_M) * STEP_M / scale for step in steps]
    at = start + steps
    return Aim(view.at_depth(at, p_camera), at, None)


def _along(view: PointerView, p_camera: Array, direction: Array, distance: float) -> Aim:
    """A drag along a line, as far as it stays before the camera."""
    forward = float(direction[2])
    low, high = -FARTHEST_M, FARTHEST_M
    if view.camera is not None and abs(forward) > 1e-9:
        ends = sorted(((NEAREST_M - p_camera[2]) / forward, (FARTHEST_M - p_camera[2]) / forward))
        low, high = min(float(ends[0]), 0.0), max(float(ends[1]), 0.0)
    place = p_camera + min(max(distance, low), high) * direction
    return Aim(place, view.project(place), direction)


def _upward(view: PointerView, p_camera: Array, gesture: Gesture) -> float:
    """Metres that the pointer went up, at the point's depth: up is farther."""
    return (gesture.from_[1] - gesture.at[1]) * view.metres_per_unit(p_camera)


def _stepped(metres: float, gesture: Gesture) -> float:
    return round(metres / STEP_M) * STEP_M if gesture.snap else metres


def _on_axis(view: PointerView, p_camera: Array, direction: Array, gesture: Gesture) -> float:
    """Metres along an axis through the point, to where the axis is nearest to the line of sight.

    An axis that is seen end on is followed by up and down, as depth is.
    """
    away = view.ray_through(p_camera)
    if 1.0 - float(away @ direction) ** 2 < _SEEN_ALONG**2:
        sign = 1.0 if away @ direction > 0 else -1.0
        return _stepped(sign * _upward(view, p_camera, gesture), gesture)
    end = view.moved(p_camera, gesture.from_, gesture.at)
    origin, ray = view.ray(end)
    slant = float(ray @ direction)
    across = max(1.0 - slant * slant, _SEEN_ALONG**2)
    gap = origin - p_camera
    return _stepped(float(gap @ direction - (gap @ ray) * slant) / across, gesture)


def move_root(context: GestureContext, view: PointerView, gesture: Gesture) -> Posed:
    """The whole body carried: along the picture at its depth, or in depth, or along one axis."""
    start = context.pose.p_camera_root
    by_size = view.camera is not None and not view.is_other_films
    if gesture.depth and gesture.axis is None and by_size:
        goal = _farther(view, start, gesture)
    else:
        goal = aim(view, start, gesture)
    place = _before_camera(goal.p_camera)
    pose = Pose(context.pose.Rs_parent_part, place)
    root = context.skeleton.body.names[0]
    kept = view.is_films and goal.line is None
    readout = Readout(
        label="Body",
        value=depth_text(place, kept),
        change=distance_text(place - start, goal.line),
        part=root,
        depth_m=float(place[2]),
    )
    return Posed(pose, None, readout)


def _farther(view: PointerView, p_camera: Array, gesture: Gesture) -> Aim:
    """The body along the line of sight: each stretch of the pointer's way changes its size in the
    picture by the same ratio, so that near and far bodies are fitted alike."""
    assert view.camera is not None
    risen = (gesture.from_[1] - gesture.at[1]) / view.camera.height
    direction = view.ray_through(p_camera)
    ratio = math.exp(min(max(risen / RISE_TO_E, -MOST_E), MOST_E))
    away = float((p_camera - view.p_camera_eye) @ direction)
    return _along(view, p_camera, direction, _stepped((ratio - 1) * away, gesture))


def _before_camera(place: Array) -> Array:
    return np.array([place[0], place[1], max(float(place[2]), NEAREST_M)])


def depth_text(p_camera: Array, kept: bool) -> str:
    """Such as "depth kept 3.21 m"."""
    return f"depth {'kept ' if kept else ''}{number_text(float(p_camera[2]), 2)} m"


def distance_text(offset: Array, line: Array | None) -> str:
    """How far something was dragged, with a sign along a line: "−12.0 cm"."""
    if line is not None:
        return f"{number_text(100 * float(offset @ unit(line)), 1, sign=True)} cm"
    return f"{number_text(100 * length(offset), 1)} cm"
