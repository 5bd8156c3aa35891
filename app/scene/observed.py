"""Observed surfaces as the page's views show them: a step's mesh, its colours, its picture.

Everything here takes a while and is asked for by several threads.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from keypose.app.document.open import OpenSession
from keypose.app.editor.shown import shown_pose
from keypose.app.editor.state import EditorState
from keypose.app.render.surface_layer import SurfaceLayer
from keypose.app.render.surfaces import colours_of, model_of
from keypose.app.render.tints import Tint
from keypose.tracker.errors import SurfaceError, VideoError
from keypose.tracker.session.evidence import surface_of
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.evidence import surfaces_of
from keypose.tracker.surface.files.unusable import describe_unusable
from keypose.tracker.surface.painting import GROUND, paint
from keypose.tracker.surface.picture import SurfaceVideo, open_surfaces
from keypose.tracker.video import Examined, VideoInfo
from keypose.tracker.video.picture import Picture

if TYPE_CHECKING:
    from keypose.tracker.surface.fit.model import SurfaceModel


def reading(doc: Session) -> tuple[Any, ...]:
    """What decides where the surfaces lie, and what cameras say of them."""
    surface = surface_of(doc)
    where = (surface.units, surface.up, surface.p_camera_surface)
    return (*where, surface.fps, surface.cameras, doc.camera)


class Outdated(VideoError):
    """The surfaces lie elsewhere by now."""


class Observed:
    """The surfaces of one opened session, as its document has them read.

    It goes with the newest document only: what asks for an older one is `Outdated`. What is read is
    read under one lock, so that nothing is closed meanwhile.
    """

    def __init__(self, opened: OpenSession) -> None:
        self._opened, self._steps = opened, surfaces_of(opened.video).steps
        self._lock = threading.RLock()
        self._video, self._read_as = surfaces_of(opened.video), reading(opened.session)
        self._newest: tuple[Any, ...] | None = self._read_as
        self.info: VideoInfo = replace(opened.video.info, missing=())
        self._model: tuple[tuple[Any, ...], SurfaceModel] | None = None
        self._rims: tuple[tuple[Any, ...], int] | None = None

    def follow(self, doc: Session) -> None:
        """From now on the surfaces lie where this document has them; never waits."""
        self._newest = reading(doc)

    def video(self, doc: Session) -> SurfaceVideo:
        """The pictures of the surfaces where the document has them lie; VideoError where they
        cannot be opened."""
        with self._lock:
            if reading(doc) != self._newest:
                raise Outdated("The surfaces have been read anew meanwhile: try again.")
            if reading(doc) != self._read_as:
                folder = self._opened.session_path.absolute().parent
                try:
                    video = open_surfaces(doc, self._opened.video.info.path, folder)
                except SurfaceError as error:  # not of one step, which would be shown as empty
                    raise VideoError(str(error)) from error
                self._leave_video()
                self._video, self._read_as = video, reading(doc)
            return self._video

    def layer(self, edit: EditorState, frame: int) -> SurfaceLayer:
        """A step in the colours that are chosen; SurfaceError where it cannot be used, VideoError
        where the session has been closed."""
        tint = edit.display.tint
        with self._lock:
            video = self.video(edit.settled)
            try:
                mesh = video.steps.mesh(frame) if tint == "photo" else video.steps.shape(frame)
                model = self._model_for(tint, edit.settled)
                return SurfaceLayer(
                    mesh, colours_of(mesh, tint, shown_pose(edit, frame).pose, model)
                )
            except SurfaceError as error:
                if video.is_closed:
                    raise VideoError(str(error)) from None
                raise

    def rims(self, edit: EditorState) -> int:
        """Edges with a face on one side only of the surface that moves; SurfaceError as above."""
        key = self._frame_key(edit.settled)
        with self._lock:
            if self._rims is None or self._rims[0] != key:
                self._rims = key, len(self.video(edit.settled).steps.shape(key[0]).rim)
            return self._rims[1]

    def is_rated(self, edit: EditorState, frame: int) -> bool:
        """Whether it is known how well cameras agree; SurfaceError as above."""
        doc = edit.settled
        if surface_of(doc).cameras is not None:
            return True
        with self._lock:
            return self.video(doc).steps.shape(frame).consistency is not None

    def unusable(self) -> str:
        """Which steps cannot be used; takes a while, and reading goes on meanwhile."""
        return describe_unusable(self._steps.unusable())

    def close(self) -> None:
        """Close what was opened here."""
        with self._lock:
            self._newest = None
            self._leave_video()

    def _leave_video(self) -> None:
        if self._video is not self._opened.video:
            self._video.close()

    def _model_for(self, tint: Tint, doc: Session) -> SurfaceModel | None:
        """The surface that moves with the body; None without a pose, or it is not
        needed."""
        keyframe = doc.model_keyframe
        if tint not in ("contact", "distance") or keyframe is None:
            return None
        key = (*self._frame_key(doc), keyframe, doc.body, surface_of(doc).binding)
        with self._lock:
            if self._model is None or self._model[0] != key:
                made = model_of(doc, self.video(doc).steps)
                self._model = None if made is None else (key, made)
            return None if self._model is None else self._model[1]

    def _frame_key(self, doc: Session) -> tuple[Any, ...]:
        keyframe = doc.model_keyframe
        return (0 if keyframe is None else keyframe.frame, reading(doc))


class TintedSource:
    """The pictures of the surfaces in colours, as a video's frames.

    Of a step that cannot be used the picture is empty: the page says why in words of its own.
    """

    def __init__(self, observed: Observed, edit: EditorState) -> None:
        self._observed, self._edit, self.info = observed, edit, observed.info

    def approach(self, number: int, since: int) -> Iterator[tuple[int, Picture]]:
        """Gives frame `number`; VideoError where the surfaces lie elsewhere by now."""
        camera = self._edit.settled.camera.without_distortion()
        try:
            surface = self._observed.layer(self._edit, number)
            yield number, paint(surface.mesh, camera, surface.colours)
        except SurfaceError:
            size = (self.info.height, self.info.width, 3)
            yield number, np.full(size, GROUND, dtype=np.uint8)

    def reindex(self) -> None: ...

    def examine(self, first: int, last: int) -> Iterator[Examined]:
        """Nothing here is built on something else: no frame is damaged by another."""
        yield Examined(first, last, frozenset(), last)

    def fingerprint(self) -> str:
        return self._observed.video(self._edit.settled).fingerprint()

    def close(self) -> None: ...
