"""Find where a film's camera went that moves through a place, from its background.

The scale is not told by pictures: the path's unit is the usual depth of points where the camera
began to move, until `metric.scale_from_stances` or a person says how long it is. The focal length
stays what it is.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.camera_motion.findings import Finding, gaps
from keypose.tracker.camera_motion.moving import MovingCamera
from keypose.tracker.camera_motion.points import Background, Grey
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import Array


@dataclass(frozen=True, eq=False)
class MovedPath:
    """A path in a unit of its own.

    moves: whether the film shows that the camera was elsewhere than at the first frame; else it
    is turned only.  known (N,): at which frames it is measured; elsewhere it stays where it was.
    error_px (N,): median residual of the points that agree, pixels of the film, NaN where unknown.
    """

    path: CameraPath
    moves: bool
    known: NDArray[np.bool_]
    error_px: Array
    findings: tuple[Finding, ...]

    def in_metres(self, metres: float) -> CameraPath:
        """The path, where its unit is so many metres long."""
        Ts = self.path.Ts_camera_world.copy()
        Ts[:, :3, 3] *= metres
        return CameraPath(Ts, self.path.zoom)


def find_moved_path(
    pictures: Iterable[Grey | None],
    camera: Camera,
    frame_count: int,
    background: Background = lambda frame: None,
    progress: Callable[[int, int], None] = lambda done, expected: None,
) -> MovedPath:
    """Follow the camera through the pictures (H, W) of a film, in order; None for one that cannot
    be read. No picture is kept.

    camera: its lens.  frame_count: how many pictures are expected.  progress(done, expected) after
    every frame; what it raises ends the work.
    """
    moving = MovingCamera(camera)
    for frame, picture in enumerate(pictures):
        moving.take(picture, background(frame))
        progress(frame + 1, max(frame_count, frame + 1))
    count = len(moving.causes)
    Ts = moving.finished() if count else np.zeros((0, 4, 4))
    known = np.array([not cause for cause in moving.causes], bool)
    return MovedPath(
        CameraPath(Ts, np.ones(count)),
        moving.known,
        known,
        np.where(known, moving.errors_px, np.nan),
        tuple(sorted(_findings(moving), key=lambda finding: finding.first_frame)),
    )


def _findings(moving: MovingCamera) -> list[Finding]:
    found = gaps(moving.causes)
    found += [Finding("cut", frame, frame, 1.0) for frame in moving.loose]
    if moving.causes and not moving.known:
        found.append(Finding("no_parallax", 0, len(moving.causes) - 1, 1.0))
    return found
