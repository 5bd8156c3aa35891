"""Residuals of sizes and poses in pictures: at contours, and at joints as posed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.pose import pose_transforms
from keypose.tracker.body.raster import BodyMesh
from keypose.tracker.fitting.sizes.contours import (
    ColourModels,
    Contour,
    colour_cells,
    contour_of,
    learn_colours,
    offsets,
    plate_odds,
)
from keypose.tracker.fitting.sizes.shared import Residuals, Shared, SharedFit
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.session.settings import IgnoreMask
from keypose.tracker.solver.posed import joints_and_landmarks, points_on_parts
from keypose.tracker.solver.sigmas import CONTOUR_PX, POSED_JOINT_PX
from keypose.tracker.video.clip_loader import ClipLoader, WorkingSize
from keypose.tracker.video.pyramid import USABLE

if TYPE_CHECKING:
    from keypose.tracker.video import Video

ALONE = 24
"""So many points of one part in one picture count; more of them share the same error, for no person
is made of cylinders."""
PLATE_FRAMES = 12
"""Frames over the video from which the empty scene is known, where the camera stands still."""


@dataclass(frozen=True, eq=False)
class Pictures:
    """Some pictures (h, w, 3) at the working size, what may be used of them, their colours' cells,
    and the log odds by the empty scene."""

    rgb: list[NDArray[np.uint8]]
    usable: list[NDArray[np.bool_]]
    cells: list[NDArray[np.int32]]
    plates: list[NDArray[np.float32]]

    @classmethod
    def of(
        cls,
        video: Video,
        camera: Camera,
        size: WorkingSize,
        frames: Sequence[int],
        masks: Sequence[IgnoreMask],
    ) -> Pictures:
        """The pictures of these frames."""
        loader = ClipLoader(video, camera, size, masks)
        spread = np.linspace(0, video.info.frame_count - 1, PLATE_FRAMES).round().astype(int)
        others = sorted({int(frame) for frame in spread} - set(frames))
        rgb = [_colours(video, camera, size, frame) for frame in frames]
        usable = [loader.load(frame, frame).levels[0][0, ..., 3] >= USABLE for frame in frames]
        plates = plate_odds(rgb, [_colours(video, camera, size, frame) for frame in others])
        return cls(rgb, usable, [colour_cells(picture) for picture in rgb], plates)

    def colour_models(self, shown_contours: Sequence[Contour], fit: SharedFit) -> ColourModels:
        """Learn the colours of parts that show where the contours say."""
        shown = [contour.shown for contour in shown_contours]
        groups = fit.proportions.group_of
        return learn_colours(self.rgb, self.usable, self.cells, shown, groups, self.plates)


def _colours(video: Video, camera: Camera, size: WorkingSize, frame: int) -> NDArray[np.uint8]:
    for _, rgb in video.frames(frame, frame + 1):
        if rgb is not None:
            return size.picture(camera.rectify(rgb))
    small = size.camera(camera)
    return np.zeros((small.height, small.width, 3), np.uint8)


def contours(fit: SharedFit, shared: Shared, looked: Sequence[int]) -> list[Contour]:
    """The contours of the poses of these indices."""
    mesh, ratios = BodyMesh.of(fit.proportions.skeleton), fit.proportions.ratios(shared.sizes)
    sized = replace(mesh, vertices=mesh.vertices * ratios[mesh.vertex_part])
    return [contour_of(sized, fit.transforms(shared, k), fit.lens(shared, k)) for k in looked]


def contour_rows(
    fit: SharedFit, shared: Shared, k: int, contour: Contour, away: NDArray[np.float64]
) -> Residuals:
    """Pose k's contour points, to be moved outward by these pixels (M,), not where that is NaN."""
    is_known = np.isfinite(away)
    parts, normals = contour.parts[is_known], contour.normals[is_known]
    points = contour.points[is_known] / fit.proportions.ratios(shared.sizes)[parts]
    sigma = CONTOUR_PX * np.sqrt(np.maximum(1.0, np.bincount(parts)[parts] / ALONE))
    residuals = Residuals(parts, points, normals, np.zeros(len(parts)), sigma)
    return replace(
        residuals, target=residuals.along(fit.pixels(shared, k, residuals)) + away[is_known]
    )


def joint_rows(fit: SharedFit, k: int) -> Residuals:
    """Joints and landmarks stay about where they were posed in picture k."""
    skeleton, posed = fit.proportions.skeleton, fit.posed[k]
    camera = fit.camera.zoomed(float(fit.zoom[k]))
    places = [place for (place,) in joints_and_landmarks(skeleton).points]
    parts, points = (np.array(column) for column in zip(*places, strict=True))
    uv = camera.project(points_on_parts(pose_transforms(skeleton, posed), parts, points))
    normals = np.repeat(np.eye(2), len(parts), axis=0)
    sigma = np.full(2 * len(parts), POSED_JOINT_PX)
    return Residuals(np.tile(parts, 2), np.tile(points, (2, 1)), normals, uv.T.ravel(), sigma)


def residuals_by_pose(
    fit: SharedFit,
    shared: Shared,
    looked: Sequence[int],
    shown_contours: Sequence[Contour],
    colour_models: ColourModels,
    reach_px: float,
) -> dict[int, Residuals]:
    """The contour rows of the poses that are looked at."""
    return {
        k: contour_rows(fit, shared, k, contour, offsets(contour, colour_models, j, reach_px))
        for j, (k, contour) in enumerate(zip(looked, shown_contours, strict=True))
    }
