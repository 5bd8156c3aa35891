"""What other films show of posed keyframes, as residuals of sizes and poses.

Their keypoints are compared with the body's joints: so lengths are measured across the first film's
view and along it. Thicknesses are measured where contours are looked at, in the first film alone.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from keypose.tracker.body.pose import Pose
from keypose.tracker.films.mend import SeenInFilm, sigmas_beside
from keypose.tracker.fitting.sizes.proportions import Proportions
from keypose.tracker.fitting.sizes.shared import (
    FilmOfPose,
    Residuals,
    SeenBeside,
    Shared,
    SharedFit,
    away_beside,
)
from keypose.tracker.keypoints.keypoints import JOINTS
from keypose.tracker.keypoints.on_body import points_on_body
from keypose.tracker.solver.posed import BodyPoints


def seen_beside(
    proportions: Proportions, posed: Sequence[Pose], films: Sequence[Iterable[SeenInFilm]]
) -> tuple[tuple[SeenBeside, ...], ...]:
    """By pose what other films show of it; nothing at all where they show it nowhere.

    films: by pose, what each of them shows at its moment.
    """
    by_pose = tuple(
        tuple(row for film in here if (row := _seen(proportions, pose, film)) is not None)
        for pose, here in zip(posed, films, strict=True)
    )
    return by_pose if any(by_pose) else ()


def _seen(proportions: Proportions, pose: Pose, film: SeenInFilm) -> SeenBeside | None:
    """What one film shows of a pose; None where that is another body, or none."""
    skeleton = proportions.skeleton
    index, parts, points = points_on_body(proportions.body, JOINTS)
    where = BodyPoints.single(skeleton, parts, points)
    sigma = sigmas_beside(skeleton, pose, where, index, film)
    if sigma is None:
        return None
    is_seen = np.isfinite(sigma)
    uv, count = film.uv[index][is_seen], int(is_seen.sum())
    rows = Residuals(
        np.tile(parts[is_seen], 2),
        np.tile(points[is_seen], (2, 1)),
        np.repeat(np.eye(2), count, axis=0),
        uv.T.ravel(),
        np.tile(sigma[is_seen], 2),
    )
    return SeenBeside(FilmOfPose(film.camera, film.T_film_first), rows)


def error_beside(fit: SharedFit, shared: Shared) -> float:
    """The median distance of joints from where other films show them, sigmas; 0 without any."""
    away = [
        np.hypot(*np.split(away_beside(fit, shared, k, row), 2))
        for k in range(len(fit.posed))
        for row in fit.seen_beside(k)
    ]
    return float(np.median(np.concatenate(away))) if away else 0.0
