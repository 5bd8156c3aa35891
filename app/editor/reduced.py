"""Keyframe reduction of a document: the motion it has, and the document with the keyframes alone.

The motion is reduced where it is known: as it was tracked, drafted or imported. Keyframes that a
person posed stay, and so do the limbs they keyed. What lay between the new keyframes is kept beside
the session: tracking starts from it, so that what was found in the film is not lost.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal, TypeAlias

import numpy as np

from keypose.app.editor.documents import (
    ActionRefused,
    keyframe_of,
    with_drafts,
    with_keyframes,
    with_part_keyframes,
)
from keypose.app.editor.outdated import up_to_date
from keypose.app.editor.part_keyframes import limbs_of
from keypose.app.editor.state import EditorState
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory, displaced
from keypose.tracker.errors import ReductionError
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.reduction.result import require_range
from keypose.tracker.session.counts import MOST
from keypose.tracker.session.keyframe import Keyframe, PartKeyframe
from keypose.tracker.session.references import FirstMotion
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.results import Fitting

Source: TypeAlias = Literal["tracked", "drafts", "imported"]
Range: TypeAlias = tuple[int, int]

LABEL = "reduce to keyframes"
"""What undo calls it."""
SOURCES: tuple[Source, ...] = ("tracked", "drafts", "imported")
"""The one that is reduced first, where it is there."""
_NONE = {
    "tracked": "Nothing is tracked as the keyframes are posed now: track first.",
    "drafts": "There are no drafts at two frames: draft the film first.",
    "imported": "No motion has been imported: import one first.",
}


@dataclass(frozen=True, eq=False)
class Reducible:
    """The motion that is to be reduced.

    motion:   its poses, NaN at frames without one; at keyframes that stay it has theirs.
    source:   where it is from.
    required: the frames that have to be keyframes, ascending.
    parts:    indices of the parts that are to be keyed alone, None for the whole body.
    """

    motion: Trajectory
    source: Source
    required: tuple[int, ...]
    parts: frozenset[int] | None


def reducible(
    doc: Session,
    fitting: Fitting,
    imported: Trajectory | None,
    *,
    frames: Range | None = None,
    source: Source | None = None,
    limbs: Sequence[str] = (),
    replacing: bool = False,
) -> Reducible:
    """The motion of a document, or of a range of its frames; Refused where there is none.

    fitting: its tracked segments.  imported: the motion in the file of its `first_motion`, from
    elsewhere or from before an earlier reduction.
    source: which motion, the first of SOURCES that is there where None.
    limbs: names of parts whose limbs are to be keyed alone.
    replacing: whether keyframes that are there may go.
    """
    if doc.view.surface is not None:
        raise ActionRefused(
            "Only the motion of a video is reduced: surfaces are fitted frame by frame."
        )
    first, last = _require_range(doc, frames)
    parts = limbs_of(doc.subject.body, limbs) if limbs else ()
    if parts and not doc.spans:
        raise ActionRefused("A limb is keyed alone between two keyframes: add them first.")
    if parts:
        first, last = max(first, doc.spans[0][0]), min(last, doc.spans[-1][1])
        if first >= last:
            raise ActionRefused("A limb is keyed alone between two keyframes: choose frames there.")
    chosen, motion = _motion(doc, fitting, imported, source, first, last)
    stay = [k for k in doc.subject.keyframes if first <= k.frame <= last]
    motion = _known(_through(doc, motion, stay, always=not replacing or bool(parts)))
    required = [] if replacing and not parts else [keyframe.frame for keyframe in stay]
    required += [k.frame for k in doc.subject.part_keyframes if parts and first <= k.frame <= last]
    indices = frozenset(map(doc.subject.body.index, parts)) if parts else None
    return Reducible(motion, chosen, tuple(sorted(required)), indices)


def reduced_session(
    doc: Session,
    reducible_motion: Reducible,
    frames: Sequence[int],
    times_s: Array,
    first_motion: FirstMotion | None,
    *,
    replacing: bool = False,
) -> Session:
    """The document with keyframes at these frames of the motion that was reduced.

    first_motion: the motion as `save_own_motion` wrote it; None leaves what there is.
    """
    if reducible_motion.parts is not None:
        return _with_limbs_keyed(doc, reducible_motion, frames, times_s)
    first, last = reducible_motion.motion.first_frame, reducible_motion.motion.last_frame
    skeleton = Skeleton.of(doc.subject.body)
    kept = [k for k in doc.subject.keyframes if not (replacing and first <= k.frame <= last)]
    keyed = {keyframe.frame for keyframe in kept}
    made = [
        keyframe_of(skeleton, reducible_motion.motion.pose(frame), frame, times_s)
        for frame in frames
        if frame not in keyed
    ]
    _require_few("keyframes", len(kept) + len(made))
    drafts = [d for d in doc.subject.drafts if not (d.is_found and first <= d.frame <= last)]
    doc = with_drafts(with_keyframes(doc, [*kept, *made]), drafts)
    if first_motion is not None:
        doc = doc.changed({"first_motion": first_motion})
    return up_to_date(doc)


def with_reduction(
    state: EditorState,
    reducible_motion: Reducible,
    frames: Sequence[int],
    first_motion: FirstMotion | None,
    *,
    replacing: bool,
) -> EditorState:
    """Take over the reduced motion, as one step."""
    doc = reduced_session(
        state.doc, reducible_motion, frames, state.times_s, first_motion, replacing=replacing
    )
    return state.with_step(doc, LABEL)


# --- the motion


def _require_range(doc: Session, frames: Range | None) -> Range:
    last = doc.view.video.frame_count - 1
    if frames is None:
        return 0, last
    if not 0 <= frames[0] < frames[1] <= last:
        raise ActionRefused(
            f"The video has frames 0 to {last}: choose two of them, the first before the last."
        )
    return frames


def _motion(
    doc: Session,
    fitting: Fitting,
    imported: Trajectory | None,
    source: Source | None,
    first: int,
    last: int,
) -> tuple[Source, Trajectory]:
    """The motion between two frames, from a source that has poses at two of them at least."""
    makers = {
        "tracked": lambda: [
            segment_result.trajectory
            for segment_result in fitting.values()
            if segment_result.finished
        ],
        "drafts": lambda: _posed(doc, doc.subject.drafts),
        "imported": lambda: [] if imported is None else _on_keyframes(doc, imported),
    }
    for name in SOURCES if source is None else (source,):
        motion = _gathered(doc, makers[name](), first, last)
        if np.isfinite(motion.ps_camera_root[:, 0]).sum() > 1:
            return name, motion
    if source is None:
        where = "" if (first, last) == (0, doc.view.video.frame_count - 1) else " in these frames"
        raise ActionRefused(
            f"There is no motion to reduce{where}: track, draft or import one first."
        )
    raise ActionRefused(_NONE[source])


def _gathered(doc: Session, motions: Iterable[Trajectory], first: int, last: int) -> Trajectory:
    """Poses of these frames as one motion, NaN where none has any."""
    count = last - first + 1
    Rs, ps = (
        np.full((count, len(doc.subject.body.parts), 3, 3), np.nan),
        np.full((count, 3), np.nan),
    )
    for motion in motions:
        a, b = max(first, motion.first_frame), min(last, motion.last_frame) + 1
        if a < b:
            rows, part = slice(a - first, b - first), require_range(motion, a, b - 1)
            Rs[rows], ps[rows] = part.Rs_parent_part, part.ps_camera_root
    return Trajectory(first, Rs, ps)


def _posed(doc: Session, keyframes: Iterable[Keyframe]) -> list[Trajectory]:
    """Poses as motions of one frame."""
    skeleton = Skeleton.of(doc.subject.body)
    poses = [(keyframe.frame, keyframe.pose(skeleton)) for keyframe in keyframes]
    return [Trajectory(n, p.Rs_parent_part[None], p.p_camera_root[None]) for n, p in poses]


def _on_keyframes(doc: Session, imported: Trajectory) -> list[Trajectory]:
    """An imported motion made to meet the keyframes between each two of them."""
    skeleton, motions = Skeleton.of(doc.subject.body), [imported]
    for a, b in pairwise(doc.subject.keyframes):
        ends = imported.first_frame <= a.frame and b.frame <= imported.last_frame
        if ends and all(_has_pose(imported, each.frame) for each in (a, b)):
            motions.append(
                displaced(imported, a.pose(skeleton), b.pose(skeleton), a.frame, b.frame)
            )
    return motions


def _has_pose(motion: Trajectory, frame: int) -> bool:
    return bool(np.isfinite(motion.ps_camera_root[frame - motion.first_frame]).all())


def _through(
    doc: Session, motion: Trajectory, keyframes: Iterable[Keyframe], *, always: bool
) -> Trajectory:
    """The motion with the poses of keyframes at their frames: of all, or where it has none."""
    Rs, ps = motion.writable()
    skeleton = Skeleton.of(doc.subject.body)
    for keyframe in keyframes:
        row = keyframe.frame - motion.first_frame
        if always or not np.isfinite(ps[row]).all():
            pose = keyframe.pose(skeleton)
            Rs[row], ps[row] = pose.Rs_parent_part, pose.p_camera_root
    return Trajectory(motion.first_frame, Rs, ps)


def _known(motion: Trajectory) -> Trajectory:
    """Cut from the first frame with a pose to the last one."""
    posed_frames = motion.first_frame + np.flatnonzero(np.isfinite(motion.ps_camera_root[:, 0]))
    return require_range(motion, int(posed_frames[0]), int(posed_frames[-1]))


# --- limbs alone


def _with_limbs_keyed(
    doc: Session, reducible_motion: Reducible, frames: Sequence[int], times_s: Array
) -> Session:
    """Set part keyframes at these frames, but for those that are keyframes."""
    skeleton = Skeleton.of(doc.subject.body)
    keyed = {keyframe.frame for keyframe in doc.subject.keyframes}
    part_keyframes = {each.frame: each for each in doc.subject.part_keyframes}
    limbs = {doc.subject.body.names[i] for i in reducible_motion.parts or ()}
    for frame in frames:
        if frame in keyed:
            continue
        if frame in part_keyframes:
            parts = limbs | set(part_keyframes[frame].parts)
            base: Keyframe = part_keyframes[frame]
        else:
            parts, base = (
                limbs,
                keyframe_of(skeleton, reducible_motion.motion.pose(frame), frame, times_s),
            )
        ordered = tuple(name for name in doc.subject.body.names if name in parts)
        part_keyframes[frame] = PartKeyframe(**{**base.model_dump(), "parts": ordered})
    _require_few("part_keyframes", len(part_keyframes))
    return with_part_keyframes(doc, part_keyframes.values())


def _require_few(kind: str, count: int) -> None:
    if count > MOST[kind]:
        raise ReductionError(
            f"That would be {count} keyframes, and a session holds at most {MOST[kind]}: allow a "
            "larger tolerance, or reduce fewer frames at a time."
        )
