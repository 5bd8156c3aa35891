"""The body over some steps from its keyframe, and by how much each part is expected to be off.

By brightness alone each pose is found from the one before it, and errors add up unseen. To see them
the body is followed back from where it came to: as far as it misses the keyframe, so far it is off.
What is hidden comes back to where it was whatever happened, so every step that the picture does not
show counts besides. On rendered people the area under the curve of both together is 0.95, for parts
that are off by more than 3 % of the height.

With keypoints all poses are solved for at once, as between two keyframes, but with an open end.
Where brightness is sure of another place for a part, the keypoints are wrong, however sure they
are: so it is with bodies that only resemble a person.
"""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from keypose.tracker.body.trajectory import Pass, Trajectory
from keypose.tracker.tracking.anchored_cycle import (
    Candidate,
    cycle,
    joint_evidence,
    measured_by_keypoints,
)
from keypose.tracker.tracking.cues.keypoint_start import from_keypoints
from keypose.tracker.tracking.cues.soft_correction import Correction
from keypose.tracker.tracking.initial.chains import Chain, follow
from keypose.tracker.tracking.segment import distance_px, extent_px, is_sound

if TYPE_CHECKING:
    from keypose.tracker.geometry.rotations import Array
    from keypose.tracker.tracking.cues.anchors import Anchors
    from keypose.tracker.tracking.method import Keypose
    from keypose.tracker.tracking.scene import Scene
    from keypose.tracker.tracking.segment import Segment

CHECKED_EVERY = 4
"""Steps between two looks back."""
MISSED = 1.7
UNSEEN = 0.004
"""A part is off by so many times what following back misses the keyframe by, in the mean, and by
such a share of the height for every step in which the picture does not show its motion."""

MOST_BY_BRIGHTNESS = 0.03
MOST_BY_KEYPOINTS = 0.08
"""Shares of the height: a part that is expected to be off by more is not trusted. What following
back misses is less than what may be wrong; with keypoints it is the median of what may."""
SURE = 0.01
ELSEWHERE = 0.06
"""Shares of the height: brightness that expects a smaller error is sure; what it is sure of lies
elsewhere when it is farther away than this."""


@dataclass(frozen=True, eq=False)
class ForwardPass:
    """A motion by step.

    expected_error (N, P): by which a part is expected to be off, a share of the body's height in
        the picture; NaN for parts of which nothing is known.
    most_error: from which on a part is not trusted.
    """

    motion: Trajectory
    expected_error: Array
    most_error: float


def by_brightness(scene: Scene, segment: Segment, method: Keypose) -> ForwardPass:
    """The motion followed from step to step, and back, as far as it stays before the camera."""
    how = (method.stride, method.chain_inner, method.stop, method.finest)
    chain = follow(scene, segment.clip, segment.start, 0, segment.last_frame, *how)
    motion = _sound(scene, segment, chain)
    steps = sorted({*range(CHECKED_EVERY, len(motion), CHECKED_EVERY), len(motion) - 1} - {0})
    parts = scene.skeleton.part_count
    missed = [np.zeros(parts)]
    for step in steps:
        back = follow(scene, segment.clip, motion.pose(step), step, 0, *how)
        missed.append(_missed(scene, motion, back))
    at, misses = np.array([0, *steps]), np.array(missed)
    every = np.arange(len(motion))
    error = np.stack([np.interp(every, at, misses[:, p]) for p in range(parts)], axis=-1)
    error = MISSED * error + UNSEEN * _unseen(scene, chain)[: len(motion)]
    return ForwardPass(motion, error, MOST_BY_BRIGHTNESS)


def _unseen(scene: Scene, chain: Chain) -> Array:
    """(N, P) in how many steps a part was not seen until then; 0 for those that are not tracked."""
    skeleton = scene.skeleton
    tracked = np.isin(np.arange(skeleton.part_count), skeleton.dof_part)
    doubt = np.where(tracked, chain.doubt.turned, 0.0)
    nothing = np.zeros_like(doubt[:1])
    return np.concatenate([nothing, np.cumsum(doubt, axis=0)])


def _sound(scene: Scene, segment: Segment, chain: Trajectory) -> Trajectory:
    """The chain up to where it leaves the space before the camera."""
    R, t = chain.writable()
    for count in range(len(chain), 1, -1):
        cut = Trajectory(0, R[:count], t[:count])
        if is_sound(scene, segment, cut):
            return cut
    return Trajectory(0, R[:1], t[:1])


def _missed(scene: Scene, motion: Trajectory, back: Trajectory) -> Array:
    """(P,) by how much a chain back misses the keyframe: of each part's marks the worst, a share of
    the body's extent."""
    first = [Trajectory(0, m.Rs_parent_part[:1], m.ps_camera_root[:1]) for m in (motion, back)]
    away = np.nan_to_num(distance_px(scene, *first)[0], nan=np.inf) / extent_px(scene, first[0])
    worst = np.zeros(scene.skeleton.part_count)
    np.maximum.at(worst, scene.marks[1], np.minimum(away, 1.0))
    return worst


def by_keypoints(
    free: Scene,
    segment: Segment,
    method: Keypose,
    candidates: Sequence[Anchors],
    plain: ForwardPass | None,
) -> Generator[Pass, None, ForwardPass]:
    """All poses at once, by brightness and keypoints; yields the motions on the way.

    plain: followed by brightness; None where brightness does not count.
    """
    tried: list[Pass] = []
    ends: list[Candidate] = []
    for anchors in candidates:
        correction = Correction(free, segment, anchors, open_end=True)
        alone = Pass("keypoints", from_keypoints(correction), None)
        yield alone
        if plain is None:
            tried.append(alone)
            ends.append(measured_by_keypoints(correction, alone.trajectory, len(tried) - 1))
            continue
        for start in (alone, Pass("both ways", plain.motion, None)):
            if len(start.trajectory) == len(alone.trajectory):
                ends.append((yield from cycle(correction, method, start, tried)))
    best = min(ends, key=lambda ended: ended.cost)
    evidence = joint_evidence(free, ends, best, keyed=(0,))
    error = evidence.expected_error(free.skeleton.part_count)
    if plain is not None:
        count = len(plain.motion)
        error[:count] = np.fmax(error[:count], _contradicted(free, best.trajectory, plain))
    return ForwardPass(best.trajectory, error, MOST_BY_KEYPOINTS)


def _contradicted(free: Scene, motion: Trajectory, plain: ForwardPass) -> Array:
    """(N, P) how far a part is from where brightness surely puts it; NaN where it is near, or
    nothing is sure."""
    count = len(plain.motion)
    same = Trajectory(0, motion.Rs_parent_part[:count], motion.ps_camera_root[:count])
    px = np.nan_to_num(distance_px(free, same, plain.motion), nan=np.inf)
    away = np.zeros_like(plain.expected_error)
    np.maximum.at(away.T, free.marks[1], px.T / extent_px(free, same))
    tracked = np.isin(np.arange(away.shape[1]), free.skeleton.dof_part)
    clear = (plain.expected_error < SURE) & (away > ELSEWHERE) & tracked
    return np.where(clear, away, np.nan)
