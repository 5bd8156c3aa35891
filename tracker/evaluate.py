"""How far a tracked motion is from a reference, beside plain interpolation of the same keyframes.

Only frames strictly between two keyframes count: at the keyframes a person, not the tracker, set
the pose. A motion of surfaces may begin or end without a keyframe: that end counts, too, and
interpolation leads to where the fit put it. A single view says little about depth, so errors in the
picture, in space and along the camera's axis stand apart.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.pose import joint_names
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory, interpolate, joined
from keypose.tracker.errors import FormatError
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import (
    Array,
    apply_transform,
    frozen,
    log_rotation,
    transpose,
)
from keypose.tracker.solver.posed import BodyPoint


@dataclass(frozen=True)
class Spread:
    """A number of errors: how many, their mean, median and 95th percentile (NaN without any)."""

    count: int
    mean: float
    median: float
    p95: float

    @classmethod
    def of(cls, errors: Array) -> Spread:
        """Summarise an array of any shape; NaN entries do not count."""
        known = errors[np.isfinite(errors)]
        if not len(known):
            return cls(0, np.nan, np.nan, np.nan)
        median, p95 = np.percentile(known, (50, 95))
        return cls(len(known), float(known.mean()), float(median), float(p95))


@dataclass(frozen=True)
class Measure:
    """One kind of error, over all joints (or parts) and for each by its name."""

    overall: Spread
    each: Mapping[str, Spread]

    @classmethod
    def of(cls, errors: Array, names: Sequence[str]) -> Measure:
        """Summarise errors (F, J) at F frames for J names."""
        each = {name: Spread.of(errors[:, i]) for i, name in enumerate(names)}
        return cls(Spread.of(errors), each)


@dataclass(frozen=True)
class Errors:
    """The errors of one motion; None where the reference does not have them.

    pixels:     distance in the picture, of the joints.
    distance_m: distance in space, of the joints.
    depth_m:    difference along the camera's axis, without sign, of the joints.
    angle_deg:  angle between the rotations in the parent's frame, of the parts.
    """

    pixels: Measure
    distance_m: Measure | None = None
    depth_m: Measure | None = None
    angle_deg: Measure | None = None


@dataclass(frozen=True)
class Evaluation:
    """The errors of the tracked motion and of linear interpolation at the same frames."""

    frames: tuple[int, ...]
    estimate: Errors
    interpolation: Errors


@dataclass(frozen=True, eq=False)
class JointReference:
    """Joints known in space or, where `has_depth` is False, in the picture only.

    names:     (J,) of the joints.
    places:    (J,) where on the body they are.
    positions: (F, J, 3) metres in the camera frame, or (F, J, 2) pixels; NaN where not known.
    frames:    (F,) video frames, ascending.
    """

    names: tuple[str, ...]
    places: tuple[BodyPoint, ...]
    positions: Array
    frames: NDArray[np.int64]

    def __post_init__(self) -> None:
        object.__setattr__(self, "positions", frozen(self.positions))

    @property
    def has_depth(self) -> bool:
        return bool(self.positions.shape[-1] == 3)


def evaluate(
    skeleton: Skeleton,
    camera: Camera,
    estimate: Trajectory,
    truth: Trajectory,
    keyframe_frames: Sequence[int],
    open_ends: Sequence[int] = (),
    path: CameraPath | None = None,
) -> Evaluation:
    """Errors against known poses of the same body.

    open_ends: those of the keyframes' frames without a posed keyframe.  path: of the camera over
        the film; None where it stands still.
    FormatError when the reference is of another body, or has no frame between two keyframes.
    """
    if truth.Rs_parent_part.shape[1] != skeleton.part_count:
        raise FormatError(
            f"The reference has {truth.Rs_parent_part.shape[1]} parts; the body has "
            f"{skeleton.part_count}."
        )
    available = np.arange(truth.first_frame, truth.last_frame + 1)
    frames, linear = _frames_and_interpolation(
        estimate, available, keyframe_frames, open_ends, path
    )
    zoom = _zoom(path, frames)
    names, joints = joint_names(skeleton), truth.joints(skeleton)[frames - truth.first_frame]
    Rs = truth.Rs_parent_part[frames - truth.first_frame]

    def errors(motion: Trajectory) -> Errors:
        rows = frames - motion.first_frame
        found = _spatial(camera, zoom, motion.joints(skeleton)[rows], joints, names)
        angle = _angles_deg(motion.Rs_parent_part[rows], Rs)
        angles = Measure.of(angle, skeleton.body.names)
        return Errors(found.pixels, found.distance_m, found.depth_m, angles)

    return Evaluation(tuple(frames.tolist()), errors(estimate), errors(linear))


def evaluate_joints(
    skeleton: Skeleton,
    camera: Camera,
    estimate: Trajectory,
    reference: JointReference,
    keyframe_frames: Sequence[int],
    open_ends: Sequence[int] = (),
    path: CameraPath | None = None,
) -> Evaluation:
    """Errors against known joints; path as of `evaluate`. FormatError when none lies between two
    keyframes."""
    frames, linear = _frames_and_interpolation(
        estimate, reference.frames, keyframe_frames, open_ends, path
    )
    zoom = _zoom(path, frames)
    known = reference.positions[np.searchsorted(reference.frames, frames)]

    def errors(motion: Trajectory) -> Errors:
        ours = _positions(
            motion.transforms(skeleton)[frames - motion.first_frame], reference.places
        )
        if reference.has_depth:
            return _spatial(camera, zoom, ours, known, reference.names)
        seen = _projected(camera, zoom, ours)
        return Errors(Measure.of(_distance(seen, known), reference.names))

    return Evaluation(tuple(frames.tolist()), errors(estimate), errors(linear))


def _frames_and_interpolation(
    estimate: Trajectory,
    available: NDArray[np.int64],
    keyframe_frames: Sequence[int],
    open_ends: Sequence[int],
    path: CameraPath | None,
) -> tuple[NDArray[np.int64], Trajectory]:
    """The frames to compare, and the motion that interpolation in the world makes of the keyframes'
    poses."""
    keys = [k for k in keyframe_frames if estimate.first_frame <= k <= estimate.last_frame]
    if len(keys) < 2:
        raise FormatError("The tracked motion must hold at least two keyframes to be compared.")
    posed = [key for key in keys if key not in open_ends]
    inside = (available >= keys[0]) & (available <= keys[-1]) & ~np.isin(available, posed)
    if not inside.any():
        raise FormatError("The reference has no frame between two keyframes, so nothing compares.")
    over = None if path is None else path.between(estimate.first_frame, estimate.last_frame)
    placed = estimate if over is None else estimate.carried(over.Ts_world_camera)
    linear = joined([interpolate(placed.pose(a), placed.pose(b), a, b) for a, b in pairwise(keys)])
    if path is not None:
        linear = linear.carried(path.between(keys[0], keys[-1]).Ts_camera_world)
    return available[inside], linear


def _zoom(path: CameraPath | None, frames: NDArray[np.int64]) -> Array | None:
    """(F, 1, 1) the focal length at frames, as a multiple of the camera's; None where it is one."""
    return None if path is None else path.zoom[frames, None, None]


def _projected(camera: Camera, zoom: Array | None, ps: Array) -> Array:
    """Pixels (F, J, 2) of points (F, J, 3) in the camera frame, zoomed (F, 1, 1)."""
    if zoom is None:
        return camera.project(ps)
    middle = np.array([camera.cx, camera.cy])
    return np.asarray(middle + zoom * (camera.project(ps) - middle))


def _positions(Ts_camera_part: Array, places: Sequence[BodyPoint]) -> Array:
    """Places (F, J, 3) in the camera frame of parts at T (F, P, 4, 4)."""
    joints = []
    for place in places:
        points = [apply_transform(Ts_camera_part[:, i], np.array([p]))[:, 0] for i, p in place]
        joints.append(np.mean(points, axis=0))
    return np.stack(joints, axis=1)


def _spatial(
    camera: Camera, zoom: Array | None, ours: Array, known: Array, names: Sequence[str]
) -> Errors:
    """Errors of joints (F, J, 3) in metres, camera frame."""
    return Errors(
        pixels=Measure.of(
            _distance(_projected(camera, zoom, ours), _projected(camera, zoom, known)), names
        ),
        distance_m=Measure.of(_distance(ours, known), names),
        depth_m=Measure.of(np.abs(ours[..., 2] - known[..., 2]), names),
    )


def _distance(a: Array, b: Array) -> Array:
    return np.asarray(np.linalg.norm(a - b, axis=-1))


def _angles_deg(Rs: Array, known: Array) -> Array:
    """(F, P) angle of the one rotation that leads from each matrix to the other."""
    return np.asarray(np.rad2deg(np.linalg.norm(log_rotation(transpose(Rs) @ known), axis=-1)))
