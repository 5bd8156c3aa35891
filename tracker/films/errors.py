"""By how much a motion misses what films show of its joints."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.films.mend import SeenInFilm
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.keypoints import JOINTS
from keypose.tracker.keypoints.on_body import points_on_body
from keypose.tracker.solver.posed import BodyPoints

LEAST_VISIBILITY: Final = 0.5
"""Of a joint that a film is said to see."""


@dataclass(frozen=True, eq=False)
class FilmErrors:
    """How far the joints of N frames lie from where one film shows them.

    name: of the film.  first_frame: of the first film.  px (N, J): in its picture, of `JOINTS`; NaN
    where it does not see one.  aside_m (N, J): the same in space, from the ray of its camera.
    """

    name: str
    first_frame: int
    px: Array
    aside_m: Array

    @property
    def median_px(self) -> float:
        """NaN where it sees nothing."""
        seen = self.px[np.isfinite(self.px)]
        return float(np.median(seen)) if seen.size else np.nan

    def rows_at(self, frames: Array) -> NDArray[np.int64]:
        """(M,) its rows nearest to frames of the first film; −1 beyond them."""
        rows = np.round(np.asarray(frames)).astype(np.int64) - self.first_frame
        return np.where((rows >= 0) & (rows < len(self.px)), rows, -1)

    def at(self, frames: Array) -> FilmErrors:
        """The same of other frames, the nearest to each, which need not follow one another."""
        rows = self.rows_at(frames)
        px, aside_m = (
            np.where((rows >= 0)[:, None], each[rows], np.nan) for each in (self.px, self.aside_m)
        )
        return FilmErrors(self.name, 0, px, aside_m)


def film_errors(
    skeleton: Skeleton,
    motion: Trajectory,
    seen: Sequence[Mapping[str, SeenInFilm]],
    names: Mapping[str, str],
) -> tuple[FilmErrors, ...]:
    """What every film shows of a motion, in the order of the names.

    motion: before the first camera; NaN where it is not known.  seen: by frame, what films show, by
    their ids.  names: of the films, by their ids.
    """
    index, parts, points = points_on_body(skeleton.body, JOINTS)
    shape = len(motion), len(JOINTS)
    joints = np.full((*shape, 3), np.nan)
    places = BodyPoints.single(skeleton, parts, points)
    joints[:, index] = places.at(motion.transforms(skeleton))
    px = {film: np.full(shape, np.nan) for film in names}
    aside_m = {film: np.full(shape, np.nan) for film in names}
    for row, films in enumerate(seen):
        for film, sight in films.items():
            px[film][row], aside_m[film][row] = _missed(joints[row], sight)
    return tuple(
        FilmErrors(name, motion.first_frame, px[film], aside_m[film])
        for film, name in names.items()
    )


def _missed(joints: Array, sight: SeenInFilm) -> tuple[Array, Array]:
    """(J,) pixels and metres by which joints (J, 3) lie beside where a film shows them."""
    p = joints @ sight.T_film_first[:3, :3].T + sight.T_film_first[:3, 3]
    with np.errstate(invalid="ignore"):
        sees = np.isfinite(sight.uv).all(axis=-1) & (sight.visibility >= LEAST_VISIBILITY)
        sees &= sight.camera.depth(p) > 0
    px = np.linalg.norm(sight.camera.project(p) - sight.uv, axis=-1)
    ray = sight.camera.back_project(sight.uv, 1.0)
    ray = ray / np.linalg.norm(ray, axis=-1, keepdims=True)
    aside_m = np.linalg.norm(np.cross(p, ray), axis=-1)
    return np.where(sees, px, np.nan), np.where(sees, aside_m, np.nan)
