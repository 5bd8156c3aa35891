"""The bundle over a body: its steps agree with finite differences, whatever the cameras do."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from keypose.tracker.films.bundle import BodyBundle, BundleData, _Adjustment, triangulated
from keypose.tracker.films.cameras import lengths_of
from keypose.tracker.geometry.film_clock import FilmClock
from keypose.tracker.keypoints.keypoints import JOINTS
from tests.rendering.motions import throw
from tests.tracker.films.film_cases import BODY, TwoFilms, two_films

ROWS = np.arange(10, 40, 10)
CASES = [(False, False), (False, True), (True, True)]


def data_of(films: TwoFilms) -> BundleData:
    film = films.film.at(films.clock, np.arange(len(films.first)))
    return BundleData.of([films.first.rows(ROWS), film.rows(ROWS)], lengths_of(BODY), (True, True))


@pytest.mark.parametrize("in_hand", CASES)
def test_its_gradient_is_that_of_its_cost(in_hand: tuple[bool, bool]) -> None:
    films = two_films(throw, 50.0, FilmClock(2.0), in_hand=in_hand)
    rng = np.random.default_rng(3)
    shift = rng.normal(0, 0.1, (len(films.film), 3)) if in_hand[1] else None
    data = data_of(replace(films, film=replace(films.film, unit_shift=shift)))
    joints = films.joints[ROWS] + rng.normal(0, 0.03, (len(ROWS), len(JOINTS), 3))
    lengths = np.where(np.isfinite(data.lengths_m), data.lengths_m, 0.4)
    Ts = np.stack([np.eye(4), films.T_film_first])
    bundle = BodyBundle(Ts, np.full(2, 0.02), np.full(2, 0.3), joints, lengths)
    problem = _Adjustment(data)
    equations = problem.at(bundle, 0).equations
    gradient = np.concatenate([equations.h, equations.g.ravel()])
    for _ in range(20):
        way = rng.normal(0, 1.0, len(gradient))
        step = 1e-6
        there, back = (problem.at(problem.moved(bundle, s * way), 0).cost for s in (step, -step))
        assert (there - back) / (2 * step) == pytest.approx(gradient @ way, rel=2e-3, abs=1e-2)


@pytest.mark.parametrize("in_hand", CASES)
def test_joints_are_where_the_rays_of_both_cameras_meet(in_hand: tuple[bool, bool]) -> None:
    films = two_films(throw, 50.0, FilmClock(2.0), in_hand=in_hand)
    joints = triangulated(data_of(films), np.stack([np.eye(4), films.T_film_first]))
    off = np.linalg.norm(joints - films.joints[ROWS], axis=-1)
    assert np.nanmedian(off) < 0.05
