"""The path of a part's far end around the present frame."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from app.editor.shown import find
from app.editor.state import EditorState
from tracker.body.body import Body
from tracker.body.pose import joint_names, joint_positions, part_transforms
from tracker.body.skeleton import Skeleton
from tracker.body.trajectory import Trajectory, interpolate
from tracker.geometry.rotations import Array

REACH = 30
"""Frames to both sides of the present at most."""


@dataclass(frozen=True, eq=False)
class EndTrail:
    """frames: (N,) ascending.  p_camera: (N, 3) metres.  keys: those of the frames with a key."""

    part: str
    frames: tuple[int, ...]
    p_camera: Array
    keys: tuple[int, ...]


def end_trail(edit: EditorState) -> EndTrail | None:
    """From the end of a segment before the present frame to the one behind it; None outside.

    Of the document without the gesture under way, which outdates what was tracked only when it
    ends.
    """
    doc = edit.settled
    ends = sorted({frame for span in doc.spans for frame in span})
    if not ends or not ends[0] <= edit.frame <= ends[-1]:
        return None
    skeleton = edit.skeleton if doc.body is edit.doc.body else Skeleton.of(doc.body)
    first, last = _reach(edit.frame, ends)
    motions = list(_motions(edit, first, last))
    Rs, ps = (np.concatenate(arrays) for arrays in zip(*motions, strict=True))
    for posed in (*doc.keyframes, *doc.drafts):
        if first <= posed.frame <= last:
            pose = posed.pose(skeleton)
            Rs[posed.frame - first] = pose.Rs_parent_part
            ps[posed.frame - first] = pose.p_camera_root
    part = edit.selected or doc.body.parts[0].name
    index = joint_names(skeleton).index(_far_end(doc.body, part))
    joints = joint_positions(skeleton, part_transforms(skeleton, Rs, ps))
    keys = tuple(k.frame for k in doc.keyframes if first <= k.frame <= last)
    return EndTrail(part, tuple(range(first, last + 1)), joints[:, index], keys)


def _reach(frame: int, ends: Sequence[int]) -> tuple[int, int]:
    """First and last frame, within the segments."""
    before = [end for end in ends if end < frame]
    after = [end for end in ends if end > frame]
    first = before[-1] if before else frame
    last = after[0] if after else frame
    return max(first, frame - REACH), min(last, frame + REACH)


def _motions(edit: EditorState, first: int, last: int) -> Iterator[tuple[Array, Array]]:
    """Rotations and positions of the frames, segment by segment, tracked or interpolated."""
    doc, at = edit.settled, first
    fitting = edit.results.fitting(doc)
    for start, end in doc.spans:
        if end < first or start > last or at > last:
            continue
        found = fitting.get((start, end))
        motion = _interpolated(edit, start, end) if found is None else found.trajectory
        rows = slice(at - start, min(end, last) - start + 1)
        at = min(end, last) + 1
        yield motion.Rs_parent_part[rows], motion.ps_camera_root[rows]


def _interpolated(edit: EditorState, start: int, end: int) -> Trajectory:
    found = (find(edit.settled.keyframes, frame) for frame in (start, end))
    posed = [known.pose(edit.skeleton) for known in found if known is not None]
    return interpolate(posed[0], posed[-1], start, end)  # of an open end one pose is known


def _far_end(body: Body, part: str) -> str:
    """The joint of the part's only child, else a landmark of its own, else its own joint."""
    children = [other.name for other in body.parts if other.parent == part]
    if len(children) == 1:
        return children[0]
    landmarks = list(body.parts[body.index(part)].landmarks)
    return landmarks[0] if landmarks else part
