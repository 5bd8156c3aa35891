"""Edit the camera and how a film was taken: lens, distortion, up, rate."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, FiniteFloat

from keypose.app.editor.documents import ActionRefused, seen_as_before, valid, with_times
from keypose.app.editor.message import Edit
from keypose.app.editor.state import EditorState
from keypose.app.posing import CAMERA_UP, up_from_vertical
from keypose.app.posing.gesture import Spot
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.geometry.up import UpEvidence, UpSource, up_of_one
from keypose.tracker.session.references import FramesPerSecond
from keypose.tracker.session.schema import Session
from keypose.tracker.session.settings import Position
from keypose.tracker.session.views import LensSource
from keypose.tracker.video.upright_lines import up_from_segments

STRAIGHT = (0.0, 0.0, 0.0, 0.0, 0.0)
BENT = (-0.316, 0.127, 0.0, 0.0, -0.026)
"""Of a lens that spreads angles evenly over the picture (r = f θ), as action cameras do: the fit of
θ / tan θ up to 52° off the axis, to 0.0014."""
LEAST_LENGTH = 1e-6
"""A shorter vector has no direction."""
SHORTEST_PX = 5
"""A line drawn to show what is up is at least this long."""


class ReadFilm(Edit):
    """How a film was taken. Fields that are left out stay; `recorded_fps` may be null, as its file
    says."""

    do: Literal["read_film"] = "read_film"
    verb = "change how the film was taken"
    recorded_fps: FramesPerSecond | None = None
    deinterlace: bool | None = None

    def apply(self, state: EditorState) -> Session:
        named = self.model_dump(include=self.model_fields_set & {"recorded_fps", "deinterlace"})
        return as_taken(state.doc, named, state.file_times_s)


class Intrinsics(Edit):
    """Focal lengths, of the present frame, and principal point."""

    do: Literal["camera"] = "camera"
    verb = "change the camera"
    fx: FiniteFloat | None = None
    fy: FiniteFloat | None = None
    cx: FiniteFloat | None = None
    cy: FiniteFloat | None = None

    def apply(self, state: EditorState) -> Session:
        changes = self.model_dump(include={"fx", "fy", "cx", "cy"}, exclude_none=True)
        zoom = state.doc.film_camera.zoom_at(state.frame)
        changes |= {name: changes[name] / zoom for name in ("fx", "fy") if name in changes}
        doc = _with_camera(state, {**changes, "origin": "intrinsics"})
        return doc.changed({"lens_source": "calibration"})


class FieldOfView(Edit):
    """A lens whose longer side spans this angle at the present frame; the distortion stays."""

    do: Literal["field_of_view"] = "field_of_view"
    verb = "change the field of view"
    deg: Annotated[FiniteFloat, Field(ge=1, le=170)]

    def apply(self, state: EditorState) -> Session:
        old = state.doc.view.camera
        new = Camera.from_field_of_view(old.width, old.height, math.radians(self.deg))
        new = _without_zoom(state, new)
        return _with_lens(state, new.model_copy(update={"distortion": old.distortion}), "person")


class Lens(Edit):
    """The lens that shows as much on 35 mm film, and who says so; without `mm` a guess. What a
    person says is of the present frame.

    bent: whether it bends straight edges, as an action camera's does; left out, as before.
    """

    do: Literal["lens"] = "lens"
    verb = "change the lens"
    mm: Annotated[FiniteFloat, Field(ge=4, le=2000)] | None = None
    known: Literal["person", "file", "guess"] = "person"
    bent: bool | None = None

    def apply(self, state: EditorState) -> Session:
        if self.mm is None:
            camera = Camera.guess(state.doc.view.camera.width, state.doc.view.camera.height)
        else:
            camera = Camera.from_focal_length(
                state.doc.view.camera.width, state.doc.view.camera.height, self.mm
            )
        bent = {True: BENT, False: STRAIGHT, None: state.doc.view.camera.distortion}[self.bent]
        source = "guess" if self.mm is None else self.known
        if source == "person":
            camera = _without_zoom(state, camera)
        return _with_lens(state, camera.model_copy(update={"distortion": bent}), source)


class Distortion(Edit):
    do: Literal["distortion"] = "distortion"
    verb = "change the distortion"
    k1: FiniteFloat | None = None
    k2: FiniteFloat | None = None
    p1: FiniteFloat | None = None
    p2: FiniteFloat | None = None
    k3: FiniteFloat | None = None

    def apply(self, state: EditorState) -> Session:
        wanted = (self.k1, self.k2, self.p1, self.p2, self.k3)
        old = state.doc.view.camera.distortion
        values = tuple(a if b is None else b for a, b in zip(old, wanted, strict=True))
        return _with_camera(state, {"distortion": values})


class Vertical(Edit):
    """A line drawn on the picture along something upright, in pixels: it shows the roll. other: a
    second one, which shows the tilt as well."""

    do: Literal["vertical"] = "vertical"
    verb = "change the up direction"
    a: Spot
    b: Spot
    other: tuple[Spot, Spot] | None = None

    def apply(self, state: EditorState) -> Session:
        if any(math.dist(*line) < SHORTEST_PX for line in ((self.a, self.b), self.other) if line):
            raise ActionRefused("Draw a longer line along something upright.")
        if self.other is not None:
            up = self._up_of_both(state, self.other)
            return state.doc.with_up_seen(state.frame, up)
        up = up_from_vertical(state.camera, self.a, self.b)
        if not np.isfinite(up).all():
            raise ActionRefused(
                "The lens shows nothing at one end of this line. Draw it nearer the centre."
            )
        return state.doc.with_up_seen(state.frame, up)

    def _up_of_both(self, state: EditorState, second_line: tuple[Spot, Spot]) -> Array:
        if _crosses((self.a, self.b), second_line):
            raise ActionRefused(
                "These lines cross in the picture: they are not both upright. Draw them along two "
                "walls, doors or poles."
            )
        up = up_from_segments(np.array([(self.a, self.b), second_line]), state.camera)
        if up is None:
            raise ActionRefused(
                "These lines do not say what is up. Draw them along two upright things that are "
                "farther apart."
            )
        return up


class LevelCamera(Edit):
    """The camera is held level: up is the picture's own."""

    do: Literal["level_camera"] = "level_camera"
    verb = "set the camera level"

    def apply(self, state: EditorState) -> Session:
        return state.doc.with_up_seen(state.frame, CAMERA_UP)


class TakeUp(Edit):
    """Up as one of the sources that were looked at shows it, in the world, and how sure that is."""

    do: Literal["take_up"] = "take_up"
    verb = "change the up direction"
    up: Position
    sigma_deg: Annotated[FiniteFloat, Field(gt=0, le=180)]
    source: UpSource

    def apply(self, state: EditorState) -> Session:
        length = math.hypot(*self.up)
        if length < LEAST_LENGTH:
            raise ActionRefused("This is no direction.")
        up = np.array(self.up) / length
        evidence = UpEvidence.of(up, math.radians(self.sigma_deg), self.source)
        return state.doc.with_up_chosen(up_of_one(evidence))


class ResetUp(Edit):
    """The camera's own up again."""

    do: Literal["reset_up"] = "reset_up"
    verb = "reset the up direction"

    def apply(self, state: EditorState) -> Session:
        return state.doc.with_up(None)


MESSAGES = (
    ReadFilm,
    Intrinsics,
    FieldOfView,
    Lens,
    Distortion,
    Vertical,
    LevelCamera,
    TakeUp,
    ResetUp,
)


def _crosses(first_line: tuple[Spot, Spot], second_line: tuple[Spot, Spot]) -> bool:
    """Whether two lines cross between their ends."""

    def side(line: tuple[Spot, Spot], p: Spot) -> float:
        (ax, ay), (bx, by) = line
        return (bx - ax) * (p[1] - ay) - (by - ay) * (p[0] - ax)

    return all(
        side(a, b[0]) * side(a, b[1]) < 0
        for a, b in ((first_line, second_line), (second_line, first_line))
    )


def as_taken(doc: Session, named: Mapping[str, Any], file_times_s: Array | None = None) -> Session:
    """The session of a film that was taken so; poses keep to their frames. Refused of surfaces.

    file_times_s: not needed where a rate is named.
    """
    if doc.view.surface is not None:
        raise ActionRefused(
            "This session has surfaces, not a video: it has no recording rate or fields."
        )
    doc = doc.changed({"video": doc.view.video.model_copy(update=dict(named))})
    if "recorded_fps" not in named:
        return doc
    return with_times(doc, doc.evidence.times_s(file_times_s))


def _without_zoom(state: EditorState, camera: Camera) -> Camera:
    """The camera whose lens is this one at the present frame."""
    zoom = state.doc.film_camera.zoom_at(state.frame)
    return camera.zoomed(1 / zoom)


def _with_lens(state: EditorState, lens: Camera, source: LensSource) -> Session:
    """Change the lens. What was posed keeps its place in the picture: a longer lens shows it as
    large as before from farther away.
    """
    names = ("fx", "fy", "cx", "cy", "distortion", "origin")
    changes = {name: getattr(lens, name) for name in names}
    doc = _with_camera(state, changes).changed({"lens_source": source})
    return seen_as_before(state.doc, doc)


def _with_camera(state: EditorState, changes: dict[str, Any]) -> Session:
    camera = valid(Camera, {**state.doc.view.camera.model_dump(), **changes})
    return state.doc.changed({"camera": camera})
