"""Left and right: what a detector exchanges suddenly is set right, and what it tells stands."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.tracking.cues.anchors import Anchors
from tests.tracker.tracking.cues.people import Filmed, moving


def _exchanged(keypoints: Keypoints, frames: slice) -> Keypoints:
    other, uv = keypoints.exchanged(), keypoints.uv.copy()
    uv[frames] = other.uv[frames]
    return replace(keypoints, uv=uv)


def test_as_reported_there_is_one_way_to_take_them() -> None:
    assert len(Filmed(moving()).anchors()) == 1


def test_a_sudden_exchange_is_set_right_beside_what_was_reported() -> None:
    film = Filmed(moving())
    wrong = _exchanged(film.keypoints, slice(5, 9))
    as_detected, mended = film.anchors(wrong)
    (right,) = film.anchors()
    assert not as_detected.exchanged
    assert mended.exchanged
    np.testing.assert_allclose(mended.uv, right.uv, atol=1e-6)
    assert np.abs(as_detected.uv - right.uv)[5:9].max() > 10


def test_keyframes_say_which_side_is_which_when_all_are_exchanged() -> None:
    film = Filmed(moving())
    (mended,) = film.anchors(
        _exchanged(film.keypoints, slice(None))
    )  # as detected they miss the body
    assert mended.exchanged
    np.testing.assert_allclose(mended.uv, film.anchors()[0].uv, atol=1e-6)


def test_frames_where_nothing_is_seen_are_passed_over() -> None:
    film = Filmed(moving())
    wrong = _exchanged(film.keypoints, slice(5, 9))
    uv = wrong.uv.copy()
    uv[7] = np.nan
    _, mended = film.anchors(replace(wrong, uv=uv, visibility=np.isfinite(uv[..., 0]) * 1.0))
    seen = [5, 6, 8]
    np.testing.assert_allclose(mended.uv[seen], film.anchors()[0].uv[seen], atol=1e-6)


def test_sides_that_pass_through_each_other_are_set_right_by_the_motion_that_was_followed() -> None:
    """Of somebody who seems to be seen from behind for some frames. Nothing jumps then, so that by
    itself it cannot be told from a body that turns round."""
    film = Filmed(moving(21))
    share = np.interp(np.arange(21), (4, 8, 13, 17), (0.0, 1.0, 1.0, 0.0), 0, 0)[:, None, None]
    own, other = film.keypoints.uv, film.keypoints.exchanged().uv
    wrong = replace(film.keypoints, uv=own + share * (other - own))
    (right,) = film.anchors()
    inside = slice(8, 14)

    def away(anchors: Anchors) -> float:
        return float(np.abs(anchors.uv[inside] - right.uv[inside]).max())

    assert min(map(away, film.anchors(wrong))) > 10
    found = film.anchors(wrong, film.truth)
    assert len(found) == len(film.anchors(wrong)) + 1
    assert away(found[-1]) < 1e-6


def test_a_motion_that_was_followed_adds_nothing_where_sides_agree_with_it() -> None:
    film = Filmed(moving())
    assert len(film.anchors(film.keypoints, film.truth)) == 1
