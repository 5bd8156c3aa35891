"""The cameras by which a session's surfaces are rated: how well their pictures agree on them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from keypose.tracker.errors import SurfaceError, VideoError
from keypose.tracker.session.references import Surface
from keypose.tracker.surface.cameras.footage import Footage
from keypose.tracker.surface.cameras.rig import Rig, View
from keypose.tracker.surface.mesh import SurfaceMesh


def open_footage(surface: Surface, folder: Path, frame_count: int) -> Footage | None:
    """The images of a session's cameras, in its camera frame; None where there are none.

    folder: what the cameras' path is relative to.  SurfaceError in one sentence where they cannot
    be used, or are not one for every step.
    """
    if surface.cameras is None:
        return None
    rig = _rig(surface, folder / surface.cameras)
    if not any(camera.images for camera in rig.cameras):
        return None
    try:
        footage = Footage(rig, "images", np.array(surface.p_camera_surface))
    except VideoError as error:
        raise SurfaceError(str(error)) from None
    if footage.frame_count != frame_count:
        footage.close()
        raise SurfaceError(
            f"The cameras of {surface.cameras!r} took {footage.frame_count} images each, and there "
            f"are {frame_count} meshes: give them one for every mesh."
        )
    return footage


def cut_by(surface: Surface, folder: Path, mesh: SurfaceMesh) -> tuple[str, ...]:
    """Names of the cameras whose pictures do not hold all of a mesh (camera frame, metres)."""
    if surface.cameras is None:
        return ()
    views = _rig(surface, folder / surface.cameras).views(np.array(surface.p_camera_surface))
    return tuple(view.name for view in views if not _holds(view, mesh))


def _holds(view: View, mesh: SurfaceMesh) -> bool:
    uv, size = view.project(mesh.vertices), (view.camera.width, view.camera.height)
    return bool(((uv >= -0.5) & (uv <= np.array(size) - 0.5)).all())  # behind it: NaN


def _rig(surface: Surface, path: Path) -> Rig:
    """The world is that of the surfaces; which axis is up, the session states."""
    return Rig.open(path).model_copy(update={"up": surface.up})
