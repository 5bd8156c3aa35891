"""Several people in one film stay who they are, also where they pass each other."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.errors import KeypointError
from keypose.tracker.keypoints.blazepose import NAMES, Seen
from keypose.tracker.keypoints.detect import DetectionWindow, Progress, Seed, detect
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.keypoints.people import (
    GREY,
    detect_people,
    painted_area,
    painted_out,
    people_changes,
)
from keypose.tracker.keypoints.person_mask import FULL_LEVEL, MASK_SIDE, PersonMask
from keypose.tracker.keypoints.region import Region
from tests.tracker.keypoints.keypoint_cases import HEIGHT, WIDTH, disc

FRAMES = 60
SIDE = 100.0
HALF_WIDTH = 10
MIDDLE_Y = HEIGHT // 2
OFFSETS = np.random.default_rng(3).uniform(-1, 1, (len(NAMES), 2)) * (HALF_WIDTH, 40)
LEAST_PIXELS = 300
"""Of a person of 20 × 80 pixels, for the network to see them."""

Place = Callable[[float], float]


def to_the_right(frame: float) -> float:
    return 80.0 + 3 * frame


def to_the_left(frame: float) -> float:
    return 257.0 - 3 * frame


def waiting(frame: float) -> float:
    return 170.0


@dataclass
class Street:
    """Upright blocks of a level each, the nearest last, and a made-up network that sees whichever
    shows most of itself near the middle of a region: so it exchanges people who pass."""

    people: tuple[Place, ...]
    slower: int = 1
    looked: list[int] = field(default_factory=list)
    fingerprint: str = "street"

    def tall(self, index: int) -> int:
        """Pixels; who is nearer is taller."""
        return 80 + 10 * index

    def picture(self, number: int) -> NDArray[np.uint8]:
        picture = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
        for index, person in enumerate(self.people):
            x, half = round(person(number / self.slower)), self.tall(index) // 2
            left, right = max(x - HALF_WIDTH, 0), max(x + HALF_WIDTH, 0)
            picture[MIDDLE_Y - half : MIDDLE_Y + half, left:right] = 200 + index
        picture[0, 0] = number
        return picture

    def infer(self, picture: NDArray[np.uint8], region: Region) -> Seen:
        self.looked.append(int(picture[0, 0, 0]))
        levels, near = picture[..., 0], np.zeros((HEIGHT, WIDTH), np.bool_)
        left = max(round(region.x - 30), 0)
        near[:, left : left + 60] = True
        counts = [int((near & (levels == 200 + k)).sum()) for k in range(len(self.people))]
        person = int(np.argmax(counts))
        shown = levels == 200 + person
        _, columns = np.nonzero(shown)
        x = float(columns.mean()) if len(columns) else region.x
        body = Region(x, MIDDLE_Y, 1.25 * self.tall(person))
        return Seen(
            OFFSETS + np.array([x, MIDDLE_Y]),
            np.full(len(NAMES), 0.9),
            np.zeros((len(NAMES), 3)),
            float(max(counts) >= LEAST_PIXELS),
            body,
            _mask(shown, region),
        )


def _mask(shown: NDArray[np.bool_], region: Region) -> PersonMask:
    """What of a picture is shown, in the square of a region."""
    A = region.to_picture(MASK_SIDE)
    rows, columns = np.indices((MASK_SIDE, MASK_SIDE))
    uv = np.stack([columns, rows], axis=-1) @ A[:, :2].T + A[:, 2]
    x, y = (np.rint(uv[..., k]).astype(int) for k in (0, 1))
    inside = (x >= 0) & (x < WIDTH) & (y >= 0) & (y < HEIGHT)
    share = np.zeros((MASK_SIDE, MASK_SIDE))
    share[inside] = shown[y[inside], x[inside]]
    return PersonMask.of(region, share)


def seed(frame: int, person: Place, slower: int = 1) -> Seed:
    return Seed(frame, Region(person(frame / slower), MIDDLE_Y, SIDE))


def together(street: Street, *frames: int) -> list[Keypoints]:
    """Everybody in all frames, those between the second ones skipped where people go slower."""
    seeds = [[seed(n, person, street.slower) for n in frames] for person in street.people]
    last, every_second = street.slower * (FRAMES - 1), street.slower > 1
    return detect_people(street.picture, (0, last), seeds, street, every_second=every_second)


def x_of(keypoints: Keypoints) -> NDArray[np.float64]:
    return np.asarray((keypoints.uv - OFFSETS)[..., 0].mean(axis=1))


CROSSINGS = {
    "one goes past who waits behind": (waiting, to_the_right),
    "one goes past who waits in front": (to_the_right, waiting),
    "both go": (to_the_left, to_the_right),
    "three": (waiting, to_the_left, to_the_right),
}


@pytest.mark.parametrize("people", CROSSINGS.values(), ids=CROSSINGS)
@pytest.mark.parametrize("frames", [(0,), (FRAMES - 1,), (0, FRAMES - 1), (6, 50)])
@pytest.mark.parametrize("slower", [1, 2], ids=["each frame", "every second frame"])
def test_who_passes_another_stays_who_they_are(
    people: tuple[Place, ...], frames: tuple[int, ...], slower: int
) -> None:
    street = Street(people, slower)
    at = [slower * frame for frame in frames]
    for person, keypoints in zip(people, together(street, *at), strict=True):
        x, true_x = x_of(keypoints), np.array([person(n / slower) for n in range(len(keypoints))])
        is_seen = np.isfinite(x)
        assert is_seen.mean() > 0.6
        assert is_seen[[0, -1]].all()
        assert np.abs(x - true_x)[is_seen].max() < HALF_WIDTH + 1


def test_alone_the_network_would_have_exchanged_them() -> None:
    street = Street((waiting, to_the_right))
    keypoints = detect(street.picture, (0, FRAMES - 1), [seed(0, waiting)], street)
    assert x_of(keypoints)[-1] == pytest.approx(to_the_right(FRAMES - 1), abs=1.0)


def test_whoever_is_hidden_is_unseen_meanwhile() -> None:
    behind, nearer = together(Street((waiting, to_the_right)), 0)
    hidden = [n for n in range(FRAMES) if abs(to_the_right(n) - waiting(n)) < HALF_WIDTH / 2]
    assert hidden
    assert np.isnan(behind.uv[hidden]).all()
    assert (behind.visibility[hidden] == 0).all()
    assert all(behind.mask(n) is None for n in hidden)
    assert np.isfinite(nearer.uv).all()


def exchanged_from(people: list[Keypoints], frame: int) -> list[Keypoints]:
    """Two people, each of whom is the other one from a frame on."""
    first, second = people
    return [
        below.over(0, frame - 1).overlaid(above.over(frame, FRAMES - 1))
        for below, above in ((first, second), (second, first))
    ]


@pytest.mark.parametrize("at", [0, FRAMES - 1])
def test_where_people_were_exchanged_they_may_be_another_from_there_on(at: int) -> None:
    street = Street(CROSSINGS["both go"])
    people = together(street, at)
    assert people_changes(street.picture, people, [at], street) == [(), ()]
    wrong = exchanged_from(people, 20)
    for changes in people_changes(street.picture, wrong, [at], street):
        assert len(changes) == 1
        assert 18 <= changes[0] <= 22


def test_one_person_is_detected_as_ever() -> None:
    street = Street((to_the_right,))
    (keypoints,) = together(street, 5, 40)
    seeds = [seed(5, to_the_right), seed(40, to_the_right)]
    alone = detect(street.picture, (0, FRAMES - 1), seeds, street)
    np.testing.assert_array_equal(keypoints.uv, alone.uv)
    assert keypoints.masks == alone.masks


def test_people_far_from_each_other_are_seen_as_each_alone() -> None:
    people = (lambda frame: 30.0, lambda frame: 290.0)
    street = Street(people)
    for person, keypoints in zip(people, together(street, 0), strict=True):
        alone = detect(street.picture, (0, FRAMES - 1), [seed(0, person)], street)
        np.testing.assert_array_equal(keypoints.uv, alone.uv)


def test_what_was_kept_is_not_looked_at_again() -> None:
    class InMemory(dict[str, DetectionWindow]):
        def put(self, key: str, stretch: DetectionWindow) -> None:
            self[key] = stretch

    kept, street = InMemory(), Street(CROSSINGS["both go"])
    seeds = [[seed(20, person)] for person in street.people]

    def run() -> list[Keypoints]:
        return detect_people(street.picture, (0, FRAMES - 1), seeds, street, film="film", kept=kept)

    first = run()
    street.looked.clear()
    for before, again in zip(first, run(), strict=True):
        np.testing.assert_array_equal(before.uv, again.uv)
        assert before.masks == again.masks
    assert set(street.looked) <= {20}


def test_progress_counts_everybodys_frames_and_what_it_raises_ends_the_work() -> None:
    street, reported = Street(CROSSINGS["three"]), list[Progress]()
    seeds = [[seed(20, person)] for person in street.people]
    detect_people(street.picture, (0, FRAMES - 1), seeds, street, report=reported.append)
    assert all(each.done < each.expected for each in reported)
    assert reported[-1].done == reported[-1].expected - 1 >= 3 * (FRAMES - 1)

    def leave(progress: Progress) -> None:
        raise InterruptedError

    with pytest.raises(InterruptedError):
        detect_people(street.picture, (0, FRAMES - 1), seeds, street, report=leave)


def test_a_box_without_anybody_is_told() -> None:
    street = Street((waiting, to_the_right))
    seeds = [[seed(0, waiting)], [Seed(7, Region(300.0, MIDDLE_Y, SIDE))]]
    with pytest.raises(KeypointError, match="No person was found at frame 7"):
        detect_people(street.picture, (0, FRAMES - 1), seeds, street)


def test_two_boxes_around_one_person_are_told() -> None:
    street = Street((waiting,))
    seeds = [[seed(0, waiting)], [Seed(0, Region(172.0, MIDDLE_Y, SIDE))]]
    with pytest.raises(KeypointError, match="Two boxes at frame 0 are around the same person"):
        detect_people(street.picture, (0, FRAMES - 1), seeds, street)


class GreyStreet(Street):
    """One whose network takes the grey of who was painted out for a person of their size."""

    def infer(self, picture: NDArray[np.uint8], region: Region) -> Seen:
        rows, columns = np.nonzero(picture[..., 0] == GREY)
        if len(rows) < LEAST_PIXELS:
            return super().infer(picture, region)
        x = float(columns.mean()) + 0.15 * SIDE  # elsewhere than who was painted out
        seen = super().infer(np.full_like(picture, 200), region)
        narrow = OFFSETS * (0.2, -0.8) + np.array([columns.mean(), MIDDLE_Y])
        return replace(seen, uv=narrow, next=Region(x, MIDDLE_Y, SIDE))


def test_whoever_is_seen_in_the_grey_of_another_is_nobody_new() -> None:
    street = GreyStreet((waiting,))
    seeds = [[seed(0, waiting)], [Seed(0, Region(172.0, MIDDLE_Y, SIDE))]]
    with pytest.raises(KeypointError, match="or one is around somebody who has a body already"):
        detect_people(street.picture, (0, FRAMES - 1), seeds, street)


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_boxes_drawn_where_one_partly_hides_the_other_are_of_both(order: tuple[int, int]) -> None:
    street = Street((waiting, to_the_right))
    both = [seed(24, waiting), seed(24, to_the_right)]
    seeds = [[both[index]] for index in order]
    people = detect_people(street.picture, (0, FRAMES - 1), seeds, street)
    for index, keypoints in zip(order, people, strict=True):
        x, person = x_of(keypoints), street.people[index]
        assert abs(x[0] - person(0)) < 1
        assert abs(x[-1] - person(FRAMES - 1)) < 1


def test_frames_that_cannot_be_decoded_are_unseen() -> None:
    street = Street((waiting, to_the_right))
    seeds = [[seed(0, person)] for person in street.people]
    for keypoints in detect_people(
        lambda number: None if number == 9 else street.picture(number),
        (0, FRAMES - 1),
        seeds,
        street,
    ):
        assert np.isnan(keypoints.uv[9]).all()
        assert np.isfinite(keypoints.uv[10]).all()


def test_others_are_painted_out_but_for_what_is_as_likely_the_own() -> None:
    picture = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
    mask, own = disc(Region(100.0, 100.0, 80.0)), disc(Region(120.0, 100.0, 80.0))
    assert painted_out(picture, painted_area(picture, [], own)) is picture
    painted = painted_out(picture, painted_area(picture, [mask], own))
    assert (painted[100, 90] == GREY).all()
    assert (painted[100, 110] == 0).all(), "both are there"
    assert (painted[100, 130] == 0).all()
    assert not picture.any()


def test_a_mask_leaves_what_was_painted_out_of_its_picture() -> None:
    mask, area = disc(Region(120.0, 100.0, 80.0)), np.zeros((HEIGHT, WIDTH), np.bool_)
    assert mask.without(area) == mask
    area[:, :115] = True
    left = mask.without(area).in_picture(WIDTH, HEIGHT)
    whole = mask.in_picture(WIDTH, HEIGHT)
    assert whole[100, 105] > 0.9
    assert left[100, 105] < 0.1
    np.testing.assert_allclose(left[:, 118:], whole[:, 118:], atol=0.01)


class Greedy(Street):
    """One whose network takes the grey beside a person for a part of them."""

    def infer(self, picture: NDArray[np.uint8], region: Region) -> Seen:
        seen = super().infer(picture, region)
        grey = picture[..., 0] == GREY
        assert seen.mask is not None
        share = np.maximum(seen.mask.levels() / FULL_LEVEL, _mask(grey, region).levels())
        return replace(seen, mask=PersonMask.of(region, np.minimum(share, 1.0)))


def test_masks_of_two_people_are_apart_though_the_network_takes_the_grey_for_a_part() -> None:
    street = Greedy((waiting, lambda frame: 200.0))
    seeds = [[seed(0, person)] for person in street.people]
    people = detect_people(street.picture, (0, FRAMES - 1), seeds, street)
    for number in range(1, FRAMES):
        masks = [keypoints.mask(number) for keypoints in people]
        drawn = [mask.in_picture(WIDTH, HEIGHT) > 0.5 for mask in masks if mask is not None]
        assert len(drawn) == 2
        assert (drawn[0] & drawn[1]).sum() < 0.1 * min(drawn[0].sum(), drawn[1].sum())
