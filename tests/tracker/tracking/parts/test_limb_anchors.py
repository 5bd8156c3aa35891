"""What keypoints say of a limb between two frames at which it is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from keypose.tracker.keypoints.keypoints import JOINTS
from keypose.tracker.solver.projection import image_points
from keypose.tracker.tracking.cues.anchors import Anchors
from keypose.tracker.tracking.parts.limb_segment import (
    LimbSegment,
    limb_anchors,
    part_of,
    resolve_sides,
)
from tests.tracker.tracking.cues.people import SKELETON, Filmed, Floats, moving

ARM = ("right_upper_arm", "right_forearm", "right_hand")
SIDES = ("left", "right")
FILM = Filmed(moving(33))
(SEEN,) = FILM.anchors()
WRIST = JOINTS.index("right_wrist")
SLIPPED = np.array([5.0, -3.0])
"""How far beside the wrist it is seen, pixels; a tenth of the man's height are 15."""


def limb_between(first: int, last: int, names: tuple[str, ...] = ARM) -> LimbSegment:
    """A limb as a segment between two rows of the film, right at both."""
    truth, whole = FILM.truth, FILM.segment
    given = part_of(truth, truth.first_frame + first, truth.first_frame + last)
    parts = np.array([SKELETON.body.index(name) for name in names])
    ends = given.pose(given.first_frame), given.pose(given.last_frame)
    return LimbSegment(
        given.first_frame, given.last_frame, *ends, whole.clip, given=given, parts=parts
    )


def with_wrist_moved(by: Floats) -> Anchors:
    """Keypoints with the right wrist beside where it is, in all frames."""
    uv = SEEN.uv.copy()
    uv[:, WRIST] += by
    return replace(SEEN, uv=uv)


def wrist_misses(found: Anchors, limb: LimbSegment) -> Floats:
    """(N, 2) how far from the wrist its keypoint lies."""
    p = found.where(limb.given.transforms(SKELETON))[:, WRIST]
    return np.asarray(found.uv[:, WRIST] - image_points(FILM.free.camera, p))


@pytest.mark.parametrize("rows", [(0, 10), (10, 12), (10, 32)])
def test_by_what_a_keypoint_misses_a_limb_that_was_set_right_it_misses_it_near_by(
    rows: tuple[int, int],
) -> None:
    limb = limb_between(*rows)
    found = limb_anchors([with_wrist_moved(SLIPPED)], limb, FILM.segment, FILM.free)
    misses = np.linalg.norm(wrist_misses(found, limb), axis=-1)
    keyframes = {0, len(FILM.truth) - 1}
    for row in {*rows} - keyframes:
        np.testing.assert_allclose(misses[row - rows[0]], 0.0, atol=1e-9)
        near = {row - 1, row + 1} & set(range(rows[0], rows[1] + 1))
        assert all(misses[n - rows[0]] < 0.3 * np.linalg.norm(SLIPPED) for n in near)


def test_far_from_where_a_limb_was_set_right_keypoints_count_as_they_did() -> None:
    limb, slipped = limb_between(0, 2), with_wrist_moved(SLIPPED)
    long = limb_between(2, 32)
    found = limb_anchors([slipped], long, FILM.segment, FILM.free)
    np.testing.assert_allclose(found.uv[-2:], slipped.uv[-2:], atol=0.1)
    other = [k for k in range(len(JOINTS)) if JOINTS[k].startswith("left")]
    np.testing.assert_array_equal(found.uv[:, other], slipped.uv[2:, other])
    short = limb_anchors([slipped], limb, FILM.segment, FILM.free)
    np.testing.assert_array_equal(short.scale, slipped.scale[:3])


def test_a_keypoint_that_lies_elsewhere_counts_for_little_near_where_the_limb_was_set_right() -> (
    None
):
    limb, elsewhere = limb_between(8, 32), with_wrist_moved(np.array([40.0, 0.0]))
    found = limb_anchors([elsewhere], limb, FILM.segment, FILM.free)
    counts = found.scale[:, WRIST] / elsewhere.scale[8:, WRIST]
    assert counts[0] == 0.0
    assert counts[1] < 0.3
    assert counts[-2] > 0.9
    np.testing.assert_array_equal(found.uv[:, WRIST], elsewhere.uv[8:, WRIST])


def test_in_each_frame_the_other_leg_tells_which_foot_is_which() -> None:
    (right,) = FILM.anchors()
    legs = [JOINTS.index(f"{side}_{joint}") for joint in ("knee", "ankle") for side in SIDES]
    other = [JOINTS.index(f"{side}_{joint}") for joint in ("knee", "ankle") for side in SIDES[::-1]]
    candidates = []
    for frames in ([4, 5], [6, 7, 8]):  # the one is wrong where the other is right
        uv = right.uv.copy()
        uv[np.ix_(frames, legs)] = right.uv[np.ix_(frames, other)]
        candidates.append(replace(right, uv=uv))
    limb = limb_between(0, len(FILM.truth) - 1, ("right_thigh", "right_shin", "right_foot"))
    for some in (candidates, candidates[::-1]):
        np.testing.assert_array_equal(resolve_sides(some, limb, FILM.free).uv, right.uv)
