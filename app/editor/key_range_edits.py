"""Edits of several keyframes at once: moved, stretched, copied, deleted, each one step of undo."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping

from keypose.app.editor import actions as do
from keypose.app.editor.documents import with_drafts, with_keyframes
from keypose.app.editor.refusal import Refused
from keypose.app.editor.state import EditorState
from keypose.tracker.session.keyframe import Keyframe
from keypose.tracker.session.schema import Session

MOST_NAMED = 3
"""Frames that a sentence lists one by one."""


def delete_keyframes(state: EditorState, action: do.DeleteKeys) -> Session:
    """Without these keyframes."""
    gone = _require(state, action.frames).keys()
    return with_keyframes(state.doc, [k for k in state.doc.keyframes if k.frame not in gone])


def retime_keyframes(state: EditorState, action: do.RetimeKeys) -> Session:
    """The same poses at other frames. Refused where another keyframe stands at one of them."""
    if action.frames == action.to:
        return state.doc
    taken = _require(state, action.frames)
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
    """With keyframes beside those that stay, in the place of what may be drafted there: that would
    hide them."""
    frames = {keyframe.frame for keyframe in placed}
    doc = with_keyframes(doc, (*stay, *placed))
    return with_drafts(doc, (draft for draft in doc.drafts if draft.frame not in frames))


def at_frame(state: EditorState, keyframe: Keyframe, frame: int) -> Keyframe:
    """The keyframe at another frame; refused outside the video."""
    if frame >= state.frame_count:
        raise Refused(f"The video has frames 0 to {state.frame_count - 1}.")
    time_s = float(state.times_s[frame])
    return keyframe.model_copy(update={"frame": frame, "time_s": time_s})


def require_free(stay: Iterable[Keyframe], frames: Iterable[int]) -> None:
    """Refused, naming them, where keyframes, of the body or of limbs, stand at some of these
    frames."""
    known = {keyframe.frame for keyframe in stay}
    met = [frame for frame in frames if frame in known]
    if len(met) == 1:
        raise Refused(f"Frame {met[0]} is already a keyframe. Delete it first.")
    if met:
        raise Refused(f"Frames {_listed(met)} are already keyframes. Delete them first.")


def _listed(frames: list[int]) -> str:
    """ "12, 24 and 36", or "12, 24 and 7 more"."""
    if len(frames) > MOST_NAMED:
        shown, last = frames[: MOST_NAMED - 1], f"{len(frames) - MOST_NAMED + 1} more"
    else:
        shown, last = frames[:-1], str(frames[-1])
    return f"{', '.join(map(str, shown))} and {last}"


def _require(state: EditorState, frames: Iterable[int]) -> Mapping[int, Keyframe]:
    known = {keyframe.frame: keyframe for keyframe in state.doc.keyframes}
    for frame in frames:
        if frame not in known:
            raise Refused(f"Frame {frame} is not a keyframe.")
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
