"""A recording at a constant rate and low-pass filtered: times, gaps, verdicts and bones."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from keypose.tracker.errors import FormatError
from keypose.tracker.formats.recording import Recording
from keypose.tracker.formats.sampling import at_rate, low_passed, moved_at_keyframes
from keypose.tracker.geometry.rotations import Array, exp_rotation
from keypose.tracker.storage.tracks import Tracks
from tests.tracker.formats import recordings

RATE = 30.0


def even(name: str, **kwargs: object) -> Recording:
    """A sample's motion at a constant rate."""
    made = recordings.recording(name, **kwargs)  # type: ignore[arg-type]
    return replace(made, times_s=np.array(made.frames) / RATE, rate=RATE)


def shaken(made: Recording, size: float = 0.05) -> Recording:
    """Every part turned a little at every frame."""
    Rs = made.tracks.Rs_parent_part
    noise = np.random.default_rng(1).normal(0.0, size, Rs.shape[:-1])
    return replace(made, tracks=replace(made.tracks, Rs_parent_part=Rs @ exp_rotation(noise)))


def bones(made: Recording) -> Array:
    """(N, P) lengths from each part's joint to its parent's."""
    ps, parents = made.ps_camera_joint, made.skeleton.parents
    steps = ps[:, 1 : len(parents)] - ps[:, parents[1:]]
    return np.asarray(np.linalg.norm(steps, axis=-1))


@pytest.mark.parametrize("rate", [24.0, 30.0, 59.94])
@pytest.mark.parametrize("name", recordings.NAMES)
def test_frames_at_a_rate_of_their_own_are_shown_when_their_numbers_say(
    name: str, rate: float
) -> None:
    made = recordings.recording(name)
    found = at_rate(made, rate)
    np.testing.assert_allclose(found.times_s, np.array(found.frames) / rate, atol=1e-12)
    assert found.is_even
    assert found.frames_per_second == rate
    assert abs(found.times_s[0] - made.times_s[0]) <= 1 / rate
    assert abs(found.times_s[-1] - made.times_s[-1]) <= 1 / rate


def test_uneven_frames_of_a_known_motion_are_right_to_a_millisecond() -> None:
    """A root that moves at 1 m/s along x and turns at 1 rad/s tells the time of every pose."""
    made = recordings.recording("box")
    seconds = made.times_s
    ps = np.outer(seconds, [1.0, 0.0, 0.0]) + np.array([0.0, 0.0, 5.0])
    Rs = made.tracks.Rs_parent_part.copy()
    Rs[:, 0] = exp_rotation(np.outer(seconds, [0.0, 1.0, 0.0]))
    moving = replace(made, tracks=replace(made.tracks, Rs_parent_part=Rs, ps_camera_root=ps))
    assert not moving.is_even
    for rate in (25.0, 29.87, moving.rate or 0.0):
        found = at_rate(moving, rate)
        np.testing.assert_allclose(found.tracks.ps_camera_root[:, 0], found.times_s, atol=1e-3)
        angle = np.arctan2(
            found.tracks.Rs_parent_part[:, 0, 0, 2], found.tracks.Rs_parent_part[:, 0, 0, 0]
        )
        np.testing.assert_allclose(angle, found.times_s, atol=1e-3)


def test_gaps_stay_gaps_and_segments_keep_their_frames() -> None:
    made = recordings.recording("person", without=(1,))
    found = at_rate(made, 60.0)
    film = found.film_frames
    np.testing.assert_array_equal(found.tracks.tracked, (film <= 24) | (film >= 48))
    assert found.segments == made.segments
    at = found.segment_at
    assert {made.segments[i].first_frame for i in at[film < 24]} == {0}
    assert set(at[(film > 24) & (film < 48)]) == {-1}
    assert {made.segments[i].first_frame for i in at[film >= 48]} == {48}
    keyed = film[found.at_keyframe]
    assert set(np.rint(keyed)) <= {0.0, 24.0, 48.0, 72.0}
    rank = made.tracks.diagnostics.rank
    steps = np.floor((film[1:] + film[:-1]) / 2).astype(int)
    np.testing.assert_array_equal(found.tracks.diagnostics.rank, rank[steps])


@pytest.mark.parametrize("name", recordings.NAMES)
def test_a_filtered_body_keeps_its_bones_and_its_ends(name: str) -> None:
    made = shaken(even(name))
    found = low_passed(made, 6.0)
    np.testing.assert_allclose(bones(found), bones(made), atol=1e-12)
    assert found.filter_hz == 6.0
    assert found.frames == made.frames
    for end in (0, -1):
        np.testing.assert_allclose(found.ps_camera_joint[end], made.ps_camera_joint[end], atol=1e-8)


def test_a_filtered_motion_shakes_less_and_says_how_far_keyframes_moved() -> None:
    true, made = even("person"), shaken(even("person"), 0.03)
    found = low_passed(made, 6.0)

    def acceleration(one: Recording) -> float:
        return float(np.sqrt(np.square(np.diff(one.ps_camera_joint, 2, axis=0) * RATE**2).mean()))

    assert acceleration(found) < 0.25 * acceleration(made)
    assert acceleration(low_passed(true, 6.0)) > 0.9 * acceleration(true)
    metres, radians = moved_at_keyframes(found, made)
    assert 0.001 < metres < 0.1
    assert 0.005 < radians < 0.15


def test_stretches_between_gaps_are_filtered_apart() -> None:
    made = shaken(even("person", without=(1,)))
    found = low_passed(made, 6.0)
    np.testing.assert_array_equal(found.tracks.tracked, made.tracks.tracked)
    alone = low_passed(made.between(0, 24), 6.0)
    np.testing.assert_allclose(
        found.tracks.Rs_parent_part[:25], alone.tracks.Rs_parent_part, atol=1e-12
    )


def test_an_uneven_recording_is_filtered_at_its_mean_rate() -> None:
    made = recordings.recording("person")
    found = low_passed(made, 6.0)
    assert found.is_even
    assert found.frames_per_second == pytest.approx(made.frames_per_second)


@pytest.mark.parametrize("cutoff", [15.0, 20.0])
def test_a_cutoff_of_half_the_rate_is_refused(cutoff: float) -> None:
    with pytest.raises(FormatError, match=r"choose a cut-off below 15 Hz\.$"):
        low_passed(even("person"), cutoff)


def test_too_few_frames_side_by_side_are_named() -> None:
    made = even("person")
    with pytest.raises(FormatError, match=r"^Frames 5 to 9 are too few .* that takes 6\.$"):
        low_passed(made.between(5, 9), 6.0)


@pytest.mark.parametrize("rate", [0.1, 1e9])
def test_a_rate_that_makes_no_motion_is_refused(rate: float) -> None:
    with pytest.raises(FormatError, match="frames a second this motion has"):
        at_rate(even("person"), rate)


def test_tracks_of_another_rate_are_such_as_are_read_from_a_file() -> None:
    found = at_rate(recordings.recording("person"), 50.0).tracks
    again = Tracks.from_bytes(found.to_bytes())
    np.testing.assert_array_equal(again.Rs_parent_part, found.Rs_parent_part)
