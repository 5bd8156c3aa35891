"""What is up by several sources: those that agree count as one, with one doubt."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from keypose.tracker.geometry.rotations import Array, exp_rotation
from keypose.tracker.geometry.up import UpEvidence, UpSource, combined, least_off, up_of_one

LEVEL = np.array([0.0, -1.0, 0.0])
SIDE = np.array([1.0, 0.0, 0.0])
AHEAD = np.array([0.0, 0.0, 1.0])


def tilted(deg: float, about: Array = SIDE) -> Array:
    return np.asarray(exp_rotation(np.radians(deg) * about) @ LEVEL)


def evidence(deg: float, sigma_deg: float, source: UpSource = "lines") -> UpEvidence:
    return UpEvidence.of(tilted(deg), np.radians(sigma_deg), source)


def angle_deg(a: Array, b: Array) -> float:
    return float(np.degrees(np.arccos(np.clip(a @ b, -1, 1))))


def test_sources_that_agree_are_weighed_by_how_sure_they_are() -> None:
    found = combined([evidence(0.0, 1.0), evidence(3.0, 2.0, "person")])
    assert found is not None
    assert angle_deg(found.up, tilted(0.6)) < 0.05
    assert np.degrees(found.sigma_rad) == pytest.approx(np.sqrt(1 / (1 + 1 / 4)), rel=0.01)
    assert found.apart == ()


def test_what_one_source_does_not_show_another_one_fills_in() -> None:
    roll = UpEvidence(tilted(4.0, AHEAD), np.outer(SIDE, SIDE) / np.radians(0.5) ** 2, "feet")
    found = combined([roll, evidence(10.0, 3.0, "person")])
    assert found is not None
    assert abs(np.degrees(np.arcsin(found.up[0])) - 3.9) < 0.3
    assert found.sigma_along(SIDE) < np.radians(0.6)
    assert found.sigma_along(AHEAD) == pytest.approx(np.radians(3.0), rel=0.05)


DISAGREE: dict[str, tuple[list[UpEvidence], set[str], set[str]]] = {
    "two: the surer one": (
        [evidence(3, 1.0), evidence(12, 1.5, "person")], {"lines"}, {"person"},
    ),
    "two against one that is surer": (
        [evidence(20, 0.5), evidence(2, 2.0, "person"), evidence(4, 3.0, "feet")],
        {"person", "feet"}, {"lines"},
    ),
    "one that says little disagrees with nobody": (
        [evidence(3, 1.0), evidence(40, 30.0, "feet")], {"lines", "feet"}, set(),
    ),
    "three of three": (
        [evidence(0, 1.0), evidence(15, 1.5, "person"), evidence(30, 2.0, "feet")],
        {"lines"}, {"person", "feet"},
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", DISAGREE)
@pytest.mark.parametrize("turned", [False, True])
def test_a_source_that_disagrees_is_named_and_does_not_count(case: str, turned: bool) -> None:
    sources, used, apart = DISAGREE[case]
    found = combined(sources[::-1] if turned else sources)
    assert found is not None
    assert {one.source for one in found.used} == used
    assert {one.evidence.source for one in found.apart} == apart
    assert all(one.sigmas > 3 for one in found.apart)


def test_how_cameras_are_held_helps_where_little_is_seen_and_gives_way_where_much_is() -> None:
    prior = UpEvidence.of(LEVEL, np.radians(3.0), "level")
    unsure, dutch = (combined([one], prior) for one in (evidence(5, 6.0), evidence(25, 1.0)))
    assert unsure is not None
    assert dutch is not None
    assert angle_deg(unsure.up, LEVEL) < 2
    assert angle_deg(dutch.up, tilted(25)) < 1e-3
    assert unsure.sources == ("lines",)
    assert combined([], prior) is None


@pytest.mark.parametrize("spread_deg", [2.0, 20.0, 60.0, 3000.0])
def test_what_was_found_names_what_it_rests_on_however_little_that_shows(spread_deg: float) -> None:
    prior = UpEvidence.of(LEVEL, np.radians(3.0), "level")
    found = combined([evidence(1.0, spread_deg, "feet")], prior)
    assert found is not None
    assert found.sources == ("feet",)
    assert up_of_one(evidence(1.0, spread_deg, "feet"), prior).sources == ("feet",)


def test_a_lens_that_is_a_guess_makes_the_tilt_less_sure_and_not_the_roll() -> None:
    seen = evidence(20.0, 0.5).seen_by_lens(0.3)
    assert seen.sigma_along(AHEAD) == pytest.approx(0.15 * np.sin(np.radians(40)), rel=0.1)
    assert seen.sigma_along(SIDE) == pytest.approx(np.radians(0.5), rel=0.01)
    assert evidence(0.0, 0.5).seen_by_lens(0.3).sigma_rad == pytest.approx(np.radians(0.5))


def test_it_is_turned_with_its_doubts() -> None:
    R = exp_rotation(np.array([0.0, np.radians(90), 0.0]))
    turned = evidence(20.0, 0.5).seen_by_lens(0.3).turned(R)
    assert turned.up == pytest.approx(R @ tilted(20.0))
    assert turned.sigma_along(R @ SIDE) == pytest.approx(np.radians(0.5), rel=0.01)


@pytest.mark.parametrize("sigmas", [(1.0, 1.0, 1.0), (0.5, 2.0, 6.0), (2.0, 3.0, 3.0)])
def test_the_deviation_of_all_is_as_large_as_their_error(sigmas: tuple[float, ...]) -> None:
    rng, true, offs = np.random.default_rng(5), tilted(12.0), []
    for _ in range(200):
        some: list[Any] = []
        for sigma, source in zip(sigmas, ("lines", "person", "feet"), strict=True):
            off = exp_rotation(np.radians(sigma) * rng.normal(size=3)) @ true
            some.append(UpEvidence.of(off, np.radians(sigma), source))  # type: ignore[arg-type]
        found = combined(some)
        assert found is not None
        offs.append(abs((found.up - true)[2]) / found.sigma_along(AHEAD))
    assert 0.9 < np.mean(np.array(offs) < 2) <= 1
    assert 0.8 < np.sqrt(np.mean(np.square(offs))) < 1.3


def test_one_source_leaves_what_it_does_not_show_as_it_was_known() -> None:
    roll = UpEvidence(tilted(4.0, AHEAD), np.outer(SIDE, SIDE) / np.radians(0.5) ** 2, "feet")
    found = up_of_one(roll, evidence(10.0, 5.0, "set"))
    assert found.sources == ("feet",)
    assert np.degrees(np.arcsin(found.up[2])) == pytest.approx(-10, abs=0.2)


@pytest.mark.parametrize("off_deg", [0.0, 20.0, 60.0])
def test_the_direction_of_least_cost_is_found_from_anywhere_near(off_deg: float) -> None:
    precision = np.diag([400.0, 1.0, 90.0])
    true = tilted(8.0, AHEAD)
    wanted = precision @ true + 3.0 * true  # so that the gradient there points outward
    assert angle_deg(least_off(precision, wanted, tilted(off_deg, SIDE + AHEAD)), true) < 1e-6
