"""How long the units of a moving camera's way are, from the body that is tracked before it."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.camera_path import CameraPath, rigid_inverse
from keypose.tracker.geometry.rotations import exp_rotation, transform
from keypose.tracker.session import Session
from keypose.tracker.session.camera_motion import CameraMotion, CameraPiece
from keypose.tracker.storage.camera_motion import with_scale
from keypose.tracker.storage.fingerprints import Span
from keypose.tracker.tracking.result import SegmentResult
from tests.tracker.storage.standing_cases import KEYS, session_of, tracked, walk

COUNT, CUT, UNITS = KEYS[-1] + 1, 45, (2.0, 0.5)


def carried(metres: tuple[float | None, float | None]) -> tuple[Session, dict[Span, SegmentResult]]:
    """Somebody who stands before a hand-held camera whose path has another unit after a cut, and
    what was tracked in its frame."""
    shown, _ = walk()
    t = np.linspace(0, 1, COUNT)
    p = np.stack([0.8 * t, 0.03 * np.sin(25 * t), 0.3 * t + 0.02 * np.sin(31 * t)], axis=1)
    R = exp_rotation(np.stack([0.02 * np.sin(19 * t), -0.2 * t, 0 * t], axis=1))
    path = CameraPath(rigid_inverse(transform(R, p)), np.ones(COUNT))
    in_units = path.in_metres((0, CUT), [1 / unit for unit in UNITS])
    pieces = tuple(
        CameraPiece(first_frame=first, metres=each)
        for first, each in zip((0, CUT), metres, strict=True)
    )
    pose = shown.truth.pose(0)
    stays = Trajectory(
        0,
        np.repeat(pose.Rs_parent_part[None], COUNT, 0),
        np.repeat(pose.p_camera_root[None], COUNT, 0),
    )
    motion = stays.carried(path.Ts_camera_world)
    session = session_of(
        shown, motion, camera_motion=CameraMotion.of("moves", in_units, pieces=pieces)
    )
    return session, tracked(session, motion)


def lengths(session: Session) -> list[float | None]:
    assert session.view.camera_motion is not None
    return [piece.metres for piece in session.view.camera_motion.pieces]


def test_every_piece_has_the_unit_that_its_own_stances_tell() -> None:
    session, fitting = carried((None, None))
    found = with_scale(session, fitting)
    assert lengths(found) == pytest.approx(UNITS, rel=0.01)
    assert found.view.camera_motion is not None
    assert found.view.camera_motion.unscaled == ()


def test_a_piece_over_which_nothing_is_tracked_has_none_and_one_that_is_known_keeps_its_own() -> (
    None
):
    session, fitting = carried((1.75, None))
    first = min(fitting)
    assert with_scale(session, {first: fitting[first]}) is session
    assert lengths(with_scale(session, fitting)) == [1.75, pytest.approx(UNITS[1], rel=0.01)]
