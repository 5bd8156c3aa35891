"""Say where in a picture the background may be: beside the body and what a person masked."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, apply_transform, rotation_between
from keypose.tracker.session.settings import IgnoreMask

NEAREST_M: Final = 0.1
"""A part nearer to the camera covers what nobody can say."""
MARGIN_SHARE: Final = 0.06
"""Of the body's extent in the picture, around its parts: clothes, hair, and poses that are off."""
FARTHEST_FRAMES: Final = 60
"""From a pose that is known, beyond which nobody says where the body is."""
WIDEST_PX: Final = 1e4
"""To which what lies far outside the picture is brought, so that OpenCV can draw it."""


@dataclass(frozen=True, eq=False)
class BodyBackground:
    """The background of a film in which a body is about where it is known to be.

    camera: of the film, with its distortion.  poses: camera frame, by frame; between two of them
    the body is on the way from one to the other.  zoom (F,): the focal length with which they are
    seen, as a multiple of the camera's; None where that is 1.
    """

    skeleton: Skeleton
    camera: Camera
    poses: Mapping[int, Pose]
    masks: Sequence[IgnoreMask] = ()
    zoom: Array | None = None

    def __call__(self, frame: int) -> NDArray[np.bool_] | None:
        """(H, W) where the background may be; None where it may be everywhere."""
        masks = [m for m in self.masks if m.first_frame <= frame <= m.last_frame]
        pose = self._pose(frame)
        if pose is None and not masks:
            return None
        covered = np.zeros((self.camera.height, self.camera.width), np.uint8)
        for mask in masks:
            corners = np.clip(np.array(mask.polygon), -WIDEST_PX, WIDEST_PX)
            cv2.fillPoly(covered, [np.round(corners).astype(np.int32)], 1)
        if pose is not None:
            camera = (
                self.camera if self.zoom is None else self.camera.zoomed(float(self.zoom[frame]))
            )
            self._cover(covered, pose, camera)
        return np.asarray(covered == 0)

    @cached_property
    def _frames(self) -> list[int]:
        return sorted(self.poses)

    def _pose(self, frame: int) -> Pose | None:
        """The pose of a frame; None where none is known nearby."""
        at = bisect_left(self._frames, frame)
        around = self._frames[max(at - 1, 0) : at + 1]
        if not around or min(abs(f - frame) for f in around) > FARTHEST_FRAMES:
            return None
        if frame in self.poses or len(around) == 1:
            return self.poses[min(around, key=lambda f: abs(f - frame))]
        first, last = around
        share = (frame - first) / (last - first)
        before, after = self.poses[first], self.poses[last]
        Rs = rotation_between(before.Rs_parent_part, after.Rs_parent_part, np.array([share]))[0]
        p = before.p_camera_root + share * (after.p_camera_root - before.p_camera_root)
        return Pose(Rs, p)

    def _cover(self, covered: NDArray[np.uint8], pose: Pose, camera: Camera) -> None:
        outlines = [uv for uv in self._outlines(pose, camera) if len(uv) > 2]
        if not outlines:
            return
        every = np.concatenate(outlines)
        margin = max(2.0, MARGIN_SHARE * float(np.ptp(every, axis=0).max()))
        for uv in outlines:
            hull = cv2.convexHull(np.round(uv).astype(np.int32))
            cv2.fillConvexPoly(covered, hull, 1)
            cv2.polylines(covered, [hull], True, 1, thickness=max(1, round(2 * margin)))

    def _outlines(self, pose: Pose, camera: Camera) -> list[Array]:
        """Pixels (K, 2) of every part's corners."""
        Ts, outlines = pose_transforms(self.skeleton, pose), []
        for T, part in zip(Ts, self.skeleton.body.parts, strict=True):
            p = apply_transform(T, part.shape.mesh().vertices)
            if p[:, 2].min() > NEAREST_M:
                outlines.append(np.clip(camera.project(p), -WIDEST_PX, WIDEST_PX))
        return outlines
