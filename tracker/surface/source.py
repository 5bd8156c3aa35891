"""The surfaces a session is about: read, placed in the camera's frame, cached.

The fit asks for steps in a row, the page for the same ones again. So the latest few are kept, and
the next is read ahead.
"""

from __future__ import annotations

import threading
import time
from collections import OrderedDict
from collections.abc import Callable, Iterable
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING, Self

import numpy as np

from keypose.tracker.errors import SurfaceError
from keypose.tracker.session.references import Surface
from keypose.tracker.surface.files.sequence import MeshSequence
from keypose.tracker.surface.files.sources import SUFFIXES
from keypose.tracker.surface.mesh import SurfaceMesh
from keypose.tracker.surface.placing import Placement
from keypose.tracker.video.folder import SUFFIXES as IMAGES

if TYPE_CHECKING:
    from keypose.tracker.surface.cameras.footage import Footage

MOST_KEPT = 6
"""Meshes of each kind: two segments at work, each with a step ahead, and one that is looked at."""

CHECKED_S = 5.0
"""So long files are read to see which cannot be used; others can be read meanwhile."""

MOST_TEXTURES = 4
"""Images that may belong to a mesh in the same folder."""
_CLOSED = "The meshes have been closed: open them again."


class SurfaceSteps:
    """The steps of a session's surfaces, in the camera frame; threads may share it.

    shape: as observed.  mesh: the same with photo-consistency, where there are cameras.
    """

    def __init__(self, sequence: MeshSequence, surface: Surface, folder: Path = Path()) -> None:
        """folder: what the path of the cameras' file is relative to."""
        self.sequence, self.placement = sequence, placement_of(surface)
        self._surface, self._folder = surface, folder
        self._footage: Footage | None = None
        self._looked = False
        self._checking, self._closing = threading.Lock(), threading.Event()
        self._shapes = _Latest("meshes", sequence.frame_count, self._read)
        self._rated = _Latest("agreement", sequence.frame_count, self._rate)

    @property
    def frame_count(self) -> int:
        return self.sequence.frame_count

    def shape(self, frame: int) -> SurfaceMesh:
        """A step's surface; SurfaceError, in one sentence, where it cannot be used."""
        return self._shapes.get(frame)

    def mesh(self, frame: int) -> SurfaceMesh:
        """The same with `consistency` as the session's cameras see it.

        SurfaceError also where these cannot be used.
        """
        rated = self._surface.cameras is not None
        return self._rated.get(frame) if rated else self._shapes.get(frame)

    def unusable(self) -> dict[int, str]:
        """Say why steps cannot be used, as far as is seen in a few seconds; ends early where these
        are closed meanwhile.
        """
        problems = dict(self.sequence.missing)
        end = time.monotonic() + CHECKED_S
        with self._checking:
            for frame in range(self.frame_count):
                if self._closing.is_set() or time.monotonic() > end:
                    break
                if words := self.sequence.problem(frame):
                    problems[frame] = words
        return problems

    def cut_by(self, frame: int) -> tuple[str, ...]:
        """Names of the session's cameras whose pictures do not hold all of a step's surface."""
        if self._surface.cameras is None:
            return ()
        from keypose.tracker.surface.rating import cut_by  # loads what only this needs

        return cut_by(self._surface, self._folder, self.shape(frame))

    def close(self) -> None:
        """Close the files."""
        self._closing.set()
        self._rated.close()
        self._shapes.close()
        if self._footage is not None:
            self._footage.close()
        with self._checking:  # a question after the end would start the process anew
            self.sequence.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def _read(self, frame: int) -> SurfaceMesh:
        return self.placement.place(self.sequence.mesh(frame))

    def _rate(self, frame: int) -> SurfaceMesh:
        """Rate a step on a thread of its own, which opens the images when the first are wanted."""
        mesh = self._shapes.get(frame)
        if not self._looked:
            from keypose.tracker.surface.rating import open_footage  # loads what only this needs

            self._footage = open_footage(self._surface, self._folder, self.frame_count)
            self._looked = True
        return mesh if self._footage is None else self._footage.rate(mesh, frame)


class UnratedSteps:
    """The same surfaces without photo-consistency: no images are read."""

    def __init__(self, steps: SurfaceSteps) -> None:
        self._steps = steps
        self.frame_count = steps.frame_count

    def mesh(self, frame: int) -> SurfaceMesh:
        """A step's surface; SurfaceError, in one sentence, where it cannot be used."""
        return self._steps.shape(frame)

    def cut_by(self, frame: int) -> tuple[str, ...]:
        """The same as `SurfaceSteps.cut_by`; none where the cameras cannot be used."""
        try:
            return self._steps.cut_by(frame)
        except SurfaceError:
            return ()


class _Latest:
    """A cache of the latest few meshes, made one at a time on a thread of its own."""

    def __init__(self, name: str, count: int, make: Callable[[int], SurfaceMesh]) -> None:
        self._count, self._make = count, make
        self._thread = ThreadPoolExecutor(1, thread_name_prefix=name)
        self._lock = threading.Lock()
        self._kept: OrderedDict[int, Future[SurfaceMesh]] = OrderedDict()
        self._before = threading.local()
        self._closed = False

    def get(self, frame: int) -> SurfaceMesh:
        """The mesh of a frame; where frames are asked for in a row, the next is started."""
        if not 0 <= frame < self._count:
            raise SurfaceError(f"There is no step {frame}; the steps are 0 to {self._count - 1}.")
        wanted = self._start(frame)
        stride = frame - getattr(self._before, "frame", frame)
        self._before.frame = frame
        if abs(stride) == 1 and 0 <= frame + stride < self._count:
            self._start(frame + stride)
        try:
            return wanted.result()
        except SurfaceError as error:  # raised anew: several threads may receive it
            raise SurfaceError(str(error)) from None
        except CancelledError:
            raise SurfaceError(_CLOSED) from None

    def close(self) -> None:
        with self._lock:
            self._closed = True
            self._kept.clear()
        self._thread.shutdown(wait=True, cancel_futures=True)

    def _start(self, frame: int) -> Future[SurfaceMesh]:
        with self._lock:
            if self._closed:
                raise SurfaceError(_CLOSED)
            future = self._kept.pop(frame, None) or self._thread.submit(self._make, frame)
            self._kept[frame] = future
            while len(self._kept) > MOST_KEPT:
                self._kept.popitem(last=False)
            return future


def placement_of(surface: Surface) -> Placement:
    """Where the meshes of a session lie."""
    return Placement(surface.units, surface.up, np.array(surface.p_camera_surface))


def open_steps(surface: Surface, meshes: Path, folder: Path) -> SurfaceSteps:
    """The surfaces at a path; the cameras' file is relative to `folder`.

    SurfaceError in one sentence where there are no meshes.
    """
    return SurfaceSteps(MeshSequence.open(meshes), surface, folder)


def holds_meshes(path: Path) -> bool:
    """Whether a path leads to observed surfaces rather than to a video: a mesh, or a folder
    with meshes that are not just lying among many images. Only names are looked at.
    """
    if not path.is_dir():
        return path.suffix.lower() in SUFFIXES
    try:
        return are_meshes([entry.name for entry in path.iterdir()])
    except OSError:
        return False


def are_meshes(names: Iterable[str]) -> bool:
    """The same of the names in a folder; hidden ones do not count."""
    shown_names = [name.lower() for name in names if not name.startswith(".")]
    meshes, images = (sum(name.endswith(of) for name in shown_names) for of in (SUFFIXES, IMAGES))
    return meshes > 0 and images <= MOST_TEXTURES * meshes
