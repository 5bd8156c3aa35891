"""Change a document by the small moves all edits are made of, or refuse in one sentence."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeVar

import numpy as np
from pydantic import BaseModel, ValidationError

from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import KeyposeError, one_sentence
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.keyframe import Keyframe, PartKeyframe, Softness
from keypose.tracker.session.schema import Session
from keypose.tracker.session.settings import FARTHEST_M
from keypose.tracker.session.views import View
from keypose.tracker.storage import changes


class ActionRefused(KeyposeError):
    """An action that is not possible now, in one sentence; the state stays as it is."""


Posed = TypeVar("Posed", bound=Keyframe)
Model = TypeVar("Model", bound=BaseModel)
SAME_FOCAL = 1e-9
"""Share by which focal lengths may differ that are one: files round."""
NEAREST_M = 0.06
"""Every joint of a pose stays this far before the camera; the session's own limit is 0.05."""


def valid(kind: type[Model], values: Mapping[str, Any]) -> Model:
    """Make a value of a kind; refused, in one sentence, where it cannot be one."""
    try:
        return kind.model_validate(values)
    except ValidationError as error:
        raise ActionRefused(one_sentence(error)) from None


def require_in_video(doc: Session, frame: int) -> int:
    """A frame that the video has; refused where it has not."""
    frame_count = doc.view.video.frame_count
    if frame >= frame_count:
        raise ActionRefused(f"The video has frames 0 to {frame_count - 1}.")
    return frame


def film_of(doc: Session, view_id: str) -> View:
    """A view after the first, by its id; refused where there is none."""
    for view in doc.views[1:]:
        if view.id == view_id:
            return view
    raise ActionRefused("This film is not in the session any more.")


def with_keyframes(doc: Session, keyframes: Iterable[Keyframe]) -> Session:
    """Set these keyframes, sorted by frame, in the place of part keyframes of the same frames."""
    keyed = tuple(sorted(keyframes, key=_frame))
    doc = doc.changed({"keyframes": keyed})
    frames = {keyframe.frame for keyframe in keyed}
    parts = tuple(each for each in doc.subject.part_keyframes if each.frame not in frames)
    return doc if len(parts) == len(doc.subject.part_keyframes) else with_part_keyframes(doc, parts)


def with_part_keyframes(doc: Session, keyframes: Iterable[PartKeyframe]) -> Session:
    """Set these part keyframes, sorted by frame."""
    return doc.changed({"part_keyframes": tuple(sorted(keyframes, key=_frame))})


def with_drafts(doc: Session, drafts: Iterable[Keyframe]) -> Session:
    """Set these drafts, sorted by frame."""
    return doc.changed({"drafts": tuple(sorted(drafts, key=_frame))})


def without(poses: Iterable[Posed], frame: int) -> tuple[Posed, ...]:
    """All but the one at this frame."""
    return tuple(pose for pose in poses if pose.frame != frame)


def posed(
    doc: Session,
    skeleton: Skeleton,
    pose: Pose,
    frame: int,
    times_s: Array,
    soft: Softness = False,
) -> Session:
    """Set this pose at a frame: in its keyframe, or else as a draft."""
    require_before_camera(skeleton, pose)
    keyframe = softened(keyframe_of(skeleton, pose, frame, times_s), soft)
    if any(each.frame == frame for each in doc.subject.keyframes):
        doc = with_keyframes(doc, (*without(doc.subject.keyframes, frame), keyframe))
        return with_drafts(doc, without(doc.subject.drafts, frame))  # it would be shown instead
    return with_drafts(doc, (*without(doc.subject.drafts, frame), keyframe))


def keyframe_of(skeleton: Skeleton, pose: Pose, frame: int, times_s: Array) -> Keyframe:
    """The pose as a keyframe; refused where it is too far away."""
    require_within_reach(pose)
    return Keyframe.of(skeleton, pose, frame, float(times_s[frame]))


def softened(keyframe: Keyframe, soft: Softness) -> Keyframe:
    """Set how far the motion in space may leave a keyframe."""
    return keyframe.model_copy(update={"soft": soft}) if soft != keyframe.soft else keyframe


def require_within_reach(pose: Pose) -> None:
    """Refused when the body would be farther away than any keyframe may be."""
    if not np.abs(pose.p_camera_root).max() <= FARTHEST_M:
        raise ActionRefused(
            f"The body would be farther than {FARTHEST_M / 1000:.0f} km away. Move it nearer."
        )


def require_before_camera(skeleton: Skeleton, pose: Pose) -> None:
    """Refused when a joint would come to lie behind the camera, or the body too far before it."""
    require_within_reach(pose)
    z = pose_transforms(skeleton, pose)[:, 2, 3]
    if not z.min() > NEAREST_M:
        raise ActionRefused("The body would be behind the camera. Move it farther away.")


def require_sound(before: Session, after: Session, action: str) -> None:
    """Refused, with the name of the action, where the document could not be read back.

    before: a document that could.
    """
    try:
        changes.require_sound(before, after)
    except ValueError as error:
        raise impossible(action, str(error)) from None


def impossible(action: str, why: str) -> ActionRefused:
    """The refusal of an action by its name, with the reason."""
    return ActionRefused(f"{action[:1].upper()}{action[1:]}: not possible ({why.rstrip('.')}).")


def _frame(keyframe: Keyframe) -> int:
    return keyframe.frame


def poses_of(doc: Session) -> tuple[Keyframe, ...]:
    """All that is posed: keyframes, part keyframes and drafts."""
    return (*doc.subject.keyframes, *doc.subject.part_keyframes, *doc.subject.drafts)


def with_poses(doc: Session, change: Callable[[Keyframe], Keyframe]) -> Session:
    """Change each of `poses_of`."""
    names = ("keyframes", "part_keyframes", "drafts")
    return doc.changed({name: tuple(map(change, doc.value(name))) for name in names})


def require_all_before_camera(doc: Session, skeleton: Skeleton) -> Session:
    """The document; refused when a joint of any pose lies behind the camera."""
    for each in poses_of(doc):
        require_before_camera(skeleton, each.pose(skeleton))
    return doc


def seen_as_before(before: Session, after: Session) -> Session:
    """All that is posed of any body seen as large as before with the lens and the zoom that a
    session has by now; refused when a joint of any pose lies behind the camera."""
    if {session.view.camera.projection for session in (before, after)} != {"perspective"}:
        return after
    focal = _focal_lengths(after) / _focal_lengths(before)
    if np.allclose(focal, 1.0, rtol=SAME_FOCAL, atol=0.0):
        return after
    for body in after.bodies:
        about = after.about(body.id)
        after = with_poses(about, lambda each: at_new_focal(each, float(focal[each.frame])))
        require_all_before_camera(after, Skeleton.of(body.body))
    return after.about(before.subject.id)


def _focal_lengths(doc: Session) -> Array:
    """(F,) pixels, at every frame of the film."""
    path = doc.camera_path
    zoom = np.ones(doc.view.video.frame_count) if path is None else path.zoom
    return np.asarray(doc.view.camera.fx * zoom)


def at_new_focal(posed: Posed, factor: float) -> Posed:
    """A lens so much longer shows the body as large as before from so much farther away."""
    if math.isclose(factor, 1.0, rel_tol=SAME_FOCAL):
        return posed
    x, y, z = posed.root_m
    return posed.model_copy(update={"root_m": (x, y, z * factor)})


def times_as_far(posed: Posed, factor: float) -> Posed:
    """So many times as far from the camera, as of a body that is so many times larger."""
    if factor == 1.0:
        return posed
    x, y, z = (factor * each for each in posed.root_m)
    return posed.model_copy(update={"root_m": (x, y, z)})


def with_cameras_apart(doc: Session, factor: float) -> Session:
    """Other films' cameras so many times as far from the first one."""
    if factor == 1.0:
        return doc
    films = tuple(
        view.model_copy(
            update={"p_camera_world": tuple(round(factor * p, 6) for p in view.p_camera_world)}
        )
        for view in doc.views[1:]
    )
    return doc.model_copy(update={"views": (doc.view, *films)})


def with_times(doc: Session, times_s: Array) -> Session:
    """Set each pose to its frame's time, which hand-written sessions may not know, and which
    another rate changes.
    """
    if all(pose.time_s == times_s[pose.frame] for pose in poses_of(doc)):
        return doc
    return with_poses(
        doc, lambda pose: pose.model_copy(update={"time_s": float(times_s[pose.frame])})
    )


def unchanged(old: tuple[Any, ...] | None, new: tuple[Any, ...]) -> bool:
    """Compare by identity what is large and immutable, by value plain numbers and words."""
    if old is None or len(old) != len(new):
        return False
    return all(
        a is b or (isinstance(a, int | float | str) and a == b)
        for a, b in zip(old, new, strict=True)
    )
