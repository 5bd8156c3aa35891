"""Edit the pose at the present frame.

Undo, redo and a walk along the film come back to such a pose, and with it to its corners; a pose
that was changed in another way has none.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from keypose.app.editor import actions as do
from keypose.app.editor.body_edits import with_body
from keypose.app.editor.documents import ActionRefused, posed
from keypose.app.editor.part_edits import WHOLE_BODY, require_correctable, with_limbs_posed
from keypose.app.editor.pinned import pinned_ends
from keypose.app.editor.shown import counts, draft_at, find, poses_beside, shown_pose
from keypose.app.editor.state import EditorState, pointer_views, up_of
from keypose.app.posing import (
    BoxCorner,
    Held,
    PlacedCorner,
    Posed,
    Readout,
    angle_curve_deg,
    angles_deg,
    drag,
    ends_to_hold,
    facing,
    is_twisted,
    keep_pinned,
    part_label,
    placed_ends,
    swap_left_right,
    untwisted_limb,
    with_angles,
    with_reset,
)
from keypose.tracker.body.pose import Pose
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, rotation_from_quaternion
from keypose.tracker.session.schema import Session
from keypose.tracker.solver.depth_turn import depths_m, strays, turned_in_depth, turns_round
from keypose.tracker.storage.results import rotations

REMEMBERED = 100
_SAME = 1e-9


@dataclass(frozen=True, eq=False)
class PosedByCorners:
    """The pose of a frame, seen by a camera, that some corners led to."""

    frame: int
    pose: Pose
    camera: Camera
    corners: tuple[PlacedCorner, ...]


def corners_placed(state: EditorState) -> tuple[PlacedCorner, ...]:
    """Return the corners placed at the present frame, the last one last."""
    readout = state.stroke.readout if state.stroke else None
    if readout is not None:
        return readout.corners
    pose = shown_pose(state).pose if state.posed_by_corners else None
    for one in reversed(state.posed_by_corners):
        if one.frame == state.frame and one.camera == state.doc.camera and _is_same(one.pose, pose):
            return one.corners
    return ()


def with_corners(state: EditorState, corners: tuple[PlacedCorner, ...]) -> EditorState:
    """The same with the present pose known as the one that these corners led to."""
    if not corners:
        return state
    new = PosedByCorners(state.frame, shown_pose(state).pose, state.doc.camera, corners)
    return replace(state, posed_by_corners=(*state.posed_by_corners, new)[-REMEMBERED:])


def _is_same(one: Pose, other: Pose | None) -> bool:
    if other is None or one.Rs_parent_part.shape != other.Rs_parent_part.shape:
        return False
    turned = np.abs(one.Rs_parent_part - other.Rs_parent_part).max()
    return bool(max(turned, np.abs(one.p_camera_root - other.p_camera_root).max()) < _SAME)


AT_REST = (1.0, 0.0, 0.0, 0.0)


def angle_curve(edit: EditorState, index: int) -> Array:
    """(F, 3) degrees of a part by frame, without jumps; NaN where nothing is known."""
    Rs = rotations(edit.fitting, edit.frame_count, index)
    name = edit.doc.body.names[index]
    keys = [keyframe.frame for keyframe in edit.doc.keyframes]
    if poses := (*edit.doc.keyframes, *(d for d in edit.doc.drafts if counts(edit, d))):
        wxyz = [posed.rotations_wxyz.get(name, AT_REST) for posed in poses]
        Rs[[posed.frame for posed in poses]] = rotation_from_quaternion(wxyz)
    known = np.flatnonzero(np.isfinite(Rs[:, 0, 0]))
    angles = np.full((edit.frame_count, 3), np.nan)
    part = edit.doc.body.parts[index]
    angles[known] = angle_curve_deg(part, Rs[known], np.searchsorted(known, keys))
    return angles


def drag_part(
    state: EditorState, before: EditorState, action: do.Drag
) -> tuple[Session, Readout | None]:
    """The document after a gesture that began in `before`."""
    result = _drag(state, before, action)
    if result.body is not None:
        doc = with_body(before, result.body)
        if isinstance(action.handle, BoxCorner):  # which poses the box as well
            doc = with_pose(before.with_doc(doc), result.pose)
        return doc, result.readout
    return with_pose(before, result.pose, partial=action.partial), result.readout


def _of_limbs(before: EditorState, pose: Pose) -> Session:
    """A pose as a part keyframe of the limbs that it moves."""
    require_correctable(before, before.frame)
    doc = with_limbs_posed(before, pose)
    if doc is None:
        raise ActionRefused(WHOLE_BODY)
    return doc


def _drag(state: EditorState, before: EditorState, action: do.Drag) -> Posed:
    looks = state.display
    last = state.stroke.readout if state.stroke else None
    pose = shown_pose(before, state.frame).pose
    return drag(
        before.doc.body,
        pose,
        action,
        pointer_views(before.doc, action.eye),
        limits_on=looks.limits,
        axes_frame=looks.axes,
        linked=looks.link,
        angle_before=last.angle_rad if last else None,
        held=_held(before, state.frame, pose),
        placed_corners=corners_placed(before),
        free_sizes=not _is_posed_elsewhere(before),
    )


def _held(before: EditorState, frame: int, pose: Pose) -> Held:
    """Return what stays while something is dragged, and the poses of the frames beside."""
    doc = before.doc
    return Held(_placed(doc, pose), pinned_ends(doc, frame), beside=poses_beside(before, frame))


def _is_posed_elsewhere(state: EditorState) -> bool:
    """Return whether a pose at another frame was found with the sizes as they are."""
    posed = (*state.doc.keyframes, *state.doc.drafts)
    return any(one.frame != state.frame for one in posed)


def _placed(doc: Session, pose: Pose) -> frozenset[str]:
    """The ends that somebody has put where they are: before the first keyframe, those of limbs
    that were posed; a body that is just being placed moves whole."""
    if doc.keyframes:
        return frozenset(handle.name for handle in ends_to_hold(doc.body))
    return placed_ends(doc.body, pose)


def set_angles(state: EditorState, action: do.Angles) -> Session:
    """One part at given angles."""
    pose = shown_pose(state).pose
    state.doc.body.index(action.part)
    pose = with_angles(
        state.skeleton, pose, action.part, action.x, action.y, action.z,
        limits_on=state.display.limits and not action.free,
    )  # fmt: skip
    return with_pose(state, _with_pinned(state, pose, action.part))


def set_root(state: EditorState, action: do.Root) -> Session:
    """The root at given coordinates."""
    pose = shown_pose(state).pose
    wanted = (action.x, action.y, action.z)
    place = [
        old if new is None else new for old, new in zip(pose.p_camera_root, wanted, strict=True)
    ]
    moved = Pose(pose.Rs_parent_part, np.array(place))
    return with_pose(state, _with_pinned(state, moved, state.doc.body.names[0]))


def _with_pinned(state: EditorState, pose: Pose, part: str) -> Pose:
    """A pose changed by numbers of one part, with what is pinned here back in its place."""
    pinned = pinned_ends(state.doc, state.frame)
    if not pinned:
        return pose
    return keep_pinned(state.skeleton, shown_pose(state).pose, pose, pinned, part)


def set_facing(state: EditorState, action: do.Face) -> Session:
    """The whole body facing a way, where it stands."""
    return with_pose(state, facing(shown_pose(state).pose, action.way, up_of(state.doc)))


def reset_part(state: EditorState, action: do.ResetPart) -> Session:
    """One part at rest."""
    return with_pose(state, with_reset(state.skeleton, shown_pose(state).pose, action.part))


def reset_pose(state: EditorState) -> Session:
    """The whole body at rest, where it stands."""
    rest = Pose.rest(state.skeleton, tuple(shown_pose(state).pose.p_camera_root))
    return with_pose(state, rest)


def swap_sides(state: EditorState) -> Session:
    """Left limbs where the right ones are seen."""
    if not state.doc.body.mirror_pairs:
        raise ActionRefused("This body has no left and right.")
    return with_pose(
        state, swap_left_right(state.skeleton, state.doc.camera, shown_pose(state).pose)
    )


def untwist(state: EditorState, action: do.Untwist) -> Session:
    """A limb turned back about its own length, its joints where they are."""
    pose, part = shown_pose(state).pose, state.doc.body.index(action.part)
    if not is_twisted(state.doc.body.parts[part], pose.Rs_parent_part[part]):
        raise ActionRefused(f"{part_label(action.part)} is not turned too far about its length.")
    return with_pose(state, untwisted_limb(state.skeleton, pose, part))


def copy_key(state: EditorState, action: do.CopyKey) -> Session:
    """The pose of another keyframe, here."""
    found = find(state.doc.keyframes, action.from_frame)
    if found is None:
        raise ActionRefused(f"Frame {action.from_frame} is not a keyframe.")
    return with_pose(state, found.pose(state.skeleton))


def take_tracked(state: EditorState) -> Session:
    """The tracked pose of this frame, as a pose of one's own."""
    pose = state.tracked(state.frame)
    if pose is None:
        raise ActionRefused(f"Frame {state.frame} is not tracked yet. Press T first.")
    return with_pose(state, pose)


def turn_key(state: EditorState, action: do.KeyAngle) -> Session:
    """One angle of a part at some keyframe."""
    found = find(state.doc.keyframes, action.frame)
    if found is None:
        raise ActionRefused(f"Frame {action.frame} is not a keyframe.")
    wanted = {action.axis: action.deg}
    shown_deg = angle_curve(state, state.doc.body.index(action.part))[action.frame]
    pose = with_angles(
        state.skeleton, found.pose(state.skeleton), action.part,
        wanted.get("x"), wanted.get("y"), wanted.get("z"), near_deg=shown_deg,
    )  # fmt: skip
    return posed(state.doc, state.skeleton, pose, action.frame, state.times_s)


def angles_at(state: EditorState, pose: Pose) -> dict[str, list[float]]:
    """Every part's [x, y, z] in degrees."""
    values = angles_deg(state.skeleton, pose).round(3).tolist()
    return dict(zip(state.doc.body.names, values, strict=True))


def with_pose(state: EditorState, pose: Pose, *, partial: bool = False) -> Session:
    """Set a pose as the keyframe of the present frame, or its part keyframe, where it has one and
    no more than limbs moved; else as a draft. partial: as a part keyframe of the limbs that it
    moves.
    """
    if partial:
        return _of_limbs(state, pose)
    is_part = find(state.doc.part_keyframes, state.frame) is not None
    if is_part and draft_at(state, state.frame) is None:
        doc = with_limbs_posed(state, pose)
        if doc is not None:
            return doc
    return posed(state.doc, state.skeleton, pose, state.frame, state.times_s)


LEAST_M = 0.02
"""A limb whose joints lie no farther apart in depth looks the same either way."""
MOST_STRAY = 0.06
"""Share of the body's height by which a joint may leave its place in the picture."""


def turn_in_depth(state: EditorState, action: do.TurnInDepth) -> Session:
    """The part and what hangs on it, or the whole body, the other way round in depth."""
    skeleton, pose = state.skeleton, shown_pose(state).pose
    top = 0 if action.part is None else state.doc.body.index(action.part)
    name = "The body" if top == 0 else part_label(skeleton.body.names[top])
    if np.ptp(depths_m(skeleton, pose, top)) < LEAST_M:
        raise ActionRefused(f"{name} lies across the view: it looks the same either way.")
    camera = state.doc.camera
    turned = turned_in_depth(skeleton, camera, pose, top)
    leaves = top != 0 and strays(skeleton, camera, pose, turned, top) > MOST_STRAY
    if leaves or not turns_round(skeleton, pose, turned, top):
        raise ActionRefused(f"{name} cannot bend the other way. Turn a part further out alone.")
    return with_pose(state, turned, partial=action.partial)
