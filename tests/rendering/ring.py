"""Calibrated cameras around a place, and what they see of textured surfaces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.shapes import Mesh
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, transform
from keypose.tracker.kernels.raster import PERSPECTIVE, fill
from keypose.tracker.surface.cameras.rig import Grey, View
from tests.rendering.shade import shade
from tests.rendering.texture import VOLUME_SIDE_M, noise_volume

SIZE = (640, 480)
FOCAL = 620.0
BACKGROUND = 62.0
NOISE = 2.0
SAMPLES = 2
AMBIENT = 0.7
GREY = 125.0
CONTRAST = 42.0
STUFF_APART_M = 0.17
"""Between the places in the textured stuff that the parts are carved from."""
TO_LIGHT = np.array([-0.35, -0.80, -0.49])
UP = np.array([0.0, -1.0, 0.0])


def ring_of(count: int, p_centre: Array, reach_m: float = 3.4) -> tuple[View, ...]:
    """Two thirds of the cameras in a ring, by turns level and a little above; the others higher."""
    low = max(3, 2 * count // 3)
    low -= low % 2 == 0  # of two cameras that face each other one silhouette tells nothing new
    views = []
    for i in range(count):
        if i < low:
            turn, radius, height = 2 * np.pi * i / low, reach_m, (0.02, 0.22)[i % 2] * reach_m
        else:
            turn = 2 * np.pi * (i - low) / (count - low) + 0.3
            radius, height = 0.72 * reach_m, 0.70 * reach_m
        p = p_centre + np.array([radius * np.cos(turn), -height, radius * np.sin(turn)])
        views.append(_looking(f"camera_{i:02d}", p, p_centre))
    return tuple(views)


def _looking(name: str, p: Array, p_target: Array) -> View:
    ahead = (p_target - p) / np.linalg.norm(p_target - p)
    right = np.cross(ahead, UP)
    right /= np.linalg.norm(right)
    R = np.stack([right, np.cross(ahead, right), ahead])
    centre = ((SIZE[0] - 1) / 2, (SIZE[1] - 1) / 2)
    camera = Camera(width=SIZE[0], height=SIZE[1], fx=FOCAL, fy=FOCAL, cx=centre[0], cy=centre[1])
    return View(name, camera, transform(R, -R @ p))


@dataclass(frozen=True, eq=False)
class Shot:
    """What one view sees: brightness, and the thing's pixels."""

    picture: Grey
    inside: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Carvings:
    """Rigid parts carved out of textured stuff: each mesh in its own frame, flat faces."""

    meshes: tuple[Mesh, ...]
    seed: int = 0

    def seen_by(self, view: View, Ts_world_part: Array, seed: list[int]) -> Shot:
        """The parts at (P, 4, 4) as a view sees them, with its own noise."""
        posed = [
            mesh.vertices @ T[:3, :3].T + T[:3, 3]
            for mesh, T in zip(self.meshes, Ts_world_part, strict=True)
        ]
        starts = np.cumsum([0, *(len(mesh.vertices) for mesh in self.meshes[:-1])])
        faces = [mesh.faces + start for mesh, start in zip(self.meshes, starts, strict=True)]
        to_stuff = np.linalg.inv(Ts_world_part)[:, :3]
        to_stuff[:, :, 3] += STUFF_APART_M * np.arange(len(self.meshes))[:, None]
        to_stuff = np.repeat(to_stuff, [len(part) for part in faces], axis=0)
        surface = np.concatenate(posed), np.concatenate(faces)
        return photograph(view, *surface, to_stuff, self.seed, seed)


@dataclass(frozen=True, eq=False)
class Skin:
    """A surface that deforms, its texture fast to it.

    p_rest: (V, 3) where its vertices were in the stuff it is carved from.  faces: (F, 3).
    """

    p_rest: Array
    faces: NDArray[np.int64]
    seed: int = 0

    def seen_by(self, view: View, p_world: Array, seed: list[int]) -> Shot:
        """The skin with its vertices at (V, 3) as a view sees it, with its own noise."""
        rest, there = (_frames(p[self.faces]) for p in (self.p_rest, p_world))
        to_stuff = (rest @ np.linalg.inv(there))[:, :3]
        return photograph(view, p_world, self.faces, to_stuff, self.seed, seed)


def _frames(corners: Array) -> Array:
    """(F, 4, 4) homogeneous: the corners (F, 3, 3) of each triangle and its normal, as columns."""
    frames = np.zeros((len(corners), 4, 4))
    frames[:, :3, :3] = np.swapaxes(corners, 1, 2)
    frames[:, 3, :3] = 1.0
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    frames[:, :3, 3] = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    return frames


def photograph(
    view: View,
    p_world: Array,
    faces: NDArray[np.int64],
    to_stuff: Array,
    texture_seed: int,
    noise_seed: list[int],
) -> Shot:
    """A textured surface as a view sees it.

    to_stuff: (F, 3, 4) from the world to each face's place in the textured stuff, metres.
    """
    n, camera = SAMPLES, view.camera
    width, height = camera.width * n, camera.height * n
    lens = np.array([
        camera.fx * n, camera.fy * n, (camera.cx + 0.5) * n - 0.5, (camera.cy + 0.5) * n - 0.5,
    ])  # fmt: skip
    p_view = np.array(view.of_view(p_world))
    nearness = np.full((height, width), -np.inf, np.float32)
    face = np.full((height, width), -1, np.int32)
    fill(p_view, faces, np.array([PERSPECTIVE, *lens, 1.0]), 0.05, nearness, face)
    depth = np.where(face >= 0, 1 / np.where(face >= 0, nearness, 1), np.inf).astype(np.float32)
    light = np.zeros((camera.height, camera.width, 3), np.float32)
    covered = np.zeros((camera.height, camera.width), np.float32)
    volume = noise_volume(texture_seed)
    to_texture = to_stuff @ np.linalg.inv(view.T_view_world) * (len(volume) / VOLUME_SIDE_M)
    shade(
        face, depth, np.array([*lens, 0.0]), n, np.arange(len(faces)), _normal_maps(p_view, faces),
        to_texture, volume, np.full((len(faces), 3), GREY), CONTRAST,
        view.T_view_world[:3, :3] @ TO_LIGHT, AMBIENT, light, covered,
    )  # fmt: skip
    noise = NOISE * np.random.default_rng(noise_seed).standard_normal(covered.shape)
    grey = light[..., 0] / n**2 + BACKGROUND * (1 - covered / n**2) + noise
    return Shot(np.clip(np.rint(grey), 0, 255).astype(np.uint8), covered >= n**2 / 2)


def _normal_maps(p_view: Array, faces: NDArray[np.int64]) -> Array:
    """(F, 3, 4) each face's own normal, wherever on it."""
    a, b, c = (p_view[faces[:, k]] for k in range(3))
    maps = np.zeros((len(faces), 3, 4))
    normals = np.cross(b - a, c - a)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    maps[:, :, 3] = normals / np.maximum(lengths, 1e-12)
    return maps
