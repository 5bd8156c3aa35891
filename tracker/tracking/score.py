"""How well a trajectory explains the pictures of its segment."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.trajectory import Pass, Trajectory
from keypose.tracker.kernels.pairs import CAP, mean_capped_square
from keypose.tracker.tracking.scene import Scene
from keypose.tracker.tracking.segment import Segment
from keypose.tracker.video.pyramid import Clip


def capped_score(scene: Scene, clip: Clip, trajectory: Trajectory, stride: int) -> float:
    """DRIFT (4), per point and capped, of one surface point in every `stride`: grey levels²."""
    slots = clip.slots(trajectory.first_frame, trajectory.last_frame)
    return _capped(scene, clip, slots, trajectory, stride)


def best_of(tried: Sequence[Pass]) -> int:
    """Index of the lowest score; of the last trajectory where that was not judged."""
    if tried[-1].score is None:
        return len(tried) - 1
    return int(np.argmin([np.inf if p.score is None else p.score for p in tried]))


def keyframe_difference(scene: Scene, segment: Segment, stride: int) -> float:
    """How different the textures of the two keyframes are, each compared with the other directly.

    Mean capped square: small where both are posed exactly, 0 where nothing can be compared.
    """
    frames, ends = (segment.first_frame, segment.last_frame), (segment.start, segment.end)
    total = 0.0
    for a, b in ((0, 1), (1, 0)):
        slots = np.concatenate([segment.clip.slots(frames[k], frames[k]) for k in (a, b)])
        jump = Trajectory(
            0,
            np.stack([ends[a].Rs_parent_part, ends[b].Rs_parent_part]),
            np.stack([ends[a].p_camera_root, ends[b].p_camera_root]),
        )
        total += 0.5 * _capped(scene, segment.clip, slots, jump, stride)
    return total


def _capped(
    scene: Scene, clip: Clip, slots: NDArray[np.int64], trajectory: Trajectory, stride: int
) -> float:
    return float(
        mean_capped_square(
            scene.arrays, scene.lens, scene.visibility, clip.levels[0], slots,
            *trajectory.writable(), stride, CAP,
        )
    )  # fmt: skip
