"""The body over some steps from its keyframe, and by how much each part is expected to be off.

By brightness alone each pose is found from the one before it, and errors add up unseen. To see them
the body is followed back from where it came to: as far as it misses the keyframe, so far it is off
(on rendered people the area under the curve is 0.94 for parts more than 3 % of the height off).

With keypoints all poses are solved for at once, as between two keyframes, but with an open end.
"""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tracker.body.trajectory import Pass, Trajectory
from tracker.tracking.anchored_cycle import Ended, cycle, joint_evidence, measured_by_keypoints
from tracker.tracking.cues.from_keypoints import from_keypoints
from tracker.tracking.cues.soft_correction import Correction
from tracker.tracking.initial.chains import follow
from tracker.tracking.segment import distance_px, extent_px, is_sound

if TYPE_CHECKING:
    from tracker.geometry.rotations import Array
    from tracker.tracking.cues.anchors import Anchors
    from tracker.tracking.method import Keypose
    from tracker.tracking.scene import Scene
    from tracker.tracking.segment import Segment

CHECKED_EVERY = 4
"""Steps between two looks back."""
MISSED = 1.7
"""A part is off by so many times what following back misses the keyframe by, in the mean."""


@dataclass(frozen=True, eq=False)
class Followed:
    """A motion by step.

    expected_error (N, P): by which a part is expected to be off, a share of the body's height in
        the picture; NaN for parts of which nothing is known.
    """

    motion: Trajectory
    expected_error: Array


def by_brightness(scene: Scene, segment: Segment, method: Keypose) -> Followed:
    """Followed from step to step, and back; as far as it stays before the camera."""
    how = (method.stride, method.chain_inner, method.stop, method.finest)
    chain = follow(scene, segment.clip, segment.start, 0, segment.last_frame, *how)
    motion = _sound(scene, segment, chain)
    steps = sorted({*range(CHECKED_EVERY, len(motion), CHECKED_EVERY), len(motion) - 1} - {0})
    parts = scene.skeleton.part_count
    missed = [np.zeros(parts)]
    for step in steps:
        back = follow(scene, segment.clip, motion.pose(step), step, 0, *how)
        missed.append(_missed(scene, motion, back))
    at, known = np.array([0, *steps]), np.array(missed)
    every = np.arange(len(motion))
    error = np.stack([np.interp(every, at, known[:, p]) for p in range(parts)], axis=-1)
    return Followed(motion, MISSED * error)


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
    chain: Trajectory | None,
) -> Generator[Pass, None, Followed]:
    """All poses at once, by brightness and keypoints; yields the motions on the way.

    chain: the body followed by brightness; None where brightness does not count.
    """
    tried: list[Pass] = []
    ends: list[Ended] = []
    for anchors in candidates:
        correction = Correction(free, segment, anchors, open_end=True)
        alone = Pass("keypoints", from_keypoints(correction), None)
        yield alone
        if chain is None:
            tried.append(alone)
            ends.append(measured_by_keypoints(correction, alone.trajectory, len(tried) - 1))
            continue
        for start in (alone, Pass("both ways", chain, None)):
            if len(start.trajectory) == len(alone.trajectory):
                ends.append((yield from cycle(correction, method, start, tried)))
    best = min(ends, key=lambda ended: ended.cost)
    same_sides = [ended for ended in ends if ended.anchors is best.anchors]
    evidence = joint_evidence(free, same_sides, best, keyed=(0,))
    error = evidence.expected_error(free.skeleton.part_count)
    return Followed(best.trajectory, error)
