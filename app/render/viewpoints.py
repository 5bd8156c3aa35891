"""Place cameras about the body, where nobody stood, and draw the floor that they see.

The level frame is the camera's, turned so that the world's down is y: x right, y down, z away. An
azimuth of 0 looks as the video's camera does, 90 from the right of its picture as the side view,
180 from behind what it films; an elevation of 90 looks straight down.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import cv2
import numpy as np

from keypose.app.orders.drawing import Viewpoint
from keypose.app.posing import eye_rotation
from keypose.app.render.lettering import length_name, round_length, write
from keypose.app.render.painting import Form
from keypose.app.render.palette import INK, PAPER, Colour, Picture
from keypose.app.render.pictures import posed_points
from keypose.app.render.strokes import SHIFT
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array, apply_transform, frozen, transform
from keypose.tracker.geometry.view import ViewCamera

FOCAL = 1.5
"""Of the shorter side of the picture: an angle of view of 37°."""
MARGIN = 1.12
NEAREST_M = 0.1
FARTHEST_M = 1e5
"""Room around the body, as a share of its size; distances of the eye from it."""


@dataclass(frozen=True, eq=False)
class Ground:
    """The level world that a body moves in.

    R_level_camera: (3, 3) from the camera's frame to the level one.
    floor_m:        y of the floor in the level frame: what is lowest in the motion stands on it.
    step_m:         between the lines of its grid.
    """

    R_level_camera: Array
    floor_m: float
    step_m: float

    @classmethod
    def under(cls, skeleton: Skeleton, R_level_camera: Array, poses: Iterable[Pose]) -> Ground:
        """The floor under a body in all of these poses; one at least."""
        down = R_level_camera[1]
        lowest = max(float((posed_points(skeleton, pose) @ down).max()) for pose in poses)
        return cls.at(skeleton, R_level_camera, -lowest)

    @classmethod
    def at(cls, skeleton: Skeleton, R_level_camera: Array, height_m: float) -> Ground:
        """A floor at a known height, so far along up from the camera's centre."""
        at_rest = posed_points(skeleton, Pose.rest(skeleton, (0.0, 0.0, 0.0)))
        size_m = float(np.linalg.norm(np.ptp(at_rest, axis=0)))
        return cls(R_level_camera, -height_m, round_length(1.25 * size_m))


def view_from(
    viewpoint: Viewpoint,
    distance_m: float,
    R_level_camera: Array,
    p_camera_centre: Array,
    size: tuple[int, int],
) -> ViewCamera:
    """The camera of a picture of `size` = (width, height), looking at centre (3,) from there."""
    R = _R_eye_level(viewpoint) @ R_level_camera
    shift = np.array([0.0, 0.0, distance_m]) - R @ p_camera_centre
    focal = FOCAL * min(size)
    centre = ((size[0] - 1) / 2, (size[1] - 1) / 2)
    return ViewCamera(frozen(transform(R, shift)), (focal, focal), centre, *size)


def least_distance(
    viewpoint: Viewpoint,
    R_level_camera: Array,
    p_camera_centre: Array,
    p_camera: Array,
    size: tuple[int, int],
) -> float:
    """The smallest distance at which points (N, 3) are all in a picture of that size, with a
    margin, and none is nearer to the camera than half of what the farthest is to the centre."""
    q = (p_camera - p_camera_centre) @ (_R_eye_level(viewpoint) @ R_level_camera).T
    reach = np.array(size) / (2 * FOCAL * min(size)) / MARGIN
    nearest = 0.5 * np.linalg.norm(q, axis=1).max()
    depth = np.maximum((np.abs(q[:, :2]) / reach).max(axis=1), nearest)
    needed = depth - q[:, 2]
    return float(np.clip(needed.max(initial=NEAREST_M), NEAREST_M, FARTHEST_M))


def round_trip(count: int) -> list[Viewpoint]:
    """`count` viewpoints once round the body, from where the video's camera stands; the one after
    the last would be the first again."""
    return [Viewpoint(360.0 * i / count) for i in range(count)]


def smoothed(places: Array, sigma: float) -> Array:
    """Places (N, 3), smoothed over about `sigma` frames, for a camera to look at."""
    if len(places) < 2 or sigma < 0.5:
        return places
    reach = min(int(3 * sigma), len(places) - 1)
    weights = np.exp(-0.5 * (np.arange(-reach, reach + 1) / sigma) ** 2)
    weights /= weights.sum()
    padded = np.pad(places, ((reach, reach), (0, 0)), mode="edge")
    return np.stack([np.convolve(column, weights, "valid") for column in padded.T], axis=1)


def _R_eye_level(viewpoint: Viewpoint) -> Array:
    return eye_rotation(viewpoint.azimuth_deg, viewpoint.elevation_deg)


LINE: Colour = (168, 176, 188)
BANDS = 6
"""The grid fades in so many steps."""
SHADE = 0.17
MOST_CELLS = 24
"""From the centre to where the grid has faded."""


def floor_picture(
    view: ViewCamera,
    ground: Ground,
    p_camera_centre: Array,
    form: Form,
    Ts_camera_part: Array | None,
) -> Picture:
    """The scene without the body: paper, the grid around the centre (3,), the body's shadow.

    Lines lie at multiples of a round length, which is written in the corner.
    """
    picture = np.full((view.height, view.width, 3), PAPER, dtype=np.uint8)
    _paint_grid(picture, view, ground, p_camera_centre)
    if Ts_camera_part is not None:
        _paint_shadow(picture, view, ground, form, Ts_camera_part)
    _write_step(picture, ground.step_m)
    return picture


def _paint_grid(picture: Picture, view: ViewCamera, ground: Ground, p_camera_centre: Array) -> None:
    """Lines cut into pieces of one cell, each the fainter the farther it is from the centre."""
    centre, step = (ground.R_level_camera @ p_camera_centre)[[0, 2]], ground.step_m
    p_eye_centre = apply_transform(view.T_view_camera, p_camera_centre)
    reach = min(max(1.6 * float(np.linalg.norm(p_eye_centre)), 4 * step), MOST_CELLS * step)
    count = int(np.ceil(reach / step))
    nodes = (np.arange(-count, count + 1)[:, None] + np.round(centre / step)) * step
    x, z = np.meshgrid(nodes[:, 0], nodes[:, 1], indexing="ij")
    p_level = np.stack([x, np.full_like(x, ground.floor_m), z], axis=-1)
    across = np.stack([p_level[:-1], p_level[1:]], axis=2).reshape(-1, 2, 3)
    along = np.stack([p_level[:, :-1], p_level[:, 1:]], axis=2).reshape(-1, 2, 3)
    pieces = np.concatenate([across, along])
    far = np.linalg.norm(pieces.mean(axis=1)[:, [0, 2]] - centre, axis=1)
    strength = np.clip(1.0 - far / reach, 0.0, 1.0)
    uv = view.project(apply_transform(view.T_view_camera, pieces @ ground.R_level_camera))
    visible = np.isfinite(uv).all(axis=(1, 2)) & (np.abs(uv) < 30_000).all(axis=(1, 2))
    band = np.ceil(strength * BANDS).astype(int)
    for k in range(1, BANDS + 1):
        chosen = np.rint(uv[visible & (band == k)] * 2**SHIFT).astype(np.int32)
        colour = _between(PAPER, LINE, (k - 0.3) / BANDS)
        thickness = max(1, round(view.height / 700))
        cv2.polylines(picture, list(chosen), False, colour, thickness, cv2.LINE_AA, SHIFT)


def _paint_shadow(
    picture: Picture, view: ViewCamera, ground: Ground, form: Form, Ts_camera_part: Array
) -> None:
    """The parts let down to the floor, blurred."""
    p_level = form.mesh.posed(Ts_camera_part) @ ground.R_level_camera.T
    p_level[:, 1] = ground.floor_m
    uv = view.project(apply_transform(view.T_view_camera, p_level @ ground.R_level_camera))
    if not np.isfinite(uv).all() or np.abs(uv).max() > 30_000:
        return
    low = np.clip(np.floor(uv.min(axis=0)).astype(int), 0, (view.width, view.height))
    high = np.clip(np.ceil(uv.max(axis=0)).astype(int) + 1, 0, (view.width, view.height))
    margin = max(3, view.height // 40)
    left, top = np.maximum(low - margin, 0)
    right, bottom = np.minimum(high + margin, (view.width, view.height))
    if right - left < 2 or bottom - top < 2:
        return
    mask = np.zeros((bottom - top, right - left), np.uint8)
    for part in range(len(Ts_camera_part)):
        points = uv[form.mesh.vertex_part == part] - (left, top)
        hull = cv2.convexHull(np.rint(points * 2**SHIFT).astype(np.int32))
        cv2.fillConvexPoly(mask, hull, 255, cv2.LINE_AA, SHIFT)
    soft = cv2.GaussianBlur(mask, (0, 0), margin / 3).astype(np.float32)
    below = picture[top:bottom, left:right]
    share = (SHADE / 255.0) * soft[..., None]
    below[:] = np.rint(below + share * (np.array(INK, dtype=np.float32) - below))


def _write_step(picture: Picture, step: float) -> None:
    size = float(np.clip(picture.shape[0] / 30, 8, 18))
    words = f"Grid {length_name(step)}"
    if picture.shape[0] >= 12 * size and picture.shape[1] >= 12 * size:
        write(picture, words, round(1.1 * size), picture.shape[0] - round(1.1 * size), size)


def _between(first: Colour, second: Colour, share: float) -> Colour:
    r, g, b = (round(a + share * (c - a)) for a, c in zip(first, second, strict=True))
    return r, g, b
