"""What films saw of one body at the same moments, as rays of their cameras."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.film_clock import FilmClock, sampled
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.keypoints import Keypoints, joints_in

SIGMA_SHARE = 0.01
"""Standard deviation of a joint in the picture, of the body's height: a detector's own place of a
joint is in it, which another view does not share."""
HEIGHT_M = 1.7
"""Of the network's person, which its metres are of."""


@dataclass(frozen=True, eq=False)
class Sightings:
    """The joints of one body as a film saw them at N moments, `JOINTS` in their order.

    xy (N, J, 2): as x/z and y/z of the film's camera without distortion and zoom, NaN where not
        seen.
    visibility (N, J): 0 where not seen.
    sigma: standard deviation of an xy of visibility 1.
    p_hips (N, J, 3): metres in the camera's axes, the middle of the hips at 0; NaN where unknown.
    path: where the camera was, in a base frame of its own, in which it is looked for; None of one
        that stands still, which is that base itself.
    unit_shift (N, 3): where the base's origin lies besides in the camera's frame, in a unit that
        nobody knows, of a path that the background alone shows; None where that is in metres.
    """

    xy: Array
    visibility: Array
    sigma: float
    p_hips: Array
    path: CameraPath | None = None
    unit_shift: Array | None = None

    @classmethod
    def of(
        cls,
        keypoints: Keypoints,
        camera: Camera,
        frame_count: int,
        path: CameraPath | None = None,
        unit_shift: Array | None = None,
    ) -> Sightings:
        """What a film's keypoints show at each of its frames, of which path and unit_shift are."""
        over = keypoints.over(0, frame_count - 1)
        uv, seen_by = joints_in(over, over.uv), joints_in(over, over.visibility)
        xy = camera.back_project(uv, 1.0)[..., :2]
        if path is not None:
            xy = xy / path.zoom[:, None, None]
        visibility = np.where(np.isfinite(xy).all(axis=-1), np.nan_to_num(seen_by), 0.0)
        p_hips = np.full((*xy.shape[:2], 3), np.nan)
        if over.p_hips is not None:
            p_hips = joints_in(over, over.p_hips)
        sigma = SIGMA_SHARE * _height(xy, p_hips, visibility)
        return cls(xy, visibility, sigma, p_hips, path, unit_shift)

    def __len__(self) -> int:
        return len(self.xy)

    def at(self, clock: FilmClock, moments: ArrayLike) -> Sightings:
        """The same at frames of the first film."""
        frames = clock.frames_at(moments)
        xy, visibility = sampled(self.xy, frames), sampled(self.visibility, frames)
        is_seen = np.isfinite(xy).all(axis=-1) & np.isfinite(visibility)
        p_hips, path, unit_shift = sampled(self.p_hips, frames), self.path, self.unit_shift
        inside = np.clip(frames, 0, len(self) - 1)
        path = None if path is None else path.sampled(inside)
        unit_shift = None if unit_shift is None else sampled(unit_shift, inside)
        visibility = np.where(is_seen, visibility, 0.0)
        return replace(
            self, xy=xy, visibility=visibility, p_hips=p_hips, path=path, unit_shift=unit_shift
        )

    def rows(self, rows: NDArray[np.int64]) -> Sightings:
        """The same of some of its moments alone."""
        path = self.path
        if path is not None:
            path = CameraPath(path.Ts_camera_world[rows], path.zoom[rows])
        return replace(
            self,
            xy=self.xy[rows],
            visibility=self.visibility[rows],
            p_hips=self.p_hips[rows],
            path=path,
            unit_shift=None if self.unit_shift is None else self.unit_shift[rows],
        )

    def Ts_camera_base(self, metres: float = 0.0) -> Array:
        """(N, 4, 4) from the base frame to the camera's at each moment, were its unit so long."""
        still = np.broadcast_to(np.eye(4), (len(self), 4, 4))
        Ts = still if self.path is None else self.path.Ts_camera_world
        if self.unit_shift is None or metres == 0:
            return Ts
        Ts = Ts.copy()
        Ts[:, :3, 3] += metres * self.unit_shift
        return Ts

    def zoomed(self, focal: float) -> Sightings:
        """The same by a lens that is so many times as long as it was taken to be."""
        return replace(self, xy=self.xy / focal, sigma=self.sigma / focal)

    @property
    def scale(self) -> Array:
        """(N, J) 1/σ of an xy, 0 where not seen: what is half seen is half as sure."""
        return self.visibility / self.sigma

    @property
    def seen(self) -> NDArray[np.bool_]:
        """(N,) whether enough of the body is seen to tell how it stands."""
        return np.asarray((self.visibility > SURE).sum(axis=-1) >= FEWEST_SEEN)


SURE = 0.5
FEWEST_SEEN = 8
"""Visibility of a joint that is sure, and of the twelve joints so many."""


def _height(xy: Array, p_hips: Array, visibility: Array) -> float:
    """The usual height of the body as x/z: by how many times the network's metres are as large."""
    ratios = []
    for rays, p, sure in zip(xy, p_hips, visibility > SURE, strict=True):
        if sure.sum() < FEWEST_SEEN or not np.isfinite(p[sure]).all():
            continue
        away, apart = rays[sure] - rays[sure].mean(axis=0), p[sure, :2] - p[sure, :2].mean(axis=0)
        ratios.append(np.sqrt((away**2).sum() / (apart**2).sum()))
    if ratios:
        return HEIGHT_M * float(np.median(ratios))
    extents = np.ptp(np.where(visibility[..., None] > SURE, xy, np.nan), axis=1)
    return float(np.nanmedian(extents.max(axis=-1))) if np.isfinite(extents).any() else 1.0
