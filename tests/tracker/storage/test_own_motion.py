"""Tracking starts from the motion that a session had before it was reduced, where it had one."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from keypose.tracker.body.body import preset
from keypose.tracker.body.modify import (
    with_clavicles,
    with_new_part,
    with_renamed_part,
    without_part,
)
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory, displaced, interpolate, joined
from keypose.tracker.errors import SessionError
from keypose.tracker.operations.track import track_session
from keypose.tracker.session import Session
from keypose.tracker.storage.files import load_session, open_video_of
from keypose.tracker.storage.sidecars import OwnMotion, load_first_motion, save_own_motion
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
            session, video, segments=[0, 1], first_motion=load_first_motion(session, tmp_path)
        )
        for event in events:
            if isinstance(event, PassFinished) and event.result.span not in begun:
                begun[event.result.span] = event.result.steps[0], event.result.trajectory
    what, trajectory = begun[first, last]
    assert what == "import"
    np.testing.assert_allclose(trajectory.ps_camera_root, motion.ps_camera_root, atol=1e-6)
    assert begun[others[0]][0] != "import"


BODIES = {
    "part removed": lambda body: without_part(body, "left_hand"),
    "part added": lambda body: with_new_part(body, "head", "hat"),
    "clavicles": with_clavicles,
    "renamed": lambda body: with_renamed_part(body, "head", "skull"),
    "another body": lambda body: preset("box"),
}


@pytest.mark.parametrize("change", BODIES)
def test_what_was_kept_follows_the_body_part_by_part(tmp_path: Path, change: str) -> None:
    session = load_session(PERSON)
    first, last = session.spans[0]
    motion = bent(session, first, last)
    own = save_own_motion(session, tmp_path / "session.json", motion)
    names = session.subject.body.names
    body = BODIES[change](session.subject.body)
    other = session.changed({"first_motion": own, "body": body})
    followed = load_first_motion(other, tmp_path)
    kept = OwnMotion.of(other, tmp_path)
    assert followed is not None
    assert kept is not None
    assert followed.ps_camera_root.tobytes() == motion.ps_camera_root.tobytes()
    for part, name in enumerate(body.names):
        known = motion.Rs_parent_part[:, names.index(name)] if name in names else np.eye(3)
        np.testing.assert_array_equal(
            followed.Rs_parent_part[:, part], np.broadcast_to(known, (len(motion), 3, 3))
        )
    inside = kept.over(other, first + 1, last - 1)
    assert inside is not None
    assert inside.Rs_parent_part.tobytes() == followed.Rs_parent_part[1:-1].tobytes()
    assert kept.over(other, first, last + 1) is None
    assert kept.over(session, first, last) is None  # which names no such motion


def test_a_session_that_names_poses_its_own_motion_lacks_is_said_in_a_sentence(
    tmp_path: Path,
) -> None:
    session = load_session(PERSON)
    first, last = session.spans[0]
    own = save_own_motion(session, tmp_path / "session.json", bent(session, first, last))
    run = own.own[0].model_copy(update={"last_frame": last + 30})
    other = session.changed({"first_motion": own.model_copy(update={"own": (run,)})})
    with pytest.raises(SessionError, match="lacks poses that the session says it has"):
        load_first_motion(other, tmp_path)
    kept = OwnMotion.of(other, tmp_path)
    assert kept is not None
    assert kept.over(other, first, last + 20) is None


def test_a_damaged_file_is_said_in_a_sentence(tmp_path: Path) -> None:
    session = load_session(PERSON)
    first, last = session.spans[0]
    own = save_own_motion(session, tmp_path / "session.json", bent(session, first, last))
    session = session.changed({"first_motion": own})
    (tmp_path / own.file).write_bytes(b"nothing")
    with pytest.raises(SessionError, match="is damaged"):
        load_first_motion(session, tmp_path)
    (tmp_path / own.file).unlink()
    with pytest.raises(SessionError, match="cannot be read"):
        load_first_motion(session, tmp_path)


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
