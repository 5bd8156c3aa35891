"""Which joints other bodies lie over in the picture of a keyframe: what a detector says of them
there may be invented, or the other's."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, apply_transform
from keypose.tracker.keypoints.keypoints import JOINTS
from keypose.tracker.keypoints.on_body import FACE, height_px, is_persons, points_on_body
from keypose.tracker.session.annotations import KeypointCorrection
from keypose.tracker.session.bodies import TrackedBody
from keypose.tracker.session.keyframe import Keyframe
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.bodies_before import skeleton_and_vertices
from keypose.tracker.storage.by_id import ById

WIDER_SHARE: Final = 0.06
"""Of a person's height, by which clothes and hair cover more than the body: so far a right keyframe
may be from where a detector believes that it sees a limb behind them."""


def covered_joints(
    session: Session, keyframes: Sequence[Keyframe]
) -> tuple[KeypointCorrection, ...]:
    """The joints of the posed body that another person lies over at some of its keyframes, before
    or behind it, as joints that are not seen; in the order of keypoint corrections.

    A thing covers nothing: no detector takes it for a limb, and a hand that holds it is seen. Nor
    is a joint covered that a person corrected. Other bodies are taken to move evenly between
    their own keyframes.
    """
    if len(session.bodies) == 1:
        return ()
    skeleton = Skeleton.of(session.subject.body)
    corrected = {(each.frame, each.joint) for each in session.view.keypoint_corrections}
    return tuple(
        KeypointCorrection(frame=keyframe.frame, joint=name)
        for keyframe in keyframes
        for name in sorted(_covered(session, keyframe.frame, keyframe.pose(skeleton)))
        if (keyframe.frame, name) not in corrected
    )


def _covered(session: Session, frame: int, pose: Pose) -> set[str]:
    """The joints of a pose at a frame that another person lies over."""
    names = (*JOINTS, *FACE)
    own = session.subject
    on_body = points_on_body(own.body, names)
    lens = session.film_camera.at(frame).without_distortion()
    Ts = pose_transforms(Skeleton.of(own.body), pose)[on_body.part]
    uv = lens.project(apply_transform(Ts, on_body.point[:, None])[:, 0])
    joints = {names[k]: at for k, at in zip(on_body.indices, uv, strict=True)}
    covered: set[str] = set()
    for body in session.bodies:
        if body.id == own.id or not is_persons(body.body):
            continue
        there = _pose_at(session, body, frame)
        if there is None:
            continue
        wider_px = WIDER_SHARE * height_px(Skeleton.of(body.body), lens, there)
        for outline in _outlines(body, there, lens):
            covered |= {name for name, at in joints.items() if _is_within(outline, at, wider_px)}
    return covered


def _pose_at(session: Session, body: TrackedBody, frame: int) -> Pose | None:
    """A body's pose at a frame, even between its keyframes; None before and after them."""
    skeleton = Skeleton.of(body.body)
    earlier = [each for each in body.keyframes if each.frame <= frame][-1:]
    later = [each for each in body.keyframes if each.frame >= frame][:1]
    if not earlier or not later:
        return None
    (begin,), (end,) = earlier, later
    if begin is end:
        return begin.pose(skeleton)
    span, start = (begin.frame, end.frame), begin.pose(skeleton)
    Rs, ps = session.film_camera.even_motion(start, end.pose(skeleton), span, np.array([frame]))
    return Pose(Rs[0], ps[0])


def _outlines(body: TrackedBody, pose: Pose, lens: Camera) -> Iterator[NDArray[np.float32]]:
    """The outlines (N, 2) in the picture, pixels, of those parts of a body that are before the
    camera."""
    skeleton, vertices = skeleton_and_vertices(ById(body.body))
    for T, corners in zip(pose_transforms(skeleton, pose), vertices, strict=True):
        uv = lens.project(apply_transform(T, corners))
        if np.isfinite(uv).all():
            yield np.asarray(cv2.convexHull(uv.astype(np.float32)), np.float32)


def _is_within(outline: NDArray[np.float32], uv: Array, wider_px: float) -> bool:
    """Whether a point of the picture lies within an outline that is so much wider."""
    if not np.isfinite(uv).all():
        return False
    inside_px = cv2.pointPolygonTest(outline, (float(uv[0]), float(uv[1])), True)
    return bool(inside_px >= -wider_px)
