"""What was copied, put to the present frame: a pose as its pose, keyframes from there on."""

from __future__ import annotations

from collections.abc import Collection

from keypose.app.editor import actions as do
from keypose.app.editor.copied import Copied, pasted_poses
from keypose.app.editor.documents import keyframe_of, posed, require_before_camera
from keypose.app.editor.key_range_edits import require_free, with_keyframes_placed
from keypose.app.editor.refusal import Refused
from keypose.app.editor.shown import find, shown_pose
from keypose.app.editor.state import EditorState
from keypose.tracker.session.schema import Session


def copied_from(state: EditorState, frames: Collection[int]) -> Copied:
    """The keyframes at some frames; of none the pose shown at the present frame."""
    if not frames:
        return Copied.pose_of(state.skeleton, shown_pose(state).pose)
    found = [find(state.doc.keyframes, frame) for frame in sorted(set(frames))]
    keyframes = [keyframe for keyframe in found if keyframe is not None]
    if len(keyframes) < len(found):
        raise Refused("One of these frames is not a keyframe any more.")
    return Copied.keys_of(state.skeleton, keyframes)


def with_copied(state: EditorState, action: do.PastePose) -> do.PastePose:
    """The action with what it pastes: what was copied in this session, unless it brings its own."""
    if action.copied is not None:
        return action
    if state.clipboard is None:
        raise Refused("Copy a pose first (Ctrl C).")
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
    _require_room(state, frames[-1] - frames[0])
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


def _require_room(state: EditorState, span: int) -> None:
    last = state.frame_count - 1
    if span > last:
        raise Refused(f"The copied keyframes span {span + 1} frames, this video has {last + 1}.")
    if state.frame + span > last:
        raise Refused(
            f"The copied keyframes would reach frame {state.frame + span}, the video ends at "
            f"{last}. Go to frame {last - span} or earlier."
        )


def pasting(action: do.PastePose) -> str:
    """What undo calls it: "paste the pose", "paste 3 keyframes"."""
    if action.copied is None or action.copied.keypose == "pose":
        return "paste the pose" if action.name is None else f"insert the pose {action.name}"
    return f"paste {len(action.copied.keys)} keyframes"
