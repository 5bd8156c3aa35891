"""Show observed surfaces in the page's views: a step's mesh with fewer triangles, its colours.

The page draws it twice. "depth" gives its nearest layer without any colour, "sheet" the colours of
that layer alone, translucent, so that the body inside is seen through one sheet and no more.

Everything here takes a while and is asked for by several threads.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from keypose.app.document.open import OpenSession
from keypose.app.editor.shown import shown_pose
from keypose.app.editor.state import EditorState
from keypose.app.orders.drawing import Tint
from keypose.app.render.surfaces import SurfaceLayer, colours_of, model_of
from keypose.tracker.errors import SurfaceError, VideoError
from keypose.tracker.formats.glb_file import Numbers
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.evidence import surface_of
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.evidence import surfaces_of
from keypose.tracker.surface.files.sequence import describe_unusable
from keypose.tracker.surface.mesh import SurfaceMesh
from keypose.tracker.surface.painting import GROUND, paint
from keypose.tracker.surface.picture import SurfaceVideo, open_surfaces
from keypose.tracker.video import Examined, VideoInfo
from keypose.tracker.video.picture import Picture

if TYPE_CHECKING:
    from keypose.tracker.surface.fit.model import SurfaceModel


GROWTH = 1.2
"""Of the cells, until there are few enough triangles."""
START = 1.6
"""A first guess of the cells: a triangle in every so much of a cell's area."""


@dataclass(frozen=True, eq=False)
class DecimatedMesh:
    """vertices: (W, 3) metres.  faces: (F, 3).  cell: (V,) the vertex each of before became."""

    vertices: Array
    faces: NDArray[np.int64]
    cell: NDArray[np.int64]

    def means(self, values: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Values (V, K) of the vertices before as those (W, K) of these."""
        columns = (_mean(self.cell, column, len(self.vertices)) for column in values.T)
        return np.rint(np.stack(list(columns), axis=1)).astype(np.uint8)


def decimate(vertices: Array, faces: NDArray[np.int64], most: int) -> DecimatedMesh:
    """Reduce to at most so many triangles: vertices of one cell of a grid become one, in their
    middle.
    """
    if len(faces) <= most:
        return DecimatedMesh(vertices, faces, np.arange(len(vertices)))
    size = np.sqrt(START * 2 * _area(vertices, faces) / most)
    while True:
        made = _in_cells(vertices, faces, size)
        if len(made.faces) <= most:
            return made
        size *= GROWTH


def _in_cells(vertices: Array, faces: NDArray[np.int64], size: float) -> DecimatedMesh:
    places = np.floor((vertices - vertices.min(axis=0)) / size).astype(np.int64)
    across = places.max(axis=0) + 1
    number = (places[:, 0] * across[1] + places[:, 1]) * across[2] + places[:, 2]
    _, cell = np.unique(number, return_inverse=True)
    count = int(cell.max()) + 1
    middles = np.stack([_mean(cell, column, count) for column in vertices.T], axis=1)
    return DecimatedMesh(middles, _without_degenerate(cell[faces]), cell)


def _without_degenerate(faces: NDArray[np.int64]) -> NDArray[np.int64]:
    """Triangles whose corners are three, each once."""
    a, b, c = faces.T
    faces = faces[(a != b) & (b != c) & (c != a)]
    _, first = np.unique(np.sort(faces, axis=1), axis=0, return_index=True)
    return faces[np.sort(first)]


def _mean(cell: NDArray[np.int64], values: NDArray[np.generic], count: int) -> Array:
    members = np.maximum(np.bincount(cell, minlength=count), 1)
    return np.asarray(np.bincount(cell, values, count) / members)


def _area(vertices: Array, faces: NDArray[np.int64]) -> float:
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


MOST_FACES = 8000
"""Of a surface in the small views, some 150 kB; twice as many could not be distinguished there."""


def skin(mesh: SurfaceMesh, colours: NDArray[np.uint8]) -> bytes:
    """The GLB of a surface (camera frame, metres) with colours (V, 3), in the camera frame."""
    thin = decimate(mesh.vertices, mesh.faces, MOST_FACES)
    numbers = Numbers()
    attributes = {
        "POSITION": numbers.add(thin.vertices.astype(np.float32), "VEC3", "vertices", bounded=True),
        "COLOR_0": numbers.add(_linear(thin.means(colours)), "VEC3", "vertices"),
    }
    wide = np.uint16 if len(thin.vertices) < 65535 else np.uint32
    corners = numbers.add(thin.faces.ravel().astype(wide), "SCALAR", "indices")
    return numbers.file(
        {
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}],
            "meshes": [
                {
                    "primitives": [
                        {"attributes": attributes, "indices": corners, "material": material}
                        for material in range(2)
                    ]
                }
            ],
            "materials": [_material("depth"), _material("sheet")],
        }
    )


def _material(name: str) -> dict[str, object]:
    rough = {"metallicFactor": 0.0, "roughnessFactor": 1.0}
    return {"name": name, "pbrMetallicRoughness": rough, "doubleSided": True}


def _linear(colours: NDArray[np.uint8]) -> NDArray[np.float32]:
    """sRGB bytes as glTF wants colours of vertices: linear, 0 to 1."""
    share = colours / 255.0
    bright = ((share + 0.055) / 1.055) ** 2.4
    return np.where(share <= 0.04045, share / 12.92, bright).astype(np.float32)


def reading(doc: Session) -> tuple[Any, ...]:
    """What decides where the surfaces lie, and what cameras say of them."""
    surface = surface_of(doc)
    where = (surface.units, surface.up, surface.p_camera_surface)
    return (*where, surface.fps, surface.cameras, doc.view.camera)


class Outdated(VideoError):
    """The surfaces lie elsewhere by now."""


class SurfaceViews:
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
        """Follow the document: from now on the surfaces lie where it has them; never waits."""
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
        key = (*self._frame_key(doc), keyframe, doc.subject.body, surface_of(doc).binding)
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

    def __init__(self, observed: SurfaceViews, edit: EditorState) -> None:
        self._observed, self._edit, self.info = observed, edit, observed.info

    def approach(self, number: int, since: int) -> Iterator[tuple[int, Picture]]:
        """Gives frame `number`; VideoError where the surfaces lie elsewhere by now."""
        camera = self._edit.settled.view.camera.without_distortion()
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
