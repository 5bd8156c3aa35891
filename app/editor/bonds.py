"""Edit bonds: which points of bodies meet, and from when to when."""

from __future__ import annotations

from itertools import takewhile
from typing import Annotated, Final, Literal, TypeAlias

import cv2
import numpy as np
from pydantic import Field

from keypose.app.editor.bodies import require_body
from keypose.app.editor.documents import ActionRefused, valid
from keypose.app.editor.message import Edit
from keypose.app.editor.shown import end_at, shown_pose
from keypose.app.editor.state import EditorState
from keypose.app.posing import part_label
from keypose.app.posing.labels import number_text
from keypose.tracker.body.body import Body, Name
from keypose.tracker.body.pose import pose_transforms
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, apply_transform
from keypose.tracker.keypoints.on_body import is_persons
from keypose.tracker.session.bonds import Bond, BondEnd, Moves
from keypose.tracker.session.schema import Session
from keypose.tracker.session.settings import FrameIndex, SceneId

FARTHEST_M: Final = 0.5
"""Points that are farther apart at the frame of a bond do not meet there."""
APART_M: Final = 0.12
"""As far apart as this they still meet at the frames around it, or twice as far as at its own."""
DEPTH_SHARE: Final = 1 / 3
"""Of a distance along the view, where it is asked what is near."""
LONGEST: Final = 1000
"""Frames before and after its own over which a bond is made by itself."""
DECIMALS: Final = 4
"""Of a point in its part's frame, metres."""
BondIndex: TypeAlias = Annotated[int, Field(ge=0, le=1000)]


class SetBond(Edit):
    """A part of the posed body and a part of a body held together at a frame, and over the frames
    around it at which they are as near.

    body: whose part it is; onto: that part; where left out the nearest of another body, one over
    which it lies in the picture before all others.
    """

    do: Literal["set_bond"] = "set_bond"
    verb = "hold"
    target = "part"
    part: Name
    frame: FrameIndex
    body: SceneId | None = None
    onto: Name | None = None

    def apply(self, state: EditorState) -> Session:
        frame, doc = min(self.frame, state.frame_count - 1), state.doc
        doc.subject.body.index(self.part)
        own = _surface(state, self.part, frame)
        body_id, onto = self._chosen(state, own, frame)
        points = _nearest(own, _surface(state.about(body_id), onto, frame))
        apart = float(np.linalg.norm(points[0] - points[1]))
        if apart > FARTHEST_M:
            raise ActionRefused(
                f"{part_label(self.part)} and {part_label(onto).lower()} are "
                f"{number_text(apart, 1)} m apart at frame {frame}: pose them together first."
            )
        middle = (points[0] + points[1]) / 2
        ends = (
            _end(state, doc.subject.id, self.part, frame, middle),
            _end(state, body_id, onto, frame, middle),
        )
        bodies = {body.id: body.body for body in doc.bodies}
        holder, held = ends if _holds(bodies[ends[0].body], bodies[ends[1].body]) else ends[::-1]
        moves: Moves = "both" if is_persons(bodies[held.body]) else "held"
        span = {"first_frame": frame, "last_frame": frame}
        bond = valid(Bond, {"holder": holder, "held": held, "moves": moves, **span})
        first, last = _range(state, bond, frame, apart)
        bond = bond.model_copy(update={"first_frame": first, "last_frame": last})
        return doc.model_copy(update={"bonds": (*doc.bonds, bond)})

    def _chosen(self, state: EditorState, own: Array, frame: int) -> tuple[str, str]:
        """The body and the part that are meant."""
        doc = state.doc
        if self.body is not None:
            require_body(doc, self.body)
        ids = [body.id for body in doc.bodies if body.id != doc.subject.id]
        choices = [
            (body.id, part.name)
            for body in doc.bodies
            for part in body.body.parts
            if (body.id == self.body if self.body is not None else body.id in ids)
            and self.onto in (None, part.name)
            and (body.id, part.name) != (doc.subject.id, self.part)
        ]
        if not choices:
            raise ActionRefused("There is no other body to hold: add one first.")
        if len(choices) == 1:
            return choices[0]
        camera = doc.film_camera.at(frame)
        own_outline = _outline(camera, own)

        def farness(choice: tuple[str, str]) -> tuple[bool, float]:
            body_id, part = choice
            surface = _surface(state.about(body_id), part, frame)
            is_near = float(np.linalg.norm(np.subtract(*_nearest(own, surface)))) <= FARTHEST_M
            is_over = is_near and _overlap(own_outline, _outline(camera, surface))
            return not is_over, _apart_as_seen(camera, own, surface)

        return min(choices, key=farness)


class ChangeBond(Edit):
    """Fields that are left out stay; an end that would pass the onto one stops there."""

    do: Literal["change_bond"] = "change_bond"
    verb = "change a hold"
    index: BondIndex
    first: FrameIndex | None = None
    last: FrameIndex | None = None
    moves: Moves | None = None

    @property
    def frames_named(self) -> tuple[int, ...]:
        """None: an end that is dragged past an end of the video stops there."""
        return ()

    def apply(self, state: EditorState) -> Session:
        bond = _require(state, self.index)
        final = state.frame_count - 1
        first = bond.first_frame if self.first is None else min(self.first, final)
        last = bond.last_frame if self.last is None else min(self.last, final)
        if self.first is not None and self.last is None:
            first = min(first, last)
        last = max(first, last)
        update = {"first_frame": first, "last_frame": last, "moves": self.moves or bond.moves}
        bonds = list(state.doc.bonds)
        bonds[self.index] = bond.model_copy(update=update)
        return state.doc.model_copy(update={"bonds": tuple(bonds)})


class DeleteBond(Edit):
    """Two points do not meet any more."""

    do: Literal["delete_bond"] = "delete_bond"
    verb = "let go"
    index: BondIndex

    def apply(self, state: EditorState) -> Session:
        gone = _require(state, self.index)
        bonds = tuple(bond for bond in state.doc.bonds if bond is not gone)
        return state.doc.model_copy(update={"bonds": bonds})


MESSAGES = (SetBond, ChangeBond, DeleteBond)


def _require(state: EditorState, index: int) -> Bond:
    if index >= len(state.doc.bonds):
        raise ActionRefused("This hold is not there any more.")
    return state.doc.bonds[index]


def _holds(first: Body, second: Body) -> bool:
    """Whether the first of two bodies is the one that holds: a person does, whatever it is."""
    return is_persons(first) or not is_persons(second)


def _surface(state: EditorState, part: str, frame: int) -> Array:
    """(V, 3) the corners of a part's shape as it is shown at a frame, camera frame."""
    index = state.doc.subject.body.index(part)
    T = pose_transforms(state.skeleton, shown_pose(state, frame).pose)[index]
    vertices = state.doc.subject.body.parts[index].shape.mesh().vertices
    return np.asarray(apply_transform(T, np.asarray(vertices)))


def _nearest(first: Array, second: Array) -> tuple[Array, Array]:
    """The nearest of two sets of points."""
    apart = np.linalg.norm(first[:, None] - second, axis=-1)
    i, j = np.unravel_index(int(np.argmin(apart)), apart.shape)
    return first[i], second[j]


def _outline(camera: Camera, points: Array) -> Array:
    """(n, 1, 2) the hull of points (V, 3) in the picture, pixels; empty where some lie behind the
    camera."""
    uv = camera.project(points).astype(np.float32)
    return np.asarray(cv2.convexHull(uv)) if np.isfinite(uv).all() else np.empty((0, 1, 2))


def _overlap(first: Array, second: Array) -> bool:
    """Whether two hulls lie over each other in the picture."""
    if not len(first) or not len(second):
        return False
    area, _ = cv2.intersectConvexConvex(first, second)
    return bool(area > 0)


def _apart_as_seen(camera: Camera, first: Array, second: Array) -> float:
    """The least distance of two sets of points, along the view counted as a share of itself: how
    far something is from the camera is a guess."""
    away = second - first[:, None]
    rays = first / np.linalg.norm(first, axis=-1, keepdims=True)
    if camera.projection != "perspective":
        rays = np.broadcast_to([0.0, 0.0, 1.0], first.shape)
    along = np.sum(away * rays[:, None], axis=-1)
    across = away - along[..., None] * rays[:, None]
    return float(np.hypot(np.linalg.norm(across, axis=-1), DEPTH_SHARE * along).min())


def _end(state: EditorState, body_id: str, part: str, frame: int, p_camera: Array) -> BondEnd:
    """A point in the frame of a part."""
    about = state.about(body_id)
    T = pose_transforms(about.skeleton, shown_pose(about, frame).pose)
    T = T[about.doc.subject.body.index(part)]
    x, y, z = (T[:3, :3].T @ (p_camera - T[:3, 3])).round(DECIMALS).tolist()
    return BondEnd(body=body_id, part=part, point_m=(x, y, z))


def apart_m(state: EditorState, bond: Bond, frame: int) -> float:
    """How far the two points of a bond are from each other as they are shown at a frame."""
    points = [end_at(state.about(end.body), end, frame) for end in bond.ends]
    return float(np.linalg.norm(points[0] - points[1]))


def _range(state: EditorState, bond: Bond, frame: int, apart: float) -> tuple[int, int]:
    """First and last frame around one at which both points are nearly as near; where nothing is
    known of the motion, this frame and what lies between its keyframes."""
    within = max(APART_M, 2 * apart)
    first, last = max(0, frame - LONGEST), min(state.frame_count - 1, frame + LONGEST)
    before = takewhile(lambda at: _meet(state, bond, at, within), range(frame - 1, first - 1, -1))
    after = takewhile(lambda at: _meet(state, bond, at, within), range(frame + 1, last + 1))
    return min(before, default=frame), max(after, default=frame)


def _meet(state: EditorState, bond: Bond, frame: int, within_m: float) -> bool:
    """Whether both bodies have a pose at a frame, or one between two of them, in which the points
    are so near."""
    sources = {shown_pose(state.about(end.body), frame).source for end in bond.ends}
    return not sources & {"rest", "held"} and apart_m(state, bond, frame) <= within_m
