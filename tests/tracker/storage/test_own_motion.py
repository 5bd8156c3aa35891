"""Tracking starts from the motion that a session had before it was reduced, where it had one."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory, displaced, interpolate, joined
from keypose.tracker.errors import SessionError
from keypose.tracker.session import Session
from keypose.tracker.storage.files import load_session, open_video_of
from keypose.tracker.storage.sidecars import (
    first_motion_of_session,
    load_first_motion_of,
    save_own_motion,
)
from keypose.tracker.storage.tracking import require_first_motion, track_session
from keypose.tracker.tracking.pool import PassFinished

PERSON = Path(__file__).parents[3] / "sample_videos" / "person" / "session.json"


def plain(session: Session) -> Trajectory:
    """Interpolation of all keyframes."""
    skeleton = Skeleton.of(session.subject.body)
    poses = [(k.frame, k.pose(skeleton)) for k in session.subject.keyframes]
    return joined([interpolate(p, q, a, b) for (a, p), (b, q) in pairwise(poses)])


def bent(session: Session, first: int, last: int) -> Trajectory:
    """The same between two keyframes, with a bump that no way of tracking would begin with."""
    motion = plain(session)
    rows = slice(first - motion.first_frame, last - motion.first_frame + 1)
    ps = motion.ps_camera_root[rows].copy()
    ps[len(ps) // 2] += (0.0, 0.02, 0.0)
    return Trajectory(first, motion.Rs_parent_part[rows], ps)


def test_only_segments_within_the_run_start_from_it_as_it_is(tmp_path: Path) -> None:
    session = load_session(PERSON)
    (first, last), *others = session.spans
    motion = bent(session, first, last)
    own = save_own_motion(session, tmp_path / "session.json", motion)
    settings = session.settings.model_copy(update={"quality": "preview"})
    session = session.changed({"first_motion": own, "settings": settings})
    begun: dict[tuple[int, int], tuple[str, Trajectory]] = {}
    with open_video_of(session, PERSON) as video:
        events = track_session(
            session, video, segments=[0, 1], first_motion=first_motion_of_session(session, tmp_path)
        )
        for event in events:
            if isinstance(event, PassFinished) and event.result.span not in begun:
                begun[event.result.span] = event.result.steps[0], event.result.trajectory
    what, trajectory = begun[first, last]
    assert what == "import"
    np.testing.assert_allclose(trajectory.ps_camera_root, motion.ps_camera_root, atol=1e-6)
    assert begun[others[0]][0] != "import"


def test_a_body_with_other_parts_is_tracked_as_if_nothing_was_kept(tmp_path: Path) -> None:
    session = load_session(PERSON)
    first, last = session.spans[0]
    own = save_own_motion(session, tmp_path / "session.json", bent(session, first, last))
    body = session.subject.body.model_copy(update={"parts": session.subject.body.parts[:-1]})
    other = session.changed({"first_motion": own, "body": body})
    assert first_motion_of_session(other, tmp_path) is None
    require_first_motion(other, None)


def test_a_damaged_file_is_said_in_a_sentence(tmp_path: Path) -> None:
    session = load_session(PERSON)
    first, last = session.spans[0]
    own = save_own_motion(session, tmp_path / "session.json", bent(session, first, last))
    session = session.changed({"first_motion": own})
    (tmp_path / own.file).write_bytes(b"nothing")
    with pytest.raises(SessionError, match="is damaged"):
        load_first_motion_of(session, tmp_path)
    (tmp_path / own.file).unlink()
    with pytest.raises(SessionError, match="cannot be read"):
        first_motion_of_session(session, tmp_path)


def test_a_displaced_motion_meets_both_poses_and_is_what_it_was_where_it_has_them() -> None:
    session = load_session(PERSON)
    first, last = session.spans[0]
    motion = bent(session, first, last)
    same = displaced(motion, motion.pose(first), motion.pose(last), first, last)
    np.testing.assert_allclose(same.Rs_parent_part, motion.Rs_parent_part, atol=1e-12)
    np.testing.assert_allclose(same.ps_camera_root, motion.ps_camera_root, atol=1e-12)
    other = plain(session).pose(session.spans[1][1])
    moved = displaced(motion, motion.pose(first), other, first, last)
    assert moved.pose(last).Rs_parent_part.tobytes() == other.Rs_parent_part.tobytes()
    assert moved.pose(first).p_camera_root.tobytes() == motion.pose(first).p_camera_root.tobytes()
    middle = len(motion) // 2
    bump = moved.ps_camera_root - plain(session).ps_camera_root[: len(motion)]
    share = np.linspace(0, 1, len(motion))[:, None]
    path = (3 - 2 * share) * share**2 * bump[-1]
    assert (bump - path)[middle] == pytest.approx((0.0, 0.02, 0.0), abs=1e-9)


def test_what_a_corrected_keyframe_adds_comes_and_goes_without_a_kink() -> None:
    session = load_session(PERSON)
    first, last = session.spans[0]
    motion = bent(session, first, last)
    end = motion.pose(last)
    higher = Pose(end.Rs_parent_part, end.p_camera_root + np.array([0.0, -0.05, 0.0]))
    moved = displaced(motion, motion.pose(first), higher, first, last)
    added = (moved.ps_camera_root - motion.ps_camera_root)[:, 1]
    assert (np.diff(added) <= 1e-12).all()
    steps, even = np.abs(np.diff(added)), 0.05 / (last - first)
    assert steps[[0, -1]].max() < 0.2 * even
    assert steps.max() < 1.6 * even
