"""The session file's contents: plain numbers, validated once when read, each alone and together.

Every error message names the field and what is allowed. Lengths are metres, angles radians,
rotations unit quaternions [w, x, y, z] of a part in its parent's frame. Fields that are not known
are kept as they are: another program may have its own.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise
from typing import Annotated, Any, Literal, Self, TypeAlias

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field, FiniteFloat, model_validator

from keypose.tracker.body.body import Body
from keypose.tracker.body.film_camera import FilmCamera
from keypose.tracker.body.heading import CAMERA_UP
from keypose.tracker.body.pose import part_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import SessionError
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import Array, rotation_from_quaternion
from keypose.tracker.geometry.up import UpEstimate, UpSource
from keypose.tracker.session.annotations import (
    NoteList,
    require_ahead,
    require_corrections,
    require_notes,
)
from keypose.tracker.session.bodies import TrackedBody, ViewKeypoints, body_called, free_id
from keypose.tracker.session.bonds import BondList, require_bonds
from keypose.tracker.session.camera_motion import path_through
from keypose.tracker.session.counts import MOST, few, require_few
from keypose.tracker.session.evidence import Evidence, evidence_of
from keypose.tracker.session.keyframe import Keyframe, quaternions_of
from keypose.tracker.session.migrate import PRESENT
from keypose.tracker.session.pins import require_pins
from keypose.tracker.session.settings import (
    Metres,
    Plain,
    Position,
    SceneId,
    Title,
    TrackSettings,
    is_unknown,
)
from keypose.tracker.session.views import View

MOST_VIEWS = 32
MOST_BODIES = 32
"""Far above what one scene has."""

NEAREST_M = 0.05
"""The least depth of a joint."""

POSES_AT_A_TIME = 500
AT_REST = (1.0, 0.0, 0.0, 0.0)


def require_fit(session: Session, subject: TrackedBody, poses: Sequence[Keyframe]) -> None:
    """ValueError in one sentence unless the session's values, each valid by itself, fit together.

    subject: the body to check.  poses: the keyframes, of parts too, and drafts of it to check
        against body and video; the others are known to fit.
    """
    require_few({name: session.value(name) for name in MOST if name in PART_OF})
    require_few({name: getattr(subject, name) for name in MOST if name in SUBJECT_FIELDS})
    for view in session.views:
        _require_view(view, session.view)
    _require_ids("views", session.views)
    _require_ids("bodies", session.bodies)
    _require_sorted(subject.keyframes)
    _require_sorted(subject.drafts)
    _require_sorted(subject.part_keyframes)
    _require_part_keyframes(subject, session.view)
    _require_keypoints(subject, session)
    _require_direction(session.world.up_world)
    _require_parts(session.settings.left_out, session.bodies)
    frame_count = session.view.video.frame_count
    require_pins(subject.pins, subject.body, frame_count)
    require_notes(session.notes, frame_count)
    require_bonds(session.bonds, {body.id: body.body for body in session.bodies}, frame_count)
    require_ahead(subject.ahead, subject.body, frame_count)
    for keyframe in poses:
        _require_in_video(keyframe, frame_count)
        _require_known_parts(keyframe, subject.body)
    skeleton = Skeleton.of(subject.body)
    for start in range(0, len(poses), POSES_AT_A_TIME):
        _require_before_camera(poses[start : start + POSES_AT_A_TIME], skeleton)


def _require_view(view: View, first: View) -> None:
    camera, video = view.camera, view.video
    if (camera.width, camera.height) != (video.width, video.height):
        raise ValueError(
            f"camera.width × height is {camera.width}×{camera.height} but video.width × height is "
            f"{video.width}×{video.height}; the sizes must agree, both the video's own"
        )
    if view.clock is None and video.frame_count != first.video.frame_count:
        raise ValueError(
            f"views: {view.id!r} has {video.frame_count} frames and {first.id!r} "
            f"{first.video.frame_count}; without a clock views must have the same frames"
        )
    if view.clock is not None:
        _require_clock(view, first)
    if view is first and (view.T_camera_world != np.eye(4)).any():
        raise ValueError(f"views: {view.id!r} is the first, whose camera is the world's frame")
    _require_camera_motion(view)
    require_corrections(view.keypoint_corrections, video.frame_count, video.width, video.height)


def _require_clock(view: View, first: View) -> None:
    if view is first:
        raise ValueError(f"views: {view.id!r} is the first, whose clock is that of all")
    if not view.film_clock.overlap(view.video.frame_count, first.video.frame_count):
        raise ValueError(
            f"views: {view.id!r} has no frame of the time that {first.id!r} shows; "
            "change where its clock begins"
        )


def _require_camera_motion(view: View) -> None:
    count, frames = view.video.frame_count, [each.frame for each in view.camera_keyframes]
    if view.camera_motion is not None and view.camera_motion.frame_count != count:
        raise ValueError(
            f"camera_motion has {view.camera_motion.frame_count} frames and the video {count}"
        )
    if frames and frames[-1] >= count:
        raise ValueError(f"camera_keyframes: frame {frames[-1]} is beyond the video's {count - 1}")
    for before, after in pairwise(frames):
        if before >= after:
            raise ValueError(f"camera_keyframes: frame {after} stands after {before}")


def _require_keypoints(subject: TrackedBody, session: Session) -> None:
    """ValueError in one sentence unless keypoints that stand with a body are of its views."""
    if subject.keypoints_by_view and subject is session.subject:
        raise ValueError(
            f"keypoints_by_view: {subject.id!r} is the body that is posed, whose keypoints stand "
            "in the views"
        )
    videos = {view.id: view.video for view in session.views}
    for view_id, each in subject.keypoints_by_view.items():
        if view_id not in videos:
            raise ValueError(f"keypoints_by_view: there is no view of the id {view_id!r}")
        video = videos[view_id]
        require_corrections(each.keypoint_corrections, video.frame_count, video.width, video.height)


def _require_ids(field: str, them: Sequence[View | TrackedBody]) -> None:
    ids = [each.id for each in them]
    twice = next((each_id for each_id in ids if ids.count(each_id) > 1), None)
    if twice is not None:
        raise ValueError(f"{field}: two have the id {twice!r}; each needs its own")


def _require_part_keyframes(subject: TrackedBody, view: View) -> None:
    """ValueError in one sentence unless each names parts of the body besides its root, at a frame
    of a film that is no keyframe."""
    if not subject.part_keyframes:
        return
    if view.surface is not None:
        raise ValueError(
            "part_keyframes: a body is fitted to surfaces as a whole; make them keyframes"
        )
    names, keyed = subject.body.names, {keyframe.frame for keyframe in subject.keyframes}
    for each in subject.part_keyframes:
        if each.frame in keyed:
            raise ValueError(f"part_keyframes: frame {each.frame} is a keyframe; one is allowed")
        unknown = sorted(set(each.parts) - set(names))
        if unknown:
            raise ValueError(
                f"part_keyframes: frame {each.frame} names {unknown[0]!r}, which the body does not "
                f"have; its parts are {', '.join(names)}"
            )
        if names[0] in each.parts:
            raise ValueError(
                f"part_keyframes: frame {each.frame} names {names[0]!r}, which carries all others; "
                "make it a keyframe"
            )
        if len(set(each.parts)) < len(each.parts):
            raise ValueError(f"part_keyframes: frame {each.frame} names a part twice")


def _require_sorted(keyframes: Sequence[Keyframe]) -> None:
    for keyframe, following in pairwise(keyframes):
        before, after = keyframe.frame, following.frame
        if before == after:
            raise ValueError(f"keyframes: frame {before} has two keyframes; one is allowed")
        if before > after:
            raise ValueError(f"keyframes: frame {after} stands after {before}; sort them by frame")
        if keyframe.time_s >= following.time_s:
            raise ValueError(
                f"keyframes: time_s of frame {after} is {following.time_s:g}; it must be later "
                f"than {keyframe.time_s:g}, the time of frame {before}"
            )


def _require_parts(left_out: tuple[str, ...], bodies: Sequence[TrackedBody]) -> None:
    names = [name for tracked_body in bodies for name in tracked_body.body.names]
    unknown = sorted(set(left_out) - set(names))
    if unknown:
        raise ValueError(
            f"settings.left_out names {unknown[0]!r}, which the body does not have; its parts are "
            f"{', '.join(names)}"
        )


def _require_direction(up_world: Position | None) -> None:
    if up_world is not None and math.hypot(*up_world) < 1e-6:
        raise ValueError("up_world: [0, 0, 0] is no direction")


def _require_in_video(keyframe: Keyframe, frame_count: int) -> None:
    if keyframe.frame >= frame_count:
        raise ValueError(
            f"keyframes: frame {keyframe.frame} is beyond the video, "
            f"whose frames are 0 to {frame_count - 1}"
        )


def _require_known_parts(keyframe: Keyframe, body: Body) -> None:
    unknown = sorted(keyframe.rotations_wxyz.keys() - set(body.names))
    if unknown:
        raise ValueError(
            f"keyframes: frame {keyframe.frame} poses {unknown[0]!r}, which the body does not "
            f"have; its parts are {', '.join(body.names)}"
        )


def _require_before_camera(keyframes: Sequence[Keyframe], skeleton: Skeleton) -> None:
    names = skeleton.body.names
    quaternions = np.array([quaternions_of(keyframe, names) for keyframe in keyframes])
    roots = np.array([keyframe.root_m for keyframe in keyframes])
    z = part_transforms(skeleton, rotation_from_quaternion(quaternions), roots)[..., 2, 3]
    behind = np.flatnonzero(~(z.min(axis=-1) > NEAREST_M))
    if len(behind):
        first = behind[0]
        raise ValueError(
            f"keyframes: frame {keyframes[first].frame} has {names[int(np.argmin(z[first]))]!r} "
            f"behind the camera; every joint needs a depth of more than {NEAREST_M} m"
        )


class World(Plain):
    """What stands still while bodies and cameras move."""

    up_world: Position | None = Field(
        default=None,
        description="The direction that is up, in the frame of the world, which is the first "
        "view's camera as it begins; null: the camera's own, −y.",
    )
    up_from: tuple[UpSource, ...] = Field(
        default=(),
        exclude_if=operator.not_,
        description="What up was found from: upright lines, how the person stands, where feet "
        'stand, and "set" where somebody chose that; left out where somebody drew it.',
    )
    up_sigma_rad: Annotated[FiniteFloat, Field(gt=0)] | None = Field(
        default=None,
        exclude_if=is_unknown,
        description="Its standard deviation where that is largest, radians; left out where it is "
        "not known.",
    )
    floor_m: Metres | None = Field(
        default=None,
        exclude_if=is_unknown,
        description="The floor's height along up, from the world's origin, metres; left out where "
        "it is not known.",
    )

    @property
    def up(self) -> Array:
        """The unit vector (3,) up; that of the first view's camera as it begins, where nobody
        knows."""
        up = np.array(CAMERA_UP if self.up_world is None else self.up_world, dtype=np.float64)
        return np.asarray(up / np.linalg.norm(up))

    @model_validator(mode="before")
    @classmethod
    def _names_its_sources(cls, data: Any) -> Any:
        """Sessions once said only whether up was found from pinned feet."""
        if not isinstance(data, dict) or "up_from_feet" not in data:
            return data
        if not isinstance(data["up_from_feet"], bool | None):
            raise ValueError("up_from_feet: is neither true nor false")
        rest = {name: value for name, value in data.items() if name != "up_from_feet"}
        return {**({"up_from": ("feet", "set")} if data["up_from_feet"] else {}), **rest}


class Session(Plain):
    """All about one scene: what cameras saw of it, the bodies in it, the settings.

    As long as there is one view and one body, `view` and `subject` are these. Of several bodies one
    is posed: its keypoints stand in the views, those of each other one with that body.
    """

    schema_version: Annotated[int, Field(ge=1)] = Field(
        default=PRESENT, description=f"{PRESENT}; a greater one is of a newer Keypose."
    )
    title: Title = Field(
        default="",
        exclude_if=operator.not_,
        description="What a person calls it; left out where it is called as its folder.",
    )
    views: Annotated[tuple[View, ...], Field(min_length=1, max_length=MOST_VIEWS)]
    bodies: Annotated[tuple[TrackedBody, ...], Field(min_length=1, max_length=MOST_BODIES)]
    posed_body: SceneId | None = Field(
        default=None,
        exclude_if=is_unknown,
        description="The id of the body that is posed; left out where it is the first.",
    )
    world: World = World()
    notes: NoteList = ()
    bonds: BondList = ()
    settings: TrackSettings = TrackSettings()

    @classmethod
    def begin(cls, **fields: Any) -> Self:
        """Begin a session of one view and one body from the fields of both, of the world and its
        own."""
        parts = by_part(fields)
        return cls(
            views=(View(**parts["view"]),),
            bodies=(TrackedBody(**parts["subject"]),),
            world=World(**parts["world"]),
            **parts["session"],
        )

    @property
    def view(self) -> View:
        """The view whose pictures are shown."""
        return self.views[0]

    @property
    def subject(self) -> TrackedBody:
        """The body that is posed and tracked."""
        return self.bodies[0] if self.posed_body is None else self._body(self.posed_body)

    def _body(self, body_id: str) -> TrackedBody:
        for body in self.bodies:
            if body.id == body_id:
                return body
        raise KeyError(body_id)

    def about(self, body_id: str) -> Self:
        """The same about another of its bodies, which is the one that is posed; KeyError where
        there is no such body."""
        chosen, left = self._body(body_id), self.subject
        if chosen is left:
            return self
        in_views = {view.id: _keypoints_in(view) for view in self.views}
        parked = {view_id: each for view_id, each in in_views.items() if each != ViewKeypoints()}
        views = tuple(
            view.model_copy(update=dict(chosen.keypoints_by_view.get(view.id, ViewKeypoints())))
            for view in self.views
        )
        changed = {
            left.id: left.model_copy(update={"keypoints_by_view": parked}),
            chosen.id: chosen.model_copy(update={"keypoints_by_view": {}}),
        }
        bodies = tuple(changed.get(body.id, body) for body in self.bodies)
        posed_body = None if body_id == bodies[0].id else body_id
        return self.model_copy(update={"views": views, "bodies": bodies, "posed_body": posed_body})

    def taking(self, state: Self) -> Self:
        """The same with the body that another state of it is about, its keypoints and the world as
        they are there."""
        there = self.about(state.subject.id).with_body(state.subject)
        keypoints = {view.id: dict(_keypoints_in(view)) for view in state.views}
        views = tuple(view.model_copy(update=keypoints.get(view.id, {})) for view in there.views)
        taken = there.model_copy(update={"views": views, "world": state.world})
        return taken.about(self.subject.id)

    @property
    def bonded(self) -> tuple[str, ...]:
        """The ids of the other bodies that bonds join to the posed one."""
        own = self.subject.id
        ids = (each for bond in self.bonds if own in bond.bodies for each in bond.bodies)
        return tuple(dict.fromkeys(each for each in ids if each != own))

    def about_called(self, name: str) -> Self:
        """The same about the body of an id, or the only one of a name; SessionError says which
        there are."""
        return self.about(body_called(self.bodies, name).id)

    def subject_in(self, file_name: str) -> str:
        """What is said to lack something: the file, or the body of it where it has several."""
        return f"Body {self.subject.id} of {file_name}" if len(self.bodies) > 1 else file_name

    def alone(self, view_id: str) -> Self:
        """The same about one of its views alone, as if that were the first; KeyError where there
        is no such view. What was chosen of the first camera says nothing of another."""
        chosen = next((view for view in self.views if view.id == view_id), None)
        if chosen is None:
            raise KeyError(view_id)
        if chosen is self.view:
            return self.model_copy(update={"views": (chosen,)})
        placed = dict.fromkeys(("clock", "placed"))
        there = {**placed, "R_camera_world_wxyz": AT_REST, "p_camera_world": (0.0, 0.0, 0.0)}
        settings = self.settings.model_copy(update={"static_camera": None})
        views = (chosen.model_copy(update=there),)
        return self.model_copy(update={"views": views, "settings": settings})

    def with_new_body(self, body: Body, wish: str) -> tuple[Self, TrackedBody]:
        """The same with one body more, not posed, whose id is as the wish, or that and a number;
        SessionError where there are as many as a session may have."""
        if len(self.bodies) >= MOST_BODIES:
            raise SessionError(
                f"The session has {MOST_BODIES} bodies already, the most that it can."
            )
        added = TrackedBody(id=free_id(wish, self.bodies), body=body)
        return self.model_copy(update={"bodies": (*self.bodies, added)}), added

    def without_body(self, body_id: str) -> Self:
        """The same without one of its bodies, its bonds, and its parts that are left out of
        tracking; where it is posed another one is. SessionError where it has no other."""
        rest = [body.id for body in self.bodies if body.id != body_id]
        if not rest:
            raise SessionError("A session needs a body: add another before you remove its last.")
        session = self.about(rest[0]) if self.subject.id == body_id else self
        bodies = tuple(body for body in session.bodies if body.id != body_id)
        names = {name for each in bodies for name in each.body.names}
        left_out = tuple(name for name in self.settings.left_out if name in names)
        update = {
            "bodies": bodies,
            "bonds": tuple(bond for bond in self.bonds if body_id not in bond.bodies),
            "settings": self.settings.model_copy(update={"left_out": left_out}),
            "posed_body": None if session.subject.id == bodies[0].id else session.subject.id,
        }
        return session.model_copy(update=update)

    def with_body(self, subject: TrackedBody) -> Self:
        """The same with another state of one of its bodies, known by its id."""
        bodies = tuple(subject if body.id == subject.id else body for body in self.bodies)
        return self.model_copy(update={"bodies": bodies})

    def value(self, name: str) -> Any:
        """A field by its name, wherever it stands: in view, subject, world or here."""
        return getattr(_owner(self, PART_OF[name]), name)

    def changed(self, fields: Mapping[str, Any]) -> Self:
        """Set fields by their names, wherever they stand, unvalidated as `model_copy` does."""
        parts = by_part(fields)
        update: dict[str, Any] = parts["session"]
        if parts["view"]:
            update["views"] = (self.view.model_copy(update=parts["view"]), *self.views[1:])
        if parts["subject"]:
            subject = self.subject.model_copy(update=parts["subject"])
            update["bodies"] = self.with_body(subject).bodies
        if parts["world"]:
            update["world"] = self.world.model_copy(update=parts["world"])
        return self.model_copy(update=update)

    @property
    def evidence(self) -> Evidence:
        """What the body is compared with."""
        return evidence_of(self)

    @property
    def has_static_camera(self) -> bool:
        """Whether the camera is taken to stand still: as the settings say, else as it was
        found; False where nobody looked.
        """
        chosen, detected = self.settings.static_camera, self.view.video.stands_still
        return bool(detected if chosen is None else chosen)

    @property
    def has_unknown_motion(self) -> bool:
        """Whether the camera is said, or was found, to move, and nobody knows how."""
        chosen, detected = self.settings.static_camera, self.view.video.stands_still
        moves = (detected if chosen is None else chosen) is False
        return moves and self.view.camera_motion is None

    @property
    def camera_path(self) -> CameraPath | None:
        """Where the camera was at every frame, as a person corrected it; None where it
        stands still, or where that is not known: then the camera is the world.
        """
        motion = self.view.camera_motion
        if motion is None or self.has_static_camera:
            return None
        return path_through(motion, self.view.camera_keyframes)

    @property
    def film_camera(self) -> FilmCamera:
        """The first view's camera, and where it was."""
        return FilmCamera(self.view.camera, self.camera_path)

    def with_up(self, up_world: Iterable[float] | None) -> Self:
        """Set what is up as somebody said, rounded to 1e-6; None where nobody knows."""
        up = None if up_world is None else tuple(round(float(v), 6) + 0.0 for v in up_world)
        return self.changed({"up_world": up, "up_from": (), "up_sigma_rad": None})

    def with_up_seen(self, frame: int, up_camera: ArrayLike) -> Self:
        """Set what is up as somebody said who saw it at a frame."""
        return self.with_up(self.film_camera.direction_to_world(frame, up_camera).tolist())

    def with_up_found(self, up_estimate: UpEstimate) -> Self:
        """Set what is up as it was found, in the frame of the world."""
        return self.with_up(up_estimate.up.tolist()).changed(
            {"up_from": up_estimate.sources, "up_sigma_rad": round(up_estimate.sigma_rad, 6)}
        )

    def with_up_chosen(self, chosen: UpEstimate) -> Self:
        """Set what is up as a person chose it of what was found: it stays as that."""
        estimated = self.with_up_found(chosen)
        return estimated.changed({"up_from": (*chosen.sources, "set")})

    @property
    def has_up_of_hand(self) -> bool:
        """Whether somebody said what is up, or chose it of what was found."""
        world = self.world
        return world.up_world is not None and (not world.up_from or "set" in world.up_from)

    @property
    def spans(self) -> tuple[tuple[int, int], ...]:
        """First and last frame of every segment: between two keyframes, and of surfaces also
        before the first and after the last."""
        return self.evidence.spans([keyframe.frame for keyframe in self.subject.keyframes])

    @property
    def model_keyframe(self) -> Keyframe | None:
        """The keyframe whose mesh moves with the body; None without surfaces or keyframes."""
        return self.evidence.model_keyframe(self.subject.keyframes)

    @property
    def is_newer(self) -> bool:
        """Whether a newer Keypose wrote it: it can then be viewed but not changed."""
        return self.schema_version > PRESENT

    @model_validator(mode="before")
    @classmethod
    def _is_of_usable_size(cls, data: Any) -> Any:
        return few(data)

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if self.posed_body not in {None, *(body.id for body in self.bodies)}:
            raise ValueError(f"posed_body: there is no body of the id {self.posed_body!r}")
        for subject in self.bodies:
            require_fit(self, subject, subject.posed)
        return self


def _keypoints_in(view: View) -> ViewKeypoints:
    return ViewKeypoints.model_construct(
        keypoints=view.keypoints, keypoint_corrections=view.keypoint_corrections
    )


SUBJECT_FIELDS = tuple(name for name in TrackedBody.model_fields if name != "id")
Part: TypeAlias = Literal["view", "subject", "world", "session"]
OWNERS: Mapping[Part, type[Plain]] = {
    "view": View,
    "subject": TrackedBody,
    "world": World,
    "session": Session,
}
_FIELDS_OF: Mapping[Part, tuple[str, ...]] = {
    "view": tuple(name for name in View.model_fields if name != "id"),
    "subject": SUBJECT_FIELDS,
    "world": tuple(World.model_fields),
    "session": tuple(n for n in Session.model_fields if n not in ("views", "bodies", "world")),
}
PART_OF: Mapping[str, Part] = {name: part for part, names in _FIELDS_OF.items() for name in names}
"""Of what each field is; no two have one name."""


def by_part(fields: Mapping[str, Any]) -> dict[Part, dict[str, Any]]:
    """Sort fields by what they are of; KeyError for one that nothing has."""
    parts: dict[Part, dict[str, Any]] = {part: {} for part in _FIELDS_OF}
    for name, value in fields.items():
        parts[PART_OF[name]][name] = value
    return parts


def _owner(session: Session, part: Part) -> Plain:
    owners: dict[Part, Plain] = {
        "view": session.view,
        "subject": session.subject,
        "world": session.world,
    }
    return owners.get(part, session)
