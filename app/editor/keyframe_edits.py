"""Edit keyframes: add, remove, move, stretch, copy and paste, of the body and of parts."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping

from keypose.app.editor import actions as do
from keypose.app.editor.copied import Copied, pasted_poses
from keypose.app.editor.documents import (
    ActionRefused,
    as_soft_as,
    keyframe_of,
    posed,
    require_before_camera,
    with_drafts,
    with_keyframes,
    with_part_keyframes,
    without,
)
from keypose.app.editor.part_edits import require_correctable
from keypose.app.editor.shown import find, shown_pose
from keypose.app.editor.state import EditorState
from keypose.tracker.session.keyframe import Keyframe, PartKeyframe
from keypose.tracker.session.schema import Session

MOST_NAMED = 3
"""Frames that a sentence lists one by one."""


def delete_keyframes(state: EditorState, action: do.DeleteKeys) -> Session:
    """Without these keyframes."""
    gone = _require_keyframes(state, action.frames).keys()
    return with_keyframes(state.doc, [k for k in state.doc.keyframes if k.frame not in gone])


def retime_keyframes(state: EditorState, action: do.RetimeKeys) -> Session:
    """The same poses at other frames. Refused where another keyframe stands at one of them."""
    if action.frames == action.to:
        return state.doc
    taken = _require_keyframes(state, action.frames)
    stay = [k for k in state.doc.keyframes if action.copy_them or k.frame not in taken]
    require_free((*stay, *state.doc.part_keyframes), action.to)
    placed = [at_frame(state, taken[a], b) for a, b in zip(action.frames, action.to, strict=True)]
    doc = with_keyframes_placed(state.doc, stay, placed)
    if action.copy_them:
        return doc
    moved = dict(zip(action.frames, action.to, strict=True))
    fields = [doc.evidence.with_key_moved(frame, to) for frame, to in moved.items()]
    return doc.model_copy(update={name: value for one in fields for name, value in one.items()})


def with_keyframes_placed(
    doc: Session, stay: Iterable[Keyframe], placed: Collection[Keyframe]
) -> Session:
    """Set keyframes beside those that stay, in the place of what may be drafted there: that would
    hide them.
    """
    frames = {keyframe.frame for keyframe in placed}
    doc = with_keyframes(doc, (*stay, *placed))
    return with_drafts(doc, (draft for draft in doc.drafts if draft.frame not in frames))


def at_frame(state: EditorState, keyframe: Keyframe, frame: int) -> Keyframe:
    """The keyframe at another frame; refused outside the video."""
    if frame >= state.frame_count:
        raise ActionRefused(f"The video has frames 0 to {state.frame_count - 1}.")
    time_s = float(state.times_s[frame])
    return keyframe.model_copy(update={"frame": frame, "time_s": time_s})


def require_free(stay: Iterable[Keyframe], frames: Iterable[int]) -> None:
    """Refused, naming them, where keyframes, of the body or of limbs, stand at some of these
    frames."""
    known = {keyframe.frame for keyframe in stay}
    met = [frame for frame in frames if frame in known]
    if len(met) == 1:
        raise ActionRefused(f"Frame {met[0]} is already a keyframe. Delete it first.")
    if met:
        raise ActionRefused(f"Frames {_listed(met)} are already keyframes. Delete them first.")


def _listed(frames: list[int]) -> str:
    """ "12, 24 and 36", or "12, 24 and 7 more"."""
    if len(frames) > MOST_NAMED:
        shown, last = frames[: MOST_NAMED - 1], f"{len(frames) - MOST_NAMED + 1} more"
    else:
        shown, last = frames[:-1], str(frames[-1])
    return f"{', '.join(map(str, shown))} and {last}"


def _require_keyframes(state: EditorState, frames: Iterable[int]) -> Mapping[int, Keyframe]:
    known = {keyframe.frame: keyframe for keyframe in state.doc.keyframes}
    for frame in frames:
        if frame not in known:
            raise ActionRefused(f"Frame {frame} is not a keyframe.")
    return {frame: known[frame] for frame in frames}


# --- what undo calls them


def deleting(action: do.DeleteKeys) -> str:
    """ "delete 3 keyframes"."""
    return f"delete {_count(action.frames)}"


def retiming(action: do.RetimeKeys) -> str:
    """ "move", "stretch" or "copy 3 keyframes"."""
    verb = "copy" if action.copy_them else "move" if action.is_shift else "stretch"
    return f"{verb} {_count(action.frames)}"


def _count(frames: Collection[int]) -> str:
    return f"{len(frames)} keyframe{'' if len(frames) == 1 else 's'}"


def add_keyframe(state: EditorState, frame: int) -> Session:
    """Make the pose shown at a frame its keyframe, unless it is that already."""
    stands = shown_pose(state, frame)
    if stands.source == "keyframe":
        return state.doc
    pose = stands.pose
    require_before_camera(state.skeleton, pose)
    keyframe = keyframe_of(state.skeleton, pose, frame, state.times_s)
    keyframe = as_soft_as(find(state.doc.keyframes, frame), keyframe)
    doc = with_keyframes(state.doc, (*without(state.doc.keyframes, frame), keyframe))
    return with_drafts(doc, without(doc.drafts, frame))


def delete_keyframe(state: EditorState, frame: int) -> Session:
    """Without the keyframe at a frame, or its part keyframe."""
    return _without(state.doc, _require(state, frame))


def delete_draft(state: EditorState, frame: int) -> Session:
    """Without the draft at a frame."""
    if find(state.doc.drafts, frame) is None:
        raise ActionRefused(f"Frame {frame} has no draft.")
    return with_drafts(state.doc, without(state.doc.drafts, frame))


def move_keyframe(state: EditorState, action: do.MoveKey) -> Session:
    """The keyframe at another frame."""
    if action.to == action.frame:
        return state.doc
    keyframe = _require(state, action.frame)
    _require_free(state, keyframe, action.to)
    doc = _keyed(_without(state.doc, keyframe), at_frame(state, keyframe, action.to))
    if isinstance(keyframe, PartKeyframe):
        return doc
    return doc.model_copy(update=doc.evidence.with_key_moved(action.frame, action.to))


def duplicate_keyframe(state: EditorState, action: do.DuplicateKey) -> Session:
    """The same pose as a keyframe of another frame, too."""
    keyframe = _require(state, action.frame)
    _require_free(state, keyframe, action.to)
    return _keyed(state.doc, at_frame(state, keyframe, action.to))


def _keyed(doc: Session, keyframe: Keyframe) -> Session:
    """Set one more keyframe, in the place of what may be drafted there: that would hide it."""
    if isinstance(keyframe, PartKeyframe):
        doc = with_part_keyframes(doc, (*doc.part_keyframes, keyframe))
    else:
        doc = with_keyframes(doc, (*doc.keyframes, keyframe))
    return with_drafts(doc, without(doc.drafts, keyframe.frame))


def _without(doc: Session, keyframe: Keyframe) -> Session:
    if isinstance(keyframe, PartKeyframe):
        return with_part_keyframes(doc, without(doc.part_keyframes, keyframe.frame))
    return with_keyframes(doc, without(doc.keyframes, keyframe.frame))


def _require(state: EditorState, frame: int) -> Keyframe:
    found = find(state.doc.keyframes, frame) or find(state.doc.part_keyframes, frame)
    if found is None:
        raise ActionRefused(f"Frame {frame} is not a keyframe.")
    return found


def _require_free(state: EditorState, keyframe: Keyframe, frame: int) -> None:
    """Refused where a keyframe cannot come to a frame."""
    if find(state.doc.keyframes, frame) or find(state.doc.part_keyframes, frame):
        raise ActionRefused(f"Frame {frame} is already a keyframe. Delete it first.")
    if isinstance(keyframe, PartKeyframe):
        require_correctable(state, frame)


def copied_from(state: EditorState, frames: Collection[int]) -> Copied:
    """The keyframes at some frames; of none the pose shown at the present frame."""
    if not frames:
        return Copied.pose_of(state.skeleton, shown_pose(state).pose)
    found = [find(state.doc.keyframes, frame) for frame in sorted(set(frames))]
    keyframes = [keyframe for keyframe in found if keyframe is not None]
    if len(keyframes) < len(found):
        raise ActionRefused("One of these frames is not a keyframe any more.")
    return Copied.keys_of(state.skeleton, keyframes)


def with_copied(state: EditorState, action: do.PastePose) -> do.PastePose:
    """The action with what it pastes: what was copied in this session, unless it brings its own."""
    if action.copied is not None:
        return action
    if state.clipboard is None:
        raise ActionRefused("Copy a pose first (Ctrl C).")
    return action.model_copy(update={"copied": state.clipboard})


def paste(state: EditorState, action: do.PastePose) -> Session:
    """A copied pose here, or copied keyframes from here on."""
    copied = with_copied(state, action).copied
    assert copied is not None
    present = shown_pose(state).pose
    poses = pasted_poses(
        state.skeleton, copied, present, mirrored=action.mirrored, onto_body=action.onto_body
    )
    if copied.keypose == "pose":
        return posed(state.doc, state.skeleton, poses[0], state.frame, state.times_s)
    frames = [state.frame + key.after for key in copied.keys]
    _require_free_frames(state, frames[-1] - frames[0])
    stay = state.doc.keyframes
    if action.replace:
        stay = tuple(keyframe for keyframe in stay if keyframe.frame not in set(frames))
    else:
        require_free((*stay, *state.doc.part_keyframes), frames)
    placed = []
    for key, pose, frame in zip(copied.keys, poses, frames, strict=True):
        require_before_camera(state.skeleton, pose)
        keyframe = keyframe_of(state.skeleton, pose, frame, state.times_s)
        placed.append(keyframe.model_copy(update={"soft": True}) if key.soft else keyframe)
    return with_keyframes_placed(state.doc, stay, placed)


def _require_free_frames(state: EditorState, span: int) -> None:
    last = state.frame_count - 1
    if span > last:
        raise ActionRefused(
            f"The copied keyframes span {span + 1} frames, this video has {last + 1}."
        )
    if state.frame + span > last:
        raise ActionRefused(
            f"The copied keyframes would reach frame {state.frame + span}, the video ends at "
            f"{last}. Go to frame {last - span} or earlier."
        )


def pasting(action: do.PastePose) -> str:
    """Return what undo calls it: "paste the pose", "paste 3 keyframes"."""
    if action.copied is None or action.copied.keypose == "pose":
        return "paste the pose" if action.name is None else f"insert the pose {action.name}"
    return f"paste {len(action.copied.keys)} keyframes"
