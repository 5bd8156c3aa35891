"""What a gesture makes of a pose: the one entry point of all drags."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from keypose.app.posing.box_corners import drag_box_corner
from keypose.app.posing.gesture import (
    AxesFrame,
    BoxCorner,
    End,
    Gesture,
    GestureContext,
    Middle,
    PlacedCorner,
    Posed,
    Ring,
    Root,
    SizeHandle,
    Surface,
)
from keypose.app.posing.handles import BodyHandle, handle_at_far_end, handle_named
from keypose.app.posing.holding import NONE_HELD, Held, Moved, with_held_ends
from keypose.app.posing.moving import move_root
from keypose.app.posing.pointer_view import PointerView
from keypose.app.posing.reaching import reach
from keypose.app.posing.resizing import resize_by_drag
from keypose.app.posing.trunk import drag_corner
from keypose.app.posing.turning import rotate_by_ring, rotate_by_surface
from keypose.tracker.body.body import Body
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import BodyError, readable


def drag(
    body: Body,
    pose_before: Pose,
    gesture: Gesture,
    views: Mapping[str, PointerView],
    *,
    limits_on: bool = True,
    axes_frame: AxesFrame = "part",
    linked: bool = True,
    angle_before: float | None = None,
    held: Held = NONE_HELD,
    placed_corners: tuple[PlacedCorner, ...] = (),
    free_sizes: bool = False,
) -> Posed:
    """The pose, or the body, that a gesture makes of the pose before it.

    views: the four views by name.  limits_on: joint limits count, unless the gesture is free.
    axes_frame: whose axes the rings turn about.  linked: sizes of both sides change together.
    angle_before: the readout's angle_rad after the move before this one, if there was one.
    held: the ends that stay where they are.  placed_corners: those of boxes that stay.
    free_sizes: a box whose corners ask for them gets other sizes.
    BodyError when the body has no such part, handle or size, or the view does not show it.
    """
    skeleton = Skeleton.of(body)
    context = GestureContext.of(skeleton, pose_before, limits_on and not gesture.free)
    view, handle = views[gesture.view], gesture.handle
    _require_seen(context, view, gesture)
    if isinstance(handle, SizeHandle):
        return resize_by_drag(context, view, gesture, handle, linked)
    if isinstance(handle, BoxCorner):
        posed = drag_box_corner(context, view, gesture, handle, placed_corners, free_sizes)
        kept = _held(held, view, gesture, handle.part)
        return with_held_ends(context, posed, kept, Moved(handle.part))
    taken = _taken(body, gesture, handle)
    held = _held(held, view, gesture, taken)
    if isinstance(taken, BodyHandle):
        return _by_handle(context, view, gesture, taken, held)
    part = body.index(taken)
    if isinstance(handle, Ring):
        turned = rotate_by_ring(context, view, gesture, part, handle.axis, axes_frame, angle_before)
    else:
        turned = rotate_by_surface(context, view, gesture, part, axes_frame, angle_before)
    return with_held_ends(context, turned, held, Moved(taken))


def _require_seen(context: GestureContext, view: PointerView, gesture: Gesture) -> None:
    """BodyError where the joint that is dragged lies behind the eye: no pointer is over it."""
    body, handle = context.skeleton.body, gesture.handle
    if isinstance(handle, SizeHandle | BoxCorner):
        taken: BodyHandle | str = handle.part
    else:
        taken = _taken(body, gesture, handle)
    name = taken.anchor if isinstance(taken, BodyHandle) else body.names[body.index(taken)]
    if not np.isfinite(view.project(context.placed(*context.point(name)))).all():
        raise BodyError(f"The {readable(name)} lies behind this view: orbit or zoom out first.")


def _held(held: Held, view: PointerView, gesture: Gesture, taken: BodyHandle | str) -> Held:
    """What stays in a gesture, and whether in the picture or in space.

    A drag along the picture says nothing of depth; that of the whole body in depth, only how large
    it is seen.
    """
    carried = isinstance(taken, BodyHandle) and taken.kind == "root"
    in_picture = view.is_films and gesture.axis is None and (carried or not gesture.depth)
    placed = frozenset[str]() if gesture.carry else held.placed
    return replace(held, placed=placed, seen=view if in_picture else None)


def _taken(
    body: Body, gesture: Gesture, handle: Ring | Root | End | Middle | Surface
) -> BodyHandle | str:
    """The handle that a gesture drags, or the part that it turns.

    A part taken by its surface: the tool in hand says which of them.
    """
    match handle:
        case Ring():
            return handle.part
        case Root():
            return handle_named(body, "root")
        case End() | Middle():
            return handle_named(body, handle.name)
        case Surface():
            tool = handle.tool or gesture.tool
            if tool == "move" or (tool == "ends" and body.index(handle.part) == 0):
                return handle_named(body, "root")
            body_handle = handle_at_far_end(body, handle.part) if tool == "ends" else None
            return body_handle or handle.part


def _by_handle(
    context: GestureContext, view: PointerView, gesture: Gesture, handle: BodyHandle, held: Held
) -> Posed:
    """The root carried, the trunk posed by one of its corners, or a limb pulled."""
    if handle.kind == "corner":
        posed = drag_corner(context, view, gesture, handle)
        return with_held_ends(context, posed, held, Moved(handle.movers[0]))
    if handle.kind == "root":
        return with_held_ends(context, move_root(context, view, gesture), held, Moved(handle.part))
    posed = reach(context, view, gesture, handle, held)
    end = handle.name if handle.kind == "end" else None
    return with_held_ends(context, posed, held, Moved(handle.part, handle.kind == "middle", end))
