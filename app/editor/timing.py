"""When poses are: a keyframe knows its frame's time."""

from __future__ import annotations

from keypose.app.editor.documents import Posed
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.schema import Session


def with_times(doc: Session, times_s: Array) -> Session:
    """With each pose at its frame's time, which hand-written sessions may not know, and which
    another rate changes."""

    def timed(poses: tuple[Posed, ...]) -> tuple[Posed, ...]:
        retimed = [(pose, float(times_s[pose.frame])) for pose in poses]
        if all(pose.time_s == time_s for pose, time_s in retimed):
            return poses
        return tuple(pose.model_copy(update={"time_s": time_s}) for pose, time_s in retimed)

    poses = {name: timed(getattr(doc, name)) for name in ("keyframes", "part_keyframes", "drafts")}
    if all(now is getattr(doc, name) for name, now in poses.items()):
        return doc
    return doc.model_copy(update=poses)
