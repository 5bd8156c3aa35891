"""Hands, feet, elbows, knees and the head dragged: the limb follows."""

from __future__ import annotations

from app.posing.chains import Chain
from app.posing.elbows import Elbow
from app.posing.gesture import Gesture, Posed, Reach, Readout
from app.posing.handles import BodyHandle, handles
from app.posing.moving import Aim, aim, depth_text, distance_text
from app.posing.sight import Sight
from app.posing.spine import Spine
from app.posing.standing import Standing
from app.posing.swinging import Swing, on_sphere
from app.posing.two_bones import Reached, TwoBones
from app.posing.vectors import across, length, unit
from tracker.geometry.rotations import Array

LEVEL_M = 0.005
"""A handle that is no nearer and no farther than this has kept its depth."""
MISSED_M = 0.002
"""A handle this far from where it was dragged is called out of reach."""


def reached(standing: Standing, sight: Sight, gesture: Gesture, handle: BodyHandle) -> Posed:
    """The limb of a handle posed so that the handle comes under the pointer."""
    part, p_part = standing.point(handle.anchor)
    before = standing.placed(part, p_part)
    goal = aim(sight, before, gesture)
    found = _solve(standing, sight, goal, handle, before)
    pose = standing.turned(found.rotations)
    after = Standing.of(standing.skeleton, pose, False).placed(part, p_part)
    return Posed(pose, None, _readout(sight, goal, handle, found, before, after))


def _solve(
    standing: Standing, sight: Sight, goal: Aim, handle: BodyHandle, before: Array
) -> Reached:
    """The way of solving that fits the number of parts that turn."""
    index = standing.skeleton.body.index
    movers = tuple(index(name) for name in handle.movers)
    part, p_part = standing.point(handle.anchor)
    tip = p_part if part == movers[-1] else standing.skeleton.joints[part]
    if handle.kind == "head":
        return Spine(standing, movers, tip).reach(sight, goal)
    if handle.kind == "middle" and len(movers) == 1:
        limb = _limb_beyond(standing, handle)
        if limb is not None:
            return Elbow(limb).reach(sight, goal)
    if len(movers) == 1:
        return _swung(standing, sight, goal, movers[0], tip, before)
    if len(movers) == 2:
        return TwoBones.of(standing, *movers, tip).reach(sight, goal)
    return Chain(standing, movers, tip).reach(sight, goal)


def _limb_beyond(standing: Standing, handle: BodyHandle) -> TwoBones | None:
    """The two bones that meet at a middle handle, where the limb has an end of two bones."""
    for other in handles(standing.skeleton.body):
        if other.kind == "end" and other.limb == handle.limb and len(other.movers) == 2:
            part, p_part = standing.point(other.anchor)
            upper, lower = (standing.skeleton.body.index(name) for name in other.movers)
            tip = p_part if part == lower else standing.skeleton.joints[part]
            return TwoBones.of(standing, upper, lower, tip)
    return None


def _swung(
    standing: Standing, sight: Sight, goal: Aim, part: int, tip: Array, before: Array
) -> Reached:
    """One bone: only its direction can change."""
    centre = standing.joint(part)
    radius = length(before - centre)
    resting = standing.resting_direction(part, tip)
    place = on_sphere(sight, goal, centre, radius, before, resting)
    direction = unit(place - centre)
    by = Swing.of(unit(before - centre), resting).to(direction)
    R = standing.R_camera_parent(part).T @ by @ standing.R_camera_part(part)
    return Reached({part: R}, centre, radius)


def _readout(
    sight: Sight, goal: Aim, handle: BodyHandle, found: Reached, before: Array, after: Array
) -> Readout:
    level = abs(float(after[2] - before[2])) < LEVEL_M
    kept = handle.kind == "end" and goal.line is None and sight.camera is not None and level
    return Readout(
        label=handle.label,
        value=depth_text(after, kept),
        change="" if goal.line is None else distance_text(after - before, goal.line),
        part=handle.part,
        reach=Reach(found.centre, found.radius_m),
        out_of_reach=_missed(sight, goal, found, after) > MISSED_M,
        depth_m=float(after[2]),
    )


def _missed(sight: Sight, goal: Aim, found: Reached, after: Array) -> float:
    """Metres, as the view shows them, by which the handle is not where it was dragged.

    A bone that is swung in a small view goes round a circle. Inside it, the handle lies in the
    direction of the pointer, which is all that is asked.
    """
    wanted = goal.p_camera if goal.line is not None else sight.at_depth(goal.at, after)
    radius, way = length(after - found.centre), wanted - found.centre
    is_bone = abs(radius - found.radius_m) < 1e-9
    if is_bone and (goal.line is not None or sight.camera is None):
        flat = way if goal.line is not None else across(way, sight.away)
        now = after - found.centre
        now = now if goal.line is not None else across(now, sight.away)
        if length(flat) < length(now):
            return length(across(now, unit(flat)))
    return length(wanted - after)
