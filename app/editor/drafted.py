"""Drafts of a whole clip: what may be drafted, and a finished draft taken over as one step."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import groupby
from typing import TYPE_CHECKING

from app.editor.ahead import without_followed
from app.editor.documents import keyframe_of, require_sound, with_drafts
from app.editor.refusal import Refused
from app.editor.state import EditorState
from tracker.body.body import PEOPLE, PRESETS, Body, preset
from tracker.body.clavicles import without_clavicles
from tracker.body.pose import Pose
from tracker.body.skeleton import Skeleton
from tracker.errors import listed
from tracker.geometry.rotations import Array
from tracker.keypoints.keypoints import JOINTS
from tracker.keypoints.on_body import points_on_body
from tracker.keypoints.region import Box, Region
from tracker.session import drafted as record
from tracker.session.schema import MOST, KeypointFile, Session

if TYPE_CHECKING:
    from tracker.fitting.draft import Proposal

LABEL = "draft"
"""What undo calls it."""
KEYPOINT_SOURCE = "BlazePose"


def require_draftable(doc: Session, frame: int, box: Box, frames: tuple[int, int]) -> None:
    """Refused, or KeypointError, in one sentence where a draft of these frames, first and last,
    from a box on one of them cannot be had."""
    count = doc.video.frame_count
    if doc.surface is not None:
        raise Refused("Drafts are made from a video, not from surfaces.")
    if len(points_on_body(doc.body, JOINTS).indices) < len(JOINTS):
        raise Refused(f"Drafts need a person's body: choose {listed(PEOPLE)} first.")
    first, last = frames
    if not 0 <= first <= last < count:
        raise Refused(f"The frames to draft must lie within those of the video, 0 to {count - 1}.")
    if not first <= frame <= last:
        raise Refused(f"The frame of the box must be one of those to draft, {first} to {last}.")
    if last - first + 1 > MOST["drafts"]:
        raise Refused(
            f"A session holds at most {MOST['drafts']} drafts: draft fewer frames at a time."
        )
    Region.of_box(box, doc.video.width, doc.video.height)


def keeps_proportions(doc: Session) -> bool:
    """Whether somebody has sized the body: keyframes are posed with it, or it is no preset's."""
    return bool(doc.keyframes) or without_clavicles(doc.body) not in map(preset, PRESETS)


def drafted_session(
    doc: Session,
    frames: tuple[int, int],
    body: Body,
    poses: Mapping[int, Pose],
    keypoints: KeypointFile | None,
    proposals: Sequence[Proposal],
    times_s: Array,
) -> Session:
    """With these drafts in place of those there were from the first to the last of the frames, and
    what was found besides: where nobody was, and which to confirm.

    Keyframes stay, and so do imported keypoints; what was tracked ahead does not.
    """
    doc = without_followed(doc)
    skeleton, keyed = Skeleton.of(body), {keyframe.frame for keyframe in doc.keyframes}
    drafts = [draft for draft in doc.drafts if not frames[0] <= draft.frame <= frames[1]]
    drafts += [
        keyframe_of(skeleton, pose, frame, times_s).model_copy(update={"drafted": True})
        for frame, pose in poses.items()
        if frame not in keyed
    ]
    update: dict[str, object] = {"body": body, "drafted": _record(doc, frames, poses, proposals)}
    update |= {} if doc.given_keypoints else {"keypoints": keypoints}
    return with_drafts(doc.model_copy(update=update), drafts)


def missing_frames(drafted: record.Drafted) -> list[int]:
    """The frames where nobody was found, ascending."""
    runs = drafted.missing
    return [frame for run in runs for frame in range(run.first_frame, run.last_frame + 1)]


def _record(
    doc: Session, frames: tuple[int, int], poses: Mapping[int, Pose], proposals: Sequence[Proposal]
) -> record.Drafted:
    """What was found in these frames, and before in others."""
    first, last = frames
    missing = set(range(first, last + 1)) - set(poses)
    places = [record.DraftPlace(frame=p.frame, reason=p.reason, parts=p.parts) for p in proposals]
    if doc.drafted is not None:
        missing |= {f for f in missing_frames(doc.drafted) if not first <= f <= last}
        places += [p for p in doc.drafted.places if not first <= p.frame <= last]
    return record.Drafted(
        first_frame=first,
        last_frame=last,
        missing=tuple(frame_runs(missing)),
        places=tuple(sorted(places, key=lambda place: place.frame)),
    )


def frame_runs(frames: Iterable[int]) -> Iterator[record.FrameRun]:
    """Frames as runs of consecutive ones."""
    for _, run in groupby(enumerate(sorted(frames)), key=lambda each: each[1] - each[0]):
        inside = [frame for _, frame in run]
        yield record.FrameRun(first_frame=inside[0], last_frame=inside[-1])


def with_clip_drafted(
    state: EditorState,
    frames: tuple[int, int],
    body: Body,
    poses: Mapping[int, Pose],
    keypoints: KeypointFile | None,
    proposals: Sequence[Proposal] = (),
) -> EditorState:
    """With the drafts of a clip, as one step; see `drafted_session`."""
    given = (frames, body, poses, keypoints, proposals)
    doc = drafted_session(state.doc, *given, state.times_s)
    require_sound(state.doc, doc, LABEL)
    history = state.history.after(state.doc, LABEL, state.frame)
    return replace(state.with_doc(doc), history=history)
