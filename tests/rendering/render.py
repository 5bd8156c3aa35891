"""A body in motion as video frames, with everything that makes video hard, by choice."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from keypose.app.render.shading import smooth_normal_maps
from keypose.tracker.body.pose import part_transforms
from keypose.tracker.body.raster import BodyMesh, raster
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import rotation_between
from keypose.tracker.geometry.view import ViewCamera
from tests.rendering.outfit import part_colours
from tests.rendering.settings import Occluder, RenderSettings
from tests.rendering.shade import shade
from tests.rendering.texture import VOLUME_SIDE_M, backdrop, noise_volume

Floats = NDArray[np.float32]

TO_LIGHT = np.array([-0.45, -0.60, -0.66]) / np.linalg.norm([-0.45, -0.60, -0.66])


def render(
    skeleton: Skeleton,
    trajectory: Trajectory,
    camera: Camera,
    settings: RenderSettings | None = None,
) -> NDArray[np.uint8]:
    """Frames (N, H, W, 3) RGB of the trajectory's N poses, as an ideal lens takes them."""
    return np.stack(list(rendered(skeleton, trajectory, camera, settings)))


def rendered(
    skeleton: Skeleton,
    trajectory: Trajectory,
    camera: Camera,
    settings: RenderSettings | None = None,
) -> Iterator[NDArray[np.uint8]]:
    """The frames (H, W, 3) of `render` one after the other."""
    settings = settings or RenderSettings()
    scene = Stage.of(skeleton, camera, settings)
    rng = np.random.default_rng([settings.seed, 1])
    gains = _gains(len(trajectory), settings)
    for j in range(len(trajectory)):
        moments = _moments(settings)
        picture = np.mean([_exposed(scene, trajectory, j, moment) for moment in moments], axis=0)
        picture *= gains[j]
        picture += settings.noise * rng.standard_normal(picture.shape, dtype=np.float32)
        yield np.clip(np.rint(picture), 0, 255).astype(np.uint8)


@dataclass(frozen=True, eq=False)
class Stage:
    """What stays the same from frame to frame. to_light: unit vector in the camera's frame."""

    skeleton: Skeleton
    settings: RenderSettings
    view: ViewCamera
    mesh: BodyMesh
    normal_maps: NDArray[np.float64]
    colours: NDArray[np.float64]
    volume: Floats
    offsets: NDArray[np.float64]
    wall: Floats
    to_light: NDArray[np.float64] = field(default_factory=TO_LIGHT.copy)

    @classmethod
    def of(cls, skeleton: Skeleton, camera: Camera, settings: RenderSettings) -> Stage:
        mesh = BodyMesh.of(skeleton)
        volume = noise_volume(settings.seed)
        rng = np.random.default_rng([settings.seed, 2])
        wall = backdrop(camera.width, camera.height, settings.background_contrast, settings.seed)
        return cls(
            skeleton,
            settings,
            ViewCamera.of(camera),
            mesh,
            smooth_normal_maps(mesh),
            part_colours(skeleton.body),
            volume,
            rng.uniform(0, len(volume), (skeleton.part_count, 3)),
            wall,
        )


def _gains(count: int, settings: RenderSettings) -> NDArray[np.float64]:
    """The gain of every frame: the ramp times the flicker."""
    rng = np.random.default_rng([settings.seed, 3])
    flicker = rng.uniform(-settings.flicker, settings.flicker, count)
    return (1 + settings.illumination_ramp * np.linspace(0, 1, count)) * (1 + flicker)


def _moments(settings: RenderSettings) -> NDArray[np.float64]:
    """Moments of exposure in frame times; the truth is the pose in their middle."""
    if settings.shutter == 0:
        return np.zeros(1)
    shares = (np.arange(settings.sub_frames) + 0.5) / settings.sub_frames - 0.5
    return shares * settings.shutter


def _exposed(scene: Stage, trajectory: Trajectory, j: int, moment: float) -> Floats:
    """The light (H, W, 3) at a moment near frame j."""
    settings, view = scene.settings, scene.view
    picture = _wall(scene.wall, settings.pan_px_per_frame * (j + moment), view.width)
    add_body(picture, scene, _transforms(scene.skeleton, trajectory, j, moment))
    if settings.occluder is not None:
        _add_bar(picture, settings.occluder)
    return picture


def _transforms(
    skeleton: Skeleton, trajectory: Trajectory, j: int, moment: float
) -> NDArray[np.float64]:
    """Ts_camera_part (P, 4, 4) between frame j and its neighbour on the moment's side."""
    other = int(np.clip(j + np.sign(moment), 0, len(trajectory) - 1))
    Rs, ps, share = trajectory.Rs_parent_part, trajectory.ps_camera_root, abs(moment)
    if moment == 0 or other == j:
        return part_transforms(skeleton, Rs[j], ps[j])
    R = rotation_between(Rs[j], Rs[other], [share])[0]
    return part_transforms(skeleton, R, ps[j] + share * (ps[other] - ps[j]))


def _wall(wall: Floats, shift_px: float, width: int) -> Floats:
    """The stretch (H, width, 3) of the backdrop that begins at shift_px."""
    whole, part = int(np.floor(shift_px)), np.float32(shift_px % 1.0)
    columns = (whole + np.arange(width + 1)) % wall.shape[1]
    stretch = wall[:, columns]
    return (1 - part) * stretch[:, :-1] + part * stretch[:, 1:]


def add_body(picture: Floats, scene: Stage, Ts_eye_part: NDArray[np.float64]) -> None:
    """Lay the body over the picture, in place."""
    left, top, right, bottom = _box(scene, Ts_eye_part)
    if right <= left or bottom <= top:
        return
    n, width, height = scene.settings.samples, right - left, bottom - top
    fine = scene.view.cropped(left, top, width, height).resized(n * width, n * height)
    seen = raster(scene.mesh, Ts_eye_part, fine)
    light = np.zeros((height, width, 3), np.float32)
    covered = np.zeros((height, width), np.float32)
    _shade(scene, Ts_eye_part, fine, seen.face, seen.depth, light, covered)
    ground = picture[top:bottom, left:right]
    ground *= 1 - covered[..., None] / n**2
    ground += light / n**2


def _shade(
    scene: Stage,
    Ts_eye_part: NDArray[np.float64],
    fine: ViewCamera,
    face: NDArray[np.int32],
    depth: Floats,
    light: Floats,
    covered: Floats,
) -> None:
    settings = scene.settings
    Ts_part_eye = np.linalg.inv(Ts_eye_part)
    part = scene.mesh.face_part
    normal_maps = Ts_eye_part[part, :3, :3] @ scene.normal_maps @ Ts_part_eye[part]
    to_texture = Ts_part_eye[:, :3] * (len(scene.volume) / VOLUME_SIDE_M)
    to_texture[:, :, 3] += scene.offsets
    lens = np.array([*fine.focal, *fine.centre, fine.parallel_m or 0.0])
    shade(
        face,
        depth,
        lens,
        settings.samples,
        part,
        normal_maps,
        to_texture,
        scene.volume,
        scene.colours,
        settings.texture_contrast,
        scene.to_light,
        settings.ambient,
        light,
        covered,
    )


def _box(scene: Stage, Ts_eye_part: NDArray[np.float64]) -> tuple[int, int, int, int]:
    """Left, top, right, bottom of the pixels the body can touch, right and bottom left out."""
    view = scene.view
    uv = view.project(scene.mesh.posed(Ts_eye_part))
    if np.isnan(uv).any():
        return 0, 0, view.width, view.height
    low = np.clip(np.floor(uv.min(axis=0) - 1), 0, (view.width, view.height)).astype(int)
    high = np.clip(np.ceil(uv.max(axis=0) + 2), 0, (view.width, view.height)).astype(int)
    return int(low[0]), int(low[1]), int(high[0]), int(high[1])


def _add_bar(picture: Floats, bar: Occluder) -> None:
    """Lay the bar over the picture, in place, rounded by its shading."""
    columns = np.arange(picture.shape[1])
    over = np.minimum(columns + 0.5, bar.left_px + bar.width_px) - np.maximum(
        columns - 0.5, bar.left_px
    )
    covered = np.clip(over, 0.0, 1.0)[:, None].astype(np.float32)
    across = np.clip((columns - bar.left_px) / bar.width_px, 0.0, 1.0)
    shading = 0.75 + 0.35 * np.sin(np.pi * across**0.8)
    picture *= 1 - covered
    picture += covered * (shading[:, None] * np.array(bar.colour)).astype(np.float32)
