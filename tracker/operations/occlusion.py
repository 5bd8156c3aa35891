"""What other bodies hide of the one that is posed: regions of the film that say nothing of it.

Both bodies are drawn into one buffer of depths. Where the other one is nearer, its pixels are kept
out as the regions are that a person drew.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Final, TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.pose import pose_transforms
from keypose.tracker.body.raster import BodyMesh, raster
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.geometry.view import ViewCamera
from keypose.tracker.session.schema import Session
from keypose.tracker.session.settings import IgnoreMask

WIDTH_PX: Final = 320
"""Of the buffer: outlines of bodies are not known better than to some pixels of the film."""
WIDER_SHARE: Final = 0.006
"""Of the film's width, by which a region is wider than the body: that is where it is about."""
NEARER_M: Final = 0.1
"""By so much a body has to be nearer to hide another one: depths are not known better."""
LEAST_AREA_PX: Final = 4.0
"""Of a region, in the buffer."""

Moving: TypeAlias = tuple[Skeleton, Trajectory]


def ignored_regions(session: Session) -> tuple[IgnoreMask, ...]:
    """The regions of the film that say nothing of the body that is posed: those that a person drew,
    and those in which other bodies are before it."""
    return (*session.view.ignore_masks, *_hidden(session))


def _hidden(session: Session) -> tuple[IgnoreMask, ...]:
    """Regions for what other bodies hide of the one that is posed between its keyframes; both are
    taken to move evenly between keyframes, so that neither waits for the motion of the other."""
    own = [(Skeleton.of(session.subject.body), motion) for motion in _motions(session)]
    regions: list[IgnoreMask] = []
    for body in session.bodies:
        if body.id == session.subject.id:
            continue
        skeleton = Skeleton.of(body.body)
        for motion in _motions(session.about(body.id)):
            for each in own:
                regions += _regions(session, (skeleton, motion), each)
    return tuple(regions)


def _motions(session: Session) -> list[Trajectory]:
    """The motions between neighbouring keyframes of the body that is posed, even in the world."""
    skeleton = Skeleton.of(session.subject.body)
    return [
        Trajectory(
            begin.frame,
            *session.film_camera.even_motion(
                begin.pose(skeleton),
                end.pose(skeleton),
                (begin.frame, end.frame),
                np.arange(begin.frame, end.frame + 1),
            ),
        )
        for begin, end in pairwise(session.subject.keyframes)
    ]


def _regions(session: Session, nearer: Moving, own: Moving) -> Iterator[IgnoreMask]:
    """Where another body is before the own one, in each frame of both motions."""
    camera = session.view.camera
    height_px = max(1, round(WIDTH_PX * camera.height / camera.width))
    meshes = [BodyMesh.of(skeleton) for skeleton, _ in (nearer, own)]
    first = max(motion.first_frame for _, motion in (nearer, own))
    last = min(motion.last_frame for _, motion in (nearer, own))
    for frame in range(first, last + 1):
        lens = session.film_camera.at(frame)
        view = ViewCamera.of(lens).resized(WIDTH_PX, height_px)
        Ts = [pose_transforms(skeleton, motion.pose(frame)) for skeleton, motion in (nearer, own)]
        boxes = [_box(view, mesh.posed(T)) for mesh, T in zip(meshes, Ts, strict=True)]
        if not _overlap(*boxes):
            continue
        depth, own_depth = (raster(mesh, T, view).depth for mesh, T in zip(meshes, Ts, strict=True))
        behind = np.where(np.isfinite(own_depth), own_depth, Ts[1][0, 2, 3])
        for polygon in _outlines(depth < behind - NEARER_M):
            uv = (polygon + 0.5) * (camera.width / WIDTH_PX) - 0.5
            film = lens.project(lens.without_distortion().back_project(uv, 1.0))
            corners = tuple((float(u), float(v)) for u, v in film)
            yield IgnoreMask(polygon=corners, first_frame=frame, last_frame=frame)


def _box(view: ViewCamera, p_eye: Array) -> Array:
    """(2, 2) the corners of what a view shows of points; the whole picture where one is behind
    it."""
    uv = view.project(p_eye)
    if np.isnan(uv).any():
        return np.array([[0.0, 0.0], [view.width, view.height]])
    return np.array([uv.min(axis=0), uv.max(axis=0)])


def _overlap(first: Array, second: Array) -> bool:
    return bool((np.maximum(first[0], second[0]) < np.minimum(first[1], second[1])).all())


def _outlines(region: NDArray[np.bool_]) -> Iterator[Array]:
    """The outlines (N, 2) of the pieces of a region, a little wider."""
    side = 2 * max(1, round(WIDER_SHARE * WIDTH_PX)) + 1
    wider = cv2.dilate(region.astype(np.uint8), np.ones((side, side), np.uint8))
    contours, _ = cv2.findContours(wider, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    for contour in contours:
        if len(contour) > 2 and cv2.contourArea(contour) > LEAST_AREA_PX:
            yield contour[:, 0].astype(np.float64)
