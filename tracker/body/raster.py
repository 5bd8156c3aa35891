"""A posed body as a picture of part, face and depth per pixel, for pictures without a window.

Written here because libraries need OpenGL, which not every server has and which draws differently
on every computer.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array, frozen
from keypose.tracker.geometry.view import ViewCamera


@dataclass(frozen=True, eq=False)
class BodyMesh:
    """The triangles of all parts of a body as arrays.

    vertices:    (V, 3) metres, each in the frame of its own part.
    vertex_part: (V,) index of that part.
    faces:       (F, 3) vertex indices, counter-clockwise seen from outside.
    face_part:   (F,) index of the part a face belongs to.
    """

    vertices: Array
    vertex_part: NDArray[np.int64]
    faces: NDArray[np.int64]
    face_part: NDArray[np.int64]

    @classmethod
    def of(cls, skeleton: Skeleton) -> BodyMesh:
        """The meshes of the body's shapes, one after the other."""
        meshes = [part.shape.mesh() for part in skeleton.body.parts]
        counts = [len(mesh.vertices) for mesh in meshes]
        starts = np.cumsum([0, *counts[:-1]])
        faces = [mesh.faces + start for mesh, start in zip(meshes, starts, strict=True)]
        parts = np.arange(len(meshes))
        return cls(
            vertices=frozen(np.concatenate([mesh.vertices for mesh in meshes])),
            vertex_part=_locked(np.repeat(parts, counts)),
            faces=_locked(np.concatenate(faces)),
            face_part=_locked(np.repeat(parts, [len(mesh.faces) for mesh in meshes])),
        )

    def posed(self, Ts_eye_part: Array) -> Array:
        """The vertices (V, 3) in the view's frame, of parts at Ts_eye_part (P, 4, 4)."""
        T = Ts_eye_part[self.vertex_part]
        p_eye = T[:, :3, :3] @ self.vertices[:, :, None] + T[:, :3, 3:]
        return np.ascontiguousarray(p_eye[..., 0])


@dataclass(frozen=True, eq=False)
class Raster:
    """The part, face and depth that each pixel (H, W) shows.

    part:  int16 index of the part, −1 for none.
    face:  int32 index of the face in BodyMesh, −1 for none.
    depth: float32 z in the view's frame, metres, inf for none. In an orthographic view it counts
           from the view's centre and may be negative.
    """

    part: NDArray[np.int16]
    face: NDArray[np.int32]
    depth: NDArray[np.float32]


def raster(mesh: BodyMesh, Ts_camera_part: Array, view: ViewCamera) -> Raster:
    """The body as the view shows it, its parts at Ts_camera_part (P, 4, 4)."""
    from keypose.tracker.kernels.raster import fill  # the loops load when something is drawn

    nearness = np.full((view.height, view.width), -np.inf, dtype=np.float32)
    face = np.full((view.height, view.width), -1, dtype=np.int32)
    p_eye = mesh.posed(view.T_view_camera @ Ts_camera_part)
    fill(p_eye, mesh.faces, projection_of(view), view.near_m, nearness, face)
    part = np.append(mesh.face_part, -1).astype(np.int16)[face]
    return Raster(part, face, depth_of(nearness, view))


def projection_of(view: ViewCamera) -> Array:
    """The six numbers by which the compiled code projects."""
    from keypose.tracker.kernels.raster import PARALLEL, PERSPECTIVE

    kind = PERSPECTIVE if view.parallel_m is None else PARALLEL
    return np.array([kind, *view.focal, *view.centre, view.parallel_m or 1.0])


def depth_of(nearness: NDArray[np.float32], view: ViewCamera) -> NDArray[np.float32]:
    """z of the buffer's 1/z or −z; inf where it is still −inf."""
    depth = np.full_like(nearness, np.inf)
    drawn = nearness > -np.inf
    depth[drawn] = 1 / nearness[drawn] if view.parallel_m is None else -nearness[drawn]
    return depth


def _locked(values: NDArray[np.int64]) -> NDArray[np.int64]:
    array = np.ascontiguousarray(values, dtype=np.int64)
    array.setflags(write=False)
    return array
