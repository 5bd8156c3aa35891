"""What stays the same while a session is tracked: body, camera, surface points, tuning."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.surface_points import SurfacePoints, sample_points, surface_area
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, frozen
from keypose.tracker.kernels.layout import BodyArrays, Lens, Prior, Visibility
from keypose.tracker.kernels.pairs import view
from keypose.tracker.solver.placed import lens_of
from keypose.tracker.solver.sigmas import PREDICTED, MotionSigma
from keypose.tracker.video.pyramid import TARGET_ONLY, USABLE, Picture

POINT_SPACING_PX = 2.3
MOST_POINTS = 14000
FEWEST_POINTS = 5000
"""On all sides of the body together, at density 1."""
FACING = 0.1
COVER_TOLERANCE = 0.018
"""Of the body's size: how far a point may lie behind another part and still count as seen."""
INFORMATION_PER_PIXEL = 0.0125
"""Independent observations per pixel: neighbouring pixels share texture and noise."""
STOOD_SHARE = 0.4
FEWEST_STOOD = 8
"""A part stood where the empty scene was taken if that leaves less of its points, of so many."""


@dataclass(frozen=True, eq=False)
class Scene:
    """A body before a camera, as arrays for the loops at the size of the working pictures.

    pixel_m: length that one pixel spans at the body's usual distance.
    marks: points (M, 3) in their parts' frames by which poses are compared, and their parts (M,).
    """

    skeleton: Skeleton
    camera: Camera
    points: SurfacePoints
    arrays: BodyArrays
    lens: Lens
    visibility: Visibility
    pixel_m: float
    marks: tuple[Array, NDArray[np.int64]]
    _of_trajectories: WeakKeyDictionary[Trajectory, dict[str, Array]] = field(
        default_factory=WeakKeyDictionary
    )

    @classmethod
    def of(
        cls,
        skeleton: Skeleton,
        camera: Camera,
        keyposes: Sequence[Pose],
        density: float = 1.0,
        sample: Callable[[Skeleton, float], SurfacePoints] = sample_points,
    ) -> Scene:
        """Prepare pictures of an undistorted `camera`, the body about where it is keyed.

        density: number of surface points as a share of the usual one. sample: makes the points; it
        may cache them, since there are few different spacings.
        """
        depths = np.concatenate([_depths(skeleton, camera, pose) for pose in keyposes])
        focal = np.sqrt(camera.fx * camera.fy)
        pixel_m = _round_length(float(np.median(depths) / focal))
        spacing = _spacing(surface_area(skeleton), pixel_m) / np.sqrt(density)
        cell = int(np.ceil(1.6 * spacing * focal / depths.min()))
        points = sample(skeleton, spacing)
        visibility = Visibility(max(2, cell), FACING, COVER_TOLERANCE * _size(skeleton))
        lens = lens_of(camera)
        return cls(
            skeleton,
            camera,
            points,
            _arrays(skeleton, points),
            lens,
            visibility,
            pixel_m,
            _marks(skeleton),
        )

    def of_skeleton(self, skeleton: Skeleton) -> Scene:
        """The same of the same body with other parts tracked."""
        arrays = _arrays(skeleton, self.points)._replace(least=self.arrays.least)
        return replace(self, skeleton=skeleton, arrays=arrays)

    def before_plate(self, shown: Sequence[tuple[Picture, Pose]], lens: Lens) -> Scene:
        """The same, but parts that look as the empty scene does wherever they are posed stood there
        when it was taken: they are followed as without it.

        shown: pictures (h, w, 4) and the pose that each shows.  lens: of their window.
        """
        on_target = np.array(
            [self._seen(picture, lens, pose, TARGET_ONLY) for picture, pose in shown]
        )
        used = np.array([self._seen(picture, lens, pose, USABLE) for picture, pose in shown])
        stood = (used < STOOD_SHARE * on_target).all(axis=0) & (on_target >= FEWEST_STOOD).all(
            axis=0
        )
        least = np.where(stood, np.float32(TARGET_ONLY), np.float32(USABLE))
        return replace(self, arrays=self.arrays._replace(least=least))

    def _seen(self, picture: Picture, lens: Lens, pose: Pose, least: float) -> NDArray[np.int64]:
        """(P,) points of every part that a pose shows, on pixels of at least this use."""
        size, parts = len(self.points.points), self.skeleton.part_count
        chosen, grey = np.empty(size + 1, np.int32), np.empty(size + 1, np.float32)
        starts = np.empty(parts + 1, np.int64)
        height, width = picture.shape[:2]
        view(
            self.arrays._replace(least=np.full(parts, least, np.float32)),
            lens,
            self.visibility,
            width,
            height,
            picture,
            1,
            *pose.writable(),
            chosen,
            grey,
            starts,
        )
        return np.diff(starts)

    @property
    def followed(self) -> tuple[Hashable, ...]:
        """What decides how a body is followed, but for pictures and poses."""
        least = self.arrays.least.tobytes()
        return self.skeleton, self.points, self.lens, self.visibility, self.pixel_m, least

    def transforms(self, trajectory: Trajectory) -> Array:
        """Ts_camera_part (N, P, 4, 4)."""
        return self._kept(trajectory, "T", lambda: trajectory.transforms(self.skeleton))

    def mark_pixels(self, trajectory: Trajectory) -> Array:
        """Where the marks of every pose are seen: (N, M, 2) pixels."""

        def seen() -> Array:
            points, parts = self.marks
            T = self.transforms(trajectory)[:, parts]
            p_camera = np.einsum("nmab,mb->nma", T[..., :3, :3], points) + T[..., :3, 3]
            return self.camera.project(p_camera)

        return self._kept(trajectory, "uv", seen)

    def _kept(self, trajectory: Trajectory, quantity: str, find: Callable[[], Array]) -> Array:
        """What was found of a trajectory before, while that is in use."""
        of_trajectory = self._of_trajectories.setdefault(trajectory, {})
        if quantity not in of_trajectory:
            of_trajectory[quantity] = find()
            of_trajectory[quantity].setflags(write=False)
        return of_trajectory[quantity]

    def point_pixels(self, trajectory: Trajectory, part: int, p_part: Array) -> Array:
        """Where a point of a part is seen in every pose: (N, 2) pixels."""
        T = self.transforms(trajectory)[:, part]
        return self.camera.project(T[:, :3, :3] @ p_part + T[:, :3, 3])

    def prior(self, stride: int) -> Prior:
        """Prior on a motion when one point in every `stride` is followed."""
        return Prior(self.precision(PREDICTED), self.information(stride))

    def precision(self, sigma: MotionSigma) -> Array:
        """(D,) 1/σ² of every degree of freedom."""
        return sigma.precision(self.skeleton, self.pixel_m)

    def information(self, stride: int) -> float:
        """Independent observations that one followed point stands for."""
        return INFORMATION_PER_PIXEL * (self.points.spacing_m / self.pixel_m) ** 2 * stride


def _depths(skeleton: Skeleton, camera: Camera, pose: Pose) -> Array:
    return np.maximum(camera.depth(pose_transforms(skeleton, pose)[:, :3, 3]), 0.05)


def _round_length(length: float) -> float:
    """The nearest of a geometric series of lengths, a fifth apart."""
    return float(2.0 ** (np.round(4 * np.log2(length)) / 4))


def _spacing(area_m2: float, pixel_m: float) -> float:
    """A little over two pixels, unless that makes too many points or, on a small body, too few."""
    least, most = np.sqrt(area_m2 / MOST_POINTS), np.sqrt(area_m2 / FEWEST_POINTS)
    return float(np.clip(POINT_SPACING_PX * pixel_m, least, max(most, 0.7 * pixel_m)))


@lru_cache(maxsize=8)
def _marks(skeleton: Skeleton) -> tuple[Array, NDArray[np.int64]]:
    """Every part's joint, landmarks and shape's marks."""
    points, parts = [], []
    for i, part in enumerate(skeleton.body.parts):
        own = [(0.0, 0.0, 0.0), *part.landmarks.values(), *part.shape.marks()]
        points += own
        parts += [i] * len(own)
    return frozen(points), np.array(parts, dtype=np.int64)


@lru_cache(maxsize=8)
def _size(skeleton: Skeleton) -> float:
    """Diagonal of the body's bounding box at rest, metres."""
    T = pose_transforms(skeleton, Pose.rest(skeleton, (0.0, 0.0, 0.0)))
    corners = [
        part.shape.mesh().vertices + T[i, :3, 3] for i, part in enumerate(skeleton.body.parts)
    ]
    return float(np.linalg.norm(np.ptp(np.concatenate(corners), axis=0)))


def _arrays(skeleton: Skeleton, points: SurfacePoints) -> BodyArrays:
    part, below = skeleton.dof_part, skeleton.below
    first, second = part[:, None], part[None, :]
    deeper = np.where(below[first, second], first, np.where(below[second, first], second, -1))
    return BodyArrays(
        skeleton.parents,
        skeleton.joints,
        part,
        skeleton.dof_turns,
        skeleton.dof_axis,
        deeper.astype(np.int64),
        points.points,
        points.normals,
        points.starts,
        np.full(len(skeleton.parents), USABLE, np.float32),
    )
