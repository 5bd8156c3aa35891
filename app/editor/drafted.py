"""Drafts of a whole clip: what may be drafted, and a finished draft taken over as one step."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from itertools import groupby
from typing import TYPE_CHECKING, Final

from keypose.app.editor.documents import (
    ActionRefused,
    keyframe_of,
    require_sound,
    softened,
    with_drafts,
    with_keyframes,
)
from keypose.app.editor.outdated import without_followed
from keypose.app.editor.state import EditorState
from keypose.tracker.body.body import Body, preset
from keypose.tracker.body.modify import unscaled, without_clavicles
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.preset_names import ANIMALS, PEOPLE, PRESETS
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import listed
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.keypoints import JOINTS
from keypose.tracker.keypoints.model_files import Model, animal_model, find_model
from keypose.tracker.keypoints.on_animal import is_animals
from keypose.tracker.keypoints.on_body import points_on_body
from keypose.tracker.keypoints.region import Box, Region
from keypose.tracker.session import annotations as record
from keypose.tracker.session.annotations import LEARN_FRAMES
from keypose.tracker.session.counts import MOST
from keypose.tracker.session.keyframe import Keyframe
from keypose.tracker.session.references import KeypointFile
from keypose.tracker.session.schema import Session
from keypose.tracker.session.settings import Position

if TYPE_CHECKING:
    from keypose.tracker.fitting.draft import Proposal

LABEL = "draft"
LIFTED = "draft anew"
"""What undo calls it."""
KEYPOINT_SOURCE = "BlazePose"


def drafting_model(doc: Session) -> Model:
    """The network that drafts the body that is posed; KeypointError where there is none."""
    chosen = doc.settings.network_used
    return animal_model(chosen) if is_animals(doc.subject.body) else find_model(chosen)


def keypoint_source(doc: Session) -> str:
    """What finds the keypoints of the body that is posed, as files name it."""
    return drafting_model(doc).name if is_animals(doc.subject.body) else KEYPOINT_SOURCE


def require_draftable(doc: Session, frame: int, box: Box, frames: tuple[int, int]) -> None:
    """Refused, or KeypointError, in one sentence where a draft of these frames, first and last,
    from a box on one of them cannot be had."""
    count = doc.view.video.frame_count
    if doc.view.surface is not None:
        raise ActionRefused("Drafts are made from a video, not from surfaces.")
    body = doc.subject.body
    if is_animals(body):
        animal_model(doc.settings.network_used)
    elif len(points_on_body(body, JOINTS).indices) < len(JOINTS):
        bodies = listed([*PEOPLE, *ANIMALS])
        raise ActionRefused(f"Drafts need a person's or an animal's body: choose {bodies} first.")
    first, last = frames
    if not 0 <= first <= last < count:
        raise ActionRefused(
            f"The frames to draft must lie within those of the video, 0 to {count - 1}."
        )
    if not first <= frame <= last:
        raise ActionRefused(
            f"The frame of the box must be one of those to draft, {first} to {last}."
        )
    if last - first + 1 > MOST["drafts"]:
        raise ActionRefused(
            f"A session holds at most {MOST['drafts']} drafts: draft fewer frames at a time."
        )
    Region.of_box(box, doc.view.video.width, doc.view.video.height)


def require_rest(doc: Session) -> record.DraftRest:
    """What a draft was cancelled before; refused where nothing is left."""
    rest = None if doc.subject.drafted is None else doc.subject.drafted.rest
    if rest is None:
        raise ActionRefused("No frames are left to draft.")
    return rest


def keeps_proportions(doc: Session) -> bool:
    """Whether somebody has sized the body: keyframes are posed with it, or it is no
    preset's. A height alone says nothing of its proportions."""
    body = without_clavicles(doc.subject.body)
    return bool(doc.subject.keyframes) or unscaled(body, map(preset, PRESETS)) is None


def drafted_session(
    doc: Session,
    frames: tuple[int, int],
    body: Body,
    poses: Mapping[int, Pose],
    keypoints: KeypointFile | None,
    proposals: Sequence[Proposal],
    times_s: Array,
    up_camera: Position | None,
    only: Collection[int] | None = None,
    rest: record.DraftRest | None = None,
    flipped: Sequence[record.FlippedDrafts] = (),
) -> Session:
    """Replace the drafts from the first to the last of the frames by these, and what was found
    besides: where nobody was, which to confirm, and which are wrong. up_camera: what was known
    to be up.

    Keyframes stay, and so do imported keypoints; what was tracked ahead does not.
    only: the frames to replace drafts of, all where left out.  rest: what is left to draft; what
    an earlier one was cancelled before where left out.
    """
    doc = without_followed(doc)
    skeleton, keyed = Skeleton.of(body), {keyframe.frame for keyframe in doc.subject.keyframes}
    taken = frozenset(range(frames[0], frames[1] + 1) if only is None else only)
    drafts = [draft for draft in doc.subject.drafts if draft.frame not in taken]
    drafts += [
        keyframe_of(skeleton, pose, frame, times_s).model_copy(update={"drafted": True})
        for frame, pose in poses.items()
        if frame in taken and frame not in keyed
    ]
    drafted = _record(doc, frames, taken, poses, proposals, rest, up_camera, flipped)
    update: dict[str, object] = {"body": body, "drafted": drafted}
    update |= {} if doc.view.given_keypoints else {"keypoints": keypoints}
    return with_drafts(doc.changed(update), drafts)


def accepted_draft(draft: Keyframe) -> Keyframe:
    """A draft as the keyframe it becomes: the very numbers it has, soft where nobody posed it."""
    return softened(draft, draft.is_found or draft.soft).model_copy(update={"followed": False})


def proposed_frames(doc: Session) -> tuple[int, ...]:
    """Frames of the drafts that were proposed to be confirmed and are drafts still, ascending, but
    those of which a limb is wrong."""
    places = () if doc.subject.drafted is None else doc.subject.drafted.places
    drafts = {draft.frame for draft in doc.subject.drafts}
    wrong = frames_of(flipped_drafts(doc))
    return tuple(sorted(({place.frame for place in places} & drafts).difference(wrong)))


def flipped_drafts(doc: Session) -> tuple[record.FlippedDrafts, ...]:
    """Runs of drafts that are known to be wrong and that nobody has posed since, by frame."""
    drafts = {draft.frame for draft in doc.subject.drafts if draft.drafted}
    runs = () if doc.subject.drafted is None else doc.subject.drafted.flipped
    left = _by_frame(runs, drafts)
    return tuple(sorted(_flipped_runs(left), key=lambda run: (run.first_frame, run.parts)))


def with_accepted(doc: Session, frames: Collection[int]) -> Session:
    """The session with its drafts of some frames as keyframes."""
    accepted = [accepted_draft(draft) for draft in doc.subject.drafts if draft.frame in frames]
    keyframes = [k for k in doc.subject.keyframes if k.frame not in frames]
    doc = with_keyframes(doc, [*keyframes, *accepted])
    return with_drafts(doc, [draft for draft in doc.subject.drafts if draft.frame not in frames])


SAME_UP_DEG: Final = 2.0
"""Standing turns what is up by about as much, and drafts are no better for it."""


def has_drafts_for_other_up(doc: Session) -> bool:
    """Whether drafts that nobody has posed were found for another up than the session has by
    now, and can be found anew from their keypoints."""
    drafted, up = doc.subject.drafted, doc.world.up_world
    if drafted is None or up is None:
        return False
    if drafted.up_camera is not None and _apart_deg(drafted.up_camera, up) < SAME_UP_DEG:
        return False
    return _has_found_keypoints(doc) and bool(to_lift(doc))


def _apart_deg(first: Position, second: Position) -> float:
    """The angle between two directions."""
    share = (
        sum(a * b for a, b in zip(first, second, strict=True))
        / math.hypot(*first)
        / math.hypot(*second)
    )
    return math.degrees(math.acos(max(-1.0, min(1.0, share))))


def to_lift(doc: Session) -> frozenset[int]:
    """Frames of drafts, and of keyframes made of them, that nobody has posed."""
    return frozenset(
        posed.frame for posed in (*doc.subject.drafts, *doc.subject.keyframes) if posed.drafted
    )


def with_lifted(state: EditorState, poses: Mapping[int, Pose]) -> EditorState:
    """Take over drafts found for another up, as one step: what nobody has posed."""
    doc = state.doc
    assert doc.subject.drafted is not None

    def lifted(posed: Keyframe) -> Keyframe:
        pose = poses.get(posed.frame)
        if pose is None or not posed.drafted:
            return posed
        fresh = keyframe_of(state.skeleton, pose, posed.frame, state.times_s)
        return fresh.model_copy(update={"drafted": True, "soft": posed.soft})

    drafted = doc.subject.drafted.model_copy(update={"up_camera": doc.world.up_world})
    doc = with_keyframes(doc, [lifted(keyframe) for keyframe in doc.subject.keyframes])
    doc = with_drafts(doc, [lifted(draft) for draft in doc.subject.drafts])
    return state.with_step(doc.changed({"drafted": drafted}), LIFTED)


def frames_of(runs: Iterable[record.FrameRun]) -> list[int]:
    """The frames of runs, ascending."""
    return [frame for run in runs for frame in range(run.first_frame, run.last_frame + 1)]


def missing_frames(drafted: record.Drafted) -> list[int]:
    """The frames where nobody was found, ascending."""
    return frames_of(drafted.missing)


def _record(
    doc: Session,
    frames: tuple[int, int],
    taken: Collection[int],
    poses: Mapping[int, Pose],
    proposals: Sequence[Proposal],
    rest: record.DraftRest | None,
    up_camera: Position | None,
    flipped: Sequence[record.FlippedDrafts],
) -> record.Drafted:
    """What was found in the frames taken over, and before in others: as long as there are
    drafts of these, what is up is as they had it."""
    first, last = frames
    if doc.subject.drafted is not None and any(frame not in taken for frame in to_lift(doc)):
        up_camera = doc.subject.drafted.up_camera
    missing = set(taken) - set(poses)
    places = [
        record.DraftPlace(frame=p.frame, reason=p.reason, parts=p.parts)
        for p in proposals
        if p.frame in taken
    ]
    wrong = _by_frame(flipped, taken)
    if doc.subject.drafted is not None:
        wrong |= _by_frame(doc.subject.drafted.flipped, _other_frames(doc.subject.drafted, taken))
        missing |= {f for f in missing_frames(doc.subject.drafted) if f not in taken}
        before = [p for p in doc.subject.drafted.places if p.frame not in taken]
        if doc.subject.drafted.rest is not None:  # one draft, in two goes
            drafts = {draft.frame for draft in doc.subject.drafts if draft.frame not in taken}
            places = _but_ends_beside(places, drafts)
            before = _but_ends_beside(before, {*poses} & {*taken})
        places += before
    return record.Drafted(
        first_frame=first,
        last_frame=last,
        up_camera=up_camera,
        missing=tuple(frame_runs(missing)),
        places=tuple(sorted(places, key=lambda place: place.frame)),
        flipped=tuple(_flipped_runs(wrong)),
        rest=rest or _left_before(doc, taken),
    )


_BEYOND: Final[Mapping[record.Reason, int]] = {"start": -1, "end": 1}
"""The frame beside an end of a draft, from that end."""


def _but_ends_beside(
    places: Iterable[record.DraftPlace], frames: Collection[int]
) -> list[record.DraftPlace]:
    """Places without ends from which a draft of these frames goes on."""
    return [
        place
        for place in places
        if place.reason not in _BEYOND or place.frame + _BEYOND[place.reason] not in frames
    ]


def _by_frame(
    runs: Iterable[record.FlippedDrafts], frames: Collection[int]
) -> dict[int, tuple[str, ...]]:
    """The parts that are wrong, by frame, of some frames."""
    return {frame: run.parts for run in runs for frame in frames_of([run]) if frame in frames}


def _other_frames(drafted: record.Drafted, taken: Collection[int]) -> Collection[int]:
    return {frame for frame in frames_of(drafted.flipped) if frame not in taken}


def _flipped_runs(wrong: Mapping[int, tuple[str, ...]]) -> Iterator[record.FlippedDrafts]:
    """Runs of consecutive frames of which the same parts are wrong."""
    for parts in sorted(set(wrong.values())):
        for run in frame_runs(frame for frame, own in wrong.items() if own == parts):
            yield record.FlippedDrafts(**run.model_dump(), parts=parts)


def _left_before(doc: Session, taken: Collection[int]) -> record.DraftRest | None:
    """What an earlier draft was cancelled before and this one has not taken over."""
    rest = None if doc.subject.drafted is None else doc.subject.drafted.rest
    left = [] if rest is None else [frame for frame in frames_of(rest.frames) if frame not in taken]
    return rest.model_copy(update={"frames": tuple(frame_runs(left))}) if rest and left else None


def frame_runs(frames: Iterable[int]) -> Iterator[record.FrameRun]:
    """Frames as runs of consecutive ones."""
    for _, run in groupby(enumerate(sorted(frames)), key=lambda each: each[1] - each[0]):
        inside = [frame for _, frame in run]
        yield record.FrameRun(first_frame=inside[0], last_frame=inside[-1])


def newly_posed(before: EditorState, after: EditorState) -> frozenset[int]:
    """Frames of the keyframes that an edit has posed, where drafts of the film can learn from them;
    none where it was undone or done again: drafts are then as they were. One that was found and not
    posed gives nothing: it is what the keypoints said."""
    was, doc = before.settled, after.settled
    history = (*before.history.past, *before.history.future)
    if was.subject.keyframes is doc.subject.keyframes or any(step.doc is doc for step in history):
        return frozenset()
    if doc.subject.body is not was.subject.body or not _can_learn(doc):
        return frozenset()
    poses_before = {k.frame: (k.root_m, k.rotations_wxyz) for k in was.subject.keyframes}
    return frozenset(
        k.frame
        for k in doc.subject.keyframes
        if poses_before.get(k.frame) != (k.root_m, k.rotations_wxyz) and not k.drafted
    )


def _can_learn(doc: Session) -> bool:
    """Whether there are drafts whose keypoints are known."""
    return _has_found_keypoints(doc) and any(draft.drafted for draft in doc.subject.drafts)


def _has_found_keypoints(doc: Session) -> bool:
    """Keypoints with depth, from which drafts are found anew: an animal's have none."""
    is_found = doc.view.keypoints is not None and doc.view.given_keypoints is None
    return is_found and not is_animals(doc.subject.body)


def near_frames(doc: Session, around: Collection[int]) -> Session:
    """Keep the poses alone that decide what drafts near some frames learn."""
    first, last = min(around) - LEARN_FRAMES - 1, max(around) + LEARN_FRAMES + 1
    near = {
        name: tuple(pose for pose in poses if first <= pose.frame <= last)
        for name, poses in (("drafts", doc.subject.drafts), ("keyframes", doc.subject.keyframes))
    }
    return doc.changed({**near, "part_keyframes": (), "results": None})


def with_learned(state: EditorState, used: Session, poses: Mapping[int, Pose]) -> EditorState:
    """Set drafts as they are with what keyframes gave, as part of the newest step: what undoes that
    step brings the drafts back.

    used: the document that they were found from. What has changed since stays as it is; all of it
    where a keyframe that gave it is gone.
    """
    doc, first, last = state.doc, min(poses, default=0), max(poses, default=-1)
    learned_from = [k for k in used.subject.keyframes if first - 1 <= k.frame <= last + 1]
    if doc.subject.body is not used.subject.body or not {id(k) for k in learned_from} <= {
        id(k) for k in doc.subject.keyframes
    }:
        return state
    own = {id(draft) for draft in used.subject.drafts}
    drafts = [
        keyframe_of(state.skeleton, poses[draft.frame], draft.frame, state.times_s).model_copy(
            update={"drafted": True}
        )
        if draft.frame in poses and draft.drafted and id(draft) in own
        else draft
        for draft in doc.subject.drafts
    ]
    after = with_drafts(doc, drafts)
    require_sound(doc, after, LABEL)
    return state.with_doc(after)
