"""Rendered sequences with their truth, kept on disk, and videos that lie in memory."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from bench.keeping import ROOT, Absent, digest, place_for
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.video import Examined, Video
from keypose.tracker.video.info import VideoInfo
from tests.rendering.render import rendered
from tests.rendering.scenes import Scene, scene
from tests.rendering.settings import RenderSettings

FPS = 30
LOOKS = {
    "textured": RenderSettings(),
    "texture-poor": RenderSettings(texture_contrast=4.0),
    "noise": RenderSettings(noise=12.0),
    "flicker": RenderSettings(flicker=0.10),
    "blur": RenderSettings(shutter=0.5),
    "panning background": RenderSettings(pan_px_per_frame=3.0),
}


@dataclass(frozen=True, eq=False)
class Sequence:
    """Grey pictures (N, H, W) of a motion that is known exactly."""

    skeleton: Skeleton
    camera: Camera
    truth: Trajectory
    grey: NDArray[np.uint8]

    def video(self) -> Video:
        return video_of(len(self.grey), self.picture)

    def picture(self, frame: int) -> NDArray[np.uint8]:
        """A frame as (H, W, 3) RGB; its grey is the kept one."""
        return np.asarray(cv2.cvtColor(np.array(self.grey[frame]), cv2.COLOR_GRAY2RGB), np.uint8)

    def keyposes(self, frames: list[int]) -> dict[int, Pose]:
        """The true poses at these frames."""
        return {frame: self.truth.pose(frame) for frame in frames}


def sequence(
    name: str,
    look: str = "textured",
    stretch: tuple[int, int] | None = None,
    size: tuple[int, int] = (640, 360),
) -> Sequence:
    """The scene of a name, first to last frame of `stretch`; rendered if it is not kept yet."""
    try:
        whole = scene(name, LOOKS[look], size)
    except FileNotFoundError:
        raise Absent(f"the recorded motion of {name!r}") from None
    shown = whole if stretch is None else whole.cut(*stretch)
    place = place_for(_file_name(name, look, size, len(shown.truth)), _key(shown), ".npy")
    if not place.is_file():
        _render(shown, place)
    grey = np.load(place, mmap_mode="r")
    return Sequence(shown.skeleton, shown.camera, shown.truth, grey)


def walking(stretch: tuple[int, int] = (0, 75), size: tuple[int, int] = (640, 360)) -> Sequence:
    """Someone who walks: recorded, or written where the recordings are not here."""
    try:
        return sequence("walk", stretch=stretch, size=size)
    except Absent:
        return sequence("stride", stretch=stretch, size=size)


def _file_name(name: str, look: str, size: tuple[int, int], count: int) -> str:
    return f"{name}-{look.replace(' ', '-')}-{size[0]}-{count}"


def _key(shown: Scene) -> str:
    truth = shown.truth.Rs_parent_part.tobytes() + shown.truth.ps_camera_root.tobytes()
    plain = f"{shown.skeleton.body!r} {shown.camera!r} {shown.settings!r}"
    return digest(ROOT / "tests" / "rendering", truth, plain.encode())


def _render(shown: Scene, place: Path) -> None:
    frames = rendered(shown.skeleton, shown.truth, shown.camera, shown.settings)
    grey = np.stack([cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY) for rgb in frames])
    unfinished = place.with_suffix(".part.npy")
    np.save(unfinished, grey)
    unfinished.replace(place)


class _Source:
    """Pictures made on demand, as a video takes them."""

    def __init__(self, count: int, picture: Callable[[int], NDArray[np.uint8]]) -> None:
        height, width = picture(0).shape[:2]
        self.picture = picture
        ticks = np.arange(count, dtype=np.int64)
        self.info = VideoInfo(
            path=Path("pictures"),
            container="pictures",
            codec="none",
            width=width,
            height=height,
            frame_count=count,
            time_base=Fraction(1, FPS),
            pts=ticks,
            times_s=ticks / FPS,
            fps=float(FPS),
            variable_rate=False,
            rotation_deg=0,
            interlaced=False,
            pixel_aspect=Fraction(1),
            missing=(),
        )

    def approach(self, number: int, since: int) -> Iterator[tuple[int, NDArray[np.uint8]]]:
        yield number, self.picture(number)

    def reindex(self) -> None:
        """Nothing surprises here."""

    def examine(self, first: int, last: int) -> Iterator[Examined]:
        """Nothing here is built on something else: no frame is damaged by another."""
        yield Examined(first, last, frozenset(), last)

    def fingerprint(self) -> str:
        return ""

    def close(self) -> None:
        """Nothing is open."""


def video_of(count: int, picture: Callable[[int], NDArray[np.uint8]]) -> Video:
    """A video of `count` frames, each (H, W, 3) RGB made by `picture`; no codec takes part."""
    return Video(_Source(count, picture), cache_bytes=0)
