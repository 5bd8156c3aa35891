"""All keyframes of a session on one picture: of the command line and the page."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import cv2
import numpy as np

from keypose.app.editor.part_edits import keyed_words
from keypose.app.export.report.subject import Subject, subject_of
from keypose.app.render.palette import Picture
from keypose.app.render.sheet import Cell, sheet, sheet_layout
from keypose.app.render.snapshots import Look, png, rectified, snapshot
from keypose.tracker.errors import SessionError
from keypose.tracker.session.schema import Session
from keypose.tracker.video import Video

MOST_KEYFRAMES = 2000


def sheet_png(
    session: Session,
    session_path: Path,
    video: Video,
    look: Look,
    columns: int | None = None,
    drawn: Callable[[int, int], None] = lambda done, of: None,
) -> tuple[bytes, str | None]:
    """The PNG file's bytes, and what a person should know of it, a sentence.

    columns: None as it fits.  drawn: receives how many of how many keyframes are drawn.
    """
    keyed, count = len(session.keyframes), len(session.keyframes) + len(session.part_keyframes)
    if not keyed or count > MOST_KEYFRAMES:
        words = f"more than {MOST_KEYFRAMES}" if keyed else "no"
        raise SessionError(f"{session_path.name} has {words} keyframes to draw.")
    fitting, size = sheet_layout(count, session.video.width / session.video.height)
    subject = subject_of(session, session_path, video.info)
    cells = _cells(subject, video, size, look, lambda done: drawn(done, count))
    return png(sheet(cells, columns or fitting, size)), subject.problem


def _cells(
    subject: Subject,
    video: Video,
    size: tuple[int, int],
    look: Look,
    drawn: Callable[[int], None],
) -> Iterator[Cell]:
    session = subject.session
    limbs = {k.frame: keyed_words(session.body, k.parts) for k in session.part_keyframes}
    for done, frame in enumerate(sorted({*subject.keys, *limbs}), start=1):
        after = None if frame in limbs else subject.after(frame)
        small: Picture | None = None
        pose = subject.poses.pose(frame)
        if pose is not None and rectified(session, video, frame) is not None:
            picture = snapshot(session, video, frame, pose, look)
            small = np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), np.uint8)
        interval, state = None, None
        if after is not None:
            interval, state = after[1] - after[0], subject.states[after]
        if frame in limbs:
            around = [span for span in subject.spans if span[0] < frame < span[1]]
            state = subject.states[around[0]] if around else None
        note = f"{limbs[frame]} only" if frame in limbs else ""
        yield Cell(small, frame, subject.time_s(frame), interval, state, note)
        drawn(done)
