"""The meshes of a moving thing, one per time step: a folder of files.

    with MeshSequence.open("scan/") as meshes:
        mesh = meshes.mesh(12)            # SurfaceMesh in the file's own frame and units

A step's number is its place in time. It never shifts: a step whose file is missing or cannot be
used keeps its number, and asking for it raises one sentence.
"""

from __future__ import annotations

import threading
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from statistics import median_low
from typing import Final, Self

import numpy as np

from keypose.tracker.errors import SurfaceError, numbers_listed
from keypose.tracker.session.settings import Units, UpAxis
from keypose.tracker.surface.files.parsing.raw import MeshRefused
from keypose.tracker.surface.files.reading import MeshReader
from keypose.tracker.surface.files.sources import FolderSource, source_at
from keypose.tracker.surface.mesh import SurfaceMesh


def describe_unusable(problems: Mapping[int, str]) -> str:
    """Which steps these are, and what is wrong with the first of them; empty where there are
    none.

    problems: of each step a sentence, which is enough where it is one step.
    """
    if len(problems) < 2:
        return "".join(problems.values())
    steps = numbers_listed(problems.keys())
    return f"Steps {steps} cannot be used. The first of them: {problems[min(problems)]}"


OTHER_SIZE: Final = 5.0
"""A step so many times larger or smaller than the first ones is not the same thing."""
_FIRST_STEPS: Final = 3
_LOOKED_AT_MOST: Final = 10


class MeshSequence:
    """Opened meshes. Several threads may share it.

    missing: per step that is known to be unusable, one sentence: those without a file from the
             start, others from when they were first asked for.
    """

    def __init__(self, path: Path, source: FolderSource, reader: MeshReader) -> None:
        self.path = path
        self.missing: dict[int, str] = dict(source.missing)
        self._source = source
        self._reader = reader
        self._sizes: dict[int, float] = {}
        self._measuring = threading.Lock()

    @classmethod
    def open(cls, path: str | Path, reader: MeshReader | None = None) -> MeshSequence:
        """A folder of PLY, OBJ or GLB files in the order of the numbers in their names.
        SurfaceError where there is none."""
        path = Path(path)
        return cls(path, source_at(path), reader or MeshReader())

    @property
    def frame_count(self) -> int:
        """How many steps there are, missing ones counted."""
        return self._source.frame_count

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

    def problem(self, frame: int) -> str:
        """Why a step cannot be used; empty where it can.

        It is only reported: the step can still be asked for, should its file have been exported
        anew meanwhile.
        """
        if frame not in self.missing:
            try:
                self._source.read(self._reader, frame)
            except MeshRefused as refusal:
                return self._sentence(frame, str(refusal))
        return self.missing.get(frame, "")

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
        except MeshRefused as refusal:
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
