"""The world of files that hold a whole scene: y up, the floor at zero, metres.

Its origin lies on the floor below the camera, which looks along −z as nearly as the floor allows.
Part frames are those of files whose y points up (`keypose.tracker.formats.axes`).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from keypose.tracker.body.ground import floor_height, lowest_heights
from keypose.tracker.errors import FormatError
from keypose.tracker.formats.axes import FLIP
from keypose.tracker.formats.recording import Recording
from keypose.tracker.geometry.rotations import Array, transform

_FORWARD, _PICTURE_UP = np.array([0.0, 0.0, 1.0]), np.array([0.0, -1.0, 0.0])
_STEEP = 0.02
"""Of a direction, the level share below which it says nothing of where that points."""


def floor_from_camera(recording: Recording) -> Array:
    """T_world_camera (4, 4), from the camera frame (x right, y down, z forward) to this world.

    The floor is where it was set or found, or else where the body stands lowest (`body.floor`).
    FormatError where neither is known.
    """
    up = recording.up_camera
    back = -_level(up)
    R = np.stack([np.cross(up, back), up, back])
    return transform(R, np.array([0.0, -_floor_m(recording), 0.0]))


def with_floor(recording: Recording) -> Recording:
    """The recording with its floor's height given, so that parts of it stand on the same floor;
    itself where no frame is tracked."""
    if recording.floor_m is not None or not recording.tracks.tracked.any():
        return recording
    return replace(recording, floor_m=_floor_m(recording))


def parts_in_world(recording: Recording, T_world_camera: Array) -> Array:
    """Ts_world_part (N, P, 4, 4) in a world whose y points up; NaN where not tracked."""
    Ts = T_world_camera @ recording.trajectory.transforms(recording.skeleton)
    Ts[..., :3, :3] *= FLIP
    return np.asarray(Ts)


def _level(up: Array) -> Array:
    """(3,) where the camera looks, made level; straight down, what is above in its picture."""
    for direction in (_FORWARD, _PICTURE_UP):
        level = direction - (direction @ up) * up
        length = float(np.linalg.norm(level))
        if length > _STEEP:
            break
    return np.asarray(level / length)


def _floor_m(recording: Recording) -> float:
    """The floor's height along up from the camera, metres."""
    tracked = recording.tracks.tracked
    if recording.floor_m is None and not tracked.any():
        raise FormatError("No frame is tracked.")
    Ts = recording.trajectory.transforms(recording.skeleton)[tracked]
    lowest = lowest_heights(recording.skeleton, Ts, recording.up_camera) if len(Ts) else ()
    return floor_height(recording.floor_m, lowest)
