"""Where a camera is at every frame of a film, how it is turned, and how far it has zoomed.

World frame: the camera's own at the first frame. A camera that stands still is the identity at
every frame, and has no path.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import (
    Array,
    exp_rotation,
    frozen,
    log_rotation,
    rotation_between,
    transform,
    transpose,
)


@dataclass(frozen=True, eq=False)
class CameraPath:
    """The motion of a camera over N frames, the first of them frame 0 of its film.

    Ts_camera_world (N, 4, 4), metres.  zoom (N,): the focal length as a multiple of the camera's.
    """

    Ts_camera_world: Array
    zoom: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "Ts_camera_world", frozen(self.Ts_camera_world))
        object.__setattr__(self, "zoom", frozen(self.zoom))

    @classmethod
    def standing_still(cls, frame_count: int) -> CameraPath:
        """The path of a camera that neither moves nor zooms."""
        return cls(np.broadcast_to(np.eye(4), (frame_count, 4, 4)), np.ones(frame_count))

    @classmethod
    def of(cls, Rs_camera_world: Array, ps_camera_world: Array, zoom: Array) -> CameraPath:
        """The path of rotations (N, 3, 3) and places (N, 3) of the world's origin."""
        return cls(transform(Rs_camera_world, ps_camera_world), zoom)

    def __len__(self) -> int:
        return len(self.zoom)

    @property
    def Ts_world_camera(self) -> Array:
        """(N, 4, 4) poses of the camera in the world, metres."""
        return rigid_inverse(self.Ts_camera_world)

    @property
    def moves(self) -> bool:
        """Whether the camera is elsewhere at any frame."""
        return bool(self.Ts_camera_world[:, :3, 3].any())

    @property
    def zooms(self) -> bool:
        """Whether the focal length changes."""
        return bool((self.zoom != 1.0).any())

    def between(self, first: int, last: int) -> CameraPath:
        """The frames first to last, of which the first is row 0 then."""
        rows = slice(first, last + 1)
        return CameraPath(self.Ts_camera_world[rows], self.zoom[rows])

    def sampled(self, frames: Array) -> CameraPath:
        """The path at frames (N,), fractions of them between two."""
        below = np.clip(np.floor(frames).astype(np.int64), 0, len(self) - 1)
        above = np.minimum(below + 1, len(self) - 1)
        share = (frames - below)[:, None]
        R, p = self.Ts_camera_world[:, :3, :3], self.Ts_camera_world[:, :3, 3]
        turn = log_rotation(R[above] @ transpose(R[below]))
        Rs = exp_rotation(share * turn) @ R[below]
        zoom = self.zoom[below] + share[:, 0] * (self.zoom[above] - self.zoom[below])
        return CameraPath.of(Rs, p[below] + share * (p[above] - p[below]), zoom)

    def in_metres(self, pieces: Sequence[int], metres: Sequence[float]) -> CameraPath:
        """The path, where units are so many metres long from the first frames of its pieces on;
        each piece goes on from where the one before it ended."""
        R, p = self.Ts_camera_world[:, :3, :3], self.Ts_camera_world[:, :3, 3]
        if len(pieces) == 1:
            return CameraPath.of(R, p * metres[0], self.zoom)
        places = self.Ts_world_camera[:, :3, 3]
        lengths = np.repeat(metres, np.diff([*pieces, len(self)]))[:, None]
        steps = lengths * np.diff(places, axis=0, prepend=places[:1])
        placed = -(R @ np.cumsum(steps, axis=0)[..., None])[..., 0]
        return CameraPath.of(R, placed, self.zoom)

    def camera_at(self, camera: Camera, frame: int) -> Camera:
        """The film's camera with the focal length of one frame."""
        return camera.zoomed(float(self.zoom[frame]))


TIED = 1e-9
"""Share of a drift that a step takes that is measured, beside one of those that are not."""


@dataclass(frozen=True, eq=False)
class CameraCorrection:
    """The camera at one frame, as a person set it: T_camera_world (4, 4), zoom."""

    frame: int
    T_camera_world: Array
    zoom: float


def corrected(
    path: CameraPath,
    corrections: Sequence[CameraCorrection],
    untied: NDArray[np.bool_] | None = None,
) -> CameraPath:
    """The path that meets every correction exactly, and steps between them as it did.

    What it misses a correction by is its drift, a motion of the world. Between two corrections it
    is spread evenly over the steps, or over those alone that nothing of the film ties together,
    where there are such: untied (N − 1,). The first frame stays, unless it is corrected itself: it
    is the world's frame.
    """
    if not corrections:
        return path
    held = {each.frame: each for each in corrections}
    start = CameraCorrection(0, path.Ts_camera_world[0], float(path.zoom[0]))
    held = {0: start, **held}
    frames = sorted(held)
    drift = np.stack(
        [rigid_inverse(path.Ts_camera_world[f]) @ held[f].T_camera_world for f in frames]
    )
    ratio = np.log([held[f].zoom / path.zoom[f] for f in frames])
    steps = np.ones(len(path) - 1) if untied is None else np.where(untied, 1.0, TIED)
    travelled = np.concatenate([[0.0], np.cumsum(steps)])
    Ts, zoom = path.Ts_camera_world.copy(), path.zoom.copy()
    for i, first in enumerate(frames):
        last = frames[i + 1] if i + 1 < len(frames) else len(path) - 1
        at, after = i, min(i + 1, len(frames) - 1)
        length = max(travelled[last] - travelled[first], 1e-300)
        shares = (travelled[first : last + 1] - travelled[first]) / length
        turn = rotation_between(drift[at, :3, :3], drift[after, :3, :3], shares)
        step = drift[after, :3, 3] - drift[at, :3, 3]
        by = transform(turn, drift[at, :3, 3] + shares[:, None] * step)
        Ts[first : last + 1] = path.Ts_camera_world[first : last + 1] @ by
        more = ratio[at] + shares * (ratio[after] - ratio[at])
        zoom[first : last + 1] = path.zoom[first : last + 1] * np.exp(more)
    for frame, each in held.items():
        Ts[frame], zoom[frame] = each.T_camera_world, each.zoom
    return CameraPath(Ts, zoom)


def rigid_inverse(T: Array) -> Array:
    """(..., 4, 4) the inverse of rigid motions."""
    R = transpose(T[..., :3, :3])
    return transform(R, -(R @ T[..., :3, 3, None])[..., 0])
