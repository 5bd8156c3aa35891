"""Estimate an animal's proportions from frames that were posed.

Animals of one kind differ more than people do: a dachshund's legs on a greyhound's trunk would be
folded. Some frames are posed again with every part a little longer, which says how their deviations
change with its length when poses give way: that is one step of Gauss and Newton. A picture shows
size and distance only together, so the body keeps its height.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from keypose.tracker.body.body import Body
from keypose.tracker.body.modify import height, resized, with_height
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.fitting.draft.animals import AnimalFit
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.least_squares import damped_step
from keypose.tracker.solver.sigmas import ANIMAL_SIZE_SHARE

SIZED: Final = (
    "left_front_upper_leg",
    "left_front_lower_leg",
    "left_hind_upper_leg",
    "left_hind_lower_leg",
    "neck",
    "head",
)
"""The parts whose size is estimated beside the trunk's, right legs with the left ones."""
WHOLE: Final = ("head",)
"""Parts of which all is made larger, not the length alone."""
FRAMES: Final = 12
"""Frames that are posed again, spread evenly."""
STEPS: Final = 4
LONGER: Final = 0.04
"""By how much a part is made longer to see what that does, as a logarithm."""
MOST: Final = 0.45
"""By how much a size differs at most from the shelf's, as a logarithm."""


def with_animal_proportions(fit: AnimalFit, motion: Trajectory) -> Body:
    """The body in the proportions with which frames of a motion are fitted best, and its height."""
    rows = _spread(fit)
    some_frames, start = fit.of_rows(rows), _of_rows(motion, rows)
    sizes = np.zeros(len(SIZED))
    for _ in range(STEPS):
        start, now = _posed(some_frames, sizes, start)
        slopes = np.zeros((len(now), len(SIZED)))
        for k in range(len(SIZED)):
            longer = sizes + LONGER * np.eye(len(SIZED))[k]
            slopes[:, k] = (_posed(some_frames, longer, start)[1] - now) / LONGER
        A = slopes.T @ slopes + np.eye(len(SIZED)) / ANIMAL_SIZE_SHARE**2
        b = slopes.T @ now + sizes / ANIMAL_SIZE_SHARE**2
        sizes = np.clip(sizes + damped_step(A, b, 0.0), -MOST, MOST)
    body = fit.skeleton.body
    return with_height(resized_animal(body, sizes), height(body))


def resized_animal(body: Body, sizes: Array) -> Body:
    """The body with its `SIZED` parts larger: logarithms of ratios."""
    for name, factor in zip(SIZED, np.exp(sizes).tolist(), strict=True):
        thicker = factor if name in WHOLE else 1.0
        body = resized(body, name, length_factor=factor, thickness_factor=thicker)
    return body


def _posed(fit: AnimalFit, sizes: Array, start: Trajectory) -> tuple[Trajectory, Array]:
    """The frames posed with other sizes, and what they deviate by."""
    skeleton = Skeleton.of(resized_animal(fit.skeleton.body, sizes))
    return replace(fit, skeleton=skeleton).posed_anew(start)


def _spread(fit: AnimalFit) -> list[int]:
    usable = np.flatnonzero(fit.observed.usable)
    places = np.linspace(0, len(usable) - 1, FRAMES).round()
    return [int(usable[int(place)]) for place in np.unique(places)]


def _of_rows(motion: Trajectory, rows: list[int]) -> Trajectory:
    return Trajectory(0, motion.Rs_parent_part[rows], motion.ps_camera_root[rows])
