"""Whether the tracked motion still fits the session, and why not."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.session.results import Results
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.fingerprints import present_keys, setup_hash
from keypose.tracker.storage.stretches import Usable, stretch_keys

if TYPE_CHECKING:
    from keypose.tracker.storage.tracks import Tracks

KEYFRAME_TOLERANCE = 1e-4
"""Radians and metres within which a tracked motion goes through a keyframe."""


def tracked_keyframes(session: Session) -> tuple[int, ...]:
    """The frames of the keyframes that the session's motion was tracked between, ascending.

    Of surfaces also its first and last frame, where it begins and ends without a keyframe.
    """
    segments = session.subject.results.segments if session.subject.results else ()
    return tuple(sorted({frame for s in segments for frame in (s.first_frame, s.last_frame)}))


def outdated_keyframes(session: Session, motion: Trajectory | Tracks) -> tuple[int, ...]:
    """Frames where motion and session differ: a keyframe was set, changed or removed since.

    Keyframes that no segment of the motion reaches are among them.
    """
    skeleton = Skeleton.of(session.subject.body)
    posed = {keyframe.frame for keyframe in session.subject.keyframes}
    changed = (set(tracked_keyframes(session)) - posed) ^ _tracked_open(session)
    for keyframe in session.subject.keyframes:
        i = keyframe.frame - motion.first_frame
        if not _reaches(motion, keyframe.frame):
            changed.add(keyframe.frame)
            continue
        if keyframe.soft and session.subject.results is not None and session.subject.results.space:
            continue  # the motion in space need only come near it
        pose = keyframe.pose(skeleton)
        turn = np.abs(pose.Rs_parent_part - motion.Rs_parent_part[i]).max()
        shift = np.abs(pose.p_camera_root - motion.ps_camera_root[i]).max()
        if max(turn, shift) > KEYFRAME_TOLERANCE:
            changed.add(keyframe.frame)
    return tuple(sorted(changed | _keyframes_inside(session)))


def outdated_beside(before: Session, after: Session) -> tuple[str, ...]:
    """The ids of tracked bodies whose own poses stay, but whose motion is out of date by a change
    of another body."""
    poses_before = {body.id: body.keyframes for body in before.bodies}
    return tuple(
        body.id
        for body in after.bodies
        if body.results is not None and body.keyframes == poses_before.get(body.id)
        if present_keys(after.about(body.id)) != present_keys(before.about(body.id))
    )


def outdated_words(session: Session, motion: Trajectory | Tracks) -> str | None:
    """Why the motion is out of date, for a note; None when it is up to date."""
    frames = outdated_keyframes(session, motion)
    unreached = [frame for frame in frames if not _reaches(motion, frame)]
    changed = [frame for frame in frames if frame not in unreached]
    reasons = _reasons(session, changed)
    faults = [f"is out of date ({', and '.join(reasons)})"] if reasons else []
    if unreached:
        faults.append(f"does not reach the keyframes at {_listed(unreached)}")
    return f"the tracked motion {' and '.join(faults)}." if faults else None


def _reasons(session: Session, changed: Sequence[int]) -> list[str]:
    """Why segments would be tracked differently now, in words; none where they would not.

    changed: frames of keyframes that are others now.
    """
    results = session.subject.results
    keyed = results is not None and all(segment.key for segment in results.segments)
    if results is None:
        return []
    moved = _other_space(session, results)
    if keyed and not moved and not _is_outdated(session, results):
        return []
    reasons = []
    if results.tracked_for not in (None, setup_hash(session)):
        reasons.append(f"{session.evidence.words.setup} have changed")
    camera = ["the camera's motion"] if _may_move(session) else []
    if keyed and moved:
        causes = ["pins", "the floor", "smoothing", *camera, "the frame rate"]
        reasons.append(f"{_either(causes)} have changed")
    if changed:
        reasons.append(f"keyframes were set, changed or removed at {_listed(changed)}")
    part_keyframes = ["part keyframes"] if session.subject.part_keyframes else []
    keypoints = ["keypoints"] if session.view.keypoint_corrections else []
    other_causes = _either([*part_keyframes, "settings", *keypoints, *camera])
    return reasons or ([f"{other_causes} have changed"] if keyed else [])


def _may_move(session: Session) -> bool:
    """Whether the film's camera does not stand still, as far as anybody has looked."""
    view = session.view
    return view.camera_motion is not None or view.video.stands_still is False


def _either(names: Sequence[str]) -> str:
    """ "settings", "settings or keypoints", "part keyframes, settings or keypoints"."""
    *most, last = names
    return f"{', '.join(most)} or {last}" if most else last


def _is_outdated(session: Session, results: Results) -> bool:
    """Whether a segment's key is another one now."""
    keys = present_keys(session)
    return any(keys.get((s.first_frame, s.last_frame)) != s.key for s in results.segments)


def _other_space(session: Session, results: Results) -> bool:
    """Whether the motion would be solved for in space in another way, now or at all."""
    rows = _rows(session)
    settings = results.settings_used(session.settings)
    as_tracked = session.changed({"settings": settings})
    wanted = stretch_keys(as_tracked, rows, _rows_beside(as_tracked))
    return wanted != {stretch.key for stretch in results.space}


def _rows_beside(session: Session) -> dict[str, list[Usable]]:
    """The segments, as they are now, of the bodies that bonds join to the posed one, by id."""
    rows = {}
    for body_id in session.bonded:
        about = session.about(body_id)
        keys = present_keys(about)
        rows[body_id] = [row for row in _rows(about) if keys.get((row.first, row.last)) == row.key]
    return rows


def _rows(session: Session) -> list[Usable]:
    """The segments that were tracked whole and in full."""
    results = session.subject.results
    if results is None:
        return []
    return [
        Usable(s.first_frame, s.last_frame, s.key or "", s.quality or results.quality)
        for s in results.segments
        if not s.missing and (s.quality or results.quality) != "preview"
    ]


def _reaches(motion: Trajectory | Tracks, frame: int) -> bool:
    i = frame - motion.first_frame
    return 0 <= i < len(motion.ps_camera_root) and bool(np.isfinite(motion.ps_camera_root[i]).all())


def _listed(frames: Sequence[int]) -> str:
    numbers = ", ".join(str(frame) for frame in frames)
    return f"frame{'s' if len(frames) > 1 else ''} {numbers}"


def _keyframes_inside(session: Session) -> set[int]:
    """Keyframes set inside a tracked segment, even where the motion happens to go through them."""
    segments = session.subject.results.segments if session.subject.results else ()
    return {
        keyframe.frame
        for keyframe in session.subject.keyframes
        if any(s.first_frame < keyframe.frame < s.last_frame for s in segments)
    }


def _tracked_open(session: Session) -> set[int]:
    """Frames at which the session's motion ends without a keyframe."""
    segments = session.subject.results.segments if session.subject.results else ()
    return {frame for segment in segments for frame in segment.open_ends}
