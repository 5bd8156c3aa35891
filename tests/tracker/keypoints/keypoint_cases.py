"""Pictures with a person in them, and a network that a test can steer."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from keypose import sample_videos
from keypose.tracker.keypoints.blazepose import NAMES, Seen
from keypose.tracker.keypoints.person_mask import MASK_SIDE, PersonMask
from keypose.tracker.keypoints.region import Region
from keypose.tracker.video.video import Video

BALANCE = Path(sample_videos.__file__).with_name("balance")
BOX = (220.0, 200.0, 390.0, 680.0)
"""Around the man at the first frame, as roughly as one draws it."""
WIDTH = 320
HEIGHT = 240
SIDE = 100.0
NO_MASK = PersonMask.of(Region(0.0, 0.0, 1.0), np.zeros((MASK_SIDE, MASK_SIDE)))
"""Of a network whose masks do not matter."""


def disc(region: Region, share: float = 1.0) -> PersonMask:
    """A mask of a body as wide as half the square."""
    rows, columns = np.indices((MASK_SIDE, MASK_SIDE)) - (MASK_SIDE - 1) / 2
    return PersonMask.of(region, share * (np.hypot(rows, columns) < MASK_SIDE / 4))


@contextmanager
def balance() -> Iterator[Video]:
    with Video.open(BALANCE / "balance.mp4") as video:
        yield video


def marks() -> dict[int, dict[str, NDArray[np.float64]]]:
    """Marked pixels (2,) by frame and joint."""
    frames = json.loads((BALANCE / "marks.json").read_text())["frames"]
    return {
        int(frame): {name: np.array(place[:2]) for name, place in joints.items()}
        for frame, joints in frames.items()
    }


def around(marked: dict[str, NDArray[np.float64]]) -> tuple[float, float, float, float]:
    """A box with room around marked joints."""
    places = np.array(list(marked.values()))
    low, high = places.min(axis=0), places.max(axis=0)
    room = 0.15 * float((high - low).max())
    left, top, right, bottom = (*(low - room), *(high + room / 2))
    return left, top, right, bottom


def body_at(x: float, y: float) -> Region:
    return Region(x, y, SIDE)


@dataclass
class Walker:
    """A made-up network: a body goes from left to right, a pixel a frame, starting at x = 100.

    The pictures hold nothing but their own number. Where the region is not around the body it sees
    nobody. `hidden` frames show nobody; from `strays_at` on, looking forward, it takes up
    something that stays behind, and is as sure of that.
    """

    hidden: frozenset[int] = frozenset()
    strays_at: int | None = None
    looked: list[int] = field(default_factory=list)
    fingerprint: str = "walker"

    def infer(self, picture: NDArray[np.uint8], region: Region) -> Seen:
        number = int(picture[0, 0, 0])
        self.looked.append(number)
        x = true_x(number)
        behind = None if self.strays_at is None else true_x(self.strays_at) - 1
        if behind is not None and number >= self.strays_at and abs(region.x - behind) < 2:
            x = behind
        is_there = abs(region.x - x) < SIDE / 2 and number not in self.hidden
        points = np.full((len(NAMES), 2), (x, 120.0))
        metres = np.zeros((len(NAMES), 3))
        sure = 1.0 if is_there else 0.0
        visibility = np.full(len(NAMES), 0.9)
        return Seen(points, visibility, metres, sure, body_at(x, 120.0), disc(region))


def true_x(number: int) -> float:
    return 100.0 + number


def numbered(number: int) -> NDArray[np.uint8]:
    return np.full((HEIGHT, WIDTH, 3), number, dtype=np.uint8)
