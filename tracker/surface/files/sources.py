"""Find the meshes of the steps in a folder, numbered by their names.

mesh_004.ply, mesh_006.ply: the step of mesh_005.ply is there, and missing. Nothing ever shifts.
"""

from __future__ import annotations

import hashlib
import math
import os
import re
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Final

import numpy as np

from keypose.tracker.errors import SurfaceError
from keypose.tracker.session.settings import Units, UpAxis
from keypose.tracker.surface.files.parsing.raw import MeshRefused, open_mesh_file
from keypose.tracker.surface.files.reading import MeshReader
from keypose.tracker.surface.mesh import SurfaceMesh
from keypose.tracker.video.folder import natural

_FEWEST_FOR_A_RHYTHM: Final = 4
"""Files whose numbers tell how many steps lie between them."""
_MOST_GAPS: Final = 20
"""Steps to every file; where numbers lie farther apart they are no numbers of steps."""


def by_steps(paths: Sequence[Path]) -> tuple[Path | None, ...]:
    """The file of every step; None where there is none.

    The last number that differs from name to name is the step's. Where all numbers are multiples
    of something apart (every tenth frame was exported), that is one step. Files without a number,
    among files that have one, are no steps; where no file has one the order is the names' own.

    SurfaceError where two files are of one step.
    """
    paths = sorted(paths, key=lambda path: natural(path.name))
    numbers = [[int(digits[-18:]) for digits in re.findall(r"[0-9]+", p.stem)] for p in paths]
    with_number = [k for k, numbers_in_name in enumerate(numbers) if numbers_in_name]
    if len(with_number) < max(2, len(paths) / 2):
        return tuple(paths)
    steps = _varying([numbers[k] for k in with_number])
    files = {step: paths[k] for step, k in zip(steps, with_number, strict=True)}
    if len(files) < len(steps):
        raise _twice([paths[k] for k in with_number], steps)
    first, last = min(steps), max(steps)
    stride = _stride(sorted(steps))
    if (last - first) // stride > _MOST_GAPS * len(steps):
        return tuple(files[step] for step in sorted(files))
    return tuple(files.get(step) for step in range(first, last + 1, stride))


def printable(path: Path) -> str:
    """A file's name as it can be printed on one line, whatever bytes it is made of."""
    name = os.fsencode(path.name).decode("utf-8", "replace")
    return "".join(
        letter if letter.isprintable() else "\N{REPLACEMENT CHARACTER}" for letter in name
    )


def _varying(numbers: list[list[int]]) -> list[int]:
    """The last number of each name that differs from name to name."""
    if len({len(numbers_in_name) for numbers_in_name in numbers}) == 1:
        for column in reversed(list(zip(*numbers, strict=True))):
            if len(set(column)) > 1:
                return list(column)
    return [numbers_in_name[-1] for numbers_in_name in numbers]


def _stride(steps: list[int]) -> int:
    if len(steps) < _FEWEST_FOR_A_RHYTHM:
        return 1
    return math.gcd(*np.diff(steps).tolist())


def _twice(paths: list[Path], steps: list[int]) -> SurfaceError:
    order = sorted(zip(steps, paths, strict=True), key=lambda pair: pair[0])
    first, second = next((a, b) for (i, a), (j, b) in pairwise(order) if i == j)
    return SurfaceError(
        f'"{printable(first)}" and "{printable(second)}" have the same number: '
        "keep one mesh per time step in the folder."
    )


SUFFIXES: Final = (".ply", ".obj", ".glb")
GLB: Final = ".glb"
_CHUNK: Final = 4 * 1024


class FolderSource:
    """The mesh files of a folder, one per step. `missing` holds, per step without a file, one
    sentence."""

    def __init__(self, files: tuple[Path | None, ...]) -> None:
        self._files = files
        self.frame_count = len(files)
        self.missing = _gaps(files)
        all_glb = all(file.suffix.lower() == GLB for file in files if file is not None)
        # glTF prescribes both.
        self.stated_units: Units | None = "m" if all_glb else None
        self.stated_up: UpAxis | None = "+y" if all_glb else None

    def name(self, frame: int) -> str:
        """The file of a step, as it can be printed."""
        file = self._files[frame]
        return "" if file is None else printable(file)

    def read(self, reader: MeshReader, frame: int) -> SurfaceMesh:
        """The mesh of a step that has a file. Raises Refused."""
        file = self._files[frame]
        assert file is not None, "a missing step is refused before"
        return reader.mesh(file)

    def fingerprint(self) -> str:
        """ "sha256:…", equal for copies."""
        digest = hashlib.sha256()
        for frame, file in enumerate(self._files):
            if file is not None:
                digest.update(f"{frame} ".encode() + os.fsencode(file.name) + b"\n")
                digest.update(_ends(file))
        return f"sha256:{digest.hexdigest()}"


def _gaps(files: tuple[Path | None, ...]) -> dict[int, str]:
    """Per step without a file, one sentence. The first and the last have one."""
    there = [(frame, printable(file)) for frame, file in enumerate(files) if file is not None]
    return {
        frame: f'Step {frame} is missing between "{before}" and "{behind}": '
        "put its mesh into the folder."
        for (first, before), (last, behind) in pairwise(there)
        for frame in range(first + 1, last)
    }


def source_at(path: Path) -> FolderSource:
    """What lies at a path. SurfaceError where these are no meshes."""
    if path.is_dir():
        return FolderSource(by_steps(_meshes_in(path)))
    if not path.exists():
        raise SurfaceError(f'There is no "{printable(path)}": choose a folder of meshes.')
    if path.suffix.lower() == GLB:
        raise SurfaceError(
            f'"{printable(path)}" is a single file, and an animation in it is not played: export '
            "numbered meshes, one per time step, and choose their folder."
        )
    if path.suffix.lower() in SUFFIXES:
        raise SurfaceError(
            f'"{printable(path)}" is the mesh of a single step: choose the folder it lies in.'
        )
    raise SurfaceError(
        f'"{printable(path)}" holds no meshes over time: choose a folder of PLY, OBJ or GLB '
        "files, one per time step."
    )


def _meshes_in(folder: Path) -> list[Path]:
    """The files that are meshes by their name; at least one."""
    try:
        # Hidden ones are what a file manager leaves beside a file.
        meshes = [
            entry
            for entry in folder.iterdir()
            if entry.suffix.lower() in SUFFIXES
            and not entry.name.startswith(".")
            and not entry.is_dir()
        ]
    except OSError as error:
        raise SurfaceError(
            f'The folder "{printable(folder)}" may not be read by you: change its permissions.'
        ) from error
    if not meshes:
        raise SurfaceError(
            f'The folder "{printable(folder)}" holds no meshes (PLY, OBJ, GLB): '
            "choose a folder with one mesh per time step."
        )
    return meshes


def _ends(path: Path) -> bytes:
    """Size, head and tail of a file; nothing of what cannot be read."""
    try:
        with open_mesh_file(path) as file:
            size = file.seek(0, os.SEEK_END)
            file.seek(0)
            head = file.read(_CHUNK)
            file.seek(max(size - _CHUNK, 0))
            return f"{size} bytes\n".encode() + head + file.read(_CHUNK)
    except (MeshRefused, OSError):
        return b"nothing\n"
