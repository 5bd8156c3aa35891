"""The motion as it is known now: tracked where it is; elsewhere as it was before it was reduced to
keyframes, or interpolated between them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from keypose.app.editor.shown import counts, find
from keypose.app.editor.state import EditorState
from keypose.tracker.body.pose import part_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory, interpolate
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.keyframe import Keyframe


@dataclass(frozen=True, eq=False)
class KnownMotion:
    """frames: (N,) ascending.  Ts_camera_part: (N, P, 4, 4) of the settled document's body."""

    frames: NDArray[np.int64]
    Ts_camera_part: Array


def settled_skeleton(edit: EditorState) -> Skeleton:
    """The layout of the body without the gesture under way."""
    doc = edit.settled
    return edit.skeleton if doc.body is edit.doc.body else Skeleton.of(doc.body)


def motion_between(edit: EditorState, first: int, last: int, stride: int = 1) -> KnownMotion:
    """From first to last, both inside the segments: every stride-th frame, and the keyframes.

    Of the document without the gesture under way, which outdates what was tracked only when it
    ends. Where somebody posed the body, it stands as posed.
    """
    doc, skeleton = edit.settled, settled_skeleton(edit)
    keys = [k.frame for k in doc.keyframes if first <= k.frame <= last]
    frames = np.union1d(np.arange(first, last + 1, stride), np.array(keys, dtype=np.int64))
    motions = list(_motions(edit, first, last))
    Rs, ps = (np.concatenate(arrays)[frames - first] for arrays in zip(*motions, strict=True))
    row_of = {frame: row for row, frame in enumerate(frames.tolist())}
    for posed in (*doc.keyframes, *doc.drafts):
        row = row_of.get(posed.frame)
        if row is not None and counts(edit, posed):
            pose = posed.pose(skeleton)
            Rs[row], ps[row] = pose.Rs_parent_part, pose.p_camera_root
    return KnownMotion(frames, part_transforms(skeleton, Rs, ps))


def known_motion(edit: EditorState, most: int) -> KnownMotion | None:
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
        for posed in (*doc.keyframes, *doc.drafts)
        if not ends or not first <= posed.frame <= last
    }
    frames = sorted(outside)[:: 1 + len(outside) // most]
    return _with_posed(settled_skeleton(edit), inside, [outside[frame] for frame in frames])


def _with_posed(
    skeleton: Skeleton, motion: KnownMotion | None, posed: list[Keyframe]
) -> KnownMotion | None:
    """A motion and poses at other frames, by frame."""
    if not posed:
        return motion
    poses = [each.pose(skeleton) for each in posed]
    Rs = np.stack([pose.Rs_parent_part for pose in poses])
    ps = np.stack([pose.p_camera_root for pose in poses])
    frames, Ts = np.array([each.frame for each in posed]), part_transforms(skeleton, Rs, ps)
    if motion is not None:
        frames = np.append(frames, motion.frames)
        Ts = np.concatenate([Ts, motion.Ts_camera_part])
    order = np.argsort(frames)
    return KnownMotion(frames[order], Ts[order])


def _motions(edit: EditorState, first: int, last: int) -> Iterator[tuple[Array, Array]]:
    """Rotations and positions of the frames, segment by segment, tracked or interpolated."""
    doc, at = edit.settled, first
    fitting = edit.results.fitting(doc)
    for start, end in doc.spans:
        if end < first or start > last or at > last:
            continue
        found = fitting.get((start, end))
        motion = _untracked(edit, start, end) if found is None else found.trajectory
        rows = slice(at - start, min(end, last) - start + 1)
        at = min(end, last) + 1
        yield motion.Rs_parent_part[rows], motion.ps_camera_root[rows]


def _untracked(edit: EditorState, start: int, end: int) -> Trajectory:
    found = edit.between(edit.settled, start, end)
    if found is not None:
        return found
    skeleton = settled_skeleton(edit)  # of an open end one pose is known
    known = (find(edit.settled.keyframes, frame) for frame in (start, end))
    pose = next(keyframe.pose(skeleton) for keyframe in known if keyframe is not None)
    return interpolate(pose, pose, start, end)
