"""A plain word on every segment: good, check these frames, or lost: add a keyframe there.

The evidence is what tracking saw, never the truth: how far the chains from the two keyframes lie
apart, which parts the picture did not decide, whether brightness is kept, whether a pass diverged.
The thresholds were set on rendered sequences with known truth.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from tracker.geometry import Array
from tracker.observe import Observation
from tracker.scene import Scene
from tracker.segment import Outcome, Segment

LOST_SHARE = 0.35
"""Of the body's height in the picture: two chains further apart than this share are lost."""
CHECK_SHARE = 0.10
UNSEEN = 0.15
"""Observability below which a part's motion is a guess."""
SHORTEST_RUN = 3
"""Frames for which a part must stay unseen before it is worth a word."""


@dataclass(frozen=True, eq=False)
class Verdict:
    """kind and words for a person; frames: first and last frame to look at, where there are any."""

    kind: Literal["good", "check", "lost"]
    words: str
    frames: tuple[int, int] | None = None


def judge(scene: Scene, segment: Segment, outcome: Outcome, seen: Observation) -> Verdict:
    """The verdict on a tracked segment."""
    middle = _frame_to_key(segment, outcome)
    if outcome.diverged and outcome.passes[outcome.best].what == "interpolation":
        return Verdict("lost", f"lost: add a keyframe near {middle}", (middle, middle))
    apart = _apart(scene, segment, outcome)
    if apart.max(initial=0.0) > LOST_SHARE:
        return Verdict("lost", f"lost: add a keyframe near {middle}", (middle, middle))
    unseen = _longest_unseen(scene, segment, seen)
    if unseen is not None:
        part, first, last = unseen
        return Verdict("check", f"check {_frames(first, last)}: {part} not seen", (first, last))
    doubtful = np.flatnonzero(apart > CHECK_SHARE)
    if len(doubtful):
        first, last = (segment.first_frame + int(k) for k in (doubtful[0], doubtful[-1]))
        part = _most_apart(scene, outcome)
        words = f"check {_frames(first, last)}: {part} followed differently from either side"
        return Verdict("check", words, (first, last))
    return Verdict("good", "good")


def _frames(first: int, last: int) -> str:
    return f"frame {first}" if first == last else f"frames {first}–{last}"


def _apart(scene: Scene, segment: Segment, outcome: Outcome) -> Array:
    """(N,) largest distance of the two chains over the joints, in shares of the body's height.

    Each frame's is weighed by how far it lies from the nearer keyframe: at a keyframe itself the
    chain from the other side has no say.
    """
    if outcome.disagreement_px is None:
        return np.zeros(segment.last_frame - segment.first_frame + 1)
    n = len(outcome.disagreement_px) - 1
    share = np.arange(n + 1) / n
    weight = 4 * share * (1 - share)
    height = _height_px(scene, segment)
    return np.asarray(outcome.disagreement_px.max(axis=1) * weight / height)


def _most_apart(scene: Scene, outcome: Outcome) -> str:
    """Name of the part whose joint the two chains place most differently."""
    if outcome.disagreement_px is None:
        return "the body"
    parts = outcome.disagreement_px[:, : scene.skeleton.part_count]
    part = int(np.unravel_index(int(parts.argmax()), parts.shape)[1])
    return scene.skeleton.body.names[part].replace("_", " ")


def _height_px(scene: Scene, segment: Segment) -> float:
    """Extent of the points on the body's surface in the picture at the first keyframe."""
    from tracker.pose import joint_positions, pose_transforms

    joints = joint_positions(scene.skeleton, pose_transforms(scene.skeleton, segment.start))
    extent = np.ptp(scene.camera.project(joints), axis=0).max()
    size = np.linalg.norm(np.ptp(scene.points.points, axis=0)) / scene.pixel_m
    return float(max(extent, size, 1.0))


def _frame_to_key(segment: Segment, outcome: Outcome) -> int:
    """Where a keyframe would help most: where the chains differ most, or the middle."""
    middle = (segment.first_frame + segment.last_frame) // 2
    if outcome.disagreement_px is None or len(outcome.disagreement_px) < 3:
        return middle
    n = len(outcome.disagreement_px) - 1
    share = np.arange(n + 1) / n
    total = outcome.disagreement_px.mean(axis=1) * share * (1 - share)
    return segment.first_frame + int(np.argmax(total))


def _longest_unseen(
    scene: Scene, segment: Segment, seen: Observation
) -> tuple[str, int, int] | None:
    """The part that goes unseen for the longest run of frames: name, first and last frame."""
    runs = []
    for i, name in enumerate(scene.skeleton.body.names):
        hidden = seen.observability[:, i] < UNSEEN  # NaN, not tracked, is never below
        runs += [(last - first, name, first, last) for first, last in _runs(hidden)]
    runs = [run for run in runs if run[0] + 1 >= SHORTEST_RUN]
    if not runs:
        return None
    _, name, first, last = max(runs)
    start = segment.first_frame + 1
    return name.replace("_", " "), start + first, start + last


def _runs(flags: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First and last index of every run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(int)))
    return [(int(a), int(b) - 1) for a, b in zip(edges[::2], edges[1::2], strict=True)]
