"""The observed surfaces of a session in the colours that are chosen, as pictures show them."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING

from keypose.app.render.palette import Picture
from keypose.app.render.surface_layer import SurfaceLayer
from keypose.app.render.tints import Colours, Tint, clay, tinted
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import SurfaceError, VideoError
from keypose.tracker.session.evidence import surface_of
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.evidence import surfaces_of
from keypose.tracker.surface.mesh import SurfaceMesh
from keypose.tracker.video import Video

if TYPE_CHECKING:
    from keypose.tracker.surface.fit.model import SurfaceModel
    from keypose.tracker.surface.picture import SurfaceVideo
    from keypose.tracker.surface.source import SurfaceSteps

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
        return paint(surface.mesh, self._session.camera.without_distortion(), surface.colours)

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
        from keypose.tracker.surface.fit.weights import photo_weights

        return tinted(tint, photo_weights(mesh.consistency))
    if tint in ("contact", "distance") and model is not None and pose is not None:
        # loads when surfaces are looked at
        from keypose.tracker.surface.fit.vertex_scalars import vertex_scalars

        return tinted(tint, vertex_scalars(model, mesh, pose, tint))
    return clay(len(mesh.vertices))


def model_of(session: Session, steps: SurfaceSteps) -> SurfaceModel | None:
    """The surface that moves with the body; None without a pose. SurfaceError where
    its step cannot be used."""
    keyframe = session.model_keyframe
    if keyframe is None:
        return None
    from keypose.tracker.surface.fit.model import SurfaceModel  # loads when surfaces are looked at

    mesh = steps.shape(keyframe.frame)
    pose = keyframe.pose(Skeleton.of(session.body))
    smooth = surface_of(session).binding == "smooth"
    return SurfaceModel.of(mesh, session.body, pose, MODEL_POINTS, smooth)
