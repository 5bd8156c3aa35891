"""Where a template lies: both searches against a plain twin, and each other."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.kernels.matching import UNUSABLE, find_exhaustively, find_sequentially
from keypose.tracker.kernels.settling import settle
from keypose.tracker.tracking.initial.templates.search import GreyPicture, cut, find_match, outwards
from keypose.tracker.video.pyramid import in_grey_levels
from tests.tracker.tracking_cases import smooth_picture, waves_at

Grey = NDArray[np.int16]
Place = tuple[int, int, int]

MOST = 40


def plain(
    picture: Grey, template: Grey, wanted: Grey, row: int, column: int, reach: int, most: int
) -> Place:
    """Row, column and sum of the best place, all candidates written out."""
    side = template.shape
    around = np.full(np.array(picture.shape) + 2 * max(side) + 200, UNUSABLE)
    edge = max(side) + 100
    around[edge : edge + picture.shape[0], edge : edge + picture.shape[1]] = picture
    best: list[tuple[int, int, int, int]] = []
    for v in range(row - reach, row + reach + 1):
        for u in range(column - reach, column + reach + 1):
            piece = around[edge + v : edge + v + side[0], edge + u : edge + u + side[1]]
            total = (wanted * np.minimum(np.abs(piece - template), most)).sum()
            best.append((int(total), (v - row) ** 2 + (u - column) ** 2, v, u))
    total, _, v, u = min(best)
    return v, u, total


def both(
    picture: Grey, template: Grey, wanted: Grey, row: int, column: int, reach: int, most: int = MOST
) -> tuple[Place, Place]:
    """What the sequential and the exhaustive search find."""
    rows = np.argsort(-np.abs(template - template.mean()).sum(axis=1), kind="stable")
    one = find_sequentially(
        picture, template, wanted, rows, row, column, outwards(reach), most
    )  # fmt: skip
    other = find_exhaustively(picture, template, wanted, row, column, reach, most)
    assert one[3] <= other[3]
    return one[:3], other[:3]


def noisy(seed: int, shape: tuple[int, int], levels: int = 256) -> Grey:
    return np.random.default_rng(seed).integers(0, levels, shape).astype(np.int16)


@pytest.mark.parametrize("seed", range(12))
def test_both_searches_find_what_the_plain_one_finds(seed: int) -> None:
    rng = np.random.default_rng([seed, 1])
    picture = noisy(seed, (40, 52), levels=(256, 3)[seed % 2])  # with three levels there are ties
    picture[rng.random(picture.shape) < 0.05] = UNUSABLE
    template = noisy(seed + 50, (7, 9), levels=(256, 3)[seed % 2])
    wanted = (rng.random(template.shape) < 0.8).astype(np.int16)
    row, column = (int(k) for k in rng.integers(-6, 44, 2))  # at and beyond the border as well
    expected = plain(picture, template, wanted, row, column, 6, MOST)
    assert both(picture, template, wanted, row, column, 6) == (expected, expected)


def test_a_piece_of_the_picture_is_found_where_it_was_cut() -> None:
    picture = noisy(3, (60, 80))
    template = picture[20:31, 33:44].copy()
    here = (20, 33, 0)
    assert both(picture, template, np.ones_like(template), 16, 37, 8) == (here, here)


def test_of_equal_sums_the_nearest_place_wins_then_the_higher_then_the_left_one() -> None:
    picture = np.zeros((40, 40), np.int16)
    template = np.zeros((3, 3), np.int16)
    wanted = np.ones_like(template)
    assert both(picture, template, wanted, 12, 17, 5) == ((12, 17, 0), (12, 17, 0))
    picture[:] = 100
    for v, u in ((10, 20), (14, 20), (12, 18), (12, 22), (12, 24)):
        picture[v, u] = 0
    one = np.zeros((1, 1), np.int16)
    assert both(picture, one, np.ones_like(one), 12, 20, 6) == ((10, 20, 0), (10, 20, 0))
    picture[10, 20] = 100
    assert both(picture, one, np.ones_like(one), 12, 20, 6) == ((12, 18, 0), (12, 18, 0))


def test_no_pixel_costs_more_than_what_cannot_be_compared() -> None:
    picture = np.full((20, 20), 250, np.int16)
    picture[:, 10:] = UNUSABLE
    template = np.zeros((4, 4), np.int16)
    wanted = np.ones_like(template)
    for column in (0, 8, 12, 30):  # on unlike, half ignored, ignored, and no pixels at all
        found_ = find_exhaustively(picture, template, wanted, 5, column, 0, MOST)
        assert found_[2] == 16 * MOST


def test_uncapped_the_sum_is_the_printed_one() -> None:
    picture, template = noisy(1, (12, 12)), noisy(2, (5, 5))
    wanted = np.ones_like(template)
    sums = [
        np.abs(picture[v : v + 5, u : u + 5].astype(int) - template).sum()
        for v in range(8)
        for u in range(8)
    ]
    _, _, total, _ = find_exhaustively(picture, template, wanted, 3, 4, 3, 255)
    assert total >= min(sums)
    assert find_exhaustively(picture, template, wanted, 4, 4, 0, 255)[2] == sums[4 * 8 + 4]


def test_the_sequential_search_looks_at_a_part_only() -> None:
    picture = np.rint(in_grey_levels(smooth_picture(4))[..., 0]).astype(np.int16)
    template = picture[40:61, 70:91].copy()
    rows = np.arange(21)
    wanted = np.ones_like(template)
    looked = find_sequentially(picture, template, wanted, rows, 42, 72, outwards(10), 255)[3]
    assert looked < 0.5 * find_exhaustively(picture, template, wanted, 42, 72, 10, 255)[3]


def test_ignored_pixels_are_not_part_of_a_template() -> None:
    picture = in_grey_levels(smooth_picture(6))
    picture[50:, :, 3] = 0.0
    template = cut(picture, np.array([80.0, 50.0]), 6)
    assert template is not None
    assert template.wanted[:6].all()
    assert not template.wanted[6:].any()
    assert cut(picture, np.array([80.0, 58.0]), 6) is None


def test_a_template_keeps_the_fraction_of_its_place() -> None:
    picture = in_grey_levels(smooth_picture(7))
    template = cut(picture, np.array([60.3, 41.8]), 7)
    assert template is not None
    match = find_match(template, GreyPicture.of(picture), np.array([63.3, 39.8]), 6)
    assert match.miss == 0.0
    np.testing.assert_allclose(match.uv, (60.3, 41.8))


def _settled_plainly(
    picture: NDArray[np.float32], xy: NDArray[np.float32], values: NDArray[np.float32],
    place: NDArray[np.float64], hold: NDArray[np.float64], soft: float, solves: int,
) -> NDArray[np.float64]:  # fmt: skip
    """Gauss–Newton as `settle` does it, whole arrays at a time."""
    place, begun, bias = place.copy(), place.copy(), None
    for _ in range(solves):
        c, s = np.exp(place[3]) * np.array([np.cos(place[2]), np.sin(place[2])])
        away = xy @ np.array([[c, s], [-s, c]])
        uv = place[:2] + away
        low = np.floor(uv).astype(int)
        f = (uv - low)[:, :, None]
        corner = [picture[low[:, 1] + j, low[:, 0] + i, :3] for j in (0, 1) for i in (0, 1)]
        upper = corner[0] * (1 - f[:, 0]) + corner[1] * f[:, 0]
        lower = corner[2] * (1 - f[:, 0]) + corner[3] * f[:, 0]
        E, Eu, Ev = (upper * (1 - f[:, 1]) + lower * f[:, 1]).T
        bias = (values - E).mean() if bias is None else bias
        r = values - E - bias
        w = (1 + (r / soft) ** 2) ** -2.0
        dx, dy = away.T
        J = np.stack([Eu, Ev, Ev * dx - Eu * dy, Eu * dx + Ev * dy, np.ones_like(Eu)], axis=1)
        A, b = J.T @ (w[:, None] * J), J.T @ (w * r)
        A[range(4), range(4)] += hold
        b[:4] += hold * (begun - place)
        step = np.linalg.solve(A, b)
        share = min(1.0, 2.0 / np.hypot(*step[:2]))
        place, bias = place + share * step[:4], bias + step[4]
    return place


def test_settling_agrees_with_its_plain_twin() -> None:
    picture = smooth_picture(8)
    rng = np.random.default_rng(8)
    side = np.stack(np.meshgrid(np.arange(-8, 9), np.arange(-8, 9)), -1).reshape(-1, 2)
    xy = side.astype(np.float32)
    values = picture[60 + side[:, 1], 70 + side[:, 0], 0] + rng.normal(9, 2, len(xy))
    start, hold = np.array([71.5, 58.9, 0.1, 0.05]), np.array([1.0, 1.0, 30.0, 30.0])
    given = (picture, xy, values.astype(np.float32))
    place, spread = start.copy(), np.empty(2)
    alike = settle(*given, place, hold, 9.0, 2, spread)
    np.testing.assert_allclose(place, _settled_plainly(*given, start, hold, 9.0, 2), atol=1e-4)
    assert 0.5 < alike <= 1.0
    assert (spread > 0).all()


def test_settling_finds_a_known_turn_to_a_fraction_of_a_pixel() -> None:
    picture = in_grey_levels(smooth_picture(9))
    side = np.stack(np.meshgrid(np.arange(-9, 10), np.arange(-9, 10)), -1).reshape(-1, 2)
    true = np.array([74.3, 61.7, 0.15, 0.08])
    c, s = np.exp(true[3]) * np.array([np.cos(true[2]), np.sin(true[2])])
    uv = true[:2] + side @ np.array([[c, s], [-s, c]])
    values = (waves_at(9, uv)[:, 0] - 12.0).astype(np.float32)  # darker by a constant
    place, spread = np.array([72.5, 63.0, 0.0, 0.0]), np.empty(2)
    alike = settle(
        picture, side.astype(np.float32), values, place, np.zeros(4), 12.0, 12, spread
    )  # fmt: skip
    np.testing.assert_allclose(place, true, atol=0.05)
    assert alike > 0.95
