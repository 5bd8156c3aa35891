"""Soft anchors: a detector's keypoints of one segment, corrected by what its keyframes say of them.

A detector puts each joint at a place of its own on the body, and knows depth only roughly. Both
keyframes are exact: they say where on its part the detector puts a joint (an offset in the part's
frame, held near zero), and by how much its depth is off.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.keypoints import JOINTS, Keypoints
from keypose.tracker.keypoints.lifted_depth import depth_along_view
from keypose.tracker.keypoints.on_body import (
    FACE,
    FEWEST,
    OTHER_PERSON,
    foot_ends,
    height_px,
    points_on_body,
)
from keypose.tracker.keypoints.outliers import excursions
from keypose.tracker.solver.least_squares import damped_step
from keypose.tracker.solver.pose_terms import DepthFromRoot, PointsInPicture
from keypose.tracker.solver.posed import BodyPoints, Posed, with_free_parts
from keypose.tracker.solver.projection import image_jacobian, image_points
from keypose.tracker.solver.robust import SQUARED, Huber, Kernel
from keypose.tracker.solver.sigmas import (
    BY_HAND_SHARE,
    FACE_ON_PART_M,
    KEYPOINT_DEPTH_M,
    KEYPOINT_SHARE,
    LEAST_DEPTH_M,
    ON_PART_BY_EYE_M,
    ON_PART_M,
    keypoint_blur,
)
from keypose.tracker.solver.terms import Term
from keypose.tracker.tracking.cues.sides import exchanged_sides
from keypose.tracker.tracking.scene import Scene
from keypose.tracker.tracking.segment import NEAREST_M, Segment

FAR_SIGMA = 4.0
"""A keypoint farther than this from a keyframe's joint pulls no harder: it may be another's."""


BY_FRAME = (
    *("uv", "scale", "depth", "depth_scale", "visibility", "by_hand", "depth_sigma_m"),
    "feet_uv",
)
FOOT_SEEN = 0.5
"""Visibility from which a heel or a toe is compared with."""


@dataclass(frozen=True, eq=False)
class Anchors:
    """Where the joints of the N frames of a segment are, as far as a detector saw them.

    points: K on the body, carried by parts (K,).
    uv (N, K, 2): pixels of the undistorted pictures worked on.
    scale (N, K): 1/σ in 1/px, 0 where nothing is known.  visibility (N, K).
    depth (N, K): metres farther than the root; depth_scale (N, K): 1/σ, 0 where unknown.
    height_px: of the body, standing.
    joints, by_hand (N, K): the points without the detector's offset, and 1/σ of where a person set
    them, 0 where nobody did; `scale` is 0 there.
    exchanged: left and right of some frames were exchanged against what the detector says.
    depth_sigma_m (N, K): the detector's own, of depths that were lifted; NaN of others.
    feet: F heels and toes on the body, feet_uv (N, F, 2): where they are seen, NaN where they are
    not: what feet are judged by, which follow nothing.
    """

    points: BodyPoints
    parts: NDArray[np.int64]
    uv: Array
    scale: Array
    depth: Array
    depth_scale: Array
    visibility: Array
    height_px: float
    joints: BodyPoints
    by_hand: Array
    depth_sigma_m: Array
    feet: BodyPoints
    feet_uv: Array
    exchanged: bool = False

    def terms(self, camera: Camera, kernel: Kernel, frames: slice | int) -> tuple[Term, ...]:
        """About the poses of these frames, or of one. kernel: of the distances in the picture;
        what a person set is never taken for a detector's mistake."""
        uv = self.uv[frames]
        anchor_terms: list[Term] = [
            PointsInPicture(self.points, camera, uv, self.scale[frames], NEAREST_M, kernel)
        ]
        if self.by_hand[frames].any():
            exact = self.by_hand[frames]
            anchor_terms.append(PointsInPicture(self.joints, camera, uv, exact, NEAREST_M, SQUARED))
        depth, scale = self.depth[frames], self.depth_scale[frames]
        if scale.any():
            anchor_terms.append(DepthFromRoot(self.points, depth, scale, Huber()))
        return tuple(anchor_terms)

    def where(self, Ts_camera_part: Array) -> Array:
        """(N, K, 3) where the points are that are compared with `uv`."""
        points, joints = self.points.at(Ts_camera_part), self.joints.at(Ts_camera_part)
        return np.where((self.by_hand > 0)[..., None], joints, points)

    def weighted(self, weight: float) -> Anchors:
        """Divide the detector's standard deviations by this."""
        return replace(self, scale=self.scale * weight, depth_scale=self.depth_scale * weight)

    def of_skeleton(self, skeleton: Skeleton) -> Anchors:
        """The same of the same body with other parts tracked."""
        points = (self.points, self.joints, self.feet)
        on_points, on_joints, on_feet = (each.of_skeleton(skeleton) for each in points)
        return replace(self, points=on_points, joints=on_joints, feet=on_feet)

    def of_rows(self, rows: slice) -> Anchors:
        """The anchors of some frames alone."""
        return replace(self, **{name: getattr(self, name)[rows] for name in BY_FRAME})

    def in_rows(self, rows: NDArray[np.bool_], anchors: Anchors) -> Anchors:
        """Put in those of others in some frames (N,)."""
        mixed = {name: getattr(self, name).copy() for name in BY_FRAME}
        for name, values in mixed.items():
            values[rows] = getattr(anchors, name)[rows]
        return replace(self, **mixed)

    @property
    def known(self) -> NDArray[np.bool_]:
        """(N, K) whether there is anything to compare with."""
        return (self.scale > 0) | (self.by_hand > 0)


@lru_cache(maxsize=8)
def with_free_joints(skeleton: Skeleton) -> Skeleton:
    """The skeleton with those parts free to turn that carry a keypoint, whatever is tracked.

    What a picture's brightness does not decide, such as a limb's turn about itself, a keypoint at
    the limb's far end may.
    """
    _, parts, _ = points_on_body(skeleton.body, (*JOINTS, *FACE))
    return with_free_parts(skeleton, {skeleton.body.names[part] for part in parts})


def anchors_of(
    scene: Scene,
    segment: Segment,
    camera: Camera,
    keypoints: Keypoints,
    *,
    open_end: bool = False,
    followed: Trajectory | None = None,
    agreed: Collection[int] | None = None,
) -> tuple[Anchors, ...]:
    """The anchors of a segment: as the detector has left and right, and, where it seems to
    exchange them, also set right. None where they lie on another body, or there are none.

    scene: of the skeleton with free joints.  camera: of the video, with its distortion.
    open_end: the first keyframe alone is posed.  followed: the motion that brightness shows.
    agreed: the keyframes that show where on its part the detector puts a joint; None: all.
    """
    index, parts, points = points_on_body(scene.skeleton.body, keypoints.names)
    if len(index) < FEWEST:
        return ()
    detected = _undistorted(keypoints.over(segment.first_frame, segment.last_frame), scene, camera)
    height = height_px(scene.skeleton, scene.camera, segment.start)
    keyed = {0: segment.start}
    if not open_end:
        keyed[len(detected) - 1] = segment.end
    places = {n: _places(scene, pose, parts, points) for n, pose in keyed.items()}
    if followed is not None:
        where = BodyPoints.single(scene.skeleton, parts, points)
        uv = image_points(scene.camera, where.at(followed.transforms(scene.skeleton)))
        places = dict(enumerate(uv)) | places
    swapped = exchanged_sides(detected, index, places, height)
    candidates = [detected] if swapped is None else [detected, swapped]
    rows = [n for n in keyed if agreed is None or segment.first_frame + n in agreed]
    anchors_by_sides = [
        _anchors(scene, k, index, parts, points, keyed, rows, height) for k in candidates
    ]
    return tuple(
        replace(anchors, exchanged=k > 0)
        for k, anchors in enumerate(anchors_by_sides)
        if anchors is not None
    )


def keyframe_off_person(
    scene: Scene, segment: Segment, camera: Camera, keypoints: Keypoints
) -> int | None:
    """The one of both keyframes whose body is not where keypoints show the person; None
    where both are, or both are not: they may be another person's then.

    scene: of the skeleton with free joints.  camera: of the video, with its distortion.
    """
    index, parts, points = points_on_body(scene.skeleton.body, keypoints.names)
    ends = {segment.first_frame: segment.start, segment.last_frame: segment.end}
    off = []
    for frame, pose in ends.items():
        uv = _undistorted(keypoints.over(frame, frame), scene, camera).uv[0, index]
        miss = np.linalg.norm(_places(scene, pose, parts, points) - uv, axis=-1)
        if np.isfinite(miss).sum() < FEWEST:
            return None
        most = OTHER_PERSON * height_px(scene.skeleton, scene.camera, pose)
        off += [frame] if np.nanmedian(miss) > most else []
    return off[0] if len(off) == 1 else None


def frame_anchors(
    scene: Scene,
    camera: Camera,
    detected: Keypoints,
    pose: Pose,
    keyed: Sequence[tuple[Pose, Keypoints]],
    kernel: Kernel,
) -> PointsInPicture | None:
    """What the keypoints of one frame say of its pose; None where they lie on another body.

    keyed: other frames' poses and keypoints, which show where on its part a detector puts a joint.
    The poses also show which side is which.
    """
    index, parts, points = points_on_body(scene.skeleton.body, detected.names)
    if len(index) < FEWEST:
        return None
    height = height_px(scene.skeleton, scene.camera, pose)

    def read(keypoints: Keypoints, posed: Pose) -> tuple[Array, Array]:
        """(K, 2) pixels, and (K,) their 1/σ, 0 where nothing is known."""
        own = _undistorted(keypoints, scene, camera)
        places = {0: _places(scene, posed, parts, points)}
        own = exchanged_sides(own, index, places, height) or own
        uv, visibility = own.uv[0, index], own.visibility[0, index]
        is_known = np.isfinite(uv).all(axis=-1)
        scale = np.where(is_known, 1 / _sigma_px(height, visibility), 0.0)
        return np.where(is_known[:, None], uv, 0.0), scale

    uv, scale = read(detected, pose)
    miss = np.linalg.norm(_places(scene, pose, parts, points) - uv, axis=-1)[scale > 0]
    if len(miss) < FEWEST or np.median(miss) > OTHER_PERSON * height:
        return None
    loose = np.array([detected.names[k] in FACE for k in index])
    sigma_m = np.where(loose, FACE_ON_PART_M, ON_PART_BY_EYE_M)
    if keyed:
        read_keyed = [read(keypoints, posed) for posed, keypoints in keyed]
        seen_uv, sure = (np.stack(arrays) for arrays in zip(*read_keyed, strict=True))
        poses = [posed for posed, _ in keyed]
        points = points + _offsets(scene, parts, points, sigma_m, poses, seen_uv, sure)
    where = BodyPoints.single(scene.skeleton, parts, points)
    return PointsInPicture(where, scene.camera, uv, scale, NEAREST_M, kernel)


def _undistorted(keypoints: Keypoints, scene: Scene, camera: Camera) -> Keypoints:
    """Convert to pixels of the undistorted pictures worked on."""
    uv = scene.camera.project(camera.back_project(keypoints.uv, 1.0))
    return replace(
        keypoints, uv=uv, visibility=np.where(np.isfinite(uv[..., 0]), keypoints.visibility, 0.0)
    )


def _places(scene: Scene, pose: Pose, parts: NDArray[np.int64], points: Array) -> Array:
    """(K, 2) pixels of points on the body."""
    return image_points(scene.camera, Posed.of(scene.skeleton, pose).points(parts, points))


def _sigma_px(height: float, visibility: Array) -> Array:
    return KEYPOINT_SHARE * height * keypoint_blur(visibility)


def _anchors(
    scene: Scene,
    keypoints: Keypoints,
    index: NDArray[np.int64],
    parts: NDArray[np.int64],
    points: Array,
    keyed: dict[int, Pose],
    agreed: list[int],
    height: float,
) -> Anchors | None:
    """None where they lie on another body than the one posed, or where no keyframe shows it.

    agreed: those of the keyed rows that show where on its part the detector puts a joint.
    """
    uv = keypoints.uv[:, index]
    is_known = np.asarray(np.isfinite(uv).all(axis=-1))
    by_hand = is_known & (False if keypoints.by_hand is None else keypoints.by_hand[:, index])
    detected = is_known & ~by_hand
    p_hips = None if keypoints.p_hips is None else keypoints.p_hips[:, index]
    names = [keypoints.names[k] for k in index]
    jumped = detected & excursions(uv, is_known, height, names, p_hips)  # depth stays with its side
    visibility = np.where(is_known & ~jumped, keypoints.visibility[:, index], 0.0)
    compared = [n for n in keyed if is_known[n].sum() >= FEWEST]
    miss = [
        np.linalg.norm(_places(scene, keyed[n], parts, points) - uv[n], axis=-1) for n in compared
    ]
    if not compared or any(np.nanmedian(away) > OTHER_PERSON * height for away in miss):
        return None
    scale = np.where(detected & ~jumped, 1 / _sigma_px(height, visibility), 0.0)
    uv = np.where(is_known[..., None], uv, 0.0)
    loose = np.array([name in FACE for name in names])
    sigma_m = np.where(loose, FACE_ON_PART_M, ON_PART_M)
    poses = [keyed[n] for n in agreed]
    joints = BodyPoints.single(scene.skeleton, parts, points)
    points = points + _offsets(scene, parts, points, sigma_m, poses, uv[agreed], scale[agreed])
    depth, depth_scale = _depths(scene, keypoints, index, parts, points, keyed)
    where = BodyPoints.single(scene.skeleton, parts, points)
    exact = by_hand / (BY_HAND_SHARE * height)
    return Anchors(
        where,
        parts,
        uv,
        scale,
        depth,
        depth_scale * detected,
        visibility,
        height,
        joints,
        exact,
        _sigmas_m(keypoints, index),
        *_feet(scene, keypoints),
    )


def _feet(scene: Scene, keypoints: Keypoints) -> tuple[BodyPoints, Array]:
    """The heels and toes of the body, and (N, F, 2) where they are seen."""
    index, parts, points = foot_ends(scene.skeleton.body, keypoints.names)
    is_seen = keypoints.visibility[:, index] >= FOOT_SEEN
    uv = np.where(is_seen[..., None], keypoints.uv[:, index], np.nan)
    return BodyPoints.single(scene.skeleton, parts, points), uv


def _sigmas_m(keypoints: Keypoints, index: NDArray[np.int64]) -> Array:
    """(N, K) of depths that were lifted; NaN of others."""
    if keypoints.depth_sigma_m is None:
        return np.full((len(keypoints), len(index)), np.nan)
    return keypoints.depth_sigma_m[:, index]


def _offsets(
    scene: Scene,
    parts: NDArray[np.int64],
    points: Array,
    sigma_m: Array,
    poses: list[Pose],
    uv: Array,
    scale: Array,
) -> Array:
    """(K, 3) from each point to where on its part the detector puts it.

    The least |offset|²/σ² and distances in the pictures of the keyframes; points near what they
    are, so one linear step is enough.
    """
    A = np.eye(3) / sigma_m[:, None, None] ** 2
    b = np.zeros((len(parts), 3))
    for pose, observed_uv, sure in zip(poses, uv, scale, strict=True):
        posed = Posed.of(scene.skeleton, pose)
        p = posed.points(parts, points)
        R = posed.Ts_camera_part[parts, :3, :3]
        J = image_jacobian(scene.camera, p, np.swapaxes(R, -1, -2))  # (K, 3, 2)
        r = (image_points(scene.camera, p) - observed_uv) * sure[:, None]
        near = np.minimum(1.0, FAR_SIGMA / np.maximum(np.linalg.norm(r, axis=-1), 1e-9))
        J = J * sure[:, None, None]
        A += J @ np.swapaxes(J, -1, -2)
        b += (J @ (r * near[:, None])[..., None])[..., 0]
    return np.stack([damped_step(A[k], b[k], 0.0) for k in range(len(parts))])


def _depths(
    scene: Scene,
    keypoints: Keypoints,
    index: NDArray[np.int64],
    parts: NDArray[np.int64],
    points: Array,
    keyed: dict[int, Pose],
) -> tuple[Array, Array]:
    """(N, K) depth from the root and its 1/σ: the detector's, plus what it lacks at both keyframes,
    linearly between."""
    if keypoints.p_hips is None:
        return np.zeros((len(keypoints), len(index))), np.zeros((len(keypoints), len(index)))
    z = depth_along_view(keypoints, scene.camera)[:, index]
    missing = np.full((2, len(index)), np.nan)
    for row, (n, pose) in enumerate(keyed.items()):
        p = Posed.of(scene.skeleton, pose).points(parts, points)
        missing[row] = p[:, 2] - pose.p_camera_root[2] - z[n]
    missing = np.where(np.isfinite(missing), missing, missing[::-1])  # one keyframe may not show it
    share = np.linspace(0.0, 1.0, len(z))[:, None]
    depth = z + (1 - share) * missing[0] + share * missing[1]
    is_known, own_m = np.isfinite(depth), _sigmas_m(keypoints, index)
    sigma_m = np.where(np.isfinite(own_m), np.maximum(own_m, LEAST_DEPTH_M), KEYPOINT_DEPTH_M)
    return np.where(is_known, depth, 0.0), np.where(is_known, 1 / sigma_m, 0.0)
