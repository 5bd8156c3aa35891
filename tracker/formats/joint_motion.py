"""Joint positions over time, as recorded motion is read into."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from typing import Final, Literal, TypeAlias

import numpy as np

from keypose.tracker.errors import FormatError
from keypose.tracker.formats.people import chosen_individual
from keypose.tracker.formats.text import Note
from keypose.tracker.geometry.rotations import Array, frozen

MOST_FRAMES: Final = 1_000_000
MOST_JOINTS: Final = 2_000
MOST_NUMBERS: Final = 15_000_000
"""Frames times joints times three."""


LEAST_SHARED: Final = 3
"""Joints that several subjects of a file share by name."""
MARKER_PAIRS: Final = (("LWRA", "LWRB"), ("RWRA", "RWRB"))
"""Markers of Plug-in Gait on either side of a joint."""

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
    rest_m:         (J, 3) the file's pose at rest in its world, where it has one: it shows which
                    way is up where `world` is only the custom.
    notes:          what is odd about the file and was read all the same.
    """

    names: tuple[str, ...]
    ps_world_joint: Array
    times_s: Array
    world: World | None
    unit: Unit | None
    assumed: Unit = "m"
    is_per_frame: bool = False
    rest_m: Array | None = None
    notes: tuple[Note, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "ps_world_joint", frozen(self.ps_world_joint))
        object.__setattr__(self, "times_s", frozen(self.times_s))

    def __len__(self) -> int:
        return len(self.times_s)

    @classmethod
    def of(
        cls,
        file: str,
        names: list[str],
        positions: Array,
        times_s: Array,
        world: World | None,
        unit: Unit | None,
        assumed: Unit = "m",
        rest_m: Array | None = None,
        notes: tuple[Note, ...] = (),
    ) -> JointMotion:
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
        return cls(tuple(names), ps, times_s, world, unit, assumed, False, rest_m, notes)

    def in_unit(self, unit: Unit) -> JointMotion:
        """The motion if its lengths had been written in this unit."""
        scale = METRES[unit] / METRES[self.unit or self.assumed]
        return replace(self, ps_world_joint=self.ps_world_joint * scale, unit=unit)

    def of_individual(self, file: str, wanted: str | None) -> JointMotion:
        """The joints of one of several subjects, whose names stand before a colon.

        FormatError where which one is not said, or is not there.
        """
        subjects, owners = self.subjects, self.owners
        if not subjects and wanted is None:
            return self
        if not subjects and wanted not in owners:
            raise FormatError(f"{file} does not tell individuals apart: leave out {wanted!r}.")
        chosen = wanted if wanted in owners else chosen_individual(file, subjects, wanted)
        mine = [i for i, subject in enumerate(owners) if subject == chosen]
        return replace(
            self,
            names=tuple(self.names[i] for i in mine),
            ps_world_joint=self.ps_world_joint[:, mine],
            rest_m=None if self.rest_m is None else self.rest_m[mine],
        )

    @property
    def owners(self) -> tuple[str, ...]:
        """(J,) what stands before the colon in each joint's name."""
        return tuple(name.rpartition(":")[0] for name in self.names)

    @property
    def subjects(self) -> tuple[str, ...]:
        """The subjects that have joints in common, whose names stand before a colon; none of a file
        of one."""
        of_name = [name.rpartition(":")[::2] for name in self.names]
        counts = Counter(joint for _, joint in of_name)
        shared = {joint for joint, count in counts.items() if count > 1}
        if len(shared) < LEAST_SHARED:
            return ()
        return tuple(dict.fromkeys(subject for subject, joint in of_name if joint in shared))

    def with_joint_centres(self) -> JointMotion:
        """Add the joint centre between each pair of markers, such as LWRA+LWRB."""
        names, ps = list(self.names), [self.ps_world_joint]
        for first, second in MARKER_PAIRS:
            for i, name in enumerate(self.names):
                partner = f"{name.removesuffix(first)}{second}"
                if name.rpartition(":")[2] == first and partner in self.names:
                    pair = [i, self.names.index(partner)]
                    names.append(f"{name}+{second}")
                    ps.append(self.ps_world_joint[:, pair].mean(axis=1, keepdims=True))
        return replace(self, names=tuple(names), ps_world_joint=np.concatenate(ps, axis=1))

    def at_rate(self, fps: float) -> JointMotion:
        """The motion with its frames evenly spaced at another rate, from the same first time."""
        if self.is_per_frame:
            return replace(self, times_s=self.times_s / fps, is_per_frame=False)
        return replace(self, times_s=self.times_s[0] + np.arange(len(self)) / fps)

    def per_frame(self, file: str) -> JointMotion:
        """The motion as one that has no clock, its times being numbers of frames."""
        if self.times_s[0] < 0 or (self.times_s != np.round(self.times_s)).any():
            raise FormatError(f"{file} numbers its frames by other than whole numbers from 0 on.")
        return replace(self, is_per_frame=True)

    def on_video(self, file: str, times_s: Array) -> JointMotion:
        """Take the times of a video's frames where it has none of its own; FormatError where there
        are not as many.
        """
        if not self.is_per_frame:
            return self
        if self.times_s[-1] >= len(times_s):
            raise FormatError(
                f"{file} has {self.times_s[-1] + 1:.0f} rows, one for each frame, and the video "
                f"{len(times_s)} frames: give the rows' rate (fps)."
            )
        notes = (*self.notes, Note("row per frame"))
        at_frames = times_s[self.times_s.astype(np.int64)]
        return replace(self, times_s=at_frames, is_per_frame=False, notes=notes)

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
        missing = "frame" if frames < 1 else "joint"
        raise FormatError(f"{file} holds no {missing}.")
    if frames > MOST_FRAMES or joints > MOST_JOINTS or frames * joints * 3 > MOST_NUMBERS:
        raise FormatError(f"{file} has {frames} frames of {joints} joints, which is too much.")
