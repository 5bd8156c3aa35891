"""Where calibrated cameras stand, and what each of them saw at one time step."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, frozen

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
