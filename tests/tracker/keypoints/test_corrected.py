"""Keypoints with what a person said of some of them."""

from __future__ import annotations

import numpy as np

from keypose.tracker.keypoints.keypoints import JOINTS, Keypoints
from keypose.tracker.session.annotations import KeypointCorrection

RNG = np.random.default_rng(3)
FOUND = Keypoints(
    5, JOINTS, RNG.uniform(10, 90, (4, 12, 2)), RNG.uniform(0.2, 0.9, (4, 12)),
    RNG.normal(size=(4, 12, 3)),
)  # fmt: skip
WRIST = JOINTS.index("left_wrist")
OTHER = JOINTS.index("right_wrist")
MOVED = KeypointCorrection(frame=6, joint="left_wrist", uv=(12.0, 34.0))
HIDDEN = KeypointCorrection(frame=7, joint="left_wrist")


def test_a_corrected_keypoint_is_seen_for_sure_and_an_ignored_one_not_at_all() -> None:
    given = FOUND.corrected([MOVED, HIDDEN])
    assert given.by_hand is not None
    assert given.uv[1, WRIST].tolist() == [12.0, 34.0]
    assert given.visibility[1:3, WRIST].tolist() == [1.0, 0.0]
    assert np.isnan(given.uv[2, WRIST]).all()
    assert given.p_hips is not None
    assert np.isnan(given.p_hips[1:3, WRIST]).all()
    untouched = ~given.by_hand
    assert untouched.sum() == 46
    np.testing.assert_array_equal(given.uv[untouched], FOUND.uv[untouched])
    np.testing.assert_array_equal(given.visibility[untouched], FOUND.visibility[untouched])


def test_corrections_of_other_frames_and_of_unknown_joints_change_nothing() -> None:
    elsewhere = MOVED.model_copy(update={"frame": 9})
    unknown = MOVED.model_copy(update={"joint": "left_toe"})
    assert FOUND.corrected([elsewhere, unknown]) is FOUND


def test_exchanging_sides_leaves_what_a_person_set_where_it_is() -> None:
    swapped = FOUND.corrected([MOVED, HIDDEN]).exchanged()
    assert swapped.uv[1, WRIST].tolist() == [12.0, 34.0]
    assert swapped.visibility[2, WRIST] == 0.0
    np.testing.assert_array_equal(swapped.uv[0, WRIST], FOUND.uv[0, OTHER])
    np.testing.assert_array_equal(swapped.uv[1, OTHER], [12.0, 34.0])


def test_a_piece_of_them_knows_which_were_set() -> None:
    piece = FOUND.corrected([MOVED]).over(4, 6)
    assert piece.by_hand is not None
    assert np.argwhere(piece.by_hand).tolist() == [[2, WRIST]]
