"""Give the motion as it is known: every frame, the path and the angles of a part, the feet."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from keypose.app.editor.frames import (
    up_of,
)
from keypose.app.editor.live import at_hand
from keypose.app.editor.shown import counts, find, is_met, shown_pose
from keypose.app.editor.state import EditorState
from keypose.app.posing import angle_curve_deg, angles_deg, handles
from keypose.tracker.body.body import Body
from keypose.tracker.body.ground import floor_height, lowest_heights
from keypose.tracker.body.limb_groups import kind_of
from keypose.tracker.body.pose import (
    Pose,
    joint_names,
    joint_positions,
    part_transforms,
    pose_transforms,
)
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array, apply_transform, rotation_from_quaternion
from keypose.tracker.session.keyframe import Keyframe
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.results import rotations


@dataclass(frozen=True, eq=False)
class MotionInWorld:
    """frames: (N,) ascending.  Ts_world_part: (N, P, 4, 4) of the settled document's body."""

    frames: NDArray[np.int64]
    Ts_world_part: Array


def settled_skeleton(edit: EditorState) -> Skeleton:
    """The layout of the body without the gesture under way."""
    doc = edit.settled
    return (
        edit.skeleton
        if doc.subject.body is edit.doc.subject.body
        else Skeleton.of(doc.subject.body)
    )


def motion_between(edit: EditorState, first: int, last: int, stride: int = 1) -> MotionInWorld:
    """The motion from first to last, both inside the segments: every stride-th frame, and
    the keyframes.

    Of the document without the gesture under way, which outdates what was tracked only when it
    ends. Where somebody posed the body, it stands as posed.
    """
    doc, skeleton = edit.settled, settled_skeleton(edit)
    keys = [k.frame for k in doc.subject.keyframes if first <= k.frame <= last]
    frames = np.union1d(np.arange(first, last + 1, stride), np.array(keys, dtype=np.int64))
    motions = list(_motions(edit, frames))
    Rs, ps = (np.concatenate(arrays) for arrays in zip(*motions, strict=True))
    row_of = {frame: row for row, frame in enumerate(frames.tolist())}
    for posed in _met_poses(edit, doc):
        row = row_of.get(posed.frame)
        if row is not None:
            pose = posed.pose(skeleton)
            Rs[row], ps[row] = pose.Rs_parent_part, pose.p_camera_root
    Ts = part_transforms(skeleton, Rs, ps)
    return MotionInWorld(frames, doc.film_camera.parts_to_world(Ts, frames))


def _met_poses(edit: EditorState, doc: Session) -> Iterator[Keyframe]:
    """The keyframes and drafts that the motion meets."""
    yield from (keyframe for keyframe in doc.subject.keyframes if is_met(edit, keyframe))
    yield from (draft for draft in doc.subject.drafts if counts(edit, draft))


def known_motion(edit: EditorState, most: int) -> MotionInWorld | None:
    """All that is known of the motion, thinned to about `most` moments; None without any: the
    frames of the segments, and those outside of them that are posed."""
    doc = edit.settled
    ends = [frame for span in doc.spans for frame in span]
    inside = None
    if ends:
        first, last = min(ends), max(ends)
        inside = motion_between(edit, first, last, 1 + (last - first) // most)
    outside = {
        posed.frame: posed
        for posed in (*doc.subject.keyframes, *doc.subject.drafts)
        if not ends or not first <= posed.frame <= last
    }
    frames = sorted(outside)[:: 1 + len(outside) // most]
    return _with_posed(edit, inside, [outside[frame] for frame in frames])


def _with_posed(
    edit: EditorState, motion: MotionInWorld | None, posed: list[Keyframe]
) -> MotionInWorld | None:
    """A motion and poses at other frames, by frame."""
    if not posed:
        return motion
    skeleton = settled_skeleton(edit)
    poses = [each.pose(skeleton) for each in posed]
    Rs = np.stack([pose.Rs_parent_part for pose in poses])
    ps = np.stack([pose.p_camera_root for pose in poses])
    frames, Ts = np.array([each.frame for each in posed]), part_transforms(skeleton, Rs, ps)
    Ts = edit.settled.film_camera.parts_to_world(Ts, frames)
    if motion is not None:
        frames = np.append(frames, motion.frames)
        Ts = np.concatenate([Ts, motion.Ts_world_part])
    order = np.argsort(frames)
    return MotionInWorld(frames[order], Ts[order])


def _motions(edit: EditorState, frames: NDArray[np.int64]) -> Iterator[tuple[Array, Array]]:
    """Rotations and positions at ascending frames, segment by segment, tracked or interpolated."""
    doc, done = edit.settled, 0
    fitting = edit.fitting if doc is edit.doc else edit.results.fitting(doc)
    for start, end in doc.spans:
        stop = int(np.searchsorted(frames, end, side="right"))
        wanted, done = frames[done:stop], stop
        if len(wanted) == 0:
            continue
        segment_result = fitting.get((start, end))
        if segment_result is None:
            yield _untracked(edit, start, end, wanted)
        else:
            motion, rows = segment_result.trajectory, wanted - start
            yield motion.Rs_parent_part[rows], motion.ps_camera_root[rows]


def _untracked(
    edit: EditorState, start: int, end: int, frames: NDArray[np.int64]
) -> tuple[Array, Array]:
    between = edit.between(edit.settled, start, end, frames)
    if between is not None:
        return between
    skeleton = settled_skeleton(edit)  # of an open end one pose is known
    doc, keyframes = edit.settled, (find(edit.settled.subject.keyframes, f) for f in (start, end))
    at, pose = next((k.frame, k.pose(skeleton)) for k in keyframes if k is not None)
    begin, finish = (doc.film_camera.pose_seen_at(frame, at, pose) for frame in (start, end))
    return doc.film_camera.even_motion(begin, finish, (start, end), frames)


REACH = 30
"""Frames to both sides of the present at most."""


@dataclass(frozen=True, eq=False)
class EndTrail:
    """frames: (N,) ascending.  p_camera: (N, 3) as the camera sees them
    at the present frame, metres.  keys: those of the frames with a key."""

    part: str
    frames: tuple[int, ...]
    p_camera: Array
    keys: tuple[int, ...]


def end_trail(edit: EditorState) -> EndTrail | None:
    """Trace the end from the end of a segment before the present frame to the one behind it; None
    outside.

    Of the document without the gesture under way, which outdates what was tracked only when it
    ends; with Live on it follows the gesture.
    """
    edit = at_hand(edit)
    doc = edit.settled
    ends = sorted({frame for span in doc.spans for frame in span})
    if not ends or not ends[0] <= edit.frame <= ends[-1]:
        return None
    skeleton = settled_skeleton(edit)
    first, last = _reach(edit.frame, ends)
    motion = motion_between(edit, first, last)
    part = edit.selected or doc.subject.body.parts[0].name
    index = joint_names(skeleton).index(_far_end(doc.subject.body, part))
    joints = joint_positions(skeleton, motion.Ts_world_part)
    keys = tuple(k.frame for k in doc.subject.keyframes if first <= k.frame <= last)
    here = apply_transform(doc.film_camera.T_camera_world(edit.frame), joints[:, index])
    p_camera = joints[:, index] if doc.camera_path is None else here
    return EndTrail(part, tuple(range(first, last + 1)), p_camera, keys)


def _reach(frame: int, ends: Sequence[int]) -> tuple[int, int]:
    """First and last frame, within the segments."""
    before = [end for end in ends if end < frame]
    after = [end for end in ends if end > frame]
    first = before[-1] if before else frame
    last = after[0] if after else frame
    return max(first, frame - REACH), min(last, frame + REACH)


def _far_end(body: Body, part: str) -> str:
    """The joint of the part's only child, else a landmark of its own, else its own joint."""
    children = [child.name for child in body.parts if child.parent == part]
    if len(children) == 1:
        return children[0]
    landmarks = list(body.parts[body.index(part)].landmarks)
    return landmarks[0] if landmarks else part


MOST_MOMENTS = 1000
SOLE_M = 0.015
"""What of a foot at rest counts as its sole: so much above its lowest point."""
MOST_ENDS = 4


@dataclass(frozen=True, eq=False)
class FeetPaths:
    """floor_m: metres along up from the world's origin.  frames: (N,) ascending, none where no pose
    is known.  paths: of every foot, or of every limb's end where a body has no feet, by the name of
    its part: (N, 3) in the world, metres."""

    floor_m: float
    frames: NDArray[np.int64]
    paths: dict[str, Array]


def feet_paths(edit: EditorState) -> FeetPaths:
    """Trace the feet over all that is known of the motion; the floor as it was set, or guessed from
    the motion.
    """
    floor_m = edit.settled.world.floor_m
    skeleton, up = settled_skeleton(edit), edit.settled.world.up
    motion = known_motion(edit, MOST_MOMENTS)
    if motion is None:
        Ts = pose_transforms(edit.skeleton, shown_pose(edit).pose)[None]
        Ts = edit.settled.film_camera.parts_to_world(Ts, [edit.frame])
        floor = floor_height(floor_m, lowest_heights(edit.skeleton, Ts, up))
        return FeetPaths(floor, np.zeros(0, dtype=np.int64), {})
    Ts = motion.Ts_world_part
    paths = {}
    for part, p_part in _soles(skeleton).items():
        T = Ts[:, skeleton.body.index(part)]
        paths[part] = T[:, :3, :3] @ p_part + T[:, :3, 3]
    floor = floor_height(floor_m, lowest_heights(skeleton, Ts, up))
    return FeetPaths(floor, motion.frames, paths)


def _soles(skeleton: Skeleton) -> dict[str, Array]:
    """The middle (3,) of every foot's sole, or the tip of every limb, in its part's frame."""
    body = skeleton.body
    feet = [name for name in body.names if kind_of(name) == "foot"]
    if not feet:
        return {part: _tip(body, part) for part in _ends(body)}
    at_rest = pose_transforms(skeleton, Pose.rest(skeleton, (0.0, 0.0, 0.0)))
    return {part: _sole(body, part, at_rest) for part in feet}


def _sole(body: Body, part: str, Ts_at_rest: Array) -> Array:
    i = body.index(part)
    vertices = body.parts[i].shape.mesh().vertices
    down = vertices @ Ts_at_rest[i, :3, :3].T[:, 1]
    return np.asarray(vertices[down > down.max() - SOLE_M].mean(axis=0))


def _ends(body: Body) -> list[str]:
    """The last parts of limbs; the root where there is no limb."""
    ends = [handle.limb[-1] for handle in handles(body) if handle.kind == "end"]
    return ends[:MOST_ENDS] or [body.names[0]]


def _tip(body: Body, part: str) -> Array:
    """The far end of a part along its length."""
    vertices = body.parts[body.index(part)].shape.mesh().vertices
    far = vertices[np.abs(vertices[:, 1]) > np.abs(vertices[:, 1]).max() - SOLE_M]
    return np.asarray(far.mean(axis=0))


_AT_REST = (1.0, 0.0, 0.0, 0.0)


def angle_curve(edit: EditorState, index: int) -> Array:
    """(F, 3) degrees of a part by frame, without jumps; NaN where nothing is known."""
    Rs = part_rotations(edit, index)
    path = edit.doc.camera_path
    if path is not None and edit.doc.subject.body.parts[index].parent is None:
        Rs = path.Ts_world_camera[:, :3, :3] @ Rs
    keys = [keyframe.frame for keyframe in edit.doc.subject.keyframes]
    known_frames = np.flatnonzero(np.isfinite(Rs[:, 0, 0]))
    angles = np.full((edit.frame_count, 3), np.nan)
    part = edit.doc.subject.body.parts[index]
    up = edit.doc.world.up
    angles[known_frames] = angle_curve_deg(
        part, Rs[known_frames], np.searchsorted(known_frames, keys), up
    )
    return angles


def part_rotations(edit: EditorState, index: int) -> Array:
    """(F, 3, 3) of a part in its parent's frame, tracked or posed; NaN where nothing is known."""
    Rs = rotations(edit.fitting, edit.frame_count, index)
    name = edit.doc.subject.body.names[index]
    if poses := tuple(_met_poses(edit, edit.doc)):
        wxyz = [posed.rotations_wxyz.get(name, _AT_REST) for posed in poses]
        Rs[[posed.frame for posed in poses]] = rotation_from_quaternion(wxyz)
    return Rs


def angles_at(state: EditorState, pose: Pose) -> dict[str, list[float]]:
    """Every part's [x, y, z] in degrees."""
    values = angles_deg(state.skeleton, pose, up_of(state.doc, state.frame)).round(3).tolist()
    return dict(zip(state.doc.subject.body.names, values, strict=True))
