"""Joint positions over time, as recorded motion is read into."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final, Literal, TypeAlias

import numpy as np

from keypose.tracker.errors import FormatError
from keypose.tracker.geometry.rotations import Array, frozen

MOST_FRAMES: Final = 1_000_000
MOST_JOINTS: Final = 2_000
MOST_NUMBERS: Final = 15_000_000
"""Frames times joints times three."""


Unit: TypeAlias = Literal["m", "cm", "mm"]
World: TypeAlias = Literal["camera", "y up", "z up"]
METRES: Final[dict[Unit, float]] = {"m": 1.0, "cm": 0.01, "mm": 0.001}


@dataclass(frozen=True, eq=False)
class JointMotion:
    """Positions of named joints over time.

    names:          (J,), each once.
    ps_world_joint: (N, J, 3) metres in the file's own world, NaN where missing.
    times_s:        (N,) ascending; the file's own clock.
    world:          which way is up there, or that it is this program's camera frame; None where
                    the file does not say.
    unit:           the unit of length the file names; None where it names none, and `assumed` is
                    then the one that its positions were read with.
    is_per_frame:   it has a row for each frame of a video and no clock: times_s count frames.
    """

    names: tuple[str, ...]
    ps_world_joint: Array
    times_s: Array
    world: World | None
    unit: Unit | None
    assumed: Unit = "m"
    is_per_frame: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "ps_world_joint", frozen(self.ps_world_joint))
        object.__setattr__(self, "times_s", frozen(self.times_s))

    def __len__(self) -> int:
        return len(self.times_s)

    @classmethod
    def of(
        cls, file: str, names: list[str], positions: Array, times_s: Array,
        world: World | None, unit: Unit | None, assumed: Unit = "m",
    ) -> JointMotion:  # fmt: skip
        """The motion of a file whose positions (N, J, 3) are in `unit`, or else in `assumed`.

        FormatError where the parts do not make a motion.
        """
        require_size(file, len(times_s), len(names))
        if not np.isfinite(times_s).all() or (np.diff(times_s) <= 0).any():
            raise FormatError(f"{file}: the times of its frames must ascend from row to row.")
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise FormatError(f"{file} names {twice[0]!r} twice; every joint needs its own name.")
        ps = np.where(np.isfinite(positions).all(-1, keepdims=True), positions, np.nan)
        ps = ps * METRES[unit or assumed]
        if np.nanmax(np.abs(ps), initial=0.0) > 1e6:
            raise FormatError(f"{file} has joints more than a thousand kilometres away.")
        if np.isnan(ps).all():
            raise FormatError(f"{file} holds no position of any joint.")
        return cls(tuple(names), ps, times_s, world, unit, assumed)

    def in_unit(self, unit: Unit) -> JointMotion:
        """The motion if its lengths had been written in this unit."""
        scale = METRES[unit] / METRES[self.unit or self.assumed]
        return replace(self, ps_world_joint=self.ps_world_joint * scale, unit=unit)

    def at_rate(self, fps: float) -> JointMotion:
        """The motion with its frames evenly spaced at another rate, from the same first time."""
        first_s = 0.0 if self.is_per_frame else self.times_s[0]
        return replace(self, times_s=first_s + np.arange(len(self)) / fps, is_per_frame=False)

    def per_frame(self) -> JointMotion:
        """The motion as one that has no clock, its times numbers of frames."""
        return replace(self, times_s=np.arange(len(self), dtype=np.float64), is_per_frame=True)

    def on_video(self, file: str, times_s: Array) -> JointMotion:
        """With the times of a video's frames, where it has none of its own; FormatError where
        there are not as many."""
        if not self.is_per_frame:
            return self
        if len(self) > len(times_s):
            raise FormatError(
                f"{file} has {len(self)} poses, one for each frame, and the video {len(times_s)} "
                "frames: give the poses' rate (fps)."
            )
        return replace(self, times_s=times_s[: len(self)], is_per_frame=False)

    def at(self, times_s: Array) -> Array:
        """Positions (M, J, 3) at times of the file's clock, NaN outside and next to missing frames.

        Between two frames straight lines; at a frame its own positions.
        """
        slack = 1e-4  # times in files are rounded
        inside = (times_s >= self.times_s[0] - slack) & (times_s <= self.times_s[-1] + slack)
        place = np.interp(times_s, self.times_s, np.arange(len(self)))
        near = np.round(place)
        place = np.where(np.abs(place - near) < 5e-3, near, place)
        low = np.minimum(place.astype(np.int64), max(len(self) - 2, 0))
        high = np.minimum(low + 1, len(self) - 1)
        share = (place - low)[:, None, None]
        a, b = self.ps_world_joint[low], self.ps_world_joint[high]
        between = np.where(share == 0, a, np.where(share == 1, b, (1 - share) * a + share * b))
        return np.asarray(np.where(inside[:, None, None], between, np.nan))


def require_size(file: str, frames: int, joints: int) -> None:
    """FormatError unless a motion may have so many frames and joints; checked before allocating."""
    if frames < 1 or joints < 1:
        what = "frame" if frames < 1 else "joint"
        raise FormatError(f"{file} holds no {what}.")
    if frames > MOST_FRAMES or joints > MOST_JOINTS or frames * joints * 3 > MOST_NUMBERS:
        raise FormatError(f"{file} has {frames} frames of {joints} joints, which is too much.")
