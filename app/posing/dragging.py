"""What a gesture makes of a pose: the one entry point of all drags."""

from __future__ import annotations

from collections.abc import Mapping

from app.posing.gesture import (
    AxesFrame,
    End,
    Gesture,
    Middle,
    Posed,
    Ring,
    Root,
    SizeHandle,
    Surface,
)
from app.posing.gesture_context import GestureContext
from app.posing.handles import handle_at_far_end, handle_named
from app.posing.moving import move_root
from app.posing.pointer_view import PointerView
from app.posing.reaching import reach
from app.posing.size_drags import resize_by_drag
from app.posing.turning import rotate_by_ring, rotate_by_surface
from tracker.body.body import Body
from tracker.body.pose import Pose
from tracker.body.skeleton import Skeleton


def drag(
    body: Body,
    pose_before: Pose,
    gesture: Gesture,
    sights: Mapping[str, PointerView],
    *,
    limits_on: bool = True,
    axes_frame: AxesFrame = "part",
    linked: bool = True,
    angle_before: float | None = None,
) -> Posed:
    """The pose, or the body, that a gesture makes of the pose before it.

    sights: the four views by name.  limits_on: joint limits count, unless the gesture is free.
    axes_frame: whose axes the rings turn about.  linked: sizes of both sides change together.
    angle_before: the readout's angle_rad after the move before this one, if there was one.
    BodyError when the body has no such part, handle or size.
    """
    skeleton = Skeleton.of(body)
    context = GestureContext.of(skeleton, pose_before, limits_on and not gesture.free)
    view, handle = sights[gesture.view], gesture.handle
    match handle:
        case Ring():
            part = body.index(handle.part)
            return rotate_by_ring(
                context, view, gesture, part, handle.axis, axes_frame, angle_before
            )
        case Root():
            return move_root(context, view, gesture)
        case End() | Middle():
            found = handle_named(body, handle.name)
            if found.kind == "root":
                return move_root(context, view, gesture)
            return reach(context, view, gesture, found)
        case Surface():
            return _by_surface(context, view, gesture, handle, axes_frame, angle_before)
        case SizeHandle():
            return resize_by_drag(context, view, gesture, handle, linked)


def _by_surface(
    context: GestureContext,
    view: PointerView,
    gesture: Gesture,
    handle: Surface,
    axes_frame: AxesFrame,
    angle_before: float | None,
) -> Posed:
    """A part taken by its surface: what the tool in hand does with it."""
    body = context.skeleton.body
    part = body.index(handle.part)
    tool = handle.tool or gesture.tool
    if tool == "move":
        return move_root(context, view, gesture)
    if tool == "ends":
        if part == 0:
            return move_root(context, view, gesture)
        found = handle_at_far_end(body, handle.part)
        if found is not None:
            return reach(context, view, gesture, found)
    return rotate_by_surface(context, view, gesture, part, axes_frame, angle_before)
