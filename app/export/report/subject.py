"""What a report is about: a session, what tracking found for it, and its motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from keypose.app.render.poses import KnownPoses
from keypose.app.words.problems import sentence
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import FormatError, SessionError
from keypose.tracker.films.errors import FilmErrors
from keypose.tracker.formats.recording import RecordedSegment, Recording
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.operations.seen_by import errors_in_films
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.outdated import outdated_words
from keypose.tracker.storage.results import Results, Span, State, load_results
from keypose.tracker.storage.tracks import Tracks
from keypose.tracker.tracking.result import SegmentResult
from keypose.tracker.video import VideoInfo

STATE_WORDS: Mapping[State, str] = {
    "good": "Good",
    "check": "Check",
    "lost": "Lost",
    "outdated": "Outdated",
    "none": "Not tracked",
}


@dataclass(frozen=True, eq=False)
class Subject:
    """states has every segment; fitting those with a motion that is theirs.

    video:   the facts of the video, None where it is not at hand.
    problem: a sentence where the motion is absent in part or does not fit; None where all is well.
    """

    session: Session
    session_path: Path
    poses: KnownPoses
    states: Mapping[Span, State]
    fitting: Mapping[Span, SegmentResult]
    video: VideoInfo | None
    problem: str | None

    @property
    def skeleton(self) -> Skeleton:
        return self.poses.skeleton

    @property
    def name(self) -> str:
        """What a person calls it, else the folder's name, as in the page, or the video's."""
        if self.session.title:
            return self.session.title
        folder = self.session_path.absolute().parent.name
        return folder.removesuffix(".keypose") or Path(self.session.view.video.path).stem

    @property
    def keys(self) -> tuple[int, ...]:
        """The keyframes' frames, ascending."""
        return tuple(keyframe.frame for keyframe in self.session.subject.keyframes)

    @property
    def spans(self) -> tuple[Span, ...]:
        """The segments: between neighbouring keyframes, of surfaces also on their outer sides."""
        return self.session.spans

    @property
    def ends(self) -> Span:
        """The first frame of the first segment and the last of the last; there must be one."""
        return self.spans[0][0], self.spans[-1][1]

    @property
    def dof_count(self) -> int:
        """Degrees of freedom that were estimated."""
        return self.session.evidence.dof_count(self.skeleton)

    @property
    def mean_interval(self) -> float:
        """Frames between neighbouring keyframes, on average; NaN with fewer than two."""
        keys = self.keys
        return (keys[-1] - keys[0]) / (len(keys) - 1) if len(keys) > 1 else np.nan

    def after(self, frame: int) -> Span | None:
        """The segment that begins at a frame."""
        return next((span for span in self.spans if span[0] == frame), None)

    def words(self, span: Span) -> str:
        """The verdict on a segment for a person, or what keeps it from having one."""
        track = self.fitting.get(span)
        if track is None or track.verdict is None:
            return STATE_WORDS[self.states[span]]
        return sentence(track.verdict, *span)

    def time_s(self, frame: int) -> float:
        """When a frame is shown, seconds; by the keyframes' times where the video is not at
        hand, NaN where these do not say.
        """
        if self.video is None and self.session.evidence.fps is None:
            return _time_by_keyframes(self.session, frame)
        return float(self.times_s[frame])

    @cached_property
    def times_s(self) -> Array:
        """(frames,) seconds in the world; TypeError where neither session nor video has them."""
        of_file = None if self.video is None else self.video.times_s
        return self.session.evidence.times_s(of_file)


def subject_of(
    session: Session, session_path: Path, video: VideoInfo | None = None, *, alone: bool = False
) -> Subject:
    """All that is known of a session; it need not be tracked, and its tracks may be damaged.

    alone: without the other bodies in its pictures."""
    present = _as_tracked(session)
    try:
        poses = KnownPoses.of(session, session_path, alone=alone)
        results = load_results(present, session_path)
        problem = None if poses.tracks is None else outdated_words(session, poses.tracks)
    except SessionError as error:
        bare = session.changed({"results": None})
        poses, results, problem = KnownPoses.of(bare, session_path), Results(), str(error)
    return Subject(
        session,
        session_path,
        poses,
        results.states(present),
        results.fitting(present),
        video,
        problem,
    )


def _as_tracked(session: Session) -> Session:
    """Take the method it was tracked by: what another one would find is not asked here."""
    if session.subject.results is None:
        return session
    settings = session.subject.results.settings_used(session.settings)
    return session.changed({"settings": settings})


def _time_by_keyframes(session: Session, frame: int) -> float:
    """Between two keyframes by theirs; beyond them at the mean rate."""
    frames = [keyframe.frame for keyframe in session.subject.keyframes]
    times_s = [keyframe.time_s for keyframe in session.subject.keyframes]
    if len(frames) < 2:
        return times_s[0] if frames == [frame] else np.nan
    pace = (times_s[-1] - times_s[0]) / (frames[-1] - frames[0])
    beyond = min(frame - frames[0], 0) + max(frame - frames[-1], 0)
    return float(np.interp(frame, frames, times_s)) + pace * beyond


def errors_of_films(subject: Subject) -> tuple[FilmErrors, ...]:
    """How far joints lie from where each of several films shows them; nothing of one film."""
    segment_results = [track for track in subject.fitting.values() if track.finished]
    if not segment_results:
        return ()
    tracks = Tracks.of(segment_results, subject.skeleton)
    return errors_in_films(subject.session, tracks, subject.session_path.absolute().parent)


def recording_of(subject: Subject) -> Recording | None:
    """None where no segment is tracked; FormatError where nobody knows when frames are shown."""
    segment_results = [track for track in subject.fitting.values() if track.finished]
    if not segment_results:
        return None
    times_s = np.array([subject.time_s(i) for i in range(subject.session.view.video.frame_count)])
    if not np.isfinite(times_s).all():
        raise FormatError("Without the video, two keyframes are needed to know how fast it moves.")
    segments = [
        RecordedSegment(track.first, track.last, track.verdict)
        for track in segment_results
        if track.verdict is not None
    ]
    return Recording.of(
        subject.session, Tracks.of(segment_results, subject.skeleton), segments, times_s
    )
