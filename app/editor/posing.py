"""Edit the pose at the present frame.

Undo, redo and a walk along the film come back to such a pose, and with it to its corners; a pose
that was changed in another way has none.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np

from keypose.app.editor.body import with_body
from keypose.app.editor.documents import ActionRefused, posed
from keypose.app.editor.frames import pointer_views, up_of
from keypose.app.editor.message import Degrees, Edit
from keypose.app.editor.part_keyframes import WHOLE_BODY, require_correctable, with_limbs_posed
from keypose.app.editor.pinned import pinned_ends
from keypose.app.editor.shown import draft_at, find, poses_beside, require_keyframe, shown_pose
from keypose.app.editor.state import EditorState, PosedByCorners
from keypose.app.posing import (
    BoxCorner,
    Gesture,
    Held,
    PlacedCorner,
    Posed,
    Readout,
    Way,
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
from keypose.app.posing.gesture import Metres, Surface
from keypose.tracker.body.body import Name
from keypose.tracker.body.pose import Pose
from keypose.tracker.session.keyframe import Softness
from keypose.tracker.session.schema import Session
from keypose.tracker.session.settings import FrameIndex
from keypose.tracker.solver.depth_turn import depths_m, strays, turned_in_depth, turns_round

REMEMBERED = 100
_SAME = 1e-9
"""Entries of rotations, and metres: a pose that differs by less is the same."""


def corners_placed(state: EditorState) -> tuple[PlacedCorner, ...]:
    """The corners placed at the present frame, the last one last."""
    readout = state.stroke.readout if state.stroke else None
    if readout is not None:
        return readout.corners
    pose = shown_pose(state).pose if state.posed_by_corners else None
    for placed in reversed(state.posed_by_corners):
        at_present = placed.frame == state.frame and placed.camera == state.camera
        if at_present and _is_same(placed.pose, pose):
            return placed.corners
    return ()


def with_corners(state: EditorState, corners: tuple[PlacedCorner, ...]) -> EditorState:
    """The same with the present pose known as the one that these corners led to."""
    if not corners:
        return state
    new = PosedByCorners(state.frame, shown_pose(state).pose, state.camera, corners)
    return replace(state, posed_by_corners=(*state.posed_by_corners, new)[-REMEMBERED:])


def _is_same(pose: Pose, other: Pose | None) -> bool:
    if other is None or pose.Rs_parent_part.shape != other.Rs_parent_part.shape:
        return False
    turned = np.abs(pose.Rs_parent_part - other.Rs_parent_part).max()
    return bool(max(turned, np.abs(pose.p_camera_root - other.p_camera_root).max()) < _SAME)


class Drag(Edit, Gesture):
    """partial: the limbs it moves become a part keyframe of the present frame."""

    do: Literal["drag"] = "drag"
    partial: bool = False

    def apply(self, state: EditorState) -> Session:
        return self.change(state, state)[0]

    def change(self, state: EditorState, before: EditorState) -> tuple[Session, Readout | None]:
        result = self._dragged(state, before)
        if result.body is not None:
            doc = with_body(before, result.body)
            if isinstance(self.handle, BoxCorner):  # which poses the box as well
                doc = with_pose(before.with_doc(doc), result.pose)
            return doc, result.readout
        in_picture = self.view == "main" and not self.depth
        doc = with_pose(before, result.pose, partial=self.partial, in_picture=in_picture)
        return doc, result.readout

    def _dragged(self, state: EditorState, before: EditorState) -> Posed:
        looks = state.display
        last = state.stroke.readout if state.stroke else None
        pose = shown_pose(before, state.frame).pose
        return drag(
            before.doc.subject.body,
            pose,
            self,
            pointer_views(before.doc, before.frame, self.eye, self.film),
            limits_on=looks.limits,
            axes_frame=looks.axes,
            linked=looks.link,
            angle_before=last.angle_rad if last else None,
            held=_held(before, state.frame, pose),
            placed_corners=corners_placed(before),
            free_sizes=not _is_posed_elsewhere(before),
        )

    def label(self, state: EditorState) -> str:
        handle = self.handle
        if isinstance(handle, Surface) and (handle.tool or self.tool) == "move":
            return "move the body"
        verbs = {"ring": "turn", "root": "move the body", "size": "resize", "surface": "turn"}
        if handle.kind == "box_corner":
            return f"move a corner of {part_label(handle.part).lower()}"
        verb = verbs.get(handle.kind, "move")
        name = getattr(handle, "part", None) or getattr(handle, "name", None)
        return verb if name is None else f"{verb} {part_label(name).lower()}"


def _held(before: EditorState, frame: int, pose: Pose) -> Held:
    """What stays while something is dragged, and the poses of the frames beside."""
    doc = before.doc
    return Held(_placed(doc, pose), pinned_ends(doc, frame), beside=poses_beside(before, frame))


def _is_posed_elsewhere(state: EditorState) -> bool:
    """Whether a pose at another frame was found with the sizes as they are."""
    posed = (*state.doc.subject.keyframes, *state.doc.subject.drafts)
    return any(keyframe.frame != state.frame for keyframe in posed)


def _placed(doc: Session, pose: Pose) -> frozenset[str]:
    """The ends that somebody has put where they are: before the first keyframe, those of limbs
    that were posed; a body that is just being placed moves whole."""
    if doc.subject.keyframes:
        return frozenset(handle.name for handle in ends_to_hold(doc.subject.body))
    return placed_ends(doc.subject.body, pose)


class Angles(Edit):
    """Some angles of a part; `free` where its joint limits have been lifted."""

    do: Literal["angles"] = "angles"
    verb = "turn"
    target = "part"
    part: Name
    free: bool = False
    x: Degrees | None = None
    y: Degrees | None = None
    z: Degrees | None = None

    def apply(self, state: EditorState) -> Session:
        state.doc.subject.body.index(self.part)
        pose = with_angles(
            state.skeleton,
            shown_pose(state).pose,
            self.part,
            self.x,
            self.y,
            self.z,
            limits_on=state.display.limits and not self.free,
            up_camera=up_of(state.doc, state.frame),
        )
        return with_pose(state, _with_pinned(state, pose, self.part))


class Root(Edit):
    do: Literal["root"] = "root"
    verb = "move the body"
    x: Metres | None = None
    y: Metres | None = None
    z: Metres | None = None

    def apply(self, state: EditorState) -> Session:
        pose, wanted = shown_pose(state).pose, (self.x, self.y, self.z)
        place = [
            old if new is None else new for old, new in zip(pose.p_camera_root, wanted, strict=True)
        ]
        moved = Pose(pose.Rs_parent_part, np.array(place))
        pose = _with_pinned(state, moved, state.doc.subject.body.names[0])
        return with_pose(state, pose, in_picture=self.z is None)


def _with_pinned(state: EditorState, pose: Pose, part: str) -> Pose:
    """A pose changed by numbers of one part, with what is pinned here back in its place."""
    pinned = pinned_ends(state.doc, state.frame)
    if not pinned:
        return pose
    return keep_pinned(state.skeleton, shown_pose(state).pose, pose, pinned, part)


class Face(Edit):
    """The whole body turned about what is up, to face a way as seen in the picture."""

    do: Literal["face"] = "face"
    verb = "turn the body"
    way: Way

    def apply(self, state: EditorState) -> Session:
        return with_pose(
            state, facing(shown_pose(state).pose, self.way, up_of(state.doc, state.frame))
        )


class ResetPart(Edit):
    do: Literal["reset_part"] = "reset_part"
    verb = "reset"
    target = "part"
    part: Name

    def apply(self, state: EditorState) -> Session:
        return with_pose(state, with_reset(state.skeleton, shown_pose(state).pose, self.part))


class ResetPose(Edit):
    """The whole body at rest, where it stands."""

    do: Literal["reset_pose"] = "reset_pose"
    verb = "reset the pose"

    def apply(self, state: EditorState) -> Session:
        rest = Pose.rest(state.skeleton, tuple(shown_pose(state).pose.p_camera_root))
        return with_pose(state, rest)


class Exchange(Edit):
    """Left and right exchanged, where they are seen."""

    do: Literal["exchange"] = "exchange"
    verb = "swap left and right"

    def apply(self, state: EditorState) -> Session:
        if not state.doc.subject.body.mirror_pairs:
            raise ActionRefused("This body has no left and right.")
        swapped = swap_left_right(state.skeleton, state.camera, shown_pose(state).pose)
        return with_pose(state, swapped)


LEAST_M = 0.02
"""A limb whose joints lie no farther apart in depth looks the same either way."""
MOST_STRAY = 0.06
"""Share of the body's height by which a joint may leave its place in the picture."""


class TurnInDepth(Edit):
    """What points toward the camera points away from it, seen where it was: of a part and what
    hangs on it, or of the whole body. partial: as of `Drag`."""

    do: Literal["turn_in_depth"] = "turn_in_depth"
    verb = "turn in depth"
    target = "part"
    part: Name | None = None
    partial: bool = False

    def apply(self, state: EditorState) -> Session:
        skeleton, pose = state.skeleton, shown_pose(state).pose
        top = 0 if self.part is None else state.doc.subject.body.index(self.part)
        name = "The body" if top == 0 else part_label(skeleton.body.names[top])
        if np.ptp(depths_m(skeleton, pose, top)) < LEAST_M:
            raise ActionRefused(f"{name} lies across the view: it looks the same either way.")
        camera = state.camera
        turned = turned_in_depth(skeleton, camera, pose, top)
        leaves = top != 0 and strays(skeleton, camera, pose, turned, top) > MOST_STRAY
        if leaves or not turns_round(skeleton, pose, turned, top):
            raise ActionRefused(f"{name} cannot bend the other way. Turn a part further out alone.")
        return with_pose(state, turned, partial=self.partial)


class Untwist(Edit):
    """A limb turned back about its own length, its elbow and, as near as it can be, its hand where
    they are."""

    do: Literal["untwist"] = "untwist"
    verb = "untwist"
    target = "part"
    part: Name

    def apply(self, state: EditorState) -> Session:
        pose, part = shown_pose(state).pose, state.doc.subject.body.index(self.part)
        if not is_twisted(state.doc.subject.body.parts[part], pose.Rs_parent_part[part]):
            raise ActionRefused(f"{part_label(self.part)} is not turned too far about its length.")
        return with_pose(state, untwisted_limb(state.skeleton, pose, part))


class CopyKey(Edit):
    """The pose of another keyframe, here, where it stands in the world."""

    do: Literal["copy_key"] = "copy_key"
    verb = "copy keyframe"
    target = "from_frame"
    from_frame: FrameIndex

    def apply(self, state: EditorState) -> Session:
        pose = require_keyframe(state, self.from_frame).pose(state.skeleton)
        film_camera = state.doc.film_camera
        return with_pose(state, film_camera.pose_seen_at(state.frame, self.from_frame, pose))


class TakeTracked(Edit):
    """The tracked pose of this frame, as a pose of one's own."""

    do: Literal["take_tracked"] = "take_tracked"
    verb = "use the tracked pose"

    def apply(self, state: EditorState) -> Session:
        pose = state.tracked(state.frame)
        if pose is None:
            raise ActionRefused(f"Frame {state.frame} is not tracked yet. Press T first.")
        return with_pose(state, pose)


MESSAGES = (
    Drag,
    Angles,
    Root,
    Face,
    ResetPart,
    ResetPose,
    Exchange,
    TurnInDepth,
    Untwist,
    CopyKey,
    TakeTracked,
)


def with_pose(
    state: EditorState, pose: Pose, *, partial: bool = False, in_picture: bool = True
) -> Session:
    """Set a pose as the keyframe of the present frame, or its part keyframe, where it has one and
    no more than limbs moved; else as a draft. partial: as a part keyframe of the limbs that it
    moves. in_picture: whether somebody has posed it by the picture, not by its depth.
    """
    if partial:
        return _of_limbs(state, pose)
    is_part = find(state.doc.subject.part_keyframes, state.frame) is not None
    if is_part and draft_at(state, state.frame) is None:
        doc = with_limbs_posed(state, pose)
        if doc is not None:
            return doc
    soft = _softness(state, state.frame, in_picture)
    return posed(state.doc, state.skeleton, pose, state.frame, state.times_s, soft)


def _softness(state: EditorState, frame: int, in_picture: bool) -> Softness:
    """How soft a pose is that is set at a frame: one found in the film, or softened, and put
    right in the picture alone stays soft in depth.
    """
    keyframe, draft = find(state.doc.subject.keyframes, frame), draft_at(state, frame)
    posed_here = draft or keyframe
    if posed_here is None:
        was = bool(state.tracked(frame) and state.doc.settings.smooth)
    else:
        was = bool(posed_here.is_found or posed_here.soft)
    return "depth" if was and in_picture else False


def _of_limbs(before: EditorState, pose: Pose) -> Session:
    """A pose as a part keyframe of the limbs that it moves."""
    require_correctable(before, before.frame)
    doc = with_limbs_posed(before, pose)
    if doc is None:
        raise ActionRefused(WHOLE_BODY)
    return doc


def pose_to_fit(state: EditorState) -> Pose:
    """The pose shown at the present frame; Refused where nothing has been posed yet.

    A surface can also be fitted from the pose in which the session opens.
    """
    if state.doc.evidence.is_posed_first and not (
        state.doc.subject.keyframes or state.doc.subject.drafts
    ):
        raise ActionRefused("Pose the body roughly first.")
    return shown_pose(state).pose


def with_pose_fitted(state: EditorState, frame: int, pose: Pose) -> EditorState:
    """Set this pose at a frame, as one step."""
    soft = _softness(state, frame, in_picture=True)
    doc = posed(state.doc, state.skeleton, pose, frame, state.times_s, soft)
    return state.with_step(doc, "fit the pose", frame)
