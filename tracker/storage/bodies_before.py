"""Which bodies may hide the one that is posed, by where keyframes have them in the picture."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Final, NamedTuple

import numpy as np

from keypose.tracker.body.pose import pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array, apply_transform
from keypose.tracker.session.bodies import TrackedBody
from keypose.tracker.session.keyframe import Keyframe
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.by_id import ById

WIDER_SHARE: Final = 0.15
"""Of the size of a body's way in the picture: between its keyframes it goes round about."""


class Extent(NamedTuple):
    """The corners (2,) of what is seen of a body, pixels, and its least and greatest depth."""

    low: Array
    high: Array
    nearest_m: float
    farthest_m: float


def keyframes_before(
    session: Session, span: tuple[int, int], ends: Sequence[Keyframe]
) -> list[tuple[TrackedBody, list[Keyframe]]]:
    """The other bodies that may be before the posed one between two of its keyframes, each with its
    keyframes around these frames: their ways in the picture meet, and the other one comes nearer to
    the camera than the posed one goes."""
    own = _extent(session, session.subject, ends)
    wider = WIDER_SHARE * (own.high - own.low)
    before = []
    for body in session.bodies:
        posed = [] if body.id == session.subject.id else _around(body.keyframes, span)
        if len(posed) < 2:
            continue
        beside = _extent(session, body, posed)
        low, high = (
            np.maximum(own.low - wider, beside.low),
            np.minimum(own.high + wider, beside.high),
        )
        if (low < high).all() and beside.nearest_m < own.farthest_m:
            before.append((body, posed))
    return before


def _around(keyframes: Sequence[Keyframe], span: tuple[int, int]) -> list[Keyframe]:
    """The keyframes within a span, and the next on either side."""
    earlier = [each for each in keyframes if each.frame <= span[0]][-1:]
    within = [each for each in keyframes if span[0] < each.frame < span[1]]
    later = [each for each in keyframes if each.frame >= span[1]][:1]
    return [*earlier, *within, *later]


def _extent(session: Session, body: TrackedBody, keyframes: Sequence[Keyframe]) -> Extent:
    """What is seen of a body at all of these keyframes."""
    camera = session.film_camera
    each = [
        _extent_at(
            ById(keyframe), ById(body.body), ById(camera.lens), camera.zoom_at(keyframe.frame)
        )
        for keyframe in keyframes
    ]
    low, high = (np.array([getattr(extent, end) for extent in each]) for end in ("low", "high"))
    nearest, farthest = (extent.nearest_m for extent in each), (e.farthest_m for e in each)
    return Extent(low.min(axis=0), high.max(axis=0), min(nearest), max(farthest))


@lru_cache(maxsize=4096)
def _extent_at(keyframe: ById, body: ById, lens: ById, zoom: float) -> Extent:
    """Cached: asked for after every edit, of every segment."""
    skeleton, vertices = skeleton_and_vertices(body)
    Ts = pose_transforms(skeleton, keyframe.it.pose(skeleton))
    p_camera = np.concatenate(
        [apply_transform(T, points) for T, points in zip(Ts, vertices, strict=True)]
    )
    camera = lens.it.zoomed(zoom).without_distortion()
    uv, depths = camera.project(p_camera), camera.depth(p_camera)
    return Extent(uv.min(axis=0), uv.max(axis=0), float(depths.min()), float(depths.max()))


@lru_cache(maxsize=32)
def skeleton_and_vertices(body: ById) -> tuple[Skeleton, tuple[Array, ...]]:
    """The body, and the corners of each part's shape in the part's frame."""
    return Skeleton.of(body.it), tuple(part.shape.mesh().vertices for part in body.it.parts)
