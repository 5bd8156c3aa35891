"""Several looks at one frame: their median, with left and right as the plain look has them."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.keypoints.augmented import (
    VARIATIONS,
    AugmentedNetwork,
    Variation,
    augmented_fingerprint,
)
from keypose.tracker.keypoints.blazepose import NAMES, BlazePose, Seen
from keypose.tracker.keypoints.keypoints import JOINTS
from keypose.tracker.keypoints.model_files import FULL
from keypose.tracker.keypoints.region import Region
from tests.tracker.keypoints import keypoint_cases as cases

REGION = Region(160.0, 120.0, 100.0, 0.2)
PICTURE = np.zeros((240, 320, 3), np.uint8)
LOOKS = len(VARIATIONS) + 1


def truth() -> Seen:
    """Somebody whose left is at the right of the picture."""
    rng = np.random.default_rng(3)
    uv = rng.uniform(130, 190, (len(NAMES), 2))
    for k, name in enumerate(NAMES):
        uv[k, 0] += 40 * ("left" in name) - 40 * ("right" in name)
    p = rng.normal(0, 0.3, (len(NAMES), 3))
    return Seen(uv, np.full(len(NAMES), 0.9), p, 0.95, REGION, cases.disc(REGION))


@dataclass
class Fake:
    """A network that sees the truth, but for what is changed in some looks."""

    changed: dict[int, Seen] = field(default_factory=dict)
    looked: list[tuple[Region, bool]] = field(default_factory=list)
    fingerprint: str = "fake"

    def infer(self, picture: NDArray[np.uint8], region: Region, *, mirrored: bool = False) -> Seen:
        self.looked.append((region, mirrored))
        return self.changed.get(len(self.looked) - 1, truth())


def looked_at(fake: Fake) -> Seen:
    return AugmentedNetwork([fake]).infer(PICTURE, REGION)


def is_truth(seen: Seen) -> bool:
    known = truth()
    return all(
        np.allclose(getattr(seen, name), getattr(known, name))
        for name in ("uv", "visibility", "p_hips")
    )


def test_the_plain_look_comes_first_and_each_variation_after_it() -> None:
    fake = Fake()
    assert is_truth(looked_at(fake))
    assert fake.looked[0] == (REGION, False)
    assert len(fake.looked) == LOOKS
    for varied, (region, mirrored) in zip(VARIATIONS, fake.looked[1:], strict=True):
        assert region == varied.of(REGION)
        assert mirrored == varied.mirrored
    assert len({*VARIATIONS, Variation()}) == LOOKS


@pytest.mark.parametrize("wrong", range(LOOKS))
def test_a_joint_that_one_look_sees_elsewhere_stays(wrong: int) -> None:
    elsewhere = truth()
    elsewhere.uv[NAMES.index("left_wrist")] += 60
    elsewhere.p_hips[NAMES.index("left_wrist")] += 0.4
    assert is_truth(looked_at(Fake({wrong: elsewhere})))


def test_looks_that_exchange_left_and_right_are_exchanged_back() -> None:
    changed = {k: truth().exchanged() for k in (1, 2, 4)}
    assert is_truth(looked_at(Fake(changed)))


def test_several_threads_find_the_same_as_one() -> None:
    with cases.balance() as video:
        picture = video.frame(0)
    region = Region.of_box(cases.BOX, picture.shape[1], picture.shape[0])
    one, three = (
        AugmentedNetwork([BlazePose.open(fast=False) for _ in range(threads)]).infer(
            picture, region
        )
        for threads in (1, 3)
    )
    for name in ("uv", "visibility", "p_hips"):
        assert np.array_equal(getattr(one, name), getattr(three, name))
    assert one.next == three.next


def test_what_the_looks_differ_by_at_random_is_halved() -> None:
    rng = np.random.default_rng(0)

    def shaken() -> Seen:
        return replace(truth(), uv=truth().uv + rng.normal(0, 4, (len(NAMES), 2)))

    alone, together = [], []
    for _ in range(20):
        looks = {k: shaken() for k in range(LOOKS)}
        alone.append(looks[0].uv - truth().uv)
        together.append(looked_at(Fake(looks)).uv - truth().uv)
    assert np.std(together) < 0.6 * np.std(alone)


def test_a_look_that_is_no_number_is_left_out() -> None:
    nothing = truth()
    nothing.uv[5] = np.nan
    assert is_truth(looked_at(Fake({2: nothing})))


def test_where_nobody_is_one_look_is_enough() -> None:
    fake = Fake({0: replace(truth(), presence=0.1)})
    assert looked_at(fake).presence == 0.1
    assert len(fake.looked) == 1


def test_whether_and_where_somebody_is_and_where_to_look_next_are_the_plain_looks() -> None:
    next_ = Region(3.0, 4.0, 50.0)
    changed = {"next": Region(0, 0, 9), "presence": 0.2, "mask": cases.NO_MASK}
    others = {k: replace(truth(), **changed) for k in range(1, LOOKS)}
    seen = looked_at(Fake({0: replace(truth(), next=next_), **others}))
    assert seen.next == next_
    assert seen.presence == truth().presence
    assert seen.mask == truth().mask


def test_what_was_found_by_one_look_is_not_taken_for_the_same() -> None:
    fake = Fake()
    assert AugmentedNetwork([fake]).fingerprint != fake.fingerprint


def test_the_fingerprint_is_known_without_the_network() -> None:
    assert AugmentedNetwork.open(FULL).fingerprint == augmented_fingerprint(FULL)


def test_a_real_man_is_found_as_near_as_by_one_look() -> None:
    network = BlazePose.open(fast=False)
    with cases.balance() as video:
        picture = video.frame(0)
    height, width = picture.shape[:2]
    region = Region.of_box(cases.BOX, width, height)
    for _ in range(3):
        region = network.infer(picture, region).next
    marked = cases.marks()[0]

    def apart(seen: Seen) -> float:
        off = [seen.uv[NAMES.index(j)] - marked[j] for j in JOINTS if j in marked]
        return float(np.mean(np.hypot(*np.transpose(off))))

    assert apart(AugmentedNetwork([network]).infer(picture, region)) < 1.1 * apart(
        network.infer(picture, region)
    )
