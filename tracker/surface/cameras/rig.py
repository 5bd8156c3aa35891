"""Calibrated cameras about a scene: read from JSON, and what each of them saw at one step.

    {"units": "cm", "up": "+z", "cameras": [
      {"name": "north", "width": 640, "height": 480, "fx": 620, "fy": 620, "cx": 319.5, "cy": 239.5,
       "R_camera_world": [[…], […], […]], "t_camera_world": [12.5, 80, 340],
       "images": "north/images", "silhouettes": "north/silhouettes",
       "box": [220, 90, 410, 460]}, …]}

A point of the world is at R_camera_world · p + t_camera_world in a camera's frame: x right, y down,
z away, pixel centres at integers. Units and the up axis are those of the world, which is also that
of the surfaces. Images and silhouettes are folders of images or videos, a picture for every step,
relative to the file. The box is about the person in the first image: left, top, right and bottom,
pixels.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Self, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, FiniteFloat, ValidationError, model_validator
from pydantic_core import from_json

from keypose.tracker.errors import SurfaceError, one_sentence
from keypose.tracker.files import read_named
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import (
    Array,
    frozen,
    nearest_rotation,
    rotation_from_quaternion,
    transform,
)
from keypose.tracker.session.settings import Plain, Units, UpAxis
from keypose.tracker.surface.mesh import SurfaceMesh
from keypose.tracker.surface.placing import METRES, Placement

Grey = NDArray[np.uint8]
Pixel = TypeVar("Pixel", np.uint8, np.float32)


def stack_pictures(pictures: Sequence[NDArray[Pixel]], beyond: float) -> NDArray[Pixel]:
    """(K, H, W) of the largest size; `beyond` where a smaller picture has ended."""
    height, width = (max(picture.shape[axis] for picture in pictures) for axis in (0, 1))
    stack = np.full((len(pictures), height, width), beyond, pictures[0].dtype)
    for whole, picture in zip(stack, pictures, strict=True):
        whole[: picture.shape[0], : picture.shape[1]] = picture
    return stack


@dataclass(frozen=True, eq=False)
class View:
    """One calibrated camera.

    camera:       its lens and the size of its pictures.
    T_view_world: (4, 4) from the world, metres, to the view's own frame (x right, y down, z away).
                  Which world that is, is the caller's: of one rig, all views have the same.
    """

    name: str
    camera: Camera
    T_view_world: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "T_view_world", frozen(self.T_view_world))

    @property
    def p_world_view(self) -> Array:
        """(3,) where the camera stands."""
        return np.asarray(-self.T_view_world[:3, :3].T @ self.T_view_world[:3, 3])

    def of_view(self, p_world: Array) -> Array:
        """Points (..., 3) of the world in the view's frame."""
        return np.asarray(p_world @ self.T_view_world[:3, :3].T + self.T_view_world[:3, 3])

    def project(self, p_world: Array) -> Array:
        """Pixels (..., 2) of points (..., 3) of the world; NaN for those not before the camera."""
        return self.camera.project(self.of_view(p_world))


@dataclass(frozen=True, eq=False)
class Lenses:
    """All views as the compiled loops want them, without distortion.

    Ts:     (K, 3, 4) from the world to each view's frame.
    lenses: (K, 4) fx, fy, cx, cy.
    sizes:  (K, 2) width, height, pixels.
    """

    Ts: Array = field(repr=False)
    lenses: Array
    sizes: NDArray[np.int64]

    @classmethod
    def of(cls, views: Sequence[View]) -> Lenses:
        cameras = [view.camera for view in views]
        return cls(
            np.stack([view.T_view_world[:3] for view in views]),
            np.array([(c.fx, c.fy, c.cx, c.cy) for c in cameras]),
            np.array([(c.width, c.height) for c in cameras], dtype=np.int64),
        )


LARGEST_BYTES = 4 * 2**20
MOST_CAMERAS = 200
"""Of a file of cameras: its bytes and how many it holds."""

Length: TypeAlias = Annotated[FiniteFloat, Field(ge=-1e9, le=1e9)]
Triple: TypeAlias = tuple[Length, Length, Length]
PathText: TypeAlias = Annotated[str, Field(min_length=1, max_length=4000)]


class RigCamera(Camera):
    """One camera of the file: a lens, where it stands, and what it took."""

    name: Annotated[str, Field(min_length=1, max_length=60)]
    R_camera_world: tuple[Triple, Triple, Triple] | None = None
    quaternion_wxyz: tuple[FiniteFloat, FiniteFloat, FiniteFloat, FiniteFloat] | None = None
    t_camera_world: Triple
    images: PathText | None = None
    silhouettes: PathText | None = None
    box: tuple[FiniteFloat, FiniteFloat, FiniteFloat, FiniteFloat] | None = None

    @model_validator(mode="after")
    def _stands_one_way(self) -> Self:
        if (self.R_camera_world is None) == (self.quaternion_wxyz is None):
            raise ValueError(f"camera {self.name!r} needs either R_camera_world or quaternion_wxyz")
        if self.R_camera_world is not None:
            R = np.array(self.R_camera_world)
            if np.abs(R @ R.T - np.eye(3)).max() > 1e-3 or np.linalg.det(R) < 0:
                raise ValueError(f"camera {self.name!r}: R_camera_world is not a rotation")
        elif not 0.99 < np.linalg.norm(np.array(self.quaternion_wxyz)) < 1.01:
            raise ValueError(f"camera {self.name!r}: quaternion_wxyz is not of length 1")
        if self.projection != "perspective":
            raise ValueError(f"camera {self.name!r} must have the perspective projection")
        return self

    @property
    def R(self) -> Array:
        """(3, 3) from the file's world to the camera's frame."""
        if self.R_camera_world is not None:
            return nearest_rotation(self.R_camera_world)
        return rotation_from_quaternion(self.quaternion_wxyz or (1, 0, 0, 0))

    @property
    def lens(self) -> Camera:
        """The lens alone."""
        return Camera(**{name: getattr(self, name) for name in Camera.model_fields})


class Rig(Plain):
    """The cameras of one file. Make one with `Rig.open`; `folder` is the file's own."""

    units: Units
    up: UpAxis
    cameras: Annotated[tuple[RigCamera, ...], Field(min_length=1, max_length=MOST_CAMERAS)]
    folder: Path = Field(default=Path(), exclude=True)

    @model_validator(mode="after")
    def _has_names_of_their_own(self) -> Self:
        names = [camera.name for camera in self.cameras]
        for name in names:
            if names.count(name) > 1:
                raise ValueError(f"camera {name!r} appears twice; every camera needs its own name")
        return self

    @classmethod
    def open(cls, path: Path) -> Rig:
        """Read the file; SurfaceError in one sentence when it is not one."""
        try:
            data = from_json(read_named(path, LARGEST_BYTES, "file of cameras", SurfaceError))
        except ValueError as error:
            raise SurfaceError(f"{path.name} is not JSON: {error}.") from None
        try:
            rig = cls.model_validate(data)
        except ValidationError as error:
            raise SurfaceError(f"{path.name}: {one_sentence(error)}") from None
        return rig.model_copy(update={"folder": path.absolute().parent})

    def placement(self, p_camera_surface: Array) -> Placement:
        """How the file's world lies in a session's camera frame."""
        return Placement(self.units, self.up, p_camera_surface)

    def views(self, p_camera_surface: Array) -> tuple[View, ...]:
        """The cameras in a session's camera frame, metres, where the surfaces are placed too."""
        R_world_file = self.placement(p_camera_surface).R_camera_surface
        views = []
        for camera in self.cameras:
            R = camera.R @ R_world_file.T
            t = METRES[self.units] * np.array(camera.t_camera_world) - R @ p_camera_surface
            views.append(View(camera.name, camera.lens, transform(R, t)))
        return tuple(views)

    def in_file(self, mesh: SurfaceMesh, p_camera_surface: Array) -> SurfaceMesh:
        """A mesh of a session's camera frame in the units and the world of the file."""
        placement = self.placement(p_camera_surface)
        p = (mesh.vertices - p_camera_surface) @ placement.R_camera_surface
        return SurfaceMesh(p / METRES[self.units], mesh.faces, mesh.consistency)
