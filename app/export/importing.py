"""Files from elsewhere brought to a session as somebody chose.

What the command line and the page share. A file holds a recorded motion, 2D keypoints, or a camera;
`recognising` says which, and `import_file` makes of it what a session takes over.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from keypose.app.editor.documents import with_drafts
from keypose.app.export.import_camera import brought, film_or_none, reading_of
from keypose.app.export.import_keypoints import Draft, drafts_of, match_keypoints
from keypose.app.export.import_motion import ImportedMotion, Placed, fit_to_session, pose_draft
from keypose.app.orders.imports import EVERY, ImportKeypoints, ImportMotion, ImportOrder
from keypose.tracker.errors import FormatError
from keypose.tracker.formats.joint_motion import JointMotion
from keypose.tracker.formats.joint_names import Matched, load_names
from keypose.tracker.formats.keypoint_files import read_people
from keypose.tracker.formats.people import People
from keypose.tracker.formats.reading import load_motion
from keypose.tracker.formats.reading_camera import CameraFile, load_camera
from keypose.tracker.formats.reading_keypoints import VideoFacts, keypoints_of, on_video
from keypose.tracker.formats.text import Note
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.session import Session
from keypose.tracker.storage.files import open_for_work
from keypose.tracker.video.info import VideoInfo

Progress: TypeAlias = Callable[[int, int], None]


@dataclass(frozen=True, eq=False)
class MotionImport:
    """A motion fitted to the body. names: of all joints in the file."""

    found: ImportedMotion
    names: tuple[str, ...]

    @property
    def matched(self) -> dict[str, str]:
        """Our joints by the file's names."""
        return {self.names[i]: ours for i, ours, _ in self.found.matched.known}


@dataclass(frozen=True, eq=False)
class DraftImport:
    """Drafts made from keypoints, or from a motion of one frame.

    names: of all keypoints or joints in the file.  frames: that were asked for.
    notes: what was odd about the file, or may be wrong.
    """

    drafts: tuple[Draft, ...]
    known: Matched
    names: tuple[str, ...]
    frames: tuple[int, ...]
    notes: tuple[Note, ...] = ()

    def added_to(self, session: Session) -> Session:
        """The session with these drafts beside those it has."""
        added = (draft.keyframe for draft in self.drafts)
        return with_drafts(session, (*session.subject.drafts, *added))


Import: TypeAlias = MotionImport | DraftImport | CameraFile
"""What a session takes over."""


def import_file(
    session: Session,
    path: Path,
    order: ImportOrder,
    video: VideoInfo,
    progress: Progress | None = None,
) -> Import:
    """What the file holds, brought to the session; FormatError in one sentence where it does
    not suit it. progress: receives how many frames of how many are done.
    """
    if isinstance(order, ImportMotion):
        motion = as_chosen(path.name, load_motion(path), order)
        times_s = session.evidence.times_s(video.times_s)
        return import_motion(session, motion, path.name, order, times_s, progress)
    if isinstance(order, ImportKeypoints):
        people = read_people(path, order.individual)
        return import_keypoints(session, people, path.name, order, video, progress)
    size = (session.view.camera.width, session.view.camera.height)
    camera_file = load_camera(path, size, reading_of(order))
    with film_or_none(lambda: open_for_work(session, video.path, video.path.parent)) as film:
        return brought(session, camera_file, path.name, order, film)


# --- motion


def as_chosen(file: str, motion: JointMotion, order: ImportMotion) -> JointMotion:
    """The motion of a file, as it is chosen to be read."""
    motion = motion.of_individual(file, order.individual)
    if order.fps is not None:
        motion = motion.at_rate(float(order.fps))
    if order.world is not None:
        motion = replace(motion, world=order.world, rest_m=None)
    if order.unit == "auto":
        return replace(motion, unit=None)
    return motion if order.unit is None else motion.in_unit(order.unit)


def import_motion(
    session: Session,
    motion: JointMotion,
    file: str,
    order: ImportMotion,
    times_s: Array,
    progress: Progress | None = None,
    beside: Placed | None = None,
) -> MotionImport | DraftImport:
    """Fit a motion to the session's body at the video's frames; one of one frame is a draft.

    beside: as of `fit_to_session`.
    """
    offset_s = _offset_s(order, times_s)
    names = None if order.names is None else load_names(order.names)
    imported_motion = fit_to_session(
        session, motion, file, times_s, offset_s, names, dict(order.places), progress, beside
    )
    if len(imported_motion.fit.trajectory) > 1:
        return MotionImport(imported_motion, motion.names)
    draft = pose_draft(session, imported_motion, file, times_s)
    return DraftImport(
        (draft,),
        imported_motion.matched,
        motion.names,
        (draft.keyframe.frame,),
        imported_motion.notes,
    )


def _offset_s(order: ImportMotion, times_s: Array) -> float | None:
    """The video's time at which the file's time 0 lies; beyond the video at its mean rate; None
    where that is left open."""
    if order.offset_frames is None:
        return order.offset_s
    frame, last = order.offset_frames, len(times_s) - 1
    if 0 <= frame <= last:
        return float(times_s[frame])
    return float(frame * (times_s[-1] - times_s[0]) / max(last, 1))


# --- keypoints


def import_keypoints(
    session: Session,
    people: People,
    file: str,
    order: ImportKeypoints,
    video: VideoInfo,
    progress: Progress | None = None,
) -> DraftImport:
    """Draft poses from the keypoints in a file, at the frames that are asked for."""
    facts = video_facts(session, video)
    people, notes = on_video(file, people, facts, order.offset_frames or 0)
    keypoints = keypoints_of(file, people, order.layout, facts)
    if order.exchange:
        keypoints = keypoints.exchanged()
    matched = match_keypoints(session, keypoints, file, dict(order.places))
    frames = _wanted_frames(session, keypoints, order)
    times_s = session.evidence.times_s(video.times_s)
    drafts = drafts_of(session, keypoints, matched, frames, times_s, progress)
    return DraftImport(drafts, matched, keypoints.names, tuple(frames), notes)


def video_facts(session: Session, info: VideoInfo) -> VideoFacts:
    """What keypoints are checked against; images have no rate of their own."""
    video = session.view.video
    has_rate = info.container != "images" and not info.variable_rate
    return VideoFacts(video.frame_count, video.width, video.height, info.fps if has_rate else None)


def _wanted_frames(session: Session, keypoints: Keypoints, order: ImportKeypoints) -> list[int]:
    count = session.view.video.frame_count
    if order.frames is not None:
        beyond = [frame for frame in order.frames if frame >= count]
        if beyond:
            raise FormatError(
                f"There is no frame {beyond[0]}; the video's frames are 0 to {count - 1}."
            )
        return sorted(set(order.frames))
    frames: list[int] = []
    for n in np.flatnonzero(keypoints.visibility.any(axis=1)).tolist():
        if not frames or keypoints.first_frame + n - frames[-1] >= (order.every or EVERY):
            frames.append(keypoints.first_frame + n)
    return frames


# --- names


def names_of(matched: Matched, names: Sequence[str]) -> dict[str, Any]:
    """Which of a file's names are known."""
    return {
        "convention": matched.convention,
        "matched": {names[i]: ours for i, ours, _ in matched.known},
        "left_out": list(matched.left_out),
    }
