"""A real textured cube, pushed by a hand: corners in pixels against an edge tracker's reference."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.keeping import data_folder
from bench.sequences import video_of
from bench.table import Expected, Report, Table
from bench.tracking import Measure, Tracked, forward, linear, track
from keypose.tracker.body.body import ALL_DOFS, Body, Part
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.shapes import Box
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.settings import IgnoreMask
from keypose.tracker.tracking.tracker import Tracker
from keypose.tracker.video import Video

INTERVALS = (20, 54, 108, 217)
BARRED = (20, 54)
EXACT_UP_TO = 108
MOST_PX = 0.8
MOST_MASKED_PX = 1.5
BAR_PX = 40


@dataclass(frozen=True, eq=False)
class Cube:
    """The video in memory and its reference: Ts_camera_cube (N, 4, 4), corners (8, 3) metres."""

    skeleton: Skeleton
    camera: Camera
    frames: list[NDArray[np.uint8]]
    Ts_camera_cube: Array
    corners_m: Array

    def keyposes(self, interval: int) -> dict[int, Pose]:
        last = len(self.frames) - 1
        return {
            f: Pose(self.Ts_camera_cube[f, None, :3, :3], self.Ts_camera_cube[f, :3, 3])
            for f in range(0, last + 1, interval)
        }

    def corners_px(self) -> Array:
        """(N, 8, 2) of the reference."""
        T = self.Ts_camera_cube
        return self.camera.project(self.corners_m @ T[:, :3, :3].mT + T[:, None, :3, 3])


def load_cube() -> Cube:
    folder = data_folder("cube")
    meta = json.loads((folder / "meta.json").read_text(encoding="utf-8"))
    with np.load(folder / "reference.npz") as reference:
        Ts, corners = reference["T_cam_from_obj"], reference["vertices_m"]
    low, high = (tuple(float(x) for x in f(axis=0)) for f in (corners.min, corners.max))
    landmarks = {f"corner_{i}": tuple(float(x) for x in c) for i, c in enumerate(corners)}
    part = Part(
        name="cube",
        shape=Box(low_m=low, high_m=high),  # type: ignore[arg-type]
        tracked=ALL_DOFS,
        landmarks=landmarks,
    )
    K = meta["K"]
    camera = Camera(
        width=meta["width"],
        height=meta["height"],
        fx=K[0][0],
        fy=K[1][1],
        cx=K[0][2],
        cy=K[1][2],
    )
    with Video.open(folder / "cube.mp4") as video:
        frames = [video.frame(i) for i in range(video.info.frame_count)]
    return Cube(Skeleton.of(Body(name="cube", parts=(part,))), camera, frames, Ts, corners)


def corner_errors(cube: Cube) -> Measure:
    """Pixels of the corners strictly between a trajectory's ends."""
    true = cube.corners_px()

    def measure(found: Trajectory) -> tuple[Array, ...]:
        ours = cube.camera.project(found.joints(cube.skeleton)[1:-1, 1:])
        return (np.linalg.norm(ours - true[found.first_frame + 1 : found.last_frame], axis=-1),)

    return measure


def mean_px(measure: Measure, trajectories: Sequence[Trajectory]) -> float:
    return float(np.mean(np.concatenate([measure(t)[0].ravel() for t in trajectories])))


def cube(report: Report) -> None:
    """The whole group."""
    here = load_cube()
    report.note("mean corner error strictly between keyframes, px; the reference is good to 0.4 px")
    columns = ("linear", "forward", "paper", "keypose", "best tried", "kept", "verdicts")
    table = report.table("by keyframe interval", *columns, wide=("verdicts",))
    for interval in INTERVALS:
        plain = Tracker(
            video_of(len(here.frames), here.frames.__getitem__),
            here.camera,
            here.skeleton,
            here.keyposes(interval),
        )
        most = [MOST_PX] if interval <= EXACT_UP_TO else []
        _write(table, f"{interval}", here, plain, most)
    title = f"behind an opaque bar {BAR_PX} px wide that stands still"
    table = report.table(title, *columns, wide=("verdicts",))
    for interval in BARRED:
        for masked in (True, False):
            name = f"{interval}, bar {'under a mask' if masked else 'left to the weights'}"
            most = [MOST_MASKED_PX] if masked else []
            _write(table, name, here, _barred(here, interval, masked), most)


def _write(table: Table, name: str, here: Cube, tracker: Tracker, most: list[float]) -> None:
    measure = corner_errors(here)
    ours, papers = track(tracker), track(tracker, method="paper")
    found = (linear(tracker), forward(tracker), papers.trajectories, ours.trajectories)
    px = [mean_px(measure, trajectories) for trajectories in found]
    best = mean_px(measure, _best_tried(measure, ours))
    expected = [Expected("", px[3], m, "px") for m in most]
    table.row(name, *px, best, ours.kept, ours.verdicts, expected=expected)


def _best_tried(measure: Measure, found: Tracked) -> list[Trajectory]:
    return [min(c, key=lambda t: float(measure(t)[0].mean())) for c in found.tried.values()]


def _barred(here: Cube, interval: int, masked: bool) -> Tracker:
    """The cube behind a bar over the middle of where it is seen, and the mask that is drawn."""
    left = round(float(np.median(here.corners_px()[..., 0])) - BAR_PX / 2)
    right, bottom, last = left + BAR_PX, here.camera.height, len(here.frames) - 1

    def picture(frame: int) -> NDArray[np.uint8]:
        barred = here.frames[frame].copy()
        barred[:, left:right] = (96, 84, 74)
        return barred

    outline = ((left, 0), (right - 1, 0), (right - 1, bottom), (left, bottom))
    mask = IgnoreMask(polygon=outline, first_frame=0, last_frame=last)
    video = video_of(len(here.frames), picture)
    masks = (mask,) if masked else ()
    return Tracker(video, here.camera, here.skeleton, here.keyposes(interval), masks)
