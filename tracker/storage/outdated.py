"""What a motion was tracked for, and whether that is still what the session says."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from tracker.body.skeleton import Skeleton
from tracker.body.trajectory import Trajectory
from tracker.session.schema import Session
from tracker.storage.fingerprints import setup_hash

if TYPE_CHECKING:
    from tracker.storage.tracks import Tracks

KEYFRAME_TOLERANCE = 1e-4
"""Radians and metres within which a tracked motion goes through a keyframe."""


def tracked_keyframes(session: Session) -> tuple[int, ...]:
    """The frames of the keyframes that the session's motion was tracked between, ascending.

    Of surfaces also its first and last frame, where it begins and ends without a keyframe.
    """
    segments = session.results.segments if session.results else ()
    return tuple(sorted({frame for s in segments for frame in (s.first_frame, s.last_frame)}))


def outdated_keyframes(session: Session, motion: Trajectory | Tracks) -> tuple[int, ...]:
    """Frames where motion and session differ: a keyframe was set, changed or taken away since.

    Keyframes that no segment of the motion reaches are among them.
    """
    skeleton = Skeleton.of(session.body)
    posed = {keyframe.frame for keyframe in session.keyframes}
    changed = (set(tracked_keyframes(session)) - posed) ^ _tracked_open(session)
    for keyframe in session.keyframes:
        i = keyframe.frame - motion.first_frame
        if not _reaches(motion, keyframe.frame):
            changed.add(keyframe.frame)
            continue
        pose = keyframe.pose(skeleton)
        turn = np.abs(pose.Rs_parent_part - motion.Rs_parent_part[i]).max()
        shift = np.abs(pose.p_camera_root - motion.ps_camera_root[i]).max()
        if max(turn, shift) > KEYFRAME_TOLERANCE:
            changed.add(keyframe.frame)
    return tuple(sorted(changed | _added(session)))


def outdated_words(session: Session, motion: Trajectory | Tracks) -> str | None:
    """What the motion does not know of the session, for a note; None when it is up to date."""
    known = session.results and session.results.tracked_for
    reasons = []
    if known and known != setup_hash(session):
        setup = "body, camera or ignore masks" if session.surface is None else "body or surfaces"
        reasons.append(f"{setup} have changed")
    frames = outdated_keyframes(session, motion)
    unreached = [frame for frame in frames if not _reaches(motion, frame)]
    changed = [frame for frame in frames if frame not in unreached]
    if changed:
        reasons.append(f"keyframes were set, changed or removed at {_listed(changed)}")
    words = [f"is out of date ({', and '.join(reasons)})"] if reasons else []
    if unreached:
        words.append(f"does not reach the keyframes at {_listed(unreached)}")
    return f"the tracked motion {' and '.join(words)}." if words else None


def _reaches(motion: Trajectory | Tracks, frame: int) -> bool:
    i = frame - motion.first_frame
    return 0 <= i < len(motion.ps_camera_root) and bool(np.isfinite(motion.ps_camera_root[i]).all())


def _listed(frames: Sequence[int]) -> str:
    numbers = ", ".join(str(frame) for frame in frames)
    return f"frame{'s' if len(frames) > 1 else ''} {numbers}"


def _added(session: Session) -> set[int]:
    """Keyframes set inside a tracked segment, even where the motion happens to go through them."""
    segments = session.results.segments if session.results else ()
    return {
        keyframe.frame
        for keyframe in session.keyframes
        if any(s.first_frame < keyframe.frame < s.last_frame for s in segments)
    }


def _tracked_open(session: Session) -> set[int]:
    """Where the session's motion was tracked to without a keyframe."""
    segments = session.results.segments if session.results else ()
    return {frame for segment in segments for frame in segment.open_ends}
