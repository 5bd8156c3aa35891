"""Where a followed body may become another one: two people cross, and the network goes on with the
wrong one.

Followed back from where it ended, a body comes to where it began, unless it was taken for another
on the way: at a crossing each way goes straight on, and before it they are two. Only frames between
which the body has moved are looked at again.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import combinations
from typing import Final

import numpy as np

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.blazepose import NAMES
from keypose.tracker.keypoints.detect import Detector, Frame, Rows
from keypose.tracker.keypoints.keypoints import JOINTS, Keypoints
from keypose.tracker.keypoints.outliers import TRUNK
from keypose.tracker.keypoints.region import Region

APART: Final = 0.25
"""Distance of two trunks, in sides of the region, from which on they are two people's: the length
of a trunk."""
MOVED: Final = 0.08
"""A frame is looked at again where the body has moved so far, in sides of the region, ..."""
SELDOM: Final = 8
"""... and one in so many where it stands."""
FIRST_LOOKS: Final = 2
"""The region where it begins is looked at so often at most."""
COINCIDE: Final = 0.25
"""Joints of two people that are so far apart in the median, in heights of the smaller one, lie on
each other."""
JOINT_COLUMNS: Final = [NAMES.index(name) for name in JOINTS]
"""Of the twelve joints among the 33 keypoints."""
_TRUNK: Final = [NAMES.index(name) for name in TRUNK]


def person_changes(
    frame: Frame,
    keypoints: Keypoints,
    seeds: Sequence[int],
    network: Detector,
    report: Callable[[int, int], None] = lambda done, expected: None,
) -> tuple[int, ...]:
    """The frames from which on the body may be another one than before, ascending.

    keypoints: as `detect` found them from seeds at these frames. Between two of them the body
               comes out at both.
    report:    frames looked at and to look at, before each; what it raises ends the work.
    """
    ways = [_back_to(max(seeds), keypoints, 1), _back_to(min(seeds), keypoints, -1)]
    changes, done, expected = list[int](), 0, sum(map(len, ways))
    for numbers in ways:
        again: Rows | None = None
        for k, number in enumerate(numbers):
            report(done, expected)
            picture, done = frame(number), done + 1
            before = keypoints.uv[number - keypoints.first_frame]
            if again is None:
                again = Rows.begun(region_around(before), network, picture, FIRST_LOOKS)
                continue
            again.add(network, picture)
            if _are_apart(before, again):
                changes.append(max(number, numbers[k - 1]))
                again = None  # goes on with the body as it was followed
    return tuple(sorted(set(changes)))


def _are_apart(before: Array, again: Rows) -> bool:
    """Whether a body that is followed again is elsewhere in its newest frame."""
    uv = again.stretch().uv[-1]
    return bool(np.isfinite(uv).all()) and trunk_distance(before, uv) > APART


def _back_to(at: int, keypoints: Keypoints, step: int) -> list[int]:
    """The frames to look at, from the last one that shows the body in this direction."""
    end = keypoints.last_frame if step > 0 else keypoints.first_frame
    numbers: list[int] = []
    for number in range(at, end + step, step):
        uv = keypoints.uv[number - keypoints.first_frame]
        if not np.isfinite(uv).all():
            continue
        if numbers and abs(number - numbers[-1]) < SELDOM:
            last = keypoints.uv[numbers[-1] - keypoints.first_frame]
            if trunk_distance(last, uv) < MOVED:
                continue
        numbers.append(number)
    return numbers[::-1]


def coincidences(people: Sequence[Keypoints]) -> list[tuple[int, ...]]:
    """Of each of several people the frames from which on their joints lie on those of another one:
    from then on each may be the other.

    people: over the same frames.
    """
    begins: list[set[int]] = [set() for _ in people]
    uv_of_people = [keypoints.uv[:, JOINT_COLUMNS] for keypoints in people]
    heights = [float(np.nanmedian(np.ptp(uv[..., 1], axis=1))) for uv in uv_of_people]
    for a, b in combinations(range(len(people)), 2):
        apart = np.linalg.norm(uv_of_people[a] - uv_of_people[b], axis=-1)
        median = np.nan_to_num(np.median(apart, axis=1), nan=np.inf)  # of frames they are both in
        coincide = median < COINCIDE * min(heights[a], heights[b])
        first_rows = np.flatnonzero(np.diff(coincide.astype(int), prepend=0) > 0)
        frames = (first_rows + people[a].first_frame).tolist()
        begins[a].update(frames)
        begins[b].update(frames)
    return [tuple(sorted(each)) for each in begins]


def trunk_distance(first: Array, second: Array) -> float:
    """The distance of two trunks, of keypoints (33, 2), in sides of the region."""
    side = np.sqrt(region_around(first).side * region_around(second).side)
    return float(np.linalg.norm(first[_TRUNK].mean(axis=0) - second[_TRUNK].mean(axis=0)) / side)


def region_around(uv: Array) -> Region:
    """Around keypoints (33, 2)."""
    return Region.of_joints(uv, uv[_TRUNK[:2]].mean(axis=0) - uv[_TRUNK[2:]].mean(axis=0))
