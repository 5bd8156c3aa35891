"""A body that is followed past others: where it may have been taken for one of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.keypoints.blazepose import NAMES, Seen
from keypose.tracker.keypoints.crossings import coincidences, person_changes
from keypose.tracker.keypoints.detect import Seed, detect
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.keypoints.region import Region
from tests.tracker.keypoints.keypoint_cases import HEIGHT, NO_MASK, SIDE, numbered

FRAMES = 80
OFFSETS = np.random.default_rng(5).uniform(-SIDE / 3, SIDE / 3, (len(NAMES), 2))

Place = Callable[[int], float]
TO_THE_RIGHT: Place = lambda frame: 60.0 + 3 * frame  # noqa: E731
TO_THE_LEFT: Place = lambda frame: 301.5 - 3 * frame  # noqa: E731
BESIDE: Place = lambda frame: TO_THE_RIGHT(frame) - 1.5 * SIDE  # noqa: E731


class Street:
    """A made-up network in a street where people walk: it sees whoever is nearest, but in
    some frames one of them, `taken`, for all who are near."""

    fingerprint = "street"

    def __init__(self, *people: Place, taken: Mapping[int, Place] | None = None) -> None:
        self.people, self.taken = people, taken or {}
        self.looked: list[int] = []

    def infer(self, picture: NDArray[np.uint8], region: Region) -> Seen:
        frame = int(picture[0, 0, 0])
        self.looked.append(frame)
        there = [person(frame) for person in self.people]
        x = min(there, key=lambda at: abs(at - region.x))
        if frame in self.taken and abs(self.taken[frame](frame) - region.x) < SIDE:
            x = self.taken[frame](frame)
        uv = OFFSETS + np.array([x, HEIGHT / 2])
        near = float(abs(x - region.x) < SIDE)
        return Seen(uv, np.full(len(NAMES), 0.9), np.zeros((len(NAMES), 3)), near,
                    Region(x, HEIGHT / 2, SIDE), NO_MASK)  # fmt: skip


def changes(network: Street, at: int, person: Place) -> tuple[int, ...]:
    seed = Seed(at, Region(person(at), HEIGHT / 2, SIDE))
    keypoints = detect(numbered, (0, FRAMES - 1), [seed], network)
    network.looked.clear()
    return person_changes(numbered, keypoints, [at], network)


@pytest.mark.parametrize("at", [0, 30, FRAMES - 1])
def test_one_person_is_one_person_all_along(at: int) -> None:
    assert changes(Street(TO_THE_RIGHT), at, TO_THE_RIGHT) == ()


def test_people_side_by_side_are_told_apart() -> None:
    assert changes(Street(TO_THE_RIGHT, BESIDE), 0, TO_THE_RIGHT) == ()


@pytest.mark.parametrize("at", [0, 20])
def test_who_is_taken_for_another_at_a_crossing_may_be_another_from_there_on(at: int) -> None:
    crossing = Street(TO_THE_RIGHT, TO_THE_LEFT, taken=dict.fromkeys(range(38, 44), TO_THE_LEFT))
    (change,) = changes(crossing, at, TO_THE_RIGHT)
    assert 30 <= change <= 48


def test_before_the_box_as_well() -> None:
    crossing = Street(TO_THE_RIGHT, TO_THE_LEFT, taken=dict.fromkeys(range(38, 44), TO_THE_LEFT))
    (change,) = changes(crossing, FRAMES - 1, TO_THE_RIGHT)
    assert 30 <= change <= 48


def test_where_somebody_stands_few_frames_are_looked_at_again() -> None:
    street = Street(lambda frame: 150.0)
    assert changes(street, 0, lambda frame: 150.0) == ()
    assert len(set(street.looked)) <= FRAMES / 8 + 1


def test_what_the_report_raises_ends_the_work() -> None:
    street = Street(TO_THE_RIGHT)
    seed = Seed(0, Region(TO_THE_RIGHT(0), HEIGHT / 2, SIDE))
    keypoints = detect(numbered, (0, FRAMES - 1), [seed], street)

    def leave(done: int, expected: int) -> None:
        assert 0 <= done < expected
        raise InterruptedError

    with pytest.raises(InterruptedError):
        person_changes(numbered, keypoints, [0], street, leave)


def walking(x_of: Callable[[int], float], frames: int = 30) -> Keypoints:
    """Somebody 100 px tall at these places of the picture."""
    rng = np.random.default_rng(5)
    shape = rng.uniform(-1, 1, (len(NAMES), 2)) * (20, 50)
    uv = np.array([shape + np.array([x_of(frame), 200.0]) for frame in range(frames)])
    return Keypoints(10, NAMES, uv, np.ones(uv.shape[:2]))


@pytest.mark.parametrize(
    ("paths", "begins"),
    [
        ((lambda n: 100.0, lambda n: 300.0), ((), ())),
        ((lambda n: 100.0, lambda n: 10.0 * n), ((18,), (18,))),
        ((lambda n: 100.0, lambda n: 300.0 - 10.0 * n), ((28,), (28,))),
        ((lambda n: 100.0, lambda n: 105.0), ((10,), (10,))),
        ((lambda n: 100.0, lambda n: 100.0 + 60.0 * (n % 15 > 4)), ((10, 25), (10, 25))),
        ((lambda n: 100.0, lambda n: 300.0, lambda n: 105.0), ((10,), (), (10,))),
    ],
    ids=["apart", "passing", "the other way", "always", "twice", "of three"],
)
def test_from_where_two_lie_on_each_other_each_may_be_the_other(
    paths: tuple[Callable[[int], float], ...], begins: tuple[tuple[int, ...], ...]
) -> None:
    assert coincidences([walking(path) for path in paths]) == list(begins)


def test_while_one_of_them_is_unseen_nobody_lies_on_anybody() -> None:
    first, second = walking(lambda n: 100.0), walking(lambda n: 105.0)
    uv = second.uv.copy()
    uv[:12] = np.nan
    assert coincidences([first, replace(second, uv=uv)]) == [(22,), (22,)]
