"""Make the hulls of a rig's silhouettes, or of a person in its images; write them as PLY."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import replace
from typing import Self

import numpy as np

from keypose.tracker.errors import SurfaceError
from keypose.tracker.keypoints.detect import Detector
from keypose.tracker.surface.cameras.footage import Footage, What, consistency
from keypose.tracker.surface.cameras.hull import hull_field, hull_mesh
from keypose.tracker.surface.cameras.person import PersonFinder
from keypose.tracker.surface.cameras.rig import Rig
from keypose.tracker.surface.mesh import SurfaceMesh


def ply_bytes(mesh: SurfaceMesh) -> bytes:
    """The file of a mesh, in the mesh's own units; `zncc` is there where it is known."""
    columns = [*mesh.vertices.T]
    names = ["x", "y", "z"]
    if mesh.consistency is not None:
        columns, names = [*columns, mesh.consistency], [*names, "zncc"]
    small = len(mesh.vertices) <= 0xFFFF
    corner = np.dtype("<u2" if small else "<i4")
    faces = np.zeros(len(mesh.faces), [("count", "u1"), ("corners", corner, 3)])
    faces["count"], faces["corners"] = 3, mesh.faces
    header = [
        "ply",
        "format binary_little_endian 1.0",
        f"element vertex {len(mesh.vertices)}",
        *(f"property float {name}" for name in names),
        f"element face {len(mesh.faces)}",
        f"property list uchar {'ushort' if small else 'int'} vertex_indices",
        "end_header\n",
    ]
    vertices = np.stack(columns, axis=1).astype("<f4")
    return "\n".join(header).encode() + vertices.tobytes() + faces.tobytes()


_NOWHERE = np.zeros(3)
"""Hulls are made about the origin of the rig's own world."""


class Hulls:
    """Meshes by step, in the units and the world of the cameras' file. Close it, or use `with`.

    left_out: by camera the steps made without it: it showed nobody, or could not be read.
    """

    def __init__(self, rig: Rig, voxel_m: float, network: Detector | None = None) -> None:
        """SurfaceError where there are too few silhouettes, or images, or a box is none.

        network: finds a person in the images, whose silhouettes are taken; None: those of the file.
        """
        self._rig, self._voxel_m = rig, voxel_m
        self._person = None if network is None else PersonFinder(rig, network)
        self.left_out: dict[str, set[int]] = {}
        self.has_images = any(camera.images for camera in rig.cameras)
        with ExitStack() as opening:
            shapes: What = "silhouettes" if network is None else "images"
            self._silhouettes = opening.enter_context(Footage(rig, shapes, _NOWHERE))
            self._images = None if network is None else self._silhouettes
            if self.has_images and network is None:
                self._images = opening.enter_context(Footage(rig, "images", _NOWHERE))
                _require_same_count(self._silhouettes, self._images)
            self._open = opening.pop_all()

    @property
    def step_count(self) -> int:
        return self._silhouettes.frame_count

    def mesh(self, step: int) -> SurfaceMesh:
        """SurfaceError where no hull can be made of this step. Of a person, ask in ascending order:
        each step is looked at where the person was last."""
        views, silhouettes = self._silhouettes.silhouettes(step, self._person)
        every = [view.name for view in self._silhouettes.views]
        if self._person is not None and len(views) < 2:
            raise SurfaceError(
                f"A person was found by {len(views)} of the {len(every)} cameras, and a hull needs "
                'two: give a "box" around the person in the cameras\' file.'
            )
        mesh = hull_mesh(hull_field(views, silhouettes, self._voxel_m))
        for name in set(every) - {view.name for view in views}:
            self.left_out.setdefault(name, set()).add(step)
        if self._images is not None:
            mesh = replace(mesh, consistency=consistency(mesh, *self._images.pictures(step)))
        return self._rig.in_file(mesh, _NOWHERE)

    def close(self) -> None:
        """Close the videos."""
        self._open.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()


def _require_same_count(silhouettes: Footage, images: Footage) -> None:
    if silhouettes.frame_count != images.frame_count:
        raise SurfaceError(
            f"There are {silhouettes.frame_count} silhouettes and {images.frame_count} images of "
            "each camera: every step needs both."
        )
