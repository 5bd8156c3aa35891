"""Keypoints without names: their order is recognised by what the limbs would look like."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.keypoints.layouts import LAYOUTS
from keypose.tracker.keypoints.recognise_layout import recognised_layout
from tests.tracker.keypoints.people import seen_person

BOTH = ("BODY_25", "BODY_25B")


@pytest.mark.parametrize("layout", BOTH)
def test_one_frame_with_all_joints_is_recognised_in_every_pose(layout: str) -> None:
    rng = np.random.default_rng(1)
    for _ in range(60):
        assert recognised_layout(BOTH, seen_person(layout, rng)) == layout


@pytest.mark.parametrize("layout", BOTH)
@pytest.mark.parametrize("missing", [0.2, 0.4])
def test_a_short_clip_with_missing_joints_is_recognised(layout: str, missing: float) -> None:
    rng = np.random.default_rng(2)
    for _ in range(25):
        assert recognised_layout(BOTH, seen_person(layout, rng, 8, missing)) == layout


@pytest.mark.parametrize("layout", BOTH)
@pytest.mark.parametrize("missing", [0.2, 0.4, 0.6, 0.8])
def test_too_few_joints_are_left_open_rather_than_recognised_wrongly(
    layout: str, missing: float
) -> None:
    rng = np.random.default_rng(3)
    found = [recognised_layout(BOTH, seen_person(layout, rng, 1, missing)) for _ in range(50)]
    assert set(found) <= {layout, None}


@pytest.mark.parametrize("layout", BOTH)
@pytest.mark.parametrize("half", ["upper", "lower", "left"])
def test_half_a_person_is_never_recognised_wrongly(layout: str, half: str) -> None:
    legs = ("hip", "knee", "ankle", "heel", "toe")
    hidden = [
        {"upper": name.endswith(legs), "lower": not name.endswith(legs),
         "left": name.startswith("right")}[half]
        for name in LAYOUTS[layout]
    ]  # fmt: skip
    rng = np.random.default_rng(4)
    for frames in (1, 8):
        for _ in range(25):
            uv = seen_person(layout, rng, frames)
            uv[:, hidden] = np.nan
            assert recognised_layout(BOTH, uv) in (layout, None)


@pytest.mark.parametrize("count", [1, 50])
def test_points_that_are_no_person_and_nobody_at_all_are_left_open(count: int) -> None:
    rng = np.random.default_rng(5)
    assert recognised_layout(BOTH, rng.uniform(0, 1000, (count, 25, 2))) is None
    assert recognised_layout(BOTH, np.full((count, 25, 2), np.nan)) is None
    assert recognised_layout(BOTH, np.full((count, 25, 2), 7.0)) is None


def test_a_layout_that_is_alone_is_recognised_by_its_count() -> None:
    assert recognised_layout(("HALPE_26",), np.full((1, 26, 2), np.nan)) == "HALPE_26"
