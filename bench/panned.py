"""Real people as a camera had taken them that pans and trembles, tracked by brightness alone.

The films of `real` are turned, exactly, and so are their marks and keyframes. What is found before
the turned film is to be as near to the marks as before the film itself: by how the camera was found
to turn its pictures are steadied, and compared with the empty scene.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from bench.camera_films import NEARLY_LOSSLESS
from bench.clips import Clip, clip
from bench.keeping import Absent, digest, place_for
from bench.keyed import jittered, keyed
from bench.measures import Over, figures
from bench.real import ROWS, Row
from bench.table import Expected, Report, Table
from bench.tracking import track
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.trajectory import joined
from keypose.tracker.camera_motion import find_camera_motion
from keypose.tracker.geometry.rotations import Array, exp_rotation
from keypose.tracker.geometry.steady import SteadyCamera
from keypose.tracker.tracking.tracker import Tracker
from keypose.tracker.video import Video
from keypose.tracker.video.encode import FilmWriter

PAN_DEG = 8.0
TREMBLE_DEG = (0.0, 0.1, 0.3)
MOST_PX = {"walk-20": 4.5, "walk-40": 10.0, "person-60": 11.0}
"""In the mean, which the steadied film should not exceed."""
JITTERS = 4
PRINTED = ("mean", "median", "p90", "worst", "over_10")


def panned(report: Report) -> None:
    """The whole group."""
    report.note(f"px at marked joints, by brightness alone; {JITTERS} disturbances of keyframes;")
    report.note(f"panned by {PAN_DEG:g}°, with a tremble of so many degrees; – is the film itself")
    table = report.table("before a camera that turns", "tremble", "way", *PRINTED, wide=PRINTED)
    for row in (row for row in ROWS if row.name in MOST_PX):
        try:
            _measured(row, table)
        except Absent as absent:
            report.note(f"{row.name} left out: {absent} is not here")


def _measured(row: Row, table: Table) -> None:
    here = clip(row.clip)
    hand = keyed(here, row.keyframes)
    with Video.open(here.video) as video:
        count = video.info.frame_count
        for static in (False, True):
            still = Tracker(video, here.camera, hand.skeleton, hand.poses, static_camera=static)
            over = _over(row, here, hand.poses, np.tile(np.eye(3), (count, 1, 1)), still)
            table.row(row.name, "–", "plate" if static else "plain", *over)
    for degrees in TREMBLE_DEG:
        Rs = turns(count, degrees)
        turned = _turned(here, Rs, f"{degrees:g}")
        poses = _seen(hand.poses, Rs)
        with Video.open(turned.video) as video:
            steady, around = _found(video, turned)
            for way, more in (
                ("plain", {}),
                ("steadied", {"steady": steady}),
                ("and plate", {"steady": steady, "turns": around}),
            ):
                tracker = Tracker(video, turned.camera, hand.skeleton, poses, **more)
                over, most = _over(row, turned, hand.poses, Rs, tracker), MOST_PX[row.name]
                expected = (
                    [Expected("mean", over[0].median, most, "px")] if way == "and plate" else []
                )
                table.row(row.name, f"{degrees:g}°", way, *over, expected=expected)


def _over(
    row: Row, shown: Clip, keyposes: Mapping[int, Pose], Rs: Array, tracker: Tracker
) -> list[Over]:
    """The figures over all disturbances of the keyframes, which are those of the film itself."""
    skeleton, found = tracker.skeleton, []
    for seed in range(JITTERS):
        poses = _seen(jittered(skeleton, keyposes, seed), Rs)
        motion = joined(track(tracker.renewed(skeleton, poses), cues=("brightness",)).trajectories)
        found.append(figures(shown, skeleton, motion, row.keyframes))
    return [Over(tuple(one[name] for one in found)) for name in PRINTED]


def turns(count: int, tremble_deg: float) -> Array:
    """(N, 3, 3) of a pan with a tremble of some cycles a second."""
    n = np.arange(count)
    shake = tremble_deg * np.stack([np.sin(1.7 * n), np.sin(1.1 * n), np.sin(0.9 * n)], axis=-1)
    shake[:, 1] += PAN_DEG * (n / (count - 1) - 0.5)
    return exp_rotation(np.radians(shake))


def _seen(poses: Mapping[int, Pose], Rs: Array) -> dict[int, Pose]:
    """Poses as the turned camera sees them."""
    seen = {}
    for frame, pose in poses.items():
        R = pose.Rs_parent_part.copy()
        R[0] = Rs[frame] @ R[0]
        seen[frame] = Pose(R, Rs[frame] @ pose.p_camera_root)
    return seen


def _found(video: Video, turned: Clip) -> tuple[SteadyCamera, Array]:
    """The steady camera, and how that is turned from the world, as the film tells."""
    greys = (
        None if rgb is None else np.asarray(cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY), np.uint8)
        for _, rgb in video.frames(0, video.info.frame_count)
    )
    path = find_camera_motion(greys, turned.camera, video.info.frame_count).path
    assert path is not None
    steady = SteadyCamera.along(turned.camera, path)
    return steady, steady.Rs_steady_camera @ path.Ts_camera_world[:, :3, :3]


def _turned(here: Clip, Rs: Array, name: str) -> Clip:
    """The clip as the turned camera had taken it, with its marks."""
    ideal = here.camera.without_distortion()
    video = place_for(f"panned-{here.name}-{name}", digest(Rs.tobytes()), ".mp4")
    if not video.is_file():
        _write(here, Rs, video)
    marks = {}
    for frame, joints in here.marks.items():
        p = here.camera.back_project(np.array(list(joints.values())), 1.0) @ Rs[frame].T
        uv = ideal.project(p).tolist()
        marks[frame] = {joint: (u, v) for joint, (u, v) in zip(joints, uv, strict=True)}
    return replace(
        here, video=video, camera=ideal, marks=marks, also_posed={}, stances=(), space=None
    )


def _write(here: Clip, Rs: Array, video: Path) -> None:
    unfinished = video.with_suffix(".part.mp4")
    size = (here.camera.width, here.camera.height)
    with FilmWriter(unfinished, size, Fraction(1, 30), Fraction(30), kind=NEARLY_LOSSLESS) as film:
        for pts, picture in enumerate(_pictures(here, Rs)):
            film.add(picture, pts)
    unfinished.replace(video)


def _pictures(here: Clip, Rs: Array) -> Iterator[NDArray[np.uint8]]:
    K, size = here.camera.K, (here.camera.width, here.camera.height)
    with Video.open(here.video) as video:
        for frame, rgb in video.frames(0, len(Rs)):
            assert rgb is not None
            H = K @ Rs[frame] @ np.linalg.inv(K)
            yield np.asarray(cv2.warpPerspective(here.camera.rectify(rgb), H, size), np.uint8)
