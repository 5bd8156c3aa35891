"""What the page receives: the state cut into sections, each made anew only when it changed.

A section is a JSON value under a name. `Sections.changed` compares what each one is made of with
what it was made of last, so that a drag sends the pose and nothing else.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from keypose.app.editor.documents import unchanged
from keypose.app.editor.live import moved_spans
from keypose.app.state.app_state import AppState
from keypose.app.store.sections import (
    angle_values,
    body_values,
    bond_values,
    camera_values,
    evidence_values,
    film_values,
    motion_values,
    scene_bodies,
    scene_values,
    space_values,
    work_values,
)
from keypose.app.store.sections.json_value import Json
from keypose.tracker.session.schema import Session


@dataclass(frozen=True)
class _Section:
    """How a section is made, and of what in the state."""

    made_of: Callable[[AppState], tuple[Any, ...]]
    make: Callable[[AppState], Json]


def _field(doc: Session | None, name: str) -> Any:
    return None if doc is None else doc.value(name)


def _doc(*names: str) -> Callable[[AppState], tuple[Any, ...]]:
    def parts(app_state: AppState) -> tuple[Any, ...]:
        doc = app_state.edit.doc if app_state.edit else None
        return (doc is None, *(_field(doc, name) for name in names))

    return parts


def _other_films(doc: Session | None) -> tuple[Any, ...]:
    return () if doc is None else doc.views[1:]


def _posed(app_state: AppState) -> tuple[Any, ...]:
    """Which body is posed."""
    return () if app_state.edit is None else (app_state.edit.doc.subject.id,)


def _bonds(app_state: AppState) -> tuple[Any, ...]:
    """The bonds, as a gesture under way has them."""
    return () if app_state.edit is None else app_state.edit.doc.bonds


def _bodies(app_state: AppState) -> tuple[Any, ...]:
    """The bodies that are not posed, and which one is."""
    doc = app_state.edit.settled if app_state.edit else None
    if doc is None:
        return (None,)
    posed = doc.subject
    return (posed.id, posed.called, *(body for body in doc.bodies if body is not posed))


def _held(app_state: AppState) -> tuple[Any, ...]:
    """The bodies that are not posed, which bonds move during a gesture."""
    doc = app_state.edit.doc if app_state.edit else None
    if doc is None or not doc.bonds:
        return ()
    return tuple(body for body in doc.bodies if body.id != doc.subject.id)


def _settled(*names: str) -> Callable[[AppState], tuple[Any, ...]]:
    """Depend on the document as _doc, but not on a gesture under way: remade when it ends."""

    def parts(app_state: AppState) -> tuple[Any, ...]:
        doc = app_state.edit.settled if app_state.edit else None
        return (doc is None, *(_field(doc, name) for name in names))

    return parts


def _edit(*names: str) -> Callable[[AppState], tuple[Any, ...]]:
    def parts(app_state: AppState) -> tuple[Any, ...]:
        edit = app_state.edit
        return (edit is None, *(getattr(edit, name, None) for name in names))

    return parts


def _both(*makers: Callable[[AppState], tuple[Any, ...]]) -> Callable[[AppState], tuple[Any, ...]]:
    return lambda app_state: tuple(part for maker in makers for part in maker(app_state))


_POSES = _doc("body", "keyframes", "part_keyframes", "drafts")


def _curve_poses(app_state: AppState) -> tuple[Any, ...]:
    """A drag moves its point of the curve at once, but not where the curve is long to draw."""
    long = app_state.edit is not None and app_state.edit.frame_count > LONG_CURVE
    return (_settled if long else _doc)("body", "keyframes", "drafts")(app_state)


def _in_hand(app_state: AppState) -> tuple[Any, ...]:
    """What the motion that follows a gesture is made of."""
    edit = app_state.edit
    if edit is None or not moved_spans(edit):
        return ()
    return edit.doc.subject.keyframes, edit.motion.previews


def _before_camera(app_state: AppState) -> tuple[Any, ...]:
    """What of a camera that moves is seen otherwise at another frame."""
    edit = app_state.edit
    path = None if edit is None else edit.doc.camera_path
    return (path, None if path is None or edit is None else edit.frame)


LONG_CURVE = 1500
"""Frames of a curve that is not made anew with every move of the pointer."""

_TRACKED = _both(
    _settled(
        *("body", "camera", "lens_source", "keyframes", "ignore_masks", "settings", "keypoints"),
        *("part_keyframes", "keypoint_corrections", "surface", "pins", "floor_m", "up_world"),
        *("reviewed", "video", "camera_motion", "camera_keyframes"),
    ),
    _edit("results"),
    lambda o: _other_films(o.edit.settled if o.edit else None),
)


def _tinted(app_state: AppState) -> tuple[Any, ...]:
    """What the pictures of observed surfaces are coloured by."""
    edit = app_state.edit
    if edit is None or not edit.doc.evidence.has_surface:
        return ()
    if edit.display.tint not in ("contact", "distance"):
        return (edit.settled.view.surface, edit.display.tint)
    doc = edit.settled
    poses = (doc.subject.body, doc.subject.keyframes, doc.subject.drafts, edit.results)
    return (doc.view.surface, edit.display.tint, *poses)


SECTIONS: dict[str, _Section] = {
    "file": _Section(
        _both(_doc("surface", "title", "video"), lambda o: (o.opened,)), scene_values.file
    ),
    "damage": _Section(lambda o: (o.opened,), scene_values.damage),
    "camera": _Section(
        _both(
            _doc(
                "camera",
                "up_world",
                "up_from",
                "up_sigma_rad",
                "lens_source",
                "video",
                "drafted",
                "drafts",
                "keyframes",
            ),
            _edit("results"),
            _before_camera,
            lambda o: (o.opened,),
            _tinted,
        ),
        scene_values.camera,
    ),
    "films": _Section(
        _both(
            _edit("frame"),
            _before_camera,
            lambda o: _other_films(o.edit.doc if o.edit else None),
        ),
        film_values.films,
    ),
    "films_seen": _Section(
        _both(_TRACKED, _settled("drafts"), _edit("selected"), lambda o: (o.keypoints,)),
        film_values.films_seen,
    ),
    "surface": _Section(
        _both(_doc("surface", "keyframes"), _edit("frame"), lambda o: (o.surface, o.unusable)),
        evidence_values.surface,
    ),
    "camera_motion": _Section(
        _doc("camera_motion", "camera_keyframes", "settings", "video"),
        camera_values.camera_motion,
    ),
    "camera_here": _Section(_before_camera, camera_values.camera_here),
    "background": _Section(
        _both(_doc("camera_motion", "camera"), _edit("frame", "display")),
        camera_values.background_points,
    ),
    "views": _Section(_both(_doc("up_world"), _before_camera), scene_values.small_view_rotations),
    "body": _Section(_doc("body"), body_values.body),
    "view": _Section(_both(_edit("frame", "selected", "display"), _posed), scene_values.view),
    "pose": _Section(_both(_POSES, _TRACKED, _edit("frame", "stroke")), body_values.pose),
    "keys": _Section(_both(_POSES, _TRACKED), body_values.keys),
    "segments": _Section(_both(_TRACKED, lambda o: (o.running,)), motion_values.segments),
    "errors": _Section(_TRACKED, motion_values.errors),
    "review": _Section(_both(_TRACKED, _settled("drafts", "drafted")), motion_values.review),
    "space": _Section(_TRACKED, space_values.space),
    "suggest": _Section(_both(_TRACKED, _settled("ahead"), _edit("frame")), motion_values.suggest),
    "need": _Section(_TRACKED, motion_values.need),
    "lanes": _Section(_TRACKED, motion_values.lanes),
    "curve": _Section(_both(_TRACKED, _curve_poses, _edit("selected")), body_values.curve),
    "joint_angle": _Section(
        _both(
            _TRACKED,
            _curve_poses,
            lambda o: (o.edit and (o.edit.display.joint, o.edit.display.angle),),
        ),
        angle_values.joint_angle,
    ),
    "trail": _Section(
        _both(_TRACKED, _settled("drafts"), _edit("selected", "frame", "display"), _in_hand),
        body_values.trail,
    ),
    "pins": _Section(
        _both(_TRACKED, _settled("drafts"), _doc("body", "pins")),
        space_values.pins,
    ),
    "proposed_pins": _Section(
        _both(_TRACKED, _doc("pins"), _edit("proposed_pins", "dismissed_pins")),
        space_values.proposed_pins,
    ),
    "still": _Section(_both(_TRACKED, _settled("pins")), space_values.still),
    "floor": _Section(_both(_TRACKED, _doc("pins", "floor_m")), space_values.floor),
    "feet": _Section(
        _both(_TRACKED, _settled("drafts", "up_world"), _edit("opening")), space_values.feet
    ),
    "ghosts": _Section(
        _both(
            _settled("body", "keyframes"),
            _doc("body"),
            _edit("frame", "display", "results"),
            _before_camera,
        ),
        space_values.ghosts,
    ),
    "solids": _Section(_doc("body"), space_values.solids),
    "bodies": _Section(
        _both(_TRACKED, _bodies, _settled("drafts", "drafted")), scene_bodies.bodies
    ),
    "bonds": _Section(_both(_TRACKED, _bodies, _bonds), bond_values.bonds),
    "solids_beside": _Section(_bodies, scene_bodies.solids_beside),
    "poses_beside": _Section(
        _both(_bodies, _held, _TRACKED, _edit("frame")), scene_bodies.poses_beside
    ),
    "before": _Section(_edit("compared", "frame", "results"), space_values.before),
    "masks": _Section(_doc("ignore_masks"), work_values.masks),
    "settings": _Section(_doc("settings", "first_motion"), work_values.settings),
    "cues": _Section(_doc("settings", "body", "video"), evidence_values.cues),
    "networks": _Section(
        _both(_doc("settings", "video", "camera_motion"), evidence_values.networks_here),
        evidence_values.networks,
    ),
    "keypoints": _Section(
        _both(
            _doc("keypoint_corrections", "body", "camera", "surface"),
            _edit("frame"),
            lambda o: (o.keypoints,),
        ),
        evidence_values.keypoints,
    ),
    "fit": _Section(lambda o: (o.fit,), work_values.fit),
    "up": _Section(lambda o: (o.up,), scene_values.found_up),
    "sizes_preview": _Section(
        _both(lambda o: (o.preview,), _edit("results")), work_values.sizes_preview
    ),
    "reduction": _Section(
        _both(lambda o: (o.reduction,), _doc("keyframes", "part_keyframes")),
        work_values.reduction,
    ),
    "people": _Section(_both(_edit("frame"), lambda o: (o.people,)), work_values.people),
    "draft": _Section(
        _both(
            _doc("body", "camera", "drafts", "keyframes", "drafted", "reviewed"),
            _TRACKED,
            lambda o: (work_values.is_latest_draft(o),),
        ),
        work_values.draft,
    ),
    "job": _Section(lambda o: (o.job,), motion_values.job),
    "saved": _Section(lambda o: (o.saved,), work_values.saved),
    "undo": _Section(_edit("history", "stroke"), work_values.undo),
    "history": _Section(_edit("history"), work_values.history),
    "notes": _Section(_doc("notes"), work_values.notes),
    "clipboard": _Section(_edit("clipboard"), work_values.clipboard),
    "poses": _Section(_both(_doc("body"), lambda o: (o.poses,)), body_values.poses),
    "guide": _Section(lambda o: (o.guide,), work_values.guide),
    "tabs": _Section(lambda o: (o.tabs,), lambda o: o.tabs),
    "server": _Section(lambda o: (o.server,), lambda o: o.server),
    "revision": _Section(lambda o: (o.revision,), lambda o: o.revision),
}


PLACES: Mapping[str, str] = {
    **dict.fromkeys(("file", "camera", "up"), "the camera"),
    **dict.fromkeys(("camera_motion", "camera_here", "background"), "the camera"),
    **dict.fromkeys(("body", "bodies", "solids", "before", "sizes_preview"), "the body"),
    **dict.fromkeys(("view", "views", "pose", "trail", "ghosts", "surface"), "the views"),
    **dict.fromkeys(
        ("people", "films", "films_seen", "solids_beside", "poses_beside"), "the views"
    ),
    **dict.fromkeys(
        (
            "keys",
            "segments",
            "errors",
            "suggest",
            "need",
            "lanes",
            "curve",
            "joint_angle",
            "damage",
        ),
        "the timeline",
    ),
    **dict.fromkeys(
        ("pins", "bonds", "proposed_pins", "still", "floor", "feet", "space"), "the floor"
    ),
    **dict.fromkeys(("masks", "cues", "networks", "keypoints", "settings"), "the settings"),
    **dict.fromkeys(("review",), "the review"),
    **dict.fromkeys(("fit", "reduction", "draft", "job"), "the progress of the work"),
    **dict.fromkeys(("undo", "history", "notes", "clipboard", "poses", "guide"), "the history"),
    **dict.fromkeys(("saved", "tabs", "server", "revision"), "the status"),
}
"""Where a section is seen, as a person calls it."""


class Sections:
    """Remembers what was made, of what, and what could not be made."""

    def __init__(self) -> None:
        self._made_of: dict[str, tuple[Any, ...]] = {}
        self._made: dict[str, Json] = {}
        self._failed: dict[str, Exception] = {}

    def changed(self, app_state: AppState) -> dict[str, Json]:
        """The sections that differ from those of the last call. One that cannot be made stays as it
        was, until what it is made of changes; `failed` has why."""
        fresh: dict[str, Json] = {}
        for name, section in SECTIONS.items():
            try:
                parts = section.made_of(app_state)
                if unchanged(self._made_of.get(name), parts):
                    continue
                self._made_of[name] = parts
                made = section.make(app_state)
            except Exception as error:  # noqa: BLE001 — the others are sent; the store says it
                self._failed[name] = error
                continue
            self._failed.pop(name, None)
            if name not in self._made or made != self._made[name]:
                self._made[name] = fresh[name] = made
        return fresh

    @property
    def all(self) -> Mapping[str, Json]:
        """Every section as made last: what a tab that has just joined is sent."""
        return self._made

    @property
    def failed(self) -> Mapping[str, Exception]:
        """The sections that could not be made as the state is now, and why."""
        return self._failed
