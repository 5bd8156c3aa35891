"""Gait: when feet touch the ground and leave it, and the strides between.

A stance is where a foot stands still, as its pins say, or as it is found standing. The foot comes
down before all of it stands still, and its heel leaves before its toes do. Both moments are those
of Zeni et al. (2008): the heel strikes where it is farthest ahead of the root, the toes leave where
they are farthest behind it, both along the way that the root takes there.

A stride goes from one heel strike of a foot to its next. Its length is the distance between the
two places where the foot stood, measured on the ground; step length and width are where the other
foot stood in between, along this line and across it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np

from keypose.tracker.body.body import Body
from keypose.tracker.body.ground import Ground
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.pins import Pin, sole_of

WAY_S: Final = 0.25
"""Width of the Gaussian over which the root's way is measured."""
APART_S: Final = 0.12
"""Pins of one foot that are no farther apart are one stance: a heel's end, the toes' begin."""
BEFORE_S: Final = 0.35
"""How long before a foot stands still its heel may strike, and after it does not its toes leave."""
LEAST_STRIDE_M: Final = 0.2
"""A foot put down nearer to where it stood has made no stride."""
SLOWEST_S: Final = 3.0
"""Nor has one that took longer."""


@dataclass(frozen=True, eq=False)
class FootPath:
    """One foot over N frames: its side's name, and heel and toe on the ground (N, 3), metres."""

    part: str
    heel: Array
    toe: Array


@dataclass(frozen=True)
class Stance:
    """A foot on the ground.

    still:       first and last frame at which it stands still.
    heel_strike, toe_off: frames; None where the motion does not show them.
    place_m:     where the heel stood on the ground: x ahead, z to the right.
    """

    part: str
    still: tuple[int, int]
    heel_strike: int | None
    toe_off: int | None
    place_m: tuple[float, float]


@dataclass(frozen=True)
class Stride:
    """From a heel strike to the same foot's next. What another foot would show is None without one.

    step_length_m: from where the other foot stood to where this one comes down.
    step_width_m:  how far the other foot stood beside the line of this one's, on its own side;
                   negative where the feet cross.
    stance_share:  of the stride's time that the foot is on the ground, 0 to 1.
    """

    part: str
    first_frame: int
    last_frame: int
    time_s: float
    length_m: float
    step_length_m: float | None
    step_width_m: float | None
    stance_share: float | None

    @property
    def speed_m_s(self) -> float:
        return self.length_m / self.time_s

    @property
    def cadence(self) -> float:
        """Steps a minute, of which a stride has two."""
        return 120.0 / self.time_s


@dataclass(frozen=True)
class Gait:
    """Stances and strides of all feet, in the order of their beginnings."""

    stances: tuple[Stance, ...]
    strides: tuple[Stride, ...]


def gait_of(
    skeleton: Skeleton, motion: Trajectory, times_s: Array, ground: Ground, pins: Sequence[Pin]
) -> Gait:
    """The gait of a body with feet; empty where none stands.

    times_s: (N,) of the motion's frames; poses that are not known are NaN.
    """
    Ts = motion.transforms(skeleton)
    root = ground.points(Ts[:, 0, :3, 3])
    paths = [_path(skeleton.body, part, Ts, ground) for part in _feet(skeleton.body)]
    first = motion.first_frame
    still = [(path, _stood(path.part, pins, first, times_s)) for path in paths]
    return gait_of_paths(root, still, times_s, first)


def gait_of_paths(
    root: Array,
    feet: Sequence[tuple[FootPath, Sequence[tuple[int, int]]]],
    times_s: Array,
    first_frame: int = 0,
) -> Gait:
    """The gait of feet on the ground.

    root: (N, 3).  feet: each with the rows at which it stands still, first and last, ascending.
    """
    direction = _way(root, times_s)
    stances: list[Stance] = []
    for path, still in feet:
        stances += _stances(path, still, root, direction, times_s, first_frame)
    stances.sort(key=lambda stance: stance.still)
    strides = [
        stride
        for path, _ in feet
        for one, next_ in pairwise(s for s in stances if s.part == path.part)
        if (stride := _stride(one, next_, stances, times_s, first_frame))
    ]
    return Gait(tuple(stances), tuple(sorted(strides, key=lambda s: (s.first_frame, s.part))))


def _feet(body: Body) -> list[str]:
    return [part.name for part in body.parts if sole_of(part)]


def _path(body: Body, part: str, Ts: Array, ground: Ground) -> FootPath:
    i = body.index(part)
    landmarks = body.parts[i].landmarks
    heel, toe = (
        ground.points(Ts[:, i, :3, :3] @ np.array(landmarks[name]) + Ts[:, i, :3, 3])
        for name in sole_of(body.parts[i])
    )
    return FootPath(part, heel, toe)


def _stood(
    part: str, pins: Sequence[Pin], first_frame: int, times_s: Array
) -> list[tuple[int, int]]:
    """The rows at which a foot stands still by its pins, neighbouring pins as one."""
    spans = sorted(pin.span for pin in pins if pin.part == part)
    last = len(times_s) - 1
    rows = [(max(a - first_frame, 0), min(b - first_frame, last)) for a, b in spans]
    ranges: list[tuple[int, int]] = []
    for a, b in rows:
        if a > b:
            continue
        if ranges and times_s[a] - times_s[ranges[-1][1]] <= APART_S:
            ranges[-1] = (ranges[-1][0], max(ranges[-1][1], b))
        else:
            ranges.append((a, b))
    return ranges


def _way(root: Array, times_s: Array) -> Array:
    """(N, 3) level unit vectors along the root's way, NaN where it is not known."""
    from scipy.ndimage import gaussian_filter1d  # scipy: loads longer than a page needs to start

    level = root * [1.0, 0.0, 1.0]
    step_s = float(np.median(np.diff(times_s))) if len(times_s) > 1 else 1.0
    is_known = np.isfinite(level[:, 0])
    direction = np.full(root.shape, np.nan)
    if is_known.sum() > 1:
        filled = np.column_stack(
            [np.interp(times_s, times_s[is_known], level[is_known, k]) for k in range(3)]
        )
        v = gaussian_filter1d(np.gradient(filled, axis=0), WAY_S / step_s, axis=0, mode="nearest")
        direction = v / np.maximum(np.linalg.norm(v, axis=1, keepdims=True), 1e-9)
    direction[~is_known] = np.nan
    return direction


def _stances(
    path: FootPath,
    still: Sequence[tuple[int, int]],
    root: Array,
    direction: Array,
    times_s: Array,
    first_frame: int,
) -> list[Stance]:
    """Every stance of one foot with its two moments."""
    ahead = ((path.heel - root) * direction).sum(axis=1)
    behind = -((path.toe - root) * direction).sum(axis=1)
    stances = []
    for k, (a, b) in enumerate(still):
        before = still[k - 1][1] + 1 if k else 0
        after = still[k + 1][0] - 1 if k + 1 < len(still) else len(times_s) - 1
        strike = _peak(ahead, max(before, _row(times_s, times_s[a] - BEFORE_S)), (a + b) // 2)
        off = _peak(behind, (a + b) // 2, min(after, _row(times_s, times_s[b] + BEFORE_S)))
        stood = path.heel[a : b + 1]
        stood = stood[np.isfinite(stood).all(axis=1)]
        if not len(stood):
            continue
        x, _, z = stood.mean(axis=0)
        stances.append(
            Stance(
                path.part,
                (a + first_frame, b + first_frame),
                None if strike is None else strike + first_frame,
                None if off is None else off + first_frame,
                (float(x), float(z)),
            )
        )
    return stances


def _peak(values: Array, first: int, last: int) -> int | None:
    """The row of the highest value between two rows, both included; None where it is at an end or
    a value is not known, for then what lies beyond may be higher."""
    between = values[first : last + 1]
    if len(between) < 3 or not np.isfinite(between).all():
        return None
    at = int(between.argmax())
    return first + at if 0 < at < len(between) - 1 else None


def _row(times_s: Array, time_s: float) -> int:
    """The row nearest to a time."""
    return int(np.abs(times_s - time_s).argmin())


def _stride(
    stance: Stance, next_: Stance, stances: Sequence[Stance], times_s: Array, first_frame: int
) -> Stride | None:
    """The stride between two stances of a foot; None where it is none, or not seen whole."""
    if stance.heel_strike is None or next_.heel_strike is None:
        return None
    start, end = (float(times_s[f - first_frame]) for f in (stance.heel_strike, next_.heel_strike))
    path = np.subtract(next_.place_m, stance.place_m)
    length = float(np.linalg.norm(path))
    if length < LEAST_STRIDE_M or end - start > SLOWEST_S:
        return None
    others = [s for s in stances if s.part != stance.part and stance.still < s.still < next_.still]
    step = width = share = None
    if len(others) == 1:
        ahead = path / length
        from_other = np.subtract(next_.place_m, others[0].place_m)
        step = float(from_other @ ahead)
        beside = float(from_other[0] * ahead[1] - from_other[1] * ahead[0])  # other to the right
        width = -beside if others[0].part.startswith("left") else beside
    if stance.toe_off is not None:
        share = (float(times_s[stance.toe_off - first_frame]) - start) / (end - start)
    return Stride(
        stance.part, stance.heel_strike, next_.heel_strike, end - start, length, step, width, share
    )
