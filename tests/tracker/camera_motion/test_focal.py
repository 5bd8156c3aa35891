"""The focal length that a camera's own motion tells, with its standard deviation; or nothing."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.camera_motion.focal import (
    FEWEST_KEYFRAMES,
    Pair,
    focal_of_map,
    focal_scale,
)
from keypose.tracker.camera_motion.lens import Lens
from keypose.tracker.camera_motion.point_map import Keyframe, PointMap
from keypose.tracker.camera_motion.points import PointFollower
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from tests.tracker.camera_cases import SMALL, turned
from tests.tracker.camera_motion.place_cases import Place

TRUE = Lens.of(SMALL)
NOISE_PX = 0.1


def said(scale: float) -> Lens:
    """The lens as somebody says it, when it is so many times as long."""
    return TRUE.scaled(1 / scale)


def pair(pan_deg: float, count: int = 120, zoom: float = 1.0, seed: int = 0) -> Pair:
    """Points before and after a pan with a zoom."""
    rng = np.random.default_rng(seed)
    uv = rng.uniform((5, 5), (315, 175), (4 * count, 2))
    there = TRUE.pixels(TRUE.directions(uv, 1.0) @ turned(pan_deg, 0.3 * pan_deg).T, zoom)
    inside = ((there > 0) & (there < (319, 179))).all(axis=1)
    uv, there = (places[inside][:count] for places in (uv, there))
    noise = rng.normal(0, NOISE_PX, (2, len(uv), 2))
    away = float(np.linalg.norm(np.median(there - uv, axis=0))) / 320
    return Pair(uv + noise[0], there + noise[1], (1.0, zoom), away)


PANS = [pair(pan, seed=k) for k, pan in enumerate((6.0, -7.0, 8.0, -9.0))]


@pytest.mark.parametrize("scale", [0.6, 0.9, 1.0, 1.15, 1.9])
def test_pans_tell_how_long_the_lens_is(scale: float) -> None:
    found = focal_scale(said(scale), 1.0, PANS)
    assert found is not None
    assert found.scale == pytest.approx(scale, rel=0.02)
    assert abs(np.log(found.scale / scale)) < 4 * found.sigma < 0.1
    assert found.aside < 0.1


def test_a_zoom_between_the_pictures_does_not_matter() -> None:
    found = focal_scale(said(1.2), 1.0, [pair(pan, zoom=1.3) for pan in (6.0, 9.0)])
    assert found is not None
    assert found.scale == pytest.approx(1.2, rel=0.03)


def test_more_pairs_are_surer() -> None:
    two, many = (focal_scale(TRUE, 1.0, [pair(8.0, seed=k) for k in range(n)]) for n in (2, 12))
    assert two is not None
    assert many is not None
    assert many.sigma < two.sigma


def test_pairs_that_disagree_make_it_less_sure() -> None:
    """Half of the pairs are of a lens 4 % longer: each alone is sure of its own."""
    longer = [
        Pair(
            1.04 * (p.uv - 159.5) + 159.5,
            1.04 * (p.uv_later - 159.5) + 159.5,
            p.zooms,
            p.displacement,
        )
        for p in (pair(8.0, seed=k) for k in range(4))
    ]
    alike = focal_scale(TRUE, 1.0, [pair(8.0, seed=k) for k in range(8)])
    mixed = focal_scale(TRUE, 1.0, [*longer, *(pair(8.0, seed=k) for k in range(4, 8))])
    assert alike is not None
    assert mixed is not None
    assert mixed.sigma > 1.5 * alike.sigma


def test_points_that_no_focal_length_explains_are_said_to_be_aside() -> None:
    astray = []
    for each in PANS:
        there = each.uv_later.copy()
        there[:30] += (9.0, -6.0)
        astray.append(Pair(each.uv, there, each.zooms, each.displacement))
    found = focal_scale(TRUE, 1.0, astray)
    assert found is not None
    assert found.aside == pytest.approx(30 / len(PANS[0].uv), abs=0.06)
    assert found.scale == pytest.approx(1.0, rel=0.05)


SILENT: dict[str, list[Pair]] = {
    "no pair": [],
    "a way too short": [pair(0.5)],
    "too few points": [pair(8.0, count=4)],
    "points that go anywhere": [
        Pair(PANS[0].uv, np.random.default_rng(k).uniform(0, 180, (120, 2)), (1.0, 1.0), 0.2)
        for k in range(3)
    ],
}


@pytest.mark.parametrize("name", SILENT)
def test_where_pictures_do_not_tell_the_length_nothing_is_said(name: str) -> None:
    assert focal_scale(TRUE, 1.0, SILENT[name]) is None


# --- of a camera that moves

CAMERA = Camera(width=1280, height=720, fx=720.0, fy=720.0, cx=639.5, cy=359.5)
NOISE = 0.5 / 720


def mapped(scale: float, views: int = 8) -> PointMap:
    """The map of a camera that goes aside, by a lens that is said so many times too short."""
    place = Place.of(views=views, points=150)
    (xy, z), rng = place.seen, np.random.default_rng(0)
    noisy: Array = scale * (xy + rng.normal(0, NOISE, xy.shape))
    point_map = PointMap(CAMERA, PointFollower(1280, 720), scale * NOISE)
    ids = np.arange(150)
    for number in range(views):
        point_map.add(Keyframe(number, place.Ts[number].copy(), ids, noisy[number]))
    point_map.has_depths = True
    point_map.depths = 1 / z[0]
    point_map.mean = np.full(150, float(np.median(point_map.depths)))
    point_map.spread = 0.1 * point_map.depths
    point_map.adjust_all()
    return point_map


@pytest.mark.parametrize("scale", [0.95, 1.0, 1.05])
def test_a_way_tells_how_long_the_lens_is(scale: float) -> None:
    found = focal_of_map(mapped(scale))
    assert found is not None
    assert found.scale == pytest.approx(scale, rel=0.02)
    assert found.sigma < 0.02
    assert found.aside < 0.05


def test_without_depths_or_with_few_keyframes_a_way_tells_nothing() -> None:
    point_map = mapped(1.0)
    point_map.has_depths = False
    assert focal_of_map(point_map) is None
    assert focal_of_map(mapped(1.0, views=FEWEST_KEYFRAMES - 1)) is None
