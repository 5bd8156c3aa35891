"""How far joints that one film shows lie from where another film's rays would have them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from keypose.tracker.geometry.camera_path import rigid_inverse
from keypose.tracker.geometry.rotations import Array

if TYPE_CHECKING:
    from keypose.tracker.films.cameras import FoundCamera
    from keypose.tracker.films.sightings import Sightings


def epipolar_residuals(first: Sightings, film: Sightings, camera: FoundCamera) -> Array:
    """(N, J) signed distances of joints from the other film's rays (Sampson), in standard
    deviations; NaN where not both films show a joint.  first, film: at the same moments."""
    used = (first.scale > 0) & (film.scale > 0)
    a, b = (np.concatenate([f.xy[used], np.ones((used.sum(), 1))], axis=1) for f in (first, film))
    a = a / np.array([camera.first_focal, camera.first_focal, 1.0])
    b = b / np.array([camera.focal, camera.focal, 1.0])
    Ts_film = film.Ts_camera_base(camera.metres) @ camera.T_camera_first
    E = essential(Ts_film @ rigid_inverse(first.Ts_camera_base()))[np.nonzero(used)[0]]
    Ea, Eb = np.einsum("nij,nj->ni", E, a), np.einsum("nij,ni->nj", E, b)
    off = (b * Ea).sum(axis=1)
    variance = (Ea[:, :2] ** 2).sum(axis=1) / film.scale[used] ** 2
    variance += (Eb[:, :2] ** 2).sum(axis=1) / first.scale[used] ** 2
    residuals = np.full(used.shape, np.nan)
    residuals[used] = off / np.sqrt(np.maximum(variance, 1e-30))
    return residuals


def essential(T_camera_first: Array) -> Array:
    """(..., 3, 3) E with bᵀ E a = 0 of rays a of the first camera and b of the other that meet."""
    x, y, z = np.moveaxis(T_camera_first[..., :3, 3], -1, 0)
    nought = np.zeros_like(x)
    cross = np.stack([nought, -z, y, z, nought, -x, -y, x, nought], axis=-1)
    return np.asarray(cross.reshape(*x.shape, 3, 3) @ T_camera_first[..., :3, :3])
