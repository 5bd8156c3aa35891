"""Landmarks in space are turned so that a person stands over their feet."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from keypose.tracker.fitting.draft.balance import MOST_RAD, balanced
from keypose.tracker.fitting.draft.observed import SIDES, Observed, place_of
from keypose.tracker.geometry.rotations import Array, exp_rotation
from tests.tracker.fitting.draft.clips import CAMERA, standing, walk

UP = np.array([0.0, -1.0, 0.0])
COUNT = 12


def leaning(lean_deg: float, count: int = COUNT) -> Observed:
    """A person who stands in the picture's middle, seen as if they leaned away from the camera."""
    seen = Observed.of(standing(count).keypoints, CAMERA)
    turn = exp_rotation(np.array([np.radians(lean_deg), 0.0, 0.0]))
    return replace(seen, p_hips=seen.p_hips @ turn.T)


def lean_deg(seen: Observed) -> Array:
    """(N,) of the line from the ankles to the shoulders, away from the camera."""
    ankles, shoulders = (
        seen.p_hips[:, [place_of(side, joint) for side in SIDES]].mean(axis=1)
        for joint in ("ankle", "shoulder")
    )
    x = shoulders - ankles
    return np.asarray(np.degrees(np.arctan2(x[:, 2], -x[:, 1])))


UPRIGHT_DEG = float(lean_deg(leaning(0.0))[0])
"""Of somebody who stands in balance: shoulders are not exactly over ankles."""


@pytest.mark.parametrize("by_deg", [-12.0, -4.0, 0.0, 6.0, 15.0])
def test_a_lean_throughout_the_film_is_taken_out(by_deg: float) -> None:
    before = leaning(by_deg)
    after = balanced(before, CAMERA, UP)
    np.testing.assert_allclose(lean_deg(before) - UPRIGHT_DEG, -by_deg, atol=0.5)
    np.testing.assert_allclose(lean_deg(after), UPRIGHT_DEG, atol=2.5)
    np.testing.assert_array_equal(after.uv, before.uv)


def test_more_than_a_network_can_be_off_is_not_taken_for_its_error() -> None:
    before = leaning(50.0)
    turned = lean_deg(balanced(before, CAMERA, UP)) - lean_deg(before)
    np.testing.assert_allclose(turned, np.degrees(MOST_RAD), atol=0.1)


def test_bones_keep_their_lengths() -> None:
    before = leaning(9.0)
    after = balanced(before, CAMERA, UP)
    for seen in (before, after):
        spans = np.linalg.norm(seen.p_hips[:, :, None] - seen.p_hips[:, None], axis=-1)
        np.testing.assert_allclose(spans[0], spans[-1])
    np.testing.assert_allclose(
        np.linalg.norm(before.p_hips, axis=-1), np.linalg.norm(after.p_hips, axis=-1)
    )


def test_who_leans_for_a_moment_keeps_that() -> None:
    """All frames are turned alike, by the median."""
    seen = leaning(0.0)
    p_hips = seen.p_hips.copy()
    p_hips[:3] = leaning(30.0, 3).p_hips
    after = lean_deg(balanced(replace(seen, p_hips=p_hips), CAMERA, UP))
    np.testing.assert_allclose(after[:3] - after[3], -30.0, atol=0.5)
    np.testing.assert_allclose(after[3:], lean_deg(balanced(seen, CAMERA, UP))[3:], atol=0.1)


def lying(seen: Observed, rows: slice) -> Observed:
    p_hips = seen.p_hips.copy()
    p_hips[rows] = p_hips[rows] @ exp_rotation(np.array([0.0, 0.0, np.pi / 2])).T
    return replace(seen, p_hips=p_hips)


def without_hips(seen: Observed, rows: slice) -> Observed:
    doubted = np.zeros_like(seen.known)
    doubted[rows, place_of("left", "hip")] = True
    return seen.without(doubted)


@pytest.mark.parametrize("less", [lying, without_hips], ids=["lies", "hips unseen"])
@pytest.mark.parametrize(("count", "is_balanced"), [(5, True), (8, False)])
def test_half_of_the_frames_must_show_somebody_standing(
    less: Callable[[Observed, slice], Observed], count: int, is_balanced: bool
) -> None:
    before = less(leaning(10.0), slice(count))
    after = balanced(before, CAMERA, UP)
    assert (after is not before) == is_balanced


def test_a_camera_that_turns_has_its_own_up_in_every_frame() -> None:
    """The same landmarks, and a camera that looks down further and further: ever more to undo."""
    seen = leaning(0.0)
    ups = np.stack([exp_rotation(np.array([np.radians(-8.0), 0.0, 0.0])) @ UP] * COUNT)
    after = balanced(seen, CAMERA, ups)
    np.testing.assert_allclose(lean_deg(after) - UPRIGHT_DEG, 8.0, atol=2.5)
    alone = balanced(seen, CAMERA, ups[0])
    np.testing.assert_allclose(after.p_hips, alone.p_hips)


def test_who_bends_across_the_view_is_not_turned() -> None:
    seen = Observed.of(walk(40, facing_deg=90).keypoints, CAMERA)
    turned = lean_deg(balanced(seen, CAMERA, UP)) - lean_deg(seen)
    assert np.abs(turned).max() < 1.0
