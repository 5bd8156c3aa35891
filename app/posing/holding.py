"""Hands and feet that stay where they are while the rest of the body moves.

After a drag has moved what it moves, every limb whose end is held is bent anew so that the end
comes back to its place, with the direction it had as far as its joint's limits let it. A limb
that is too short for that is stretched straight toward the place. A place is one in space, or of a
drag on the picture where the limb is seen (`seen_limbs.py`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from keypose.app.posing.chains import Chain
from keypose.app.posing.gesture import GestureContext, Posed
from keypose.app.posing.handles import BodyHandle, handles
from keypose.app.posing.pointer_view import PointerView
from keypose.app.posing.seen_limbs import SeenLimb
from keypose.app.posing.two_bones import TwoBones
from keypose.app.posing.vectors import length, smooth_step
from keypose.tracker.body.body import Body
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array, exp_rotation, log_rotation

MISSED_M = 0.002
"""An end this far from its place is called out of reach."""

_SAME = 1e-12
"""Metres, and entries of a rotation, that are rounding."""

_AT_REST = 1e-9
"""Entries of a rotation: a part that is turned by less is as it was built."""

_TURNED_BACK = math.radians(50.0)
_NOT_BACK = math.radians(110.0)
"""How far what carries a hand or a foot turns until that no longer keeps all of its direction, and
until it keeps none."""


@dataclass(frozen=True)
class Held:
    """Names of ends (`BodyHandle.name`) that stay.

    placed: where the trunk or a joint of their own limb is dragged.
    pinned: whatever is changed, unless it is they themselves.
    seen: the film's own view where something is dragged in it: it shows nothing of depth, so there
        limbs whose ends are placed stay where they are seen, elbows and knees too. None where ends
        stay where they are in space, as those that are pinned always do.
    beside: the poses of the frames before and after, as far as they are known.
    """

    placed: frozenset[str] = frozenset()
    pinned: frozenset[str] = frozenset()
    seen: PointerView | None = None
    beside: tuple[Pose, ...] = ()

    def limb_in_picture(self, limb: TwoBones, end: str, before: GestureContext) -> SeenLimb | None:
        """The limb of an end that stays where it is seen; None of one that does not."""
        if self.seen is None or end not in self.placed - self.pinned:
            return None
        return SeenLimb.of(limb, self.seen, before, self.beside)


NONE_HELD = Held()


@dataclass(frozen=True)
class Moved:
    """What a change is about: the part it turns, or the root that it carries.

    joint: it drags the joint at which the part hangs.  end: the end that it drags itself.
    """

    part: str
    joint: bool = False
    end: str | None = None


@dataclass(frozen=True, eq=False)
class Kept:
    """A pose with its held ends back in their places; those that cannot get there, by name."""

    pose: Pose
    unreached: tuple[str, ...] = ()


def ends_to_hold(body: Body) -> tuple[BodyHandle, ...]:
    """The ends that can be held: those of limbs with at least two bones to bend."""
    return tuple(h for h in handles(body) if h.kind == "end" and len(h.movers) >= 2)


def placed_ends(body: Body, pose: Pose) -> frozenset[str]:
    """Ends of limbs that are not as they are at rest: somebody has put them there."""
    return frozenset(
        handle.name
        for handle in ends_to_hold(body)
        if any(_is_turned(pose, body.index(name)) for name in handle.limb)
    )


def _is_turned(pose: Pose, part: int) -> bool:
    return bool(np.abs(pose.Rs_parent_part[part] - np.eye(3)).max() > _AT_REST)


def with_held_ends(before: GestureContext, posed: Posed, held: Held, moved: Moved) -> Posed:
    """What a drag has made of the pose before it, its held ends back in their places."""
    kept = keep_ends(before, posed.pose, held, moved)
    if kept.pose is posed.pose:
        return posed
    return replace(posed, pose=kept.pose, readout=replace(posed.readout, unreached=kept.unreached))


def keep_ends(before: GestureContext, after: Pose, held: Held, moved: Moved) -> Kept:
    """The pose after a change, with the held ends where they were before it."""
    pose, unreached = after, []
    for handle in ends_to_hold(before.skeleton.body):
        bending = _bending(handle, held, moved)
        if len(bending) < 2:
            continue
        brought_back = _BroughtBack(before, handle, bending, held, moved).found(pose)
        if brought_back is None:
            continue
        pose, missed_m = brought_back
        if missed_m > MISSED_M:
            unreached.append(handle.name)
    return Kept(pose, tuple(unreached))


def _is_carried(handle: BodyHandle, moved: Moved) -> bool:
    """Whether the trunk moves, or a part before the limb's bones."""
    limb = handle.limb
    return moved.part not in limb or limb.index(moved.part) < limb.index(handle.movers[0])


def _bending(handle: BodyHandle, held: Held, moved: Moved) -> tuple[str, ...]:
    """The parts that bend to bring this end back; none where it need not stay."""
    is_pinned, is_placed = handle.name in held.pinned, handle.name in held.placed
    if handle.name == moved.end or not (is_pinned or is_placed):
        return ()
    if _is_carried(handle, moved):
        return handle.movers
    if moved.joint and len(handle.movers) > 2:  # the joint itself stays under the pointer
        return handle.movers[handle.movers.index(moved.part) :]
    if moved.joint or (is_pinned and moved.part in handle.movers):
        return handle.movers
    return ()


@dataclass(frozen=True, eq=False)
class _BroughtBack:
    """One limb bent anew, so that its end is where it was before; `bending` are its parts that
    bend."""

    before: GestureContext
    handle: BodyHandle
    bending: tuple[str, ...]
    held: Held
    moved: Moved

    def found(self, after: Pose) -> tuple[Pose, float] | None:
        """The pose, and the metres its end is off; None where it never moved."""
        before, skeleton = self.before, self.before.skeleton
        context = GestureContext.of(skeleton, after, before.limits_on, before.posed)
        part, p_part = context.point(self.handle.anchor)
        place = before.placed(part, p_part)
        last = skeleton.body.index(self.handle.limb[-1])
        if _is_same(before, context, last, place, context.placed(part, p_part)):
            return None
        pose = self._bent(context, place)
        if last not in self._parts:
            pose = _facing_as_before(before, pose, last)
        end = GestureContext.of(skeleton, pose, False).placed(part, p_part)
        return pose, self._missed_m(end, place)

    @property
    def _parts(self) -> tuple[int, ...]:
        return tuple(self.before.skeleton.body.index(name) for name in self.bending)

    def _bent(self, context: GestureContext, place: Array) -> Pose:
        """Where the limb was moved as a whole, it begins as it lay in space, so that elbows
        and knees do not turn with the trunk.
        """
        before, parts = self.before, self._parts
        if _is_carried(self.handle, self.moved):
            R = context.R_camera_parent(parts[0]).T @ before.R_camera_part(parts[0])
            context = GestureContext.of(
                before.skeleton, context.turned({parts[0]: R}), before.limits_on, before.posed
            )
        part, p_part = context.point(self.handle.anchor)
        tip = p_part if part == parts[-1] else before.skeleton.joints[part]
        limb = limb_of(context, parts, tip)
        seen_limb = None
        if isinstance(limb, TwoBones):
            seen_limb = self.held.limb_in_picture(limb, self.handle.name, before)
        if seen_limb is None:
            return context.turned(limb.toward(place).rotations)
        if self._drags(parts[1]):
            return context.pose
        ats = (seen_limb.view.project(p) for p in (before.joint(parts[1]), place))
        return context.turned(seen_limb.with_end(*ats).rotations)

    def _drags(self, part: int) -> bool:
        """Whether the joint of this part is what is dragged."""
        return self.moved.joint and self.before.skeleton.body.index(self.moved.part) == part

    def _missed_m(self, end: Array, place: Array) -> float:
        """How far an end is from its place; in the picture where it stays there."""
        view = self.held.seen
        if view is None or self.handle.name in self.held.pinned:
            return length(end - place)
        return length(view.project(end) - view.project(place)) * view.metres_per_unit(place)


def _is_same(
    before: GestureContext, after: GestureContext, last: int, place: Array, now: Array
) -> bool:
    turned = np.abs(after.R_camera_part(last) - before.R_camera_part(last)).max()
    return bool(max(float(turned), length(now - place)) < _SAME)


def limb_of(context: GestureContext, parts: tuple[int, ...], tip: Array) -> TwoBones | Chain:
    """Parts that follow one another, to be bent; tip: their end, (3,) in the last one's frame."""
    if len(parts) == 2:
        return TwoBones.of(context, *parts, tip)
    return Chain(context, parts, tip)


def _facing_as_before(before: GestureContext, pose: Pose, part: int) -> Pose:
    """The pose with a part turned as it was in space, as far as its limits let it.

    Where what carries it has turned far, less and less: else it would jump from one limit to
    another.
    """
    context = GestureContext.of(before.skeleton, pose, before.limits_on)
    R = pose.Rs_parent_part[part]
    back = log_rotation(R.T @ context.R_camera_parent(part).T @ before.R_camera_part(part))
    share = 1.0 - smooth_step((length(back) - _TURNED_BACK) / (_NOT_BACK - _TURNED_BACK))
    return context.turned({part: context.allowed(part, R @ exp_rotation(share * back))})


def keep_pinned(
    skeleton: Skeleton, before: Pose, after: Pose, pinned: frozenset[str], part: str
) -> Pose:
    """A pose changed by numbers of one part, or of the root's place, with its pinned ends back."""
    context = GestureContext.of(skeleton, before, True)
    return keep_ends(context, after, Held(pinned=pinned), Moved(part)).pose
