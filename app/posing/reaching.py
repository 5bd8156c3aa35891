"""Hands, feet, elbows, knees and the head dragged: the limb follows."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from keypose.app.posing.chains import Chain, Spine
from keypose.app.posing.elbows import Elbow, Swivel
from keypose.app.posing.gesture import Gesture, GestureContext, Posed, Reach, Readout
from keypose.app.posing.handles import BodyHandle, handles
from keypose.app.posing.holding import MISSED_M, NONE_HELD, Held
from keypose.app.posing.moving import Aim, aim, depth_text, distance_text
from keypose.app.posing.pointer_view import PointerView
from keypose.app.posing.swinging import Swing, on_sphere
from keypose.app.posing.two_bones import Reached, TwoBones
from keypose.app.posing.vectors import across, length, smooth_step, unit
from keypose.tracker.geometry.rotations import Array

CORRECTED = 0.25
DRAWN_FAR = 0.5
"""A drag of an end so long, in lengths of its limb, leaves the joint between where it is seen, and
one so long does not."""

MISSED_PX = 0.5
HALVINGS = 6
"""Where less of it would leave the end more than this beside the pointer, what takes the joint
between along is found to a share of 1 in 64."""

LEVEL_M = 0.005
"""A handle that is no nearer and no farther than this has kept its depth."""


def reach(
    context: GestureContext,
    view: PointerView,
    gesture: Gesture,
    handle: BodyHandle,
    held: Held = NONE_HELD,
) -> Posed:
    """The limb of a handle posed so that the handle comes under the pointer.

    Of a limb of two bones whose end is held, the other joint stays where it is seen while one is
    dragged on the picture. In other views an elbow or a knee goes round the end, as near to the
    pointer as it can; so it does where the end is pinned.
    """
    part, p_part = context.point(handle.anchor)
    before = context.placed(part, p_part)
    goal = aim(view, before, gesture)
    reached = _solve(context, view, goal, handle, before, held)
    pose = context.turned(reached.rotations)
    after = GestureContext.of(context.skeleton, pose, False).placed(part, p_part)
    return Posed(pose, None, _readout(view, goal, handle, reached, before, after))


def _solve(
    context: GestureContext,
    view: PointerView,
    goal: Aim,
    handle: BodyHandle,
    before: Array,
    held: Held,
) -> Reached:
    """The way of solving that fits the number of parts that turn."""
    index = context.skeleton.body.index
    movers = tuple(index(name) for name in handle.movers)
    part, p_part = context.point(handle.anchor)
    tip = p_part if part == movers[-1] else context.skeleton.joints[part]
    if handle.kind == "head":
        return Spine(context, movers, tip).reach(view, goal)
    if handle.kind == "middle" and len(movers) == 1:
        end = _end_beyond(context, handle)
        if end is not None:
            return _middle_dragged(_two_bones(context, end), view, goal, end.name, held)
    if len(movers) == 1:
        return _swung(context, view, goal, movers[0], tip, before)
    if len(movers) == 2:
        return _end_dragged(TwoBones.of(context, *movers, tip), view, goal, handle.name, held)
    return Chain(context, movers, tip).reach(view, goal)


def _middle_dragged(limb: TwoBones, view: PointerView, goal: Aim, end: str, held: Held) -> Reached:
    seen_limb = held.limb_in_picture(limb, end, limb.context)
    if seen_limb is not None:
        return seen_limb.with_middle(goal.at, seen_limb.end_at)
    drag = Swivel if end in held.placed | held.pinned else Elbow
    return drag(limb).reach(view, goal)


def _end_dragged(limb: TwoBones, view: PointerView, goal: Aim, end: str, held: Held) -> Reached:
    """A hand or a foot that is corrected leaves elbow or knee where they are seen; one that is
    drawn far takes them along, and so does one that would not come under the pointer otherwise."""
    reached = limb.reach(view, goal)
    seen_limb = held.limb_in_picture(limb, end, limb.context)
    if seen_limb is None:
        return reached
    drawn = length(goal.p_camera - limb.end) / limb.hinge.farthest_m
    along = smooth_step((drawn - CORRECTED) / (DRAWN_FAR - CORRECTED))
    context = limb.context
    after = GestureContext.of(context.skeleton, context.turned(reached.rotations), False)
    offset = view.project(after.joint(limb.lower)) - seen_limb.middle_at
    if not np.isfinite(offset).all():  # drawn behind the camera
        return reached

    def taken(share: float) -> Reached:
        return seen_limb.with_end(seen_limb.middle_at + share * offset, goal.at)

    def missed_px(candidate: Reached) -> float:
        posed = GestureContext.of(context.skeleton, context.turned(candidate.rotations), False)
        return length(view.project(posed.placed(limb.lower, limb.tip)) - goal.at)

    allowed = missed_px(reached) + MISSED_PX
    return _least(taken, along, lambda candidate: missed_px(candidate) <= allowed) or reached


def _least(
    taken: Callable[[float], Reached], least: float, is_there: Callable[[Reached], bool]
) -> Reached | None:
    """What is taken with the least share, from `least` to 1, that leads there; None where
    all of it does not.
    """
    reached = taken(least)
    if is_there(reached):
        return reached
    low, high, reached = least, 1.0, taken(1.0)
    if not is_there(reached):
        return None
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        tried = taken(middle)
        low, high, reached = (low, middle, tried) if is_there(tried) else (middle, high, reached)
    return reached


def _end_beyond(context: GestureContext, handle: BodyHandle) -> BodyHandle | None:
    """The end of the limb of two bones that meet at a middle handle."""
    for body_handle in handles(context.skeleton.body):
        meets = body_handle.limb == handle.limb and body_handle.movers[0] == handle.movers[0]
        if body_handle.kind == "end" and meets and len(body_handle.movers) == 2:
            return body_handle
    return None


def _two_bones(context: GestureContext, end: BodyHandle) -> TwoBones:
    part, p_part = context.point(end.anchor)
    upper, lower = (context.skeleton.body.index(name) for name in end.movers)
    tip = p_part if part == lower else context.skeleton.joints[part]
    return TwoBones.of(context, upper, lower, tip)


def _swung(
    context: GestureContext, view: PointerView, goal: Aim, part: int, tip: Array, before: Array
) -> Reached:
    """One bone: only its direction can change, as far as its limits allow."""
    centre = context.joint(part)
    radius = length(before - centre)
    resting = context.resting_direction(part, tip)
    place = on_sphere(view, goal, centre, radius, before, resting)
    direction = unit(place - centre)
    by = Swing.of(unit(before - centre), resting).to(direction)
    R = context.R_camera_parent(part).T @ by @ context.R_camera_part(part)
    return Reached({part: context.allowed(part, R)}, centre, radius)


def _readout(
    view: PointerView, goal: Aim, handle: BodyHandle, reached: Reached, before: Array, after: Array
) -> Readout:
    level = abs(float(after[2] - before[2])) < LEVEL_M
    kept = handle.kind == "end" and goal.line is None and view.is_films and level
    return Readout(
        label=handle.label,
        value=depth_text(after, kept),
        change="" if goal.line is None else distance_text(after - before, goal.line),
        part=handle.part,
        reach=Reach(reached.centre, reached.radius_m),
        out_of_reach=_miss_m(view, goal, reached, after) > MISSED_M,
        depth_m=float(after[2]),
    )


def _miss_m(view: PointerView, goal: Aim, reached: Reached, after: Array) -> float:
    """Metres, as the view shows them, by which the handle is not where it was dragged.

    A bone that is swung in a small view goes round a circle. Inside it, the handle lies in the
    direction of the pointer, which is all that is asked.
    """
    wanted = goal.p_camera if goal.line is not None else view.at_depth(goal.at, after)
    radius, offset = length(after - reached.centre), wanted - reached.centre
    is_bone = abs(radius - reached.radius_m) < 1e-9
    if is_bone and (goal.line is not None or view.camera is None):
        flat = offset if goal.line is not None else across(offset, view.away)
        now = after - reached.centre
        now = now if goal.line is not None else across(now, view.away)
        if length(flat) < length(now):
            return length(across(now, unit(flat)))
    return length(wanted - after)
