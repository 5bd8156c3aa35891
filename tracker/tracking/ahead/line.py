"""Frames counted from a keyframe, in either direction of time.

Everything that follows a body counts steps: step 0 is the keyframe, and the larger the step, the
farther from it. What is before a keyframe is thus followed by the same code as what is after it.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.video.pyramid import Clip

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from keypose.tracker.keypoints.keypoints import Keypoints
    from keypose.tracker.session.annotations import Direction


@dataclass(frozen=True)
class Line:
    """The frames from a keyframe on in one direction."""

    frame: int
    direction: Direction

    @property
    def sign(self) -> int:
        """What one step adds to the frame."""
        return 1 if self.direction == "forward" else -1

    def frame_at(self, step: int) -> int:
        """The frame of a step."""
        return self.frame + self.sign * step

    def span(self, steps: int) -> tuple[int, int]:
        """First and last frame of so many steps."""
        ends = self.frame, self.frame_at(steps)
        return min(ends), max(ends)

    def clip(self, clip: Clip, steps: int) -> Clip:
        """The pictures of so many steps, by step."""
        first, last = self.span(steps)
        slots = clip.slots(first, last)[:: self.sign]
        damaged = frozenset(abs(n - self.frame) for n in clip.damaged if first <= n <= last)
        return _Steps(0, clip.levels, damaged, slots)

    def keypoints(self, found: Keypoints, steps: int) -> Keypoints:
        """Those of so many steps, by step."""
        over = found.over(*self.span(steps))
        rows = slice(None, None, self.sign)
        depth = None if over.p_hips is None else over.p_hips[rows]
        by_hand = None if over.by_hand is None else over.by_hand[rows]
        uv, visibility = over.uv[rows], over.visibility[rows]
        return replace(
            over, first_frame=0, uv=uv, visibility=visibility, p_hips=depth, by_hand=by_hand
        )

    def motion(self, steps: Trajectory) -> Trajectory:
        """A motion by steps as one by frames."""
        rows = slice(None, None, self.sign)
        first, _ = self.span(len(steps) - 1)
        return Trajectory(first, steps.Rs_parent_part[rows], steps.ps_camera_root[rows])


@dataclass(frozen=True, eq=False)
class _Steps(Clip):
    """Pictures by step. places: where each step's lie in the arrays."""

    places: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))

    def __len__(self) -> int:
        return len(self.places)

    def slots(self, first_frame: int, last_frame: int) -> NDArray[np.int64]:
        """Where these steps lie in the arrays; IndexError beyond them."""
        if first_frame < 0 or last_frame >= len(self):
            raise IndexError(f"steps {first_frame} to {last_frame} are not all in the clip")
        return np.ascontiguousarray(self.places[first_frame : last_frame + 1])
