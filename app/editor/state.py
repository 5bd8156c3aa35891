"""Everything the page shows that a person decided, in one immutable value."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from keypose.app.editor.copied import Copied
from keypose.app.editor.documents import require_sound
from keypose.app.editor.frames import first_pose
from keypose.app.editor.known import KnownMotion
from keypose.app.editor.outdated import up_to_date
from keypose.app.posing import PlacedCorner, Readout
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import displaced
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.history import History
from keypose.tracker.session.pins import Pin, pins_apart
from keypose.tracker.session.references import Repeats
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.by_id import ById
from keypose.tracker.storage.results import Fitting, Results, pose_at
from keypose.tracker.storage.sidecars import OwnMotion

if TYPE_CHECKING:
    from keypose.tracker.video.info import Timecode


@dataclass(frozen=True)
class Display:
    """How the views are drawn, and how gestures act; shared by all tabs, not part of the document.

    live: whether segments are tracked while a keyframe beside them is moved.  limits: whether
    joints stop at their limits.  axes: about which a part is turned and along which it is moved.
    link: whether a size of one side is changed on the other, too.  tint: what the colours of an
    observed surface show.
    """

    mode: Literal["wire", "solid", "both"] = "both"
    opacity: float = 0.5
    ghosts: bool = False
    trail: bool = True
    floor: bool = False
    background: bool = False
    """Whether the points of the background are shown, by which the camera's motion was found."""
    live: bool = False
    limits: bool = True
    axes: Literal["part", "parent", "view"] = "part"
    link: bool = True
    tint: Literal["clay", "contact", "photo", "distance"] = "clay"
    joint: str | None = None
    """The joint whose angle is charted: "knee"."""
    angle: str = ""
    """Which of its angles, by its name; empty for the first."""


@dataclass(frozen=True, eq=False)
class Stroke:
    """A gesture under way: the document before it, and what it does at the moment."""

    name: str
    before: Session
    label: str
    frame: int
    readout: Readout | None = None


@dataclass(frozen=True, eq=False)
class PosedByCorners:
    """The pose of a frame, seen by a camera, that some corners led to."""

    frame: int
    pose: Pose
    camera: Camera
    corners: tuple[PlacedCorner, ...]


@dataclass(frozen=True, eq=False)
class EditorState:
    """doc: the session as it stands, results left out.  file_times_s: (frames,) seconds as the
    video's file has them.  timecode: the video's.

    skeleton always is the layout of doc.body; `opening` is where a body first stands.  over: names
    of the gestures that ended lately, whose late moves count no more.  compared: a document whose
    body is shown beside this one's, as an outline.  proposed_pins: what was proposed when the
    pins changed last, until it is known anew; dismissed_pins: what was refused of it.  own_motion:
    the motion from before it was reduced to keyframes.  posed_by_corners: poses of boxes whose
    corners were put in their places, the latest last.
    """

    doc: Session
    skeleton: Skeleton
    file_times_s: Array
    opening: Pose
    motion: KnownMotion = field(default_factory=KnownMotion)
    history: History = field(default_factory=History)
    frame: int = 0
    selected: str | None = None
    display: Display = field(default_factory=Display)
    stroke: Stroke | None = None
    over: tuple[str, ...] = ()
    clipboard: Copied | None = None
    compared: Session | None = None
    proposed_pins: tuple[Pin, ...] = ()
    dismissed_pins: tuple[Pin, ...] = ()
    timecode: Timecode | None = None
    own_motion: OwnMotion | None = None
    posed_by_corners: tuple[PosedByCorners, ...] = ()

    @property
    def camera(self) -> Camera:
        """The camera as it is at the present frame."""
        return self.doc.film_camera.at(self.frame)

    @property
    def frame_count(self) -> int:
        return self.doc.view.video.frame_count

    @cached_property
    def times_s(self) -> Array:
        """(frames,) seconds in the world."""
        return self.doc.evidence.times_s(self.file_times_s)

    @property
    def keys(self) -> tuple[int, ...]:
        """Frames of the keyframes, ascending."""
        return tuple(keyframe.frame for keyframe in self.doc.subject.keyframes)

    @property
    def settled(self) -> Session:
        """The document without the gesture under way."""
        return self.doc if self.stroke is None else self.stroke.before

    @property
    def results(self) -> Results:
        """What was tracked, whichever keyframes it is of."""
        return self.motion.results

    @cached_property
    def fitting(self) -> Fitting:
        """The motion of the present segments."""
        return self.motion.fitting(self.doc)

    @property
    def finished(self) -> Fitting:
        """The motion of the present segments whose tracking has ended: what is on its way does not
        count."""
        return {span: segment for span, segment in self.fitting.items() if segment.finished}

    def tracked(self, frame: int) -> Pose | None:
        """The tracked pose at a frame."""
        return pose_at(self.fitting, frame)

    def with_results(self, results: Results) -> EditorState:
        """The same with what else was tracked by now."""
        if results is self.results:
            return self
        return replace(self, motion=replace(self.motion, results=results))

    def between(
        self, doc: Session, start: int, end: int, frames: NDArray[np.int64]
    ) -> tuple[Array, Array] | None:
        """Rotations (N, P, 3, 3) and root positions (N, 3) at frames between two neighbouring
        keyframes whose motion is not tracked: as it was before it was reduced, where it was,
        displaced to meet them; else interpolated. None where one of them is no keyframe."""
        at = {k.frame: k for k in doc.subject.keyframes if k.frame in (start, end)}
        if len(at) < 2:
            return None
        skeleton = (
            self.skeleton
            if doc.subject.body is self.doc.subject.body
            else Skeleton.of(doc.subject.body)
        )
        begin, finish = at[start].pose(skeleton), at[end].pose(skeleton)
        own = None if self.own_motion is None else self.own_motion.over(doc, start, end)
        if own is not None:
            trajectory = displaced(own, begin, finish, start, end)
            return trajectory.Rs_parent_part[frames - start], trajectory.ps_camera_root[
                frames - start
            ]
        return doc.film_camera.even_motion(begin, finish, (start, end), frames)

    def with_repeats(self, repeats: Repeats | None) -> EditorState:
        """The same with the repeated frames of the film, which are no edit; itself where they are
        known, or None."""
        if repeats is None or repeats == self.doc.view.video.repeats:
            return self

        def knowing(doc: Session) -> Session:
            video_reference = doc.view.video.model_copy(update={"repeats": repeats})
            return doc.changed({"video": video_reference})

        stroke = self.stroke and replace(self.stroke, before=knowing(self.stroke.before))
        return replace(self, doc=knowing(self.doc), stroke=stroke)

    @property
    def proposals(self) -> tuple[Pin, ...]:
        """Where feet stand still, as the motion was last solved for in space."""
        space_results = self.results.space(self.settled)
        if not space_results:
            return self.proposed_pins
        return pins_apart([pin for stretch in space_results for pin in stretch.proposed])

    def stamped(self, before: EditorState, now_s: float) -> EditorState:
        """The same with the time of the step that was made since `before`, seconds since 1970."""
        history = self.history
        if history is not before.history:
            history = history.stamped(before.history, self.settled, now_s)
        return self if history is self.history else replace(self, history=history)

    def with_proposals_anew(self) -> EditorState:
        """The same with nothing dismissed: the motion will be another one."""
        return replace(self, dismissed_pins=()) if self.dismissed_pins else self

    def with_step(self, doc: Session, label: str, frame: int | None = None) -> EditorState:
        """The same with another document as one step of undo, made at a frame, the present one
        where left out; refused where the document could not be read back."""
        require_sound(self.doc, doc, label)
        at = self.frame if frame is None else frame
        return replace(self.with_doc(doc), history=self.history.after(self.doc, label, at))

    def about(self, body_id: str) -> EditorState:
        """The same as if another of its bodies were posed: no gesture is under way."""
        if len(self.settled.bodies) == 1:
            return self
        doc, skeleton, opening = _posing(ById(self.settled), body_id)
        return replace(self._of_no_body(), doc=doc, skeleton=skeleton, opening=opening, stroke=None)

    def with_doc(self, doc: Session) -> EditorState:
        """The same with another document, but for what it makes outdated of what was tracked
        ahead; the skeleton is rebuilt only for another body."""
        doc = up_to_date(doc)
        if doc.subject.pins is not self.doc.subject.pins:
            self = replace(self, proposed_pins=self.proposals)
        is_another = doc.subject.id != self.doc.subject.id
        if is_another:
            self = replace(self._of_no_body(), opening=first_pose(doc))
        if doc.subject.body is self.doc.subject.body:
            return replace(self, doc=doc, opening=self._opening_for(doc))
        changed = replace(self, doc=doc, skeleton=Skeleton.of(doc.subject.body))
        if is_another or doc.subject.body.names == self.doc.subject.body.names:
            return changed
        return replace(changed, opening=first_pose(doc))

    def _of_no_body(self) -> EditorState:
        """The same without what is known of the body that was posed until now."""
        motion = replace(self.motion.without_previews(), bent=None)
        return replace(
            self,
            motion=motion,
            compared=None,
            proposed_pins=(),
            dismissed_pins=(),
            own_motion=None,
            posed_by_corners=(),
        )

    def _opening_for(self, doc: Session) -> Pose:
        """Where the body stands before it is posed: as large with another lens."""
        if doc.view.camera is self.doc.view.camera or doc.view.surface is not None:
            return self.opening
        return first_pose(doc)


@lru_cache(maxsize=32)
def _posing(session: ById, body_id: str) -> tuple[Session, Skeleton, Pose]:
    """Cached: asked for at every frame, of every body."""
    doc: Session = session.it.about(body_id)
    return doc, Skeleton.of(doc.subject.body), first_pose(doc)
