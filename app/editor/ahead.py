"""Take over poses found by tracking ahead as one step, and say how far it came.

They are drafts beyond the last keyframe, or before the first, with a record of how far they reach
and why no farther. Both go together, with the edit that makes them outdated: another pose of the
keyframe they came from, another body or camera, or a keyframe beyond, which makes a segment there.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from keypose.app.editor.documents import ActionRefused, keyframe_of, with_drafts
from keypose.app.editor.outdated import without_records
from keypose.app.editor.state import EditorState
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.errors import readable
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.annotations import Ahead, Direction, Stop, StopCause
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.fingerprints import ahead_key

if TYPE_CHECKING:
    from keypose.tracker.tracking.ahead.follow import FoundAhead


@dataclass(frozen=True)
class _StopWords:
    """Why it ends at a frame, and why nothing leads on from its keyframe at all."""

    there: str
    at_once: str = "nothing leads on"


_STOPS: Final[Mapping[StopCause, _StopWords]] = {
    "uncertain": _StopWords("{Part} may be wrong from there", "{part} may be wrong right after it"),
    "not_seen": _StopWords(
        "{Part} may be wrong from there, {hidden}", "{part} may be wrong right after it, {hidden}"
    ),
    "left_picture": _StopWords(
        "The body leaves the picture there", "the body is hardly in the picture"
    ),
    "damaged": _StopWords(
        "The next frames are damaged in the video", "the next frame is damaged in the video"
    ),
    "cut": _StopWords("Another scene begins after it", "another scene begins after it"),
    "keyframe": _StopWords("The next keyframe follows"),
    "clip_end": _StopWords("The video {ends} there"),
    "limit": _StopWords("Set a keyframe there and track on"),
    "cancelled": _StopWords("Cancelled there", "it was cancelled"),
}


def why_stopped(record: Ahead) -> str:
    """What is not known of the frames beyond: "Right forearm may be wrong from there, hidden
    behind the chest".
    """
    return _STOPS[record.stop.cause].there.format(**_named(record.stop, record.is_forward))


def tracked_to(record: Ahead) -> str:
    """ "Tracked ahead to 47"."""
    return f"Tracked {'ahead' if record.is_forward else 'back'} to {record.to_frame}"


def found_sentence(found_ahead: FoundAhead) -> str:
    """What is said when it ends."""
    if found_ahead.to_frame == found_ahead.frame:
        why = _STOPS[found_ahead.stop.cause].at_once
        named = _named(found_ahead.stop, found_ahead.direction == "forward")
        nothing = f"Nothing tracked from {found_ahead.frame}: {why.format(**named)}."
        return f"{nothing} Pose the next keyframe by hand."
    record = Ahead(
        from_frame=found_ahead.frame, to_frame=found_ahead.to_frame, stop=found_ahead.stop
    )
    return f"{tracked_to(record)}. {why_stopped(record)}."


def _named(stop: Stop, forward: bool) -> dict[str, str]:
    part = readable(stop.part or "the body")
    hidden = f"hidden behind the {readable(stop.behind)}" if stop.behind else "out of the picture"
    capital = part[:1].upper() + part[1:]
    return {
        "part": part,
        "Part": capital,
        "hidden": hidden,
        "ends": "ends" if forward else "begins",
    }


LABEL = "track ahead"
"""What undo calls it."""


def start_frame(doc: Session, direction: Direction) -> int:
    """The keyframe to track ahead from, the last one or, backward, the first; Refused where that
    leads nowhere."""
    if doc.view.surface is not None:
        raise ActionRefused("Surfaces are fitted from one keyframe on: press Fit.")
    if not doc.subject.keyframes:
        raise ActionRefused("Pose a frame and add it as a keyframe first.")
    forward = direction == "forward"
    frame = doc.subject.keyframes[-1 if forward else 0].frame
    if frame == (doc.view.video.frame_count - 1 if forward else 0):
        end = "last frame" if forward else "first frame"
        raise ActionRefused(f"The keyframe at {frame} is the video's {end}: nothing lies beyond.")
    return frame


def followed_session(
    doc: Session,
    frame: int,
    motion: Trajectory,
    to_frame: int,
    stop: Stop | None,
    times_s: Array,
) -> Session:
    """Replace what was followed from the keyframe at a frame by these poses, with the record of
    them where it is known why they end.

    What a person posed stays, and so do keyframes. Drafts of the whole film do not.
    """
    skeleton = Skeleton.of(doc.subject.body)
    first, last = min(frame, to_frame), max(frame, to_frame)
    doc = without_records(
        doc, [record for record in doc.subject.ahead if _same_way(record, frame, to_frame)]
    )
    own = {k.frame for k in doc.subject.keyframes}
    if doc.subject.drafted is None:
        own |= {draft.frame for draft in doc.subject.drafts}
    fresh = [
        keyframe_of(skeleton, motion.pose(at), at, times_s).model_copy(update={"followed": True})
        for at in range(first, last + 1)
        if at not in own
    ]
    replaced = {draft.frame for draft in fresh}
    doc = with_drafts(doc, [*fresh, *(d for d in doc.subject.drafts if d.frame not in replaced)])
    keyframe = next(k for k in doc.subject.keyframes if k.frame == frame)
    if stop is None or to_frame == frame:
        return doc
    record = Ahead(from_frame=frame, to_frame=to_frame, stop=stop, key=ahead_key(doc, keyframe))
    ordered = sorted((*doc.subject.ahead, record), key=lambda ahead: ahead.from_frame)
    return doc.changed({"ahead": tuple(ordered)})


def followed_so_far(state: EditorState, frame: int, motion: Trajectory) -> Session:
    """The document with what was followed from a frame until now, to be shown."""
    to_frame = motion.last_frame if motion.first_frame == frame else motion.first_frame
    return followed_session(state.doc, frame, motion, to_frame, None, state.times_s)


def with_followed(state: EditorState, found_ahead: FoundAhead) -> EditorState:
    """Take over what was followed, as one step."""
    doc = followed_session(
        state.doc,
        found_ahead.frame,
        found_ahead.motion,
        found_ahead.to_frame,
        found_ahead.stop,
        state.times_s,
    )
    return state.with_step(doc, LABEL)


def _same_way(record: Ahead, frame: int, to_frame: int) -> bool:
    return record.from_frame == frame and record.is_forward == (to_frame >= frame)
