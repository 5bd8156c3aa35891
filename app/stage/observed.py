"""Observed surfaces as the page's views show them: a step's mesh, its colours, its picture.

Everything here takes a while and is asked for by several threads.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from app.drawing.tints import Colours, Tint, clay, tinted
from app.editor.shown import shown
from app.editor.state import EditorState
from app.opening import Workpiece
from tracker.errors import SurfaceError
from tracker.session.schema import Session
from tracker.skeleton import Skeleton
from tracker.surface.looking import look
from tracker.surface.mesh import SurfaceMesh
from tracker.surface.model import SurfaceModel
from tracker.surface.painting import GROUND
from tracker.surface.picture import SurfaceVideo, open_surfaces
from tracker.surface.weights import in_agreement
from tracker.video import MissingFrame, VideoInfo
from tracker.video.picture import Picture

MODEL_POINTS = 3000


def reading(doc: Session) -> tuple[Any, ...]:
    """What decides where the surfaces lie, and what cameras say of them."""
    surface = doc.surface
    assert surface is not None
    return (surface.units, surface.up, surface.p_camera_surface, surface.cameras, doc.camera)


@dataclass(frozen=True, eq=False)
class Sight:
    """A step's surface (camera frame, metres) and the colours (V, 3) of its vertices."""

    mesh: SurfaceMesh
    colours: Colours


class Observed:
    """The surfaces of one opened session, as its document has them read."""

    def __init__(self, piece: Workpiece) -> None:
        assert isinstance(piece.video, SurfaceVideo)
        self._piece = piece
        self._lock = threading.RLock()
        self._video, self._read_as = piece.video, reading(piece.session)
        self._model: tuple[tuple[Any, ...], SurfaceModel] | None = None
        self._rims: tuple[tuple[Any, ...], int] | None = None

    def video(self, doc: Session) -> SurfaceVideo:
        """The pictures of the surfaces where the document has them lie."""
        with self._lock:
            if reading(doc) != self._read_as:
                folder = self._piece.session_path.absolute().parent
                video = open_surfaces(doc, self._piece.video.info.path, folder)
                self._leave_video()
                self._video, self._read_as = video, reading(doc)
            return self._video

    def sight(self, edit: EditorState, frame: int) -> Sight:
        """A step in the colours that are chosen; SurfaceError where it cannot be used."""
        steps, tint = self.video(edit.settled).steps, edit.display.tint
        mesh = steps.mesh(frame) if tint == "photo" else steps.shape(frame)
        return Sight(mesh, self._colours(edit, frame, mesh, tint))

    def rims(self, edit: EditorState) -> int:
        """Edges with a face on one side only of the surface that moves; SurfaceError as above."""
        key = self._frame_key(edit.settled)
        if self._rims is None or self._rims[0] != key:
            keyframe = edit.settled.model_keyframe
            frame = 0 if keyframe is None else keyframe.frame
            self._rims = key, len(self.video(edit.settled).steps.shape(frame).rim)
        return self._rims[1]

    def is_rated(self, edit: EditorState, frame: int) -> bool:
        """Whether it is known how well cameras agree; SurfaceError as above."""
        doc = edit.settled
        if doc.surface is not None and doc.surface.cameras is not None:
            return True
        return self.video(doc).steps.shape(frame).consistency is not None

    def close(self) -> None:
        """Let go of what was opened here."""
        with self._lock:
            self._leave_video()

    def _leave_video(self) -> None:
        if self._video is not self._piece.video:
            self._video.close()

    def _colours(self, edit: EditorState, frame: int, mesh: SurfaceMesh, tint: Tint) -> Colours:
        if tint == "photo" and mesh.consistency is not None:
            return tinted(tint, in_agreement(mesh.consistency))
        model = self._model_of(edit.settled) if tint in ("contact", "distance") else None
        if model is None or tint == "clay":
            return clay(len(mesh.vertices))
        return tinted(tint, look(model, mesh, shown(edit, frame).pose, tint))

    def _model_of(self, doc: Session) -> SurfaceModel | None:
        """The surface that moves with the body; None where nobody has posed it."""
        keyframe, surface = doc.model_keyframe, doc.surface
        if keyframe is None or surface is None:
            return None
        key = (*self._frame_key(doc), keyframe, doc.body, surface.binding)
        with self._lock:
            if self._model is None or self._model[0] != key:
                mesh = self.video(doc).steps.shape(keyframe.frame)
                pose, smooth = keyframe.pose(Skeleton.of(doc.body)), surface.binding == "smooth"
                made = SurfaceModel.of(mesh, doc.body, pose, MODEL_POINTS, smooth)
                self._model = key, made
            return self._model[1]

    def _frame_key(self, doc: Session) -> tuple[Any, ...]:
        keyframe = doc.model_keyframe
        return (0 if keyframe is None else keyframe.frame, reading(doc))


class TintedSource:
    """The pictures of the surfaces in colours, as a video's frames.

    Of a step that cannot be used the picture is empty: the page says why in words of its own.
    """

    def __init__(self, observed: Observed, edit: EditorState) -> None:
        self._observed, self._edit = observed, edit
        self._video = observed.video(edit.settled)
        self.info: VideoInfo = replace(self._video.info, missing=())

    def approach(self, number: int, since: int) -> Iterator[tuple[int, Picture]]:
        """Gives frame `number`."""
        try:
            colours = self._observed.sight(self._edit, number).colours
            yield number, self._video.coloured(number, colours)
        except (SurfaceError, MissingFrame):
            size = (self.info.height, self.info.width, 3)
            yield number, np.full(size, GROUND, dtype=np.uint8)

    def reindex(self) -> None: ...

    def fingerprint(self) -> str:
        return self._video.fingerprint()

    def close(self) -> None: ...
