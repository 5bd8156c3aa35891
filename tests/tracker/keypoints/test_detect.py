"""One body followed from its seeds: forward, backward, lost, found again, cancelled."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from keypose.tracker.errors import KeypointError
from keypose.tracker.keypoints.blazepose import BlazePose, Seen
from keypose.tracker.keypoints.detect import (
    PATIENCE,
    STRETCH,
    DetectionWindow,
    Progress,
    Seed,
    detect,
)
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.keypoints.region import Region
from tests.tracker.keypoints import keypoint_cases as cases
from tests.tracker.keypoints.keypoint_cases import Walker, body_at, numbered, true_x


class Kept(dict[str, DetectionWindow]):
    """Stretches in memory."""

    def put(self, key: str, stretch: DetectionWindow) -> None:
        self[key] = stretch


class Stop(Exception):
    pass


def seeds(*frames: int) -> list[Seed]:
    return [Seed(frame, body_at(true_x(frame), 120)) for frame in frames]


def seen_x(found: Keypoints) -> np.ndarray:
    return found.uv[:, 0, 0]


def test_a_body_is_followed_both_ways_from_one_seed() -> None:
    found = detect(numbered, (0, 80), seeds(40), Walker())
    assert (found.first_frame, found.last_frame) == (0, 80)
    assert seen_x(found) == pytest.approx([true_x(n) for n in range(81)])
    assert (found.visibility > 0).all()


def test_where_the_person_is_is_known_of_the_frames_that_show_one() -> None:
    found = detect(numbered, (0, 80), seeds(40), Walker(hidden=frozenset([50, 51])))
    assert [n for n in range(81) if found.mask(n) is None] == [50, 51]
    for number in (0, 40, 80):
        mask = found.mask(number)
        assert mask is not None
        assert mask.region.distance(body_at(true_x(number), 120)) < 0.02
    part = found.over(79, 82)
    assert [part.mask(n) is not None for n in range(78, 84)] == [*(0, 1, 1), *(0, 0, 0)]
    assert part.mask(80) is found.mask(80)


def test_between_seeds_every_frame_is_looked_at_once() -> None:
    walker = Walker()
    detect(numbered, (0, 60), seeds(0, 60), walker)
    assert all(walker.looked.count(n) == 1 for n in range(1, 60))


def test_where_the_forward_chain_takes_up_something_else_the_backward_one_is_used() -> None:
    walker = Walker(strays_at=20)
    found = detect(numbered, (0, 100), seeds(0, 100), walker)
    assert seen_x(found) == pytest.approx([true_x(n) for n in range(101)], abs=2)


def test_a_body_that_is_hidden_longer_than_a_chain_waits_is_found_from_the_other_seed() -> None:
    hidden = frozenset(range(20, 22 + PATIENCE))
    found = detect(numbered, (0, 80), seeds(0, 80), Walker(hidden=hidden))
    unseen = np.isnan(seen_x(found))
    assert set(np.flatnonzero(unseen)) == hidden
    assert (found.visibility[unseen] == 0).all()
    assert found.p_hips is not None
    assert np.isnan(found.p_hips[unseen]).all()


def test_a_short_gap_is_bridged() -> None:
    hidden = frozenset(range(20, 20 + PATIENCE))
    found = detect(numbered, (0, 80), seeds(0), Walker(hidden=hidden))
    assert set(np.flatnonzero(np.isnan(seen_x(found)))) == hidden


def test_a_body_that_has_gone_is_not_looked_for_for_ever() -> None:
    walker = Walker(hidden=frozenset(range(20, 200)))
    found = detect(numbered, (0, 199), seeds(0), walker)
    assert np.isnan(seen_x(found)[20:]).all()
    assert max(walker.looked) == 20 + PATIENCE


def test_a_body_that_walks_out_of_the_picture_is_gone() -> None:
    found = detect(numbered, (0, 250), seeds(0), Walker())
    outside = np.array([true_x(n) > cases.WIDTH - 0.5 for n in range(251)])
    assert np.array_equal(np.isnan(seen_x(found)), outside)


def test_a_frame_that_cannot_be_decoded_is_left_out() -> None:
    found = detect(lambda n: None if n == 7 else numbered(n), (0, 20), seeds(0), Walker())
    assert list(np.flatnonzero(np.isnan(seen_x(found)))) == [7]


class Leans:
    """Somebody who lies on the side, as a network finds out a little better at each look."""

    fingerprint = "leans"

    def __init__(self) -> None:
        self.turns: list[float] = []

    def infer(self, picture: np.ndarray, region: Region) -> Seen:
        self.turns.append(region.turn_rad)
        seen = Walker().infer(picture, region)
        return replace(seen, next=replace(region, turn_rad=min(region.turn_rad + 0.2, LYING)))


LYING = 1.5


def test_a_seed_is_looked_at_until_the_region_is_the_bodys() -> None:
    leans, walks = Leans(), Walker()
    detect(numbered, (3, 3), seeds(3), leans)
    assert leans.turns[-1] == pytest.approx(LYING)
    assert len(leans.turns) == 9
    detect(numbered, (3, 3), seeds(3), walks)
    assert walks.looked == [3], "where it is at once, once is enough"


def test_a_seed_that_shows_nobody_is_named() -> None:
    with pytest.raises(KeypointError, match="No person was found at frame 5: "):
        detect(numbered, (0, 9), seeds(5), Walker(hidden=frozenset([5])))


def test_a_seed_that_shows_nobody_is_left_out_beside_one_that_does() -> None:
    found = detect(numbered, (0, 9), seeds(2, 5), Walker(hidden=frozenset([5])))
    assert list(np.flatnonzero(np.isnan(seen_x(found)))) == [5]


@pytest.mark.parametrize("frames", [(), (3, 3), (30,)])
def test_seeds_are_of_different_frames_of_the_range(frames: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match="seeds"):
        detect(numbered, (0, 20), seeds(*frames), Walker())


def test_every_look_is_reported_and_what_is_raised_ends_the_work_at_once() -> None:
    walker, kept = Walker(), Kept()

    def report(progress: Progress) -> None:
        if progress.frame == STRETCH + 10:
            raise Stop

    with pytest.raises(Stop):
        detect(numbered, (0, 200), seeds(0), walker, report=report, kept=kept)
    assert max(walker.looked) == STRETCH + 9
    assert {len(stretch) for stretch in kept.values()} == {1, STRETCH}


def test_progress_grows_to_what_was_expected() -> None:
    reported: list[Progress] = []
    detect(numbered, (0, 50), seeds(20), Walker(), report=reported.append)
    assert [p.done for p in reported] == list(range(51))
    assert {p.expected for p in reported} == {51}
    assert {p.frame for p in reported} == set(range(51))


def test_work_that_was_cancelled_is_taken_up_where_it_was_left() -> None:
    whole, kept = detect(numbered, (0, 100), seeds(0), Walker()), Kept()

    def report(progress: Progress) -> None:
        if progress.frame == 70:
            raise Stop

    with pytest.raises(Stop):
        detect(numbered, (0, 100), seeds(0), Walker(), report=report, kept=kept)
    walker = Walker()
    found = detect(numbered, (0, 100), seeds(0), walker, kept=kept)
    assert min(walker.looked) == 70 // STRETCH * STRETCH + 1
    assert np.array_equal(found.uv, whole.uv)


def test_what_was_kept_serves_no_other_film_network_or_region() -> None:
    kept = Kept()
    detect(numbered, (0, 9), seeds(0), Walker(), film="a", kept=kept)
    again, other = Walker(), Walker(fingerprint="other")
    detect(numbered, (0, 9), seeds(0), again, film="a", kept=kept)
    assert not again.looked
    for film, network in (("b", Walker()), ("a", other)):
        detect(numbered, (0, 9), seeds(0), network, film=film, kept=kept)
        assert network.looked
    elsewhere = Walker()
    detect(numbered, (0, 9), [Seed(0, body_at(101, 120))], elsewhere, film="a", kept=kept)
    assert 0 in elsewhere.looked


def test_a_real_man_is_followed_from_a_box_and_backward_as_well_as_forward() -> None:
    network = BlazePose.open(fast=False)
    with cases.balance() as video:
        width, height = video.info.width, video.info.height
        seed = Seed.of_box(0, cases.BOX, width, height)
        forward = detect(video.frame, (0, 15), [seed], network)
        back = Seed(15, seed.region)
        backward = detect(video.frame, (0, 15), [back], network)
    for found in (forward, backward):
        assert found.p_hips is not None
        assert np.isfinite(found.uv).all()
        assert np.isfinite(found.p_hips).all()
    apart = np.hypot(*np.moveaxis(forward.uv - backward.uv, -1, 0))
    assert np.median(apart[5:10]) < 3


def test_nobody_in_a_flat_picture_is_one_sentence() -> None:
    flat = np.full((240, 320, 3), 90, dtype=np.uint8)
    seed = Seed.of_box(3, (100, 50, 200, 220), 320, 240)
    with pytest.raises(KeypointError, match="No person was found at frame 3"):
        detect(lambda number: flat, (0, 9), [seed], BlazePose.open(fast=False))


@pytest.mark.parametrize("begins", [37, 40, 48])
def test_a_chain_from_a_keyframe_in_between_takes_what_another_found(begins: int) -> None:
    kept = Kept()
    whole = detect(numbered, (0, 100), seeds(0), Walker(), kept=kept)
    walker = Walker()
    x = true_x(begins) + 3  # posed a little beside
    found = detect(numbered, (begins, 100), [Seed(begins, body_at(x, 120))], walker, kept=kept)
    assert max(walker.looked) <= -(-begins // STRETCH) * STRETCH
    assert np.array_equal(found.uv[STRETCH:], whole.uv[begins + STRETCH :])


def in_every_second(last: int, network: Walker, kept: Kept | None = None) -> Keypoints:
    """Found from a seed at frame 0."""
    return detect(numbered, (0, last), seeds(0), network, film="film", kept=kept, every_second=True)


@pytest.mark.parametrize("last", [40, 41])
def test_of_every_second_frame_those_between_are_means_and_the_last_one_is_looked_at(
    last: int,
) -> None:
    network = Walker()
    found = in_every_second(last, network)
    assert set(network.looked) == {*range(0, last + 1, 2), last}
    assert seen_x(found) == pytest.approx([true_x(n) for n in range(last + 1)])
    assert (found.visibility == 0.9).all()
    assert found.mask(20) is not None
    assert found.mask(21) is None


def test_a_body_that_is_lost_is_looked_for_in_every_frame() -> None:
    network = Walker(hidden=frozenset({10, 11, 12}))
    found = in_every_second(30, network)
    assert {10, 11, 12, 13} <= set(network.looked)
    missing = np.flatnonzero(np.isnan(seen_x(found)))
    assert missing.tolist() == [9, 10, 11, 12]


def test_what_was_kept_of_every_second_frame_ends_where_it_is_asked_to() -> None:
    kept = Kept()
    longer, shorter = in_every_second(31, Walker(), kept), in_every_second(21, Walker(), kept)
    assert np.isfinite(seen_x(shorter)).all()
    assert seen_x(shorter) == pytest.approx(seen_x(longer)[:22])
