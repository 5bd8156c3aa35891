"""Edit the body: shapes, sizes, joints, presets, what is tracked."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Annotated, Any, Literal, TypeAlias, TypeVar

import numpy as np
from pydantic import Field, FiniteFloat

from keypose.app.editor.documents import (
    ActionRefused,
    at_new_focal,
    keyframe_of,
    require_all_before_camera,
    softened,
    times_as_far,
    with_cameras_apart,
    with_keyframes,
    with_poses,
)
from keypose.app.editor.message import Edit
from keypose.app.editor.state import EditorState
from keypose.app.posing import part_label, with_height, with_joint, with_shape, with_size
from keypose.tracker.body.body import Body, Dof, Name, Part, preset
from keypose.tracker.body.modify import (
    can_have_clavicles,
    has_clavicles,
    unscaled,
    with_clavicles,
    with_new_part,
    with_renamed_part,
    without_clavicles,
    without_part,
)
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.preset_names import PRESETS
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.session.annotations import Reviewed
from keypose.tracker.session.keyframe import Keyframe, PartKeyframe
from keypose.tracker.session.pins import Pin
from keypose.tracker.session.schema import Session

Centimetres: TypeAlias = Annotated[FiniteFloat, Field(ge=-1e6, le=1e6)]
Named = TypeVar("Named", Pin, Reviewed)


class Shape(Edit):
    """A part of another shape, about as large."""

    do: Literal["shape"] = "shape"
    verb = "change the shape of"
    target = "part"
    part: Name
    kind: Annotated[str, Field(max_length=40)]

    def apply(self, state: EditorState) -> Session:
        linked = state.display.link
        return with_body(
            state, with_shape(state.doc.subject.body, self.part, self.kind, linked=linked)
        )


class Size(Edit):
    do: Literal["size"] = "size"
    verb = "resize"
    target = "part"
    part: Name
    key: Annotated[str, Field(max_length=40)]
    cm: Centimetres

    def apply(self, state: EditorState) -> Session:
        linked = state.display.link
        body = with_size(state.doc.subject.body, self.part, self.key, self.cm, linked=linked)
        return with_body(state, body)


class Joint(Edit):
    """Where a part hangs on its parent."""

    do: Literal["joint"] = "joint"
    verb = "move the joint of"
    target = "part"
    part: Name
    x: Centimetres | None = None
    y: Centimetres | None = None
    z: Centimetres | None = None

    def apply(self, state: EditorState) -> Session:
        body, wanted = state.doc.subject.body, (self.x, self.y, self.z)
        was = body.parts[body.index(self.part)].joint_m
        x, y, z = (100 * a if b is None else b for a, b in zip(was, wanted, strict=True))
        linked = state.display.link
        return with_body(state, with_joint(body, self.part, (x, y, z), linked=linked))


class Height(Edit):
    """The whole body made this high."""

    do: Literal["height"] = "height"
    verb = "change the height"
    cm: Centimetres

    def apply(self, state: EditorState) -> Session:
        body = state.doc.subject.body
        # From the preset itself: a height that is corrected leaves no rounding of the one before.
        whole = unscaled(body, map(preset, PRESETS)) or body
        return with_body(state, with_height(whole, self.cm))


class Preset(Edit):
    """One of the bodies that come with the product."""

    do: Literal["preset"] = "preset"
    verb = "change the body to"
    target = "name"
    name: Name

    def apply(self, state: EditorState) -> Session:
        return with_body(state, _as_jointed(state.doc.subject.body, preset(self.name)))


class SetBody(Edit):
    """A body of one's own, as in its file."""

    do: Literal["body"] = "body"
    verb = "change the body"
    body: Body

    def apply(self, state: EditorState) -> Session:
        return with_body(state, self.body)


class AddPart(Edit):
    """One more part at the far end of another, as long as that and thinner."""

    do: Literal["add_part"] = "add_part"
    verb = "add"
    target = "name"
    parent: Name
    name: Name

    def apply(self, state: EditorState) -> Session:
        return with_body(state, with_new_part(state.doc.subject.body, self.parent, self.name))


class DeletePart(Edit):
    """A part and all that hangs on it."""

    do: Literal["delete_part"] = "delete_part"
    verb = "delete"
    target = "part"
    part: Name

    def apply(self, state: EditorState) -> Session:
        body = state.doc.subject.body
        if body.parts[body.index(self.part)].parent is None:
            raise ActionRefused(
                "The first part carries all others and stays. Choose another body instead."
            )
        return with_body(state, without_part(body, self.part))


class RenamePart(Edit):
    """Another name of a part, wherever the session names it."""

    do: Literal["rename_part"] = "rename_part"
    verb = "rename"
    target = "part"
    part: Name
    name: Name

    def apply(self, state: EditorState) -> Session:
        doc = state.doc
        left_out = self._renamed(doc.settings.left_out)
        update = {
            "body": with_renamed_part(doc.subject.body, self.part, self.name),
            "settings": doc.settings.model_copy(update={"left_out": left_out}),
            "pins": tuple(map(self._of_part, doc.subject.pins)),
            "reviewed": tuple(map(self._of_part, doc.subject.reviewed)),
        }
        return with_poses(doc.changed(update), self._posed)

    def _renamed(self, names: Iterable[str]) -> tuple[str, ...]:
        return tuple(self.name if name == self.part else name for name in names)

    def _posed(self, keyframe: Keyframe) -> Keyframe:
        rotations = keyframe.rotations_wxyz
        named = zip(self._renamed(rotations), rotations.values(), strict=True)
        update: dict[str, Any] = {"rotations_wxyz": dict(named)}
        if isinstance(keyframe, PartKeyframe):
            update["parts"] = self._renamed(keyframe.parts)
        return keyframe.model_copy(update=update)

    def _of_part(self, named: Named) -> Named:
        return named.model_copy(update={"part": self.name}) if named.part == self.part else named


class ResetBody(Edit):
    """The preset's own sizes again."""

    do: Literal["reset_body"] = "reset_body"
    verb = "reset the body"

    def apply(self, state: EditorState) -> Session:
        name = state.doc.subject.body.name
        if name not in PRESETS:
            raise ActionRefused("This body is not based on a preset.")
        return with_body(state, _as_jointed(state.doc.subject.body, preset(name)))


class Clavicles(Edit):
    """Whether shoulders move on the chest. Poses stay as they are; without, arms keep their
    directions."""

    do: Literal["clavicles"] = "clavicles"
    verb = "change the clavicles"
    on: bool

    def apply(self, state: EditorState) -> Session:
        body = state.doc.subject.body
        if not self.on:
            return with_body(_with_arms_turned(state), without_clavicles(body))
        if not can_have_clavicles(body) and not has_clavicles(body):
            raise ActionRefused("Clavicles need a chest with two upper arms.")
        return with_body(state, with_clavicles(body))


class Tracked(Edit):
    """Which motions of a part the tracker estimates."""

    do: Literal["tracked"] = "tracked"
    verb = "change the tracked motions of"
    target = "part"
    part: Name
    dofs: Annotated[tuple[Dof, ...], Field(max_length=6)]

    def apply(self, state: EditorState) -> Session:
        body = state.doc.subject.body
        part = body.parts[body.index(self.part)]
        changed = Part.model_validate({**part.model_dump(), "tracked": self.dofs})
        return with_body(state, body.with_part(changed))


MESSAGES = (
    Shape,
    Size,
    Joint,
    Height,
    Preset,
    SetBody,
    AddPart,
    DeletePart,
    RenamePart,
    ResetBody,
    Clavicles,
    Tracked,
)


def _as_jointed(old: Body, body: Body) -> Body:
    """Add clavicles where the old body had them and this one can."""
    return with_clavicles(body) if has_clavicles(old) and can_have_clavicles(body) else body


def _with_arms_turned(state: EditorState) -> EditorState:
    """Every upper arm turned as its clavicle is, so that it points the same way without it."""
    skeleton = Skeleton.of(state.doc.subject.body)

    def turned(keyframe: Keyframe) -> Keyframe:
        pose = keyframe.pose(skeleton)
        Rs = pose.Rs_parent_part.copy()
        for side in ("left", "right"):
            arm, clavicle = (skeleton.body.index(f"{side}_{n}") for n in ("upper_arm", "clavicle"))
            Rs[arm] = Rs[clavicle] @ Rs[arm]
        made = Keyframe.of(skeleton, Pose(Rs, pose.p_camera_root), keyframe.frame, keyframe.time_s)
        return keyframe.model_copy(update={"rotations_wxyz": made.rotations_wxyz})

    has = has_clavicles(state.doc.subject.body)
    return replace(state, doc=with_poses(state.doc, turned)) if has else state


def with_body(state: EditorState, body: Body) -> Session:
    """Another body in all poses: parts it does not have are left out of them."""
    part_names = set(body.names)
    _require_pinned_parts(state, part_names)
    settings = state.doc.settings
    left_out = tuple(name for name in settings.left_out if name in part_names)
    update = {
        "body": body,
        "settings": settings.model_copy(update={"left_out": left_out}),
        "part_keyframes": tuple(_with_parts(state.doc, part_names)),
    }
    doc = with_poses(state.doc.changed(update), lambda each: _fitted(each, part_names))
    return require_all_before_camera(doc, Skeleton.of(body))


def _require_pinned_parts(state: EditorState, part_names: set[str]) -> None:
    """Refused where a pin would lose its part."""
    lost = [pin.part for pin in state.doc.subject.pins if pin.part not in part_names]
    if lost:
        raise ActionRefused(
            f"{part_label(lost[0])} is pinned and not part of that body. Unpin it first."
        )


def _with_parts(doc: Session, part_names: set[str]) -> Iterator[PartKeyframe]:
    """The part keyframes of which any part is left."""
    for keyframe in doc.subject.part_keyframes:
        parts = tuple(name for name in keyframe.parts if name in part_names)
        if parts:
            yield keyframe.model_copy(update={"parts": parts})


def _fitted(keyframe: Keyframe, part_names: set[str]) -> Keyframe:
    if set(keyframe.rotations_wxyz) <= part_names:
        return keyframe
    rotations = {name: q for name, q in keyframe.rotations_wxyz.items() if name in part_names}
    return keyframe.model_copy(update={"rotations_wxyz": rotations})


# --- sizes that were fitted


def require_sizes_to_fit(state: EditorState) -> None:
    """Refused where the sizes cannot be estimated."""
    if len(state.keys) < 2:
        raise ActionRefused("Needs 2 keyframes that show the body from different sides.")


def with_sizes_fitted(
    state: EditorState,
    body: Body,
    camera: Camera,
    keyposes: Mapping[int, Pose],
    larger: float = 1.0,
    apart: float = 1.0,
) -> EditorState:
    """Take over this body and camera, and the keyframes posed for them; what is posed as it was
    stays to the last digit.

    larger: how many times farther away all that is posed is; apart: and other films' cameras from
    the first one.
    """
    skeleton, nearer = Skeleton.of(body), camera.fx / state.doc.view.camera.fx

    def fitted(keyframe: Keyframe) -> Keyframe:
        pose, own = keyposes[keyframe.frame], keyframe.pose(state.skeleton)
        same = np.array_equal(own.Rs_parent_part, pose.Rs_parent_part)
        if same and np.array_equal(own.p_camera_root, pose.p_camera_root):
            return keyframe
        return softened(keyframe_of(skeleton, pose, keyframe.frame, state.times_s), keyframe.soft)

    source = "fitted" if nearer != 1.0 else state.doc.view.lens_source
    doc = with_poses(
        state.doc, lambda each: times_as_far(at_new_focal(each, nearer), larger)
    ).changed({"body": body, "camera": camera, "lens_source": source})
    doc = with_cameras_apart(doc, apart)
    doc = with_keyframes(doc, map(fitted, state.doc.subject.keyframes))
    return state.with_step(require_all_before_camera(doc, skeleton), "fit the sizes")
