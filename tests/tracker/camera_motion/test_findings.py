"""What is doubtful about a camera's motion is told by frames, and with its cause."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.camera_motion.findings import (
    FEWEST_SCENE,
    Finding,
    Likeness,
    are_faded,
    contrast_of,
    gaps,
    is_filled,
    scenes,
)
from tests.tracker.camera_cases import SMALL, noisy, rendered, texture, turned

# --- gaps

GAPS: dict[str, tuple[list[str], list[Finding]]] = {
    "nothing": ([""] * 8, []),
    "no frame": ([], []),
    "a short gap, which is bridged": (["", "", "not_rigid", "not_rigid", "", ""], []),
    "a long one": (
        ["", "no_texture", "no_texture", "no_texture", ""],
        [Finding("no_texture", 1, 3, 0.6)],
    ),
    "the most frequent cause": (
        ["body_fills", "no_texture", "no_texture", "", ""],
        [Finding("no_texture", 0, 2, 0.6)],
    ),
    "until the end": (["", "", *["no_picture"] * 6], [Finding("no_picture", 2, 7, 0.75)]),
    "two": (
        ["not_rigid"] * 3 + [""] + ["body_fills"] * 4,
        [Finding("not_rigid", 0, 2, 0.375), Finding("body_fills", 4, 7, 0.5)],
    ),
    "a cut alone, which is told apart": (["", "cut", "cut", "cut", ""], []),
    "a cut, then nothing known": (
        ["", "cut", "not_rigid", "not_rigid", ""],
        [Finding("not_rigid", 1, 3, 0.6)],
    ),
    "a film shorter than a gap": (["no_texture"], [Finding("no_texture", 0, 0, 1.0)]),
}


@pytest.mark.parametrize("name", GAPS)
def test_runs_of_frames_without_a_camera_are_told_by_their_cause(name: str) -> None:
    causes, expected = GAPS[name]
    assert gaps(causes) == expected


# --- scenes

LONG = FEWEST_SCENE + 3


def test_a_film_in_one_piece_begins_once() -> None:
    known, cuts, pieces = scenes(np.zeros(LONG, np.int64), np.ones(LONG, bool), [], [])
    assert known.all()
    assert cuts == []
    assert pieces == (0,)


def test_a_scene_that_nothing_ties_begins_a_piece() -> None:
    keyframe = np.repeat([0, 1], LONG)
    known = np.ones(2 * LONG, bool)
    known[LONG - 1] = False  # lost before the jump
    kept, _, pieces = scenes(keyframe, known, [1], [])
    np.testing.assert_array_equal(kept, known)
    assert pieces == (0, LONG - 1)


def test_a_keyframe_that_is_tied_begins_none() -> None:
    keyframe = np.repeat([0, 1, 2], LONG)
    pieces = scenes(keyframe, np.ones(3 * LONG, bool), [2], [])[2]
    assert pieces == (0, 2 * LONG)


def test_a_scene_of_too_few_frames_is_not_known() -> None:
    keyframe = np.repeat([0, 1, 2], [LONG, FEWEST_SCENE - 1, LONG])
    known, _, pieces = scenes(keyframe, np.ones(len(keyframe), bool), [1, 2], [])
    np.testing.assert_array_equal(known, keyframe != 1)
    assert pieces == (0, LONG)


@pytest.mark.parametrize(("cut", "is_kept"), [(LONG, True), (2, False), (2 * LONG - 2, False)])
def test_a_cut_counts_with_enough_frames_on_either_side(cut: int, is_kept: bool) -> None:
    keyframe = np.zeros(2 * LONG, np.int64)
    _, cuts, pieces = scenes(keyframe, np.ones(2 * LONG, bool), [], [cut])
    assert cuts == ([cut] if is_kept else [])
    assert pieces == ((0, cut) if is_kept else (0,))


def test_the_only_scene_stays_however_short() -> None:
    assert scenes(np.zeros(2, np.int64), np.ones(2, bool), [], [])[0].all()


# --- what hides the background, fading, and cuts


@pytest.mark.parametrize(
    ("share", "fills"), [(0.0, True), (0.25, True), (0.35, False), (1.0, False)]
)
def test_a_picture_is_filled_by_what_leaves_less_than_a_third_of_it(
    share: float, fills: bool
) -> None:
    usable = np.arange(100).reshape(10, 10) < 100 * share
    assert is_filled(usable) == fills
    assert not is_filled(None)


CONTRASTS: dict[str, tuple[list[float], list[int]]] = {
    "a steady film": ([40.0, 41.0] * 20, []),
    "a night film": ([3.0] * 30, [*range(30)]),
    "five black frames": ([0.0] * 5 + [40.0] * 35, [*range(5), *range(6, 11)]),
    "a slow fade": ([*np.linspace(0, 40, 20)] + [40.0] * 40, [*range(23)]),
    "a flash": ([40.0] * 20 + [0.0] + [40.0] * 20, [14, 20, 26]),
    "what cannot be read": ([np.nan] * 10 + [40.0] * 30, []),
    "nothing": ([np.nan] * 4, []),
}
"""Of the pictures of a film, and those that are faint or fade."""


@pytest.mark.parametrize("case", CONTRASTS)
def test_pictures_that_fade_are_known_by_the_contrast_of_the_film(case: str) -> None:
    contrasts, faded = CONTRASTS[case]
    assert np.flatnonzero(are_faded(np.array(contrasts))).tolist() == faded


def test_the_contrast_is_that_of_the_grey_levels() -> None:
    picture = texture(0)[:180, :320]
    assert contrast_of(np.full((180, 320), 90, np.uint8)) == 0.0
    assert contrast_of(picture) == pytest.approx(float(picture.std()), rel=0.1)
    assert contrast_of(picture // 2) == pytest.approx(contrast_of(picture) / 2, rel=0.05)


def test_pictures_of_one_scene_are_alike_and_those_at_a_cut_are_not() -> None:
    rng = np.random.default_rng(0)
    likeness = Likeness()
    shown = [rendered(SMALL, turned(0.5 * k), seed=0 if k < 5 else 5) for k in range(10)]
    told = [likeness.of(noisy(picture, rng, 4.0)) for picture in shown]
    assert told[0] == 1.0  # nothing came before it
    assert min(told[1:5] + told[6:]) > 0.7
    assert told[5] < 0.5


def test_a_change_of_light_is_no_cut_and_black_pictures_say_nothing() -> None:
    likeness, picture = Likeness(), rendered(SMALL, turned(0.0))
    likeness.of(picture)
    assert likeness.of((picture * 0.5).astype(np.uint8)) > 0.99
    likeness.of(np.zeros_like(picture))
    assert likeness.of(np.zeros_like(picture)) == 1.0
