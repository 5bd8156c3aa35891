"""The path of a part's far end around the present frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from keypose.app.editor.motion import motion_between, settled_skeleton
from keypose.app.editor.state import EditorState
from keypose.tracker.body.body import Body
from keypose.tracker.body.pose import joint_names, joint_positions
from keypose.tracker.geometry.rotations import Array

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
    skeleton = settled_skeleton(edit)
    first, last = _reach(edit.frame, ends)
    motion = motion_between(edit, first, last)
    part = edit.selected or doc.body.parts[0].name
    index = joint_names(skeleton).index(_far_end(doc.body, part))
    joints = joint_positions(skeleton, motion.Ts_camera_part)
    keys = tuple(k.frame for k in doc.keyframes if first <= k.frame <= last)
    return EndTrail(part, tuple(range(first, last + 1)), joints[:, index], keys)


def _reach(frame: int, ends: Sequence[int]) -> tuple[int, int]:
    """First and last frame, within the segments."""
    before = [end for end in ends if end < frame]
    after = [end for end in ends if end > frame]
    first = before[-1] if before else frame
    last = after[0] if after else frame
    return max(first, frame - REACH), min(last, frame + REACH)


def _far_end(body: Body, part: str) -> str:
    """The joint of the part's only child, else a landmark of its own, else its own joint."""
    children = [other.name for other in body.parts if other.parent == part]
    if len(children) == 1:
        return children[0]
    landmarks = list(body.parts[body.index(part)].landmarks)
    return landmarks[0] if landmarks else part
