"""Each frame of a camera that turns is measured from one keyframe, and new ones are set in time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.camera_motion.findings import LOST_FRAMES
from keypose.tracker.camera_motion.lens import Lens
from keypose.tracker.camera_motion.measurements import Measured
from keypose.tracker.camera_motion.turning_odometry import (
    DISPLACED_SHARE,
    ROLL,
    ZOOM,
    TurningOdometry,
)
from keypose.tracker.geometry.rotations import Array
from tests.tracker.camera_cases import SMALL, Grey, off_deg, rendered, turned

Mask = NDArray[np.bool_]


def odometry_over(
    pictures: Sequence[Grey | None], usable: Mask | None = None
) -> tuple[TurningOdometry, list[Measured]]:
    odometry = TurningOdometry(Lens.of(SMALL))
    measured = [odometry.advance(k, picture, usable) for k, picture in enumerate(pictures)]
    odometry.finish()
    return odometry, measured


def filmed(rotations: Sequence[Array], zooms: Sequence[float] | None = None) -> list[Grey]:
    each = [1.0] * len(rotations) if zooms is None else zooms
    return [rendered(SMALL, R, zoom) for R, zoom in zip(rotations, each, strict=True)]


PAN = [turned(0.8 * k) for k in range(36)]


def test_each_frame_is_measured_from_its_keyframe() -> None:
    odometry, measured = odometry_over(filmed(PAN))
    for k, frame in enumerate(measured):
        assert frame.known
        true = PAN[k] @ PAN[odometry.map.frames[frame.keyframe]].T
        assert off_deg(frame.turn.R[None], [true]).max() < 0.05
        assert frame.error_px < 0.2


def test_a_keyframe_is_set_where_the_picture_went_away_by_its_share() -> None:
    odometry, _ = odometry_over(filmed(PAN))
    steps = np.diff(odometry.map.frames)
    share = np.tan(np.radians(0.8 * steps)) * SMALL.fx / SMALL.width
    assert len(steps) >= 3
    assert (share > DISPLACED_SHARE).all()
    assert (share < DISPLACED_SHARE + 0.05).all()


@pytest.mark.parametrize(
    ("rotations", "zooms", "due"),
    [
        ([turned(0, 0, 1.2 * k) for k in range(12)], [1.0] * 12, np.ceil(np.degrees(ROLL) / 1.2)),
        ([np.eye(3)] * 12, [1.02**k for k in range(12)], np.ceil(ZOOM / np.log(1.02))),
    ],
    ids=["rolls", "zooms"],
)
def test_so_it_is_where_windows_no_longer_look_alike(
    rotations: list[Array], zooms: list[float], due: float
) -> None:
    odometry, measured = odometry_over(filmed(rotations, zooms))
    assert odometry.map.frames == [0, due]
    assert all(frame.known for frame in measured)
    last = odometry.map.turns[measured[-1].keyframe].then(measured[-1].turn)
    assert off_deg(last.R[None], [rotations[-1]]).max() < 0.05
    assert last.zoom == pytest.approx(zooms[-1], rel=2e-3)


def test_a_still_camera_needs_one_keyframe_and_has_no_doubt_to_speak_of() -> None:
    odometry, measured = odometry_over(filmed([np.eye(3)] * 40))
    assert odometry.map.frames == [0]
    assert max(np.sqrt(np.diag(frame.covariance)[:3]).max() for frame in measured) < 1e-3


def test_a_camera_that_comes_back_closes_its_loop() -> None:
    there_and_back = [turned(24 * np.sin(np.pi * k / 29)) for k in range(30)]
    odometry, _ = odometry_over(filmed(there_and_back))
    closed = [edge for edge in odometry.map.edges if edge.closes_loop]
    assert closed
    assert all(edge.target - edge.source > 1 for edge in closed)


def test_pairs_far_apart_are_kept_for_the_focal_length() -> None:
    odometry, _ = odometry_over(filmed(PAN))
    assert len(odometry.pairs) >= 3
    displacements = [pair.displacement for pair in odometry.pairs]
    assert displacements == sorted(displacements, reverse=True)
    assert displacements[2] > 0.2
    assert all(len(pair.uv) == len(pair.uv_later) for pair in odometry.pairs)


BLACK = np.zeros((180, 320), np.uint8)


def test_a_camera_that_is_lost_for_a_while_finds_its_keyframe_again() -> None:
    pictures = filmed(PAN[:12])
    pictures[5:7] = [BLACK] * 2
    odometry, measured = odometry_over(pictures)
    assert [frame.known for frame in measured] == [True] * 5 + [False] * 2 + [True] * 5
    assert odometry.untied == []


def test_a_jump_that_no_picture_shows_begins_a_scene_tied_to_nothing() -> None:
    pictures = filmed([*PAN[:8], *[turned(100 + 0.3 * k) for k in range(10)]])
    odometry, measured = odometry_over(pictures)
    (untied,) = odometry.untied
    assert 8 <= odometry.map.frames[untied] <= 8 + LOST_FRAMES
    assert measured[-1].known
    assert measured[-1].keyframe >= untied


def test_a_cut_is_a_cut_once_the_film_has_settled() -> None:
    rotations = [turned(0.3 * k) for k in range(16)]
    pictures = [rendered(SMALL, R, seed=0 if k < 8 else 5) for k, R in enumerate(rotations)]
    odometry, measured = odometry_over(pictures)
    assert odometry.cuts == [8]
    assert measured[8].cause == "cut"
    assert measured[9].known


def test_a_scene_that_was_left_is_recognised() -> None:
    """As where two cameras of one conversation take turns."""
    seeds = [0] * 8 + [5] * 8 + [0] * 8
    pictures = [rendered(SMALL, turned(0.2 * k), seed=seed) for k, seed in enumerate(seeds)]
    odometry, measured = odometry_over(pictures)
    assert measured[-1].keyframe == measured[7].keyframe
    assert measured[16].known  # at once, so that nothing was cut
    assert odometry.cuts == [8]


CAUSES: dict[str, tuple[Grey | None, Mask | None, str]] = {
    "a picture that cannot be read": (None, None, "no_picture"),
    "black": (BLACK, None, "no_texture"),
    "somebody who fills it": (
        rendered(SMALL, np.eye(3)), np.zeros((180, 320), bool), "body_fills",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", CAUSES)
def test_where_there_is_nothing_to_follow_the_cause_is_said(name: str) -> None:
    picture, usable, cause = CAUSES[name]
    odometry, measured = odometry_over([picture] * 6, usable)
    assert {frame.cause for frame in measured} == {cause}
    assert not any(frame.known for frame in measured)
    assert len(odometry.map.turns) == 1  # the film has a first camera all the same
