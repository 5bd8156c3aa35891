"""The hulls of a rig's silhouettes, step by step, rated by its images where there are any."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import replace
from typing import Self

import numpy as np

from keypose.tracker.errors import SurfaceError
from keypose.tracker.surface.cameras.footage import Footage
from keypose.tracker.surface.cameras.hull import hull_field, hull_mesh
from keypose.tracker.surface.cameras.photo import consistency
from keypose.tracker.surface.cameras.rig import Rig
from keypose.tracker.surface.mesh import SurfaceMesh

_NOWHERE = np.zeros(3)
"""Hulls are made about the origin of the rig's own world."""


class Hulls:
    """Meshes by step, in the units and the world of the cameras' file. Close it, or use `with`."""

    def __init__(self, rig: Rig, voxel_m: float, *, carve: bool = False) -> None:
        """carve: remove what the cameras see through, by the images.  SurfaceError where there
        are too few silhouettes, or no images to carve by."""
        self._rig, self._voxel_m, self._carve = rig, voxel_m, carve
        self.has_images = any(camera.images for camera in rig.cameras)
        if carve and not self.has_images:
            raise SurfaceError("Carving needs images: the cameras' file names none.")
        with ExitStack() as opening:
            self._silhouettes = opening.enter_context(Footage(rig, "silhouettes", _NOWHERE))
            self._images: Footage | None = None
            if self.has_images:
                self._images = opening.enter_context(Footage(rig, "images", _NOWHERE))
                _require_same_count(self._silhouettes, self._images)
            self._open = opening.pop_all()

    @property
    def step_count(self) -> int:
        return self._silhouettes.frame_count

    def mesh(self, step: int) -> SurfaceMesh:
        """SurfaceError where no hull can be made of this step."""
        field = hull_field(*self._silhouettes.silhouettes(step), self._voxel_m)
        if self._images is None:
            return self._rig.in_file(hull_mesh(field), _NOWHERE)
        views, pictures = self._images.pictures(step)
        if self._carve:
            from keypose.tracker.surface.cameras.carve import carve_field

            field = carve_field(field, views, pictures)
        mesh = hull_mesh(field)
        mesh = replace(mesh, consistency=consistency(mesh, views, pictures))
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
