"""Ready scenes: a body, its motion, the camera that sees it."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.body import preset
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.camera import Camera
from tests.rendering import motions
from tests.rendering.bodies import box_body
from tests.rendering.render import render
from tests.rendering.settings import RenderSettings

RECORDED = ("walk", "jump", "wash", "pirouette", "jumping_jacks")
PERSON_MOTIONS = ("speech", "throw", "stride", "shelf", "crossing", *RECORDED)
NAMES = (*PERSON_MOTIONS, "tumbling_box")


@dataclass(frozen=True, eq=False)
class Scene:
    """A sequence before it is rendered; `truth` is exact at the middle of every exposure."""

    name: str
    skeleton: Skeleton
    truth: Trajectory
    camera: Camera
    settings: RenderSettings = field(default_factory=RenderSettings)

    def frames(self) -> NDArray[np.uint8]:
        """(N, H, W, 3) RGB."""
        return render(self.skeleton, self.truth, self.camera, self.settings)

    def cut(self, first: int, last: int) -> Scene:
        """Frames first to last of the motion, both included, counted from 0 again."""
        Rs, ps = self.truth.Rs_parent_part[first : last + 1], self.truth.ps_camera_root
        return replace(self, truth=Trajectory(0, Rs, ps[first : last + 1]))


def camera(width: int = 640, height: int = 360) -> Camera:
    """The usual camera, f = 900 pixels at 640×360, scaled to the picture's width."""
    f = 900.0 * width / 640
    centre = ((width - 1) / 2, (height - 1) / 2)
    return Camera(width=width, height=height, fx=f, fy=f, cx=centre[0], cy=centre[1])


def scene(
    name: str,
    settings: RenderSettings | None = None,
    size: tuple[int, int] = (640, 360),
    body: str = "adult_male",
) -> Scene:
    """The scene of a name in NAMES; those in RECORDED need recorded motions."""
    if name not in NAMES:
        raise ValueError(f"there is no scene {name!r}; the scenes are {', '.join(NAMES)}")
    skeleton = Skeleton.of(box_body() if name == "tumbling_box" else preset(body))
    truth: Trajectory = getattr(motions, name)(skeleton)
    return Scene(name, skeleton, truth, camera(*size), settings or RenderSettings())
