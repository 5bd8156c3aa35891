"""The pose at a frame: set by a person, tracked, or the best that is known so far."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np

from keypose.app.editor.documents import ActionRefused, Posed
from keypose.app.editor.state import EditorState
from keypose.app.posing.carrying import placed
from keypose.tracker.body.body import Body
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.geometry.rotations import Array, rotation_between
from keypose.tracker.review.places import drafts_to_confirm
from keypose.tracker.session.annotations import DraftPlace
from keypose.tracker.session.bonds import BondEnd
from keypose.tracker.session.keyframe import Keyframe

Source: TypeAlias = Literal["keyframe", "draft", "tracked", "part", "between", "held", "rest"]


@dataclass(frozen=True, eq=False)
class ShownPose:
    """A pose and where it comes from.

    "part" is as a part keyframe was set, "between" is interpolated, "held" is the nearest
    keyframe's, "rest" the initial pose.
    """

    pose: Pose
    source: Source


def shown_pose(state: EditorState, frame: int | None = None) -> ShownPose:
    """The pose shown at a frame, by default the present one."""
    frame = state.frame if frame is None else frame
    posed = posed_at(state, frame)
    if posed is not None:
        return posed
    return pose_behind(state, frame)


def pose_behind(state: EditorState, frame: int) -> ShownPose:
    """The pose of a frame as it would be shown had nobody posed the whole body there."""
    return _followed(state, frame) or _from_neighbours(state, frame)


def poses_beside(state: EditorState, frame: int) -> tuple[Pose, ...]:
    """The poses of the frames before and after, as far as these have poses of their own."""
    inside = (f for f in (frame - 1, frame + 1) if 0 <= f < state.frame_count)
    own = (posed_at(state, f) or _followed(state, f) for f in inside)
    return tuple(each.pose for each in own if each is not None)


def _followed(state: EditorState, frame: int) -> ShownPose | None:
    """The pose as it was tracked, or as limbs of it were set."""
    tracked = state.tracked(frame)
    if tracked is not None:
        return ShownPose(tracked, "tracked")
    parts = find(state.doc.subject.part_keyframes, frame)
    return None if parts is None else ShownPose(parts.pose(state.skeleton), "part")


def posed_at(state: EditorState, frame: int) -> ShownPose | None:
    """What a person posed at a frame: a draft before the keyframe it would replace."""
    draft, keyframe = draft_at(state, frame), find(state.doc.subject.keyframes, frame)
    if draft is not None:
        return ShownPose(draft.pose(state.skeleton), "draft")
    return None if keyframe is None else ShownPose(_keypose(state, keyframe), "keyframe")


def _keypose(state: EditorState, keyframe: Keyframe) -> Pose:
    """The pose at a keyframe: a soft one is shown as the motion passes it."""
    passed = None if is_met(state, keyframe) else state.tracked(keyframe.frame)
    return keyframe.pose(state.skeleton) if passed is None else passed


def draft_at(state: EditorState, frame: int) -> Keyframe | None:
    """The draft that counts at a frame."""
    draft = find(state.doc.subject.drafts, frame)
    return None if draft is None or not counts(state, draft) else draft


def counts(state: EditorState, draft: Keyframe) -> bool:
    """Whether a draft is the pose of its frame: one that was found in the film gives way to
    what is tracked there by now.
    """
    return not draft.is_found or state.tracked(draft.frame) is None


def places_to_confirm(state: EditorState) -> list[DraftPlace]:
    """Where a person should say whether the draft is right, by frame."""
    if state.doc.subject.drafted is None:
        return []
    waiting = {draft.frame for draft in state.doc.subject.drafts if counts(state, draft)}
    frames = waiting.intersection(drafts_to_confirm(state.doc))
    return [place for place in state.doc.subject.drafted.places if place.frame in frames]


def is_met(state: EditorState, keyframe: Keyframe) -> bool:
    """Whether the motion is, at a keyframe, as that was posed: past a soft one it goes as it
    was solved for.
    """
    return not keyframe.soft or state.tracked(keyframe.frame) is None


def ghosts(state: EditorState) -> list[tuple[int, Pose]]:
    """The poses of the keyframes before and after the present frame, by frame; and at a soft one,
    which the motion does not pass as it was posed, its own."""
    before = [key for key in state.keys if key < state.frame][-1:]
    after = [key for key in state.keys if key > state.frame][:1]
    here = find(state.settled.subject.keyframes, state.frame)
    own = [] if here is None or is_met(state, here) else [state.frame]
    neighbours = (
        (frame, find(state.settled.subject.keyframes, frame)) for frame in (*before, *after, *own)
    )
    return [(frame, key.pose(state.skeleton)) for frame, key in neighbours if key is not None]


def ghost_transforms(state: EditorState, frame: int, pose: Pose) -> Array:
    """Ts_camera_part (P, 4, 4) of a pose of another frame, as the camera sees it at the present
    one."""
    Ts = pose_transforms(state.skeleton, pose)
    return np.asarray(state.doc.film_camera.parts_seen_at(state.frame, Ts[None], [frame])[0])


def transforms_beside(state: EditorState) -> dict[str, Array]:
    """Ts_camera_part (P, 4, 4) at the present frame of each body that is not posed, by its id; what
    is held goes along while a gesture is under way."""
    if state.doc.bonds:
        state = replace(state, stroke=None)
    beside = [body.id for body in state.doc.bodies if body.id != state.doc.subject.id]
    alone = {body_id: state.about(body_id) for body_id in beside}
    return {
        body_id: pose_transforms(each.skeleton, shown_pose(each).pose)
        for body_id, each in alone.items()
    }


def bodies_beside(state: EditorState) -> list[tuple[int, Body, Array]]:
    """Each body that is not posed: its place among all, itself, and `transforms_beside`."""
    Ts_of_body = transforms_beside(state)
    return [
        (place, body.body, Ts_of_body[body.id])
        for place, body in enumerate(state.doc.bodies)
        if body.id in Ts_of_body
    ]


def find(poses: tuple[Posed, ...], frame: int) -> Posed | None:
    """The one at this frame."""
    return next((pose for pose in poses if pose.frame == frame), None)


def require_keyframe(state: EditorState, frame: int) -> Keyframe:
    """The keyframe at a frame; refused where there is none."""
    keyframe = find(state.doc.subject.keyframes, frame)
    if keyframe is None:
        raise ActionRefused(f"Frame {frame} is not a keyframe.")
    return keyframe


def part_at(state: EditorState, part: str, frame: int) -> Array:
    """(4, 4) where a part is shown at a frame, camera frame."""
    Ts = pose_transforms(state.skeleton, shown_pose(state, frame).pose)
    return np.asarray(Ts[state.doc.subject.body.index(part)])


def end_at(state: EditorState, end: BondEnd, frame: int) -> Array:
    """(3,) where an end of a bond on the posed body is shown at a frame, camera frame."""
    return placed(part_at(state, end.part, frame), np.array(end.point_m))


def _from_neighbours(state: EditorState, frame: int) -> ShownPose:
    keyframes = state.doc.subject.keyframes or state.doc.subject.drafts
    if not keyframes:
        return ShownPose(state.opening, "rest")
    place = bisect_right([keyframe.frame for keyframe in keyframes], frame)
    film_camera = state.doc.film_camera
    if place == 0 or place == len(keyframes):
        nearest = keyframes[min(place, len(keyframes) - 1)]
        held = film_camera.pose_seen_at(frame, nearest.frame, nearest.pose(state.skeleton))
        return ShownPose(held, "held")
    before, after = keyframes[place - 1], keyframes[place]
    here = np.array([frame])
    motion = None
    if state.own_motion is not None:
        motion = state.between(state.doc, before.frame, after.frame, here)
    if motion is not None:
        return ShownPose(Pose(motion[0][0], motion[1][0]), "between")
    share = (frame - before.frame) / (after.frame - before.frame)
    start, end = (
        film_camera.pose_seen_at(frame, k.frame, k.pose(state.skeleton)) for k in (before, after)
    )
    return ShownPose(_mixed(start, end, share), "between")


def _mixed(start: Pose, end: Pose, share: float) -> Pose:
    """One frame of tracker.body.trajectory.interpolate."""
    Rs = rotation_between(start.Rs_parent_part, end.Rs_parent_part, np.array([share]))[0]
    return Pose(Rs, (1 - share) * start.p_camera_root + share * end.p_camera_root)
