"""The meshes of a moving thing, one per time step: a folder of files, or one animated file.

    with MeshSequence.open("scan/") as meshes:
        mesh = meshes.mesh(12)            # SurfaceMesh in the file's own frame and units

A step's number is its place in time. It never shifts: a step whose file is missing or cannot be
used keeps its number, and asking for it raises one sentence.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from statistics import median_low
from typing import Final, Self

import numpy as np

from keypose.tracker.errors import SurfaceError
from keypose.tracker.session.settings import Units, UpAxis
from keypose.tracker.surface.files.parsing.raw import Refused
from keypose.tracker.surface.files.reading import MeshReader
from keypose.tracker.surface.files.sources import Source, source_at
from keypose.tracker.surface.mesh import SurfaceMesh

OTHER_SIZE: Final = 5.0
"""A step so many times larger or smaller than the first ones is not the same thing."""
GLANCE_S: Final = 0.5
"""So long files are only glanced at."""
_FIRST_STEPS: Final = 3
_LOOKED_AT_MOST: Final = 10


@dataclass(frozen=True)
class Glance:
    """What is known without reading all meshes.

    problems:  of each step that cannot be used a sentence; others may turn out so when read.
    looked_at: so many steps, from the first on, were looked at.
    """

    problems: Mapping[int, str]
    looked_at: int


class MeshSequence:
    """Opened meshes. Several threads may share it.

    missing: per step that is known to be unusable, one sentence: those without a file from the
             start, others from when they were first asked for.
    """

    def __init__(self, path: Path, source: Source, reader: MeshReader) -> None:
        self.path = path
        self.missing: dict[int, str] = dict(source.missing)
        self._source = source
        self._reader = reader
        self._sizes: dict[int, float] = {}
        self._measuring = threading.Lock()

    @classmethod
    def open(cls, path: str | Path, reader: MeshReader | None = None) -> MeshSequence:
        """A folder of PLY, OBJ, GLB or OFF files in the order of the numbers in their names, or a
        GLB file. SurfaceError where there is none."""
        path = Path(path)
        reader = reader or MeshReader()
        try:
            return cls(path, source_at(path, reader), reader)
        except BaseException:
            reader.close()
            raise

    @property
    def frame_count(self) -> int:
        """How many steps there are, missing ones counted."""
        return self._source.frame_count

    @property
    def fps(self) -> float | None:
        """Steps a second, where the file knows."""
        return self._source.fps

    @property
    def stated_units(self) -> Units | None:
        """The unit of length, where the kind of file prescribes one."""
        return self._source.stated_units

    @property
    def stated_up(self) -> UpAxis | None:
        """The axis that is up, where the kind of file prescribes one."""
        return self._source.stated_up

    def mesh(self, frame: int) -> SurfaceMesh:
        """The mesh of a step, in the file's own frame and units.

        SurfaceError, naming step and file, where it is missing, cannot be used, or is of another
        size than the first ones.
        """
        if not 0 <= frame < self.frame_count:
            raise SurfaceError(
                f"There is no step {frame}: the meshes end at step {self.frame_count - 1}."
            )
        if frame in self.missing:
            raise SurfaceError(self.missing[frame])
        mesh = self._read(frame)
        self._require_usual_size(frame)
        return mesh

    def glance(
        self, seconds: float | None = None, stop: Callable[[], bool] = lambda: False
    ) -> Glance:
        """Look at the beginnings of the files, for so long at most; GLANCE_S when left out.

        What is found is only reported: a step can still be asked for, should its file have been
        exported anew meanwhile.
        """
        problems = dict(self.missing)
        end = time.monotonic() + (GLANCE_S if seconds is None else seconds)
        for frame in range(self.frame_count):
            if stop() or time.monotonic() > end:
                return Glance(problems, frame)
            try:
                if frame not in problems:
                    self._source.glance(self._reader, frame)
            except Refused as refusal:
                problems[frame] = self._sentence(frame, str(refusal))
        return Glance(problems, self.frame_count)

    def fingerprint(self) -> str:
        """ "sha256:…" of the files' names, sizes, heads and tails: quick, and equal for copies."""
        return self._source.fingerprint()

    def close(self) -> None:
        """End the process that reads."""
        self._reader.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def _read(self, frame: int) -> SurfaceMesh:
        try:
            mesh = self._source.read(self._reader, frame)
        except Refused as refusal:
            raise self._unusable(frame, str(refusal)) from refusal
        self._sizes[frame] = float(np.linalg.norm(mesh.extent))
        return mesh

    def _unusable(self, frame: int, why: str) -> SurfaceError:
        self.missing[frame] = self._sentence(frame, why)
        return SurfaceError(self.missing[frame])

    def _sentence(self, frame: int, why: str) -> str:
        return f'Step {frame} ("{self._source.name(frame)}") {why}'

    def _require_usual_size(self, frame: int) -> None:
        """Against the median of the first ones, so that an odd one among them does not decide."""
        size = self._sizes[frame]
        usual = median_low(self._first_sizes() or [size])
        if usual / OTHER_SIZE <= size <= usual * OTHER_SIZE:
            return
        times, how = (size / usual, "larger") if size > usual else (usual / size, "smaller")
        raise self._unusable(
            frame,
            f"is {times:,.0f} times {how} than the first steps, as if in other units: "
            "save all steps in the same.",
        )

    def _first_sizes(self) -> list[float]:
        """The sizes of the first usable steps, which are read where nobody has yet."""
        sizes: list[float] = []
        with self._measuring:
            for frame in range(min(self.frame_count, _LOOKED_AT_MOST)):
                if len(sizes) < _FIRST_STEPS and (size := self._size(frame)) is not None:
                    sizes.append(size)
        return sizes

    def _size(self, frame: int) -> float | None:
        if frame not in self._sizes and frame not in self.missing:
            with suppress(SurfaceError):
                self._read(frame)
        return self._sizes.get(frame)
