"""Draw observed surfaces in the colours that are chosen, over the body that stands in them.

It is the nearest layer of the surface, as on the page: where that lies before the body, the body
shines through it; where the body comes out, it is bare.
"""

from __future__ import annotations

import threading
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.app.orders.drawing import Tint
from keypose.app.render.painting import FINE, Form, box_of
from keypose.app.render.palette import INK, Canvas, Picture
from keypose.app.render.tints import Colours, clay, colours_for_tint
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.raster import raster
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import SurfaceError, VideoError
from keypose.tracker.geometry.rotations import Array, apply_transform
from keypose.tracker.geometry.view import ViewCamera
from keypose.tracker.session.evidence import surface_of
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.evidence import surfaces_of
from keypose.tracker.surface.mesh import SurfaceMesh
from keypose.tracker.surface.painting import Colours as SurfaceColours
from keypose.tracker.surface.painting import Layer, layer
from keypose.tracker.video import Video

if TYPE_CHECKING:
    from keypose.tracker.surface.fit.model import SurfaceModel
    from keypose.tracker.surface.picture import SurfaceVideo
    from keypose.tracker.surface.source import SurfaceSteps


Depth: TypeAlias = NDArray[np.float32]

OPACITY = 0.42
"""Over the body, as on the page …"""
OPACITY_OVER_PAPER = 0.75
"""… and where nothing stands in it: on the page that is dark, and clay is as bright as paper."""
RIM = 0.35
"""Strength of the line around it."""


@dataclass(frozen=True, eq=False)
class SurfaceLayer:
    """A step's surface (camera frame, metres) and the colours (V, 3) of its vertices."""

    mesh: SurfaceMesh
    colours: SurfaceColours


def draw_surface(
    picture: Picture,
    view: ViewCamera,
    surface: SurfaceLayer,
    form: Form,
    Ts_camera_part: Array | None,
) -> Picture:
    """The surface over a picture of the view's size that shows the body solid, or None."""
    result = picture.copy()
    left, top, right, bottom = box_of(
        apply_transform(view.T_view_camera, surface.mesh.vertices), view
    )
    if right <= left or bottom <= top:
        return result
    width, height = right - left, bottom - top
    fine = view.cropped(left, top, width, height).resized(FINE * width, FINE * height)
    surface_layer = layer(surface.mesh, fine, surface.colours)
    below = picture[top:bottom, left:right].astype(np.float32)
    canvas = below.repeat(FINE, axis=0).repeat(FINE, axis=1)
    _lay(canvas, surface_layer, _body_depth(form, Ts_camera_part, fine))
    small = cv2.resize(canvas, (width, height), interpolation=cv2.INTER_AREA)
    result[top:bottom, left:right] = np.clip(np.rint(small), 0, 255)
    return result


def _body_depth(form: Form, Ts_camera_part: Array | None, view: ViewCamera) -> Depth:
    if Ts_camera_part is None:
        return np.full((view.height, view.width), np.inf, dtype=np.float32)
    return raster(form.mesh, Ts_camera_part, view).depth


def _lay(canvas: Canvas, surface_layer: Layer, body: Depth) -> None:
    """The layer over a canvas in place, where it lies before the body; its rim is a fine line."""
    there = np.isfinite(surface_layer.depth)
    shown = there & (surface_layer.depth <= body)
    share = np.where(np.isfinite(body), OPACITY, OPACITY_OVER_PAPER)[shown].astype(np.float32)
    canvas[shown] += share[:, None] * (surface_layer.rgb[shown] - canvas[shown])
    inner = cv2.erode(there.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    rim = shown & ~inner
    canvas[rim] += np.float32(RIM) * (np.array(INK, dtype=np.float32) - canvas[rim])


MODEL_POINTS = 3000
"""So many points of the moving surface give the observed one its colours."""


class SurfaceLayers:
    """What is seen of a session's surfaces; threads may share it."""

    def __init__(self, session: Session, video: SurfaceVideo, tint: Tint) -> None:
        self._session, self._video, self._tint = session, video, tint
        self._lock = threading.Lock()
        self._model: SurfaceModel | None = None

    @classmethod
    def of(cls, session: Session, video: Video | None, tint: Tint = "clay") -> SurfaceLayers | None:
        """None where the session has no surfaces, such as of a film, or they are not at hand."""
        if video is None or not session.evidence.has_surface:
            return None
        return cls(session, surfaces_of(video), tint)

    @property
    def is_clay(self) -> bool:
        """Whether its picture by the camera is the video's own."""
        return self._tint == "clay"

    def at(self, frame: int, pose: Pose | None) -> SurfaceLayer | None:
        """A step's surface with the body at this pose; None where the step cannot be used.

        VideoError where the meshes have been closed, SurfaceError where the colours need what
        cannot be used, such as images or the surface that moves.
        """
        steps = self._video.steps
        try:
            mesh = steps.shape(frame)
        except SurfaceError as error:
            if self._video.is_closed:
                raise VideoError(str(error)) from None
            return None
        if self._tint == "photo":
            mesh = steps.mesh(frame)
            if mesh.consistency is None:
                raise SurfaceError(
                    f"It is not known how well cameras agree on the surface of frame {frame}: name "
                    "their file with `keypose fit --cameras FILE`, or choose another colouring."
                )
        return SurfaceLayer(mesh, colours_of(mesh, self._tint, pose, self._model_where_needed()))

    def picture(self, frame: int, pose: Pose | None) -> Picture | None:
        """The same as the session's camera sees it; None as above."""
        from keypose.tracker.surface.painting import paint

        surface = self.at(frame, pose)
        if surface is None:
            return None
        return paint(surface.mesh, self._session.view.camera.without_distortion(), surface.colours)

    def _model_where_needed(self) -> SurfaceModel | None:
        """Made once, of the surface that moves with the body."""
        if self._tint not in ("contact", "distance"):
            return None
        with self._lock:
            if self._model is None:
                self._model = model_of(self._session, self._video.steps)
            return self._model


def colours_of(
    mesh: SurfaceMesh, tint: Tint, pose: Pose | None, model: SurfaceModel | None
) -> Colours:
    """The colours (V, 3) of a step's surface, the body at a pose; clay where nothing is known."""
    if tint == "photo" and mesh.consistency is not None:
        from keypose.tracker.surface.fit.pairing import photo_weights

        return colours_for_tint(tint, photo_weights(mesh.consistency))
    if tint in ("contact", "distance") and model is not None and pose is not None:
        # loads when surfaces are looked at
        from keypose.tracker.surface.fit.pairing import vertex_scalars

        return colours_for_tint(tint, vertex_scalars(model, mesh, pose, tint))
    return clay(len(mesh.vertices))


def model_of(session: Session, steps: SurfaceSteps) -> SurfaceModel | None:
    """The surface that moves with the body; None without a pose. SurfaceError where
    its step cannot be used."""
    keyframe = session.model_keyframe
    if keyframe is None:
        return None
    from keypose.tracker.surface.fit.model import SurfaceModel  # loads when surfaces are looked at

    mesh = steps.shape(keyframe.frame)
    pose = keyframe.pose(Skeleton.of(session.subject.body))
    smooth = surface_of(session).binding == "smooth"
    return SurfaceModel.of(mesh, session.subject.body, pose, MODEL_POINTS, smooth)
