"""Whether films agree of a keyframe: whether its joints are where the rays of all of them meet.

Where on its part a detector puts a joint is learnt from keyframes. One that was posed over one film
alone has a depth that another film contradicts: learnt from it, that film would be explained away.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from keypose.tracker.body.modify import height
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.geometry.triangulation import where_rays_meet
from keypose.tracker.keypoints.keypoints import JOINTS, Keypoints, joints_in
from keypose.tracker.keypoints.on_body import FEWEST, points_on_body
from keypose.tracker.solver.posed import BodyPoints
from keypose.tracker.tracking.film_beside import FilmBeside

SURE = 0.5
"""Visibility of a joint from which a film counts."""
AGREED = 0.019
"""Share of the body's height by which joints of a keyframe lie beside where rays meet, in the
median. Six keyframes of a man on a beam, by two films: exact ones 0.012 to 0.017, those posed over
one film, joints 8 cm (σ) off in depth, 0.022 to 0.055, the same mended by both 0.006 to 0.015."""


def films_agree(
    frame: int,
    pose: Pose,
    skeleton: Skeleton,
    camera: Camera,
    keypoints: Keypoints,
    films: Sequence[FilmBeside],
) -> bool:
    """Whether the films agree of a keyframe; so they do where fewer than two see it.

    pose: before the first film's camera, whose keypoints these are.
    """
    if not films:
        return True
    shown = [(camera, keypoints.over(frame, frame), np.eye(4))]
    for film in films:
        beside = film.keypoints_at(frame, frame)
        if beside is not None:
            shown.append((film.film.camera, beside, film.Ts_first[frame]))
    xy = np.stack([_rays(camera, over) for camera, over, _ in shown])
    sure = np.stack([joints_in(over, over.visibility)[0] > SURE for _, over, _ in shown])
    sure &= np.isfinite(xy).all(axis=-1)
    Ts = np.stack([T for *_, T in shown])[:, None]
    met = where_rays_meet(np.nan_to_num(xy)[:, None], sure[:, None].astype(float), Ts)[0]
    index, parts, points = points_on_body(skeleton.body, JOINTS)
    joints = BodyPoints.single(skeleton, parts, points).at(pose_transforms(skeleton, pose))
    off = np.linalg.norm(met[index] - joints, axis=-1)
    if np.isfinite(off).sum() < FEWEST:
        return True
    return bool(np.nanmedian(off) <= AGREED * height(skeleton.body))


def _rays(camera: Camera, keypoints: Keypoints) -> Array:
    """(J, 2) x/z and y/z of `JOINTS` in a single frame."""
    return camera.back_project(joints_in(keypoints, keypoints.uv)[0], 1.0)[:, :2]
