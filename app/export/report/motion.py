"""The motion that a report is about, as the writers of files have it."""

from __future__ import annotations

import numpy as np

from keypose.app.export.report.subject import Subject
from keypose.tracker.errors import FormatError
from keypose.tracker.formats.recording import RecordedSegment, Recording
from keypose.tracker.storage.tracks import Tracks


def recording_of(subject: Subject) -> Recording | None:
    """None where no segment is tracked; FormatError where nobody knows when frames are shown."""
    found = [track for track in subject.fitting.values() if track.finished]
    if not found:
        return None
    times_s = np.array([subject.time_s(i) for i in range(subject.session.video.frame_count)])
    if not np.isfinite(times_s).all():
        raise FormatError("Without the video, two keyframes are needed to know how fast it moves.")
    segments = [
        RecordedSegment(track.first, track.last, track.verdict)
        for track in found
        if track.verdict is not None
    ]
    return Recording.of(subject.session, Tracks.of(found, subject.skeleton), segments, times_s)
