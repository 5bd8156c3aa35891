"""What counts as a look, an exchange, as hidden and as short, of bodies whose truth is known."""

from __future__ import annotations

import numpy as np
import pytest

from bench.bodies.bonds import MEETINGS, Meeting
from bench.bodies.crossing import FILMS, LEAST_HIDDEN_FRAMES, exchanged_frames
from bench.bodies.film import Actor, hidden_shares
from bench.bodies.film_of_two import RIGHT_SHARE, judged_look
from bench.bodies.people import on_one_floor, passing_by, place_path
from bench.bodies.promises import Promise, write_promises
from bench.standing_cases import TILT_RAD
from bench.table import Report
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import Array, rotation_from_euler
from keypose.tracker.session.pins import sole_of
from tests.rendering.scenes import camera

LENS = camera()
APART = (*range(0, 20, 4), *range(54, 72, 4))
"""Frames in which the two are beside each other."""


def seen(actor: Actor, frame: int) -> Array:
    """(J, 2) the true joints of a body in the picture."""
    return LENS.project(actor.joints[frame])


def test_looks_at_rendered_people_are_counted_by_whom_they_show() -> None:
    far, near = passing_by()
    looks = []
    for frame in APART:
        own, other = seen(far, frame), seen(near, frame)
        below = own + np.array([[0.0, 2 * RIGHT_SHARE * np.ptp(own[:, 1])]])
        for shown in (own, own, own, other, other, below, np.full_like(own, np.nan)):
            looks.append(judged_look(shown, own, other))
    counts = {kind: looks.count(kind) for kind in ("right", "other", "wrong", "unseen")}
    each = len(APART)
    assert counts == {"right": 3 * each, "other": 2 * each, "wrong": each, "unseen": each}


@pytest.mark.parametrize("share", [0.9 * RIGHT_SHARE, 1.1 * RIGHT_SHARE])
def test_a_look_is_right_up_to_a_share_of_the_height_of_who_is_meant(share: float) -> None:
    far, near = passing_by()
    own, other = seen(far, 0), seen(near, 0)
    look = judged_look(own + np.array([[share * np.ptp(own[:, 1]), 0.0]]), own, other)
    assert (look == "right") is (share < RIGHT_SHARE)


def test_a_motion_is_exchanged_where_it_is_that_of_the_other() -> None:
    far, near = passing_by()
    frames = slice(0, 20)
    of_far, of_near = (
        Trajectory(0, actor.truth.Rs_parent_part[frames], actor.truth.ps_camera_root[frames])
        for actor in (far, near)
    )
    assert exchanged_frames(of_far, far, near, LENS) == 0
    assert exchanged_frames(of_near, far, near, LENS) == 20


@pytest.mark.parametrize("name", FILMS)
def test_the_one_behind_is_hidden_for_long_and_the_one_before_never(name: str) -> None:
    far, near = FILMS[name]()
    assert (hidden_shares(far, near, LENS) > 0).sum() >= LEAST_HIDDEN_FRAMES
    assert hidden_shares(near, far, LENS).max() == 0


@pytest.mark.parametrize("meeting", MEETINGS, ids=lambda meeting: meeting.name)
def test_what_meets_does_so_in_truth(meeting: Meeting) -> None:
    paths = [
        place_path(actor.skeleton, actor.truth, part, place)
        for actor, (part, place) in zip(meeting.actors(), meeting.places, strict=True)
    ]
    np.testing.assert_allclose(paths[0], paths[1], atol=1e-9)
    assert np.ptp(paths[0], axis=0).max() > 0.02


def test_the_feet_of_two_are_on_one_floor_in_truth() -> None:
    up = rotation_from_euler(0.0, 0.0, TILT_RAD) @ (0.0, -1.0, 0.0)
    lowest = [
        np.min(
            [
                place_path(actor.skeleton, actor.truth, part.name, sole) @ up
                for part in actor.body.parts
                if sole_of(part)
                for sole in part.landmarks.values()
            ],
            axis=0,
        )
        for actor in on_one_floor()
    ]
    assert np.ptp(lowest) < 0.005


def test_a_promise_falls_short_of_what_is_wanted_at_most_and_at_least() -> None:
    report = Report("promises")
    write_promises(
        report,
        [
            Promise.at_most("kept", 1.2, 1.2),
            Promise.at_most("broken", 1.3, 1.2),
            Promise.at_least("kept", 26, 26),
            Promise.at_least("broken", 25, 26),
        ],
    )
    assert report.short == 2
