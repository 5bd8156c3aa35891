"""The way a part's far end takes around the present frame."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from app.editor.shown import find
from app.editor.state import EditorState
from tracker.body.pose import joint_names, joint_positions, part_transforms
from tracker.body.trajectory import Trajectory, interpolate
from tracker.geometry.rotations import Array

REACH = 30
"""Frames to both sides of the present at most."""


@dataclass(frozen=True, eq=False)
class Way:
    """frames: (N,) ascending.  p_camera: (N, 3) metres.  keys: those of the frames with a key."""

    part: str
    frames: tuple[int, ...]
    p_camera: Array
    keys: tuple[int, ...]


def way(edit: EditorState) -> Way | None:
    """From the end of a segment before the present frame to the one behind it; None outside."""
    ends = sorted({frame for span in edit.doc.spans for frame in span})
    if not ends or not ends[0] <= edit.frame <= ends[-1]:
        return None
    first, last = _reach(edit.frame, ends)
    pieces = list(_pieces(edit, first, last))
    Rs, ps = (np.concatenate(arrays) for arrays in zip(*pieces, strict=True))
    for posed in (*edit.doc.keyframes, *edit.doc.drafts):
        if first <= posed.frame <= last:
            pose = posed.pose(edit.skeleton)
            Rs[posed.frame - first] = pose.Rs_parent_part
            ps[posed.frame - first] = pose.p_camera_root
    part = edit.selected or edit.doc.body.parts[0].name
    index = joint_names(edit.skeleton).index(_far_end(edit, part))
    joints = joint_positions(edit.skeleton, part_transforms(edit.skeleton, Rs, ps))
    keys = tuple(key for key in edit.keys if first <= key <= last)
    return Way(part, tuple(range(first, last + 1)), joints[:, index], keys)


def _reach(frame: int, ends: Sequence[int]) -> tuple[int, int]:
    """First and last frame, within the segments."""
    before = [end for end in ends if end < frame]
    after = [end for end in ends if end > frame]
    first = before[-1] if before else frame
    last = after[0] if after else frame
    return max(first, frame - REACH), min(last, frame + REACH)


def _pieces(edit: EditorState, first: int, last: int) -> Iterator[tuple[Array, Array]]:
    """Rotations and positions of the frames, segment by segment, tracked or interpolated."""
    at = first
    for start, end in edit.doc.spans:
        if end < first or start > last or at > last:
            continue
        motion = _motion(edit, start, end)
        piece = slice(at - start, min(end, last) - start + 1)
        at = min(end, last) + 1
        yield motion.Rs_parent_part[piece], motion.ps_camera_root[piece]


def _motion(edit: EditorState, start: int, end: int) -> Trajectory:
    track = edit.fitting.get((start, end))
    if track is not None:
        return track.trajectory
    found = (find(edit.doc.keyframes, frame) for frame in (start, end))
    posed = [known.pose(edit.skeleton) for known in found if known is not None]
    return interpolate(posed[0], posed[-1], start, end)  # of an open end one pose is known


def _far_end(edit: EditorState, part: str) -> str:
    """The joint of the part's only child, else a landmark of its own, else its own joint."""
    children = [other.name for other in edit.doc.body.parts if other.parent == part]
    if len(children) == 1:
        return children[0]
    landmarks = list(edit.doc.body.parts[edit.doc.body.index(part)].landmarks)
    return landmarks[0] if landmarks else part
