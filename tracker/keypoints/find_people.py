"""Find the people in a film before anybody has said where they are: a box to draft each from."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.detect import MOST_LOOKS_AT_SEED, Detector, Rows
from keypose.tracker.keypoints.detectors import open_detector
from keypose.tracker.keypoints.joint_network import JointNetwork, SeenJoints
from keypose.tracker.keypoints.model_files import THUNDER
from keypose.tracker.keypoints.region import SMALLEST_BOX_PX, Box, Region

FRAMES: Final = 5
"""Frames of a film that are looked at, spread over it."""
WHOLE_AND_NEAR: Final[Sequence[float]] = (1.0, 0.6)
"""Sides of the squares that are searched, shares of the picture's shorter side but for the first,
which shows all of it. A person of a third of the height is found in the second."""
FAR: Final[Sequence[float]] = (0.3,)
"""The same for people who are small, looked for where nobody else was found."""
OVERLAP: Final = 0.5
"""By how much neighbouring squares overlap, a share of their side."""
SURE_JOINT: Final = 0.2
LEAST_JOINTS: Final = 4
LEAST_CANDIDATE: Final = 0.3
"""Mean confidence of the joints from which on a candidate is looked at closely."""
LEAST_CONFIDENCE: Final = 0.4
"""The same of somebody who was: people in films 0.59 to 0.84, rendered ones from 0.42 on, poles and
branches 0.12 to 0.30."""
SAME: Final = 0.6
"""Shared area over the smaller box's, from which on two boxes are around one person."""
AS_LARGE: Final = 0.6
"""Somebody of so much of the tallest one's height may be the one who is meant."""
MARGIN: Final = 0.13
"""Around the joints, of the longer side around them: the crown lies so far above the ears."""


@dataclass(frozen=True)
class FoundPerson:
    """A person in one picture. box: around the body, within the picture, pixels.
    confidence: mean of the joints', from 0 to 1."""

    box: Box
    confidence: float

    @property
    def height_px(self) -> float:
        return self.box[3] - self.box[1]


@dataclass(frozen=True)
class PeopleInFilm:
    """Who may be drafted, in one frame.

    frame: the one that shows them best.  people: from left to right.
    smaller: by frame, those left out as they are much smaller.
    """

    frame: int
    people: tuple[FoundPerson, ...]
    smaller: Mapping[int, tuple[FoundPerson, ...]]


class PeopleFinder:
    """Finds everybody in a picture, with the two bundled networks."""

    def __init__(
        self,
        detector: Detector,
        joints: JointNetwork,
        leave: Callable[[], object] = lambda: None,
    ) -> None:
        """leave: called before every look at a part of the picture; may raise Cancelled."""
        self._detector, self._joints, self._leave = detector, joints, leave

    @classmethod
    def open(cls, leave: Callable[[], object] = lambda: None) -> PeopleFinder:
        """KeypointError where a network cannot be read."""
        return cls(open_detector(THUNDER), JointNetwork.open(THUNDER), leave)

    def near_or_far(self, picture: NDArray[np.uint8]) -> tuple[FoundPerson, ...]:
        """The people in a picture; those who are far away where nobody is near."""
        return self(picture) or self(picture, FAR)

    def __call__(
        self, picture: NDArray[np.uint8], shares: Sequence[float] = WHOLE_AND_NEAR
    ) -> tuple[FoundPerson, ...]:
        """The people in a picture (H, W, 3), RGB, the surest first."""
        people: list[FoundPerson] = []
        for box in self._candidates(picture, shares):
            if any(_shared(box, found_person.box) > SAME for found_person in people):
                continue
            person = self._near(picture, box)
            if person is not None and all(_shared(person.box, p.box) <= SAME for p in people):
                people.append(person)
        return tuple(sorted(people, key=lambda person: -person.confidence))

    def _candidates(self, picture: NDArray[np.uint8], shares: Sequence[float]) -> list[Box]:
        """Boxes of what may be people, the likeliest first."""
        height, width = picture.shape[:2]
        rated = [
            (float(seen_joints.confidence.mean()), box)
            for square in searched_squares(width, height, shares)
            for seen_joints in self._everybody(picture, square)
            if (box := _box_of_joints(seen_joints, width, height)) is not None
        ]
        likely = [each for each in rated if each[0] >= LEAST_CANDIDATE]
        return [box for _, box in sorted(likely, key=lambda each: -each[0])]

    def _everybody(self, picture: NDArray[np.uint8], square: Region) -> Sequence[SeenJoints]:
        self._leave()
        return self._joints.everybody(picture, square)

    def _near(self, picture: NDArray[np.uint8], box: Box) -> FoundPerson | None:
        """Who is in a box, as drafting would find them from it; None where nobody is."""
        self._leave()
        height, width = picture.shape[:2]
        begun = Region.of_box(box, width, height)
        rows = Rows.begun(begun, self._detector, picture, MOST_LOOKS_AT_SEED)
        uv = rows.stretch().uv[0]
        if not np.isfinite(uv).all():
            return None
        confidence = float(self._joints.infer(picture, rows.region).confidence.mean())
        around = _box_around(uv, width, height)
        if confidence < LEAST_CONFIDENCE or around is None:
            return None
        return FoundPerson(around, round(confidence, 3))


def spread_frames(first: int, last: int) -> list[int]:
    """Frames to look at, spread between two, which films often begin or end badly with."""
    return sorted(set(np.linspace(first, last, FRAMES + 2).round().astype(int)[1:-1].tolist()))


def searched_squares(width: int, height: int, shares: Sequence[float]) -> Iterator[Region]:
    """Squares that cover a picture, those of each share overlapping; a share of 1 is all of it."""
    for share in shares:
        if share >= 1.0:
            yield Region((width - 1) / 2, (height - 1) / 2, float(max(width, height)))
            continue
        side = share * min(width, height)
        for y in _middles(height, side):
            for x in _middles(width, side):
                yield Region(x, y, side)


def _middles(length: int, side: float) -> list[float]:
    count = int(np.ceil((length - side) / ((1 - OVERLAP) * side))) + 1
    return [float(x) for x in np.linspace(side / 2, length - side / 2, count) - 0.5]


def people_in_film(people_of_frame: Mapping[int, Sequence[FoundPerson]]) -> PeopleInFilm | None:
    """Who may be meant, of the people seen at some frames: in the frame with the most people of
    about the tallest one's height in any of them, and of such frames in that with the surest. None
    where there is nobody."""
    large: dict[int, list[FoundPerson]] = {}
    smaller: dict[int, tuple[FoundPerson, ...]] = {}
    heights = [person.height_px for people in people_of_frame.values() for person in people]
    tallest = max(heights, default=0.0)
    for frame, people in people_of_frame.items():
        large[frame] = [p for p in people if p.height_px >= AS_LARGE * tallest]
        if rest := tuple(p for p in people if p.height_px < AS_LARGE * tallest):
            smaller[frame] = rest
    if not any(large.values()):
        return None

    def rank(frame: int) -> tuple[int, float]:
        return len(large[frame]), min((p.confidence for p in large[frame]), default=0.0)

    best = max(large, key=rank)
    return PeopleInFilm(best, tuple(sorted(large[best], key=lambda p: p.box[0])), smaller)


def _box_of_joints(seen_joints: SeenJoints, width: int, height: int) -> Box | None:
    """Around the joints that are sure; None of too few, or of none in the picture."""
    sure = seen_joints.confidence >= SURE_JOINT
    if sure.sum() < LEAST_JOINTS:
        return None
    return _box_around(seen_joints.uv[sure], width, height)


def _box_around(uv: Array, width: int, height: int) -> Box | None:
    """Around pixels (N, 2), with a margin, as far as it lies in the picture; None where it does
    not, or has no size."""
    low, high = uv.min(axis=0), uv.max(axis=0)
    margin = MARGIN * float((high - low).max())
    edges = np.array([width - 1, height - 1])
    low, high = np.clip(low - margin, 0, edges), np.clip(high + margin, 0, edges)
    if (high - low).min() < SMALLEST_BOX_PX:
        return None
    (left, top), (right, bottom) = low.round().tolist(), high.round().tolist()
    return left, top, right, bottom


def _shared(first: Box, second: Box) -> float:
    """The area that two boxes share, over the smaller one's."""
    width = min(first[2], second[2]) - max(first[0], second[0])
    height = min(first[3], second[3]) - max(first[1], second[1])
    least = min((b[2] - b[0]) * (b[3] - b[1]) for b in (first, second))
    return max(width, 0.0) * max(height, 0.0) / least
