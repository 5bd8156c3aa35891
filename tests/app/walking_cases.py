"""A session of a person who walks, tracked, as results and files have it; its film is small and
shows nobody."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np

from keypose.tracker.body.body import preset
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.session import Keyframe, Session, VideoReference
from keypose.tracker.session.verdict import GOOD
from keypose.tracker.storage.files import open_video_of, save_session
from keypose.tracker.storage.results import Results, save_results, segment_key
from keypose.tracker.tracking.result import Diagnostics, SegmentResult
from tests.rendering.motions import crossing
from tests.tracker.video_cases import write_numbered

FRAMES = 153
KEYED = (0, 51, 102, 152)
SKELETON = Skeleton.of(preset("adult_female"))
WIDTH = 64
HEIGHT = 48


def write_walk(folder: Path, film: str = "walk.mkv", rate: int = 30) -> tuple[Path, Results]:
    """The session file beside its film, with six steps and a keyframe at every stride."""
    folder.mkdir(parents=True)
    clip = folder / film
    write_numbered(clip, FRAMES, rate=rate)
    motion = crossing(SKELETON, FRAMES)
    camera = Camera(width=WIDTH, height=HEIGHT, fx=60.0, fy=60.0, cx=31.5, cy=23.5)
    session = Session.begin(
        video=VideoReference(
            path=clip.name, fingerprint="", frame_count=FRAMES, width=WIDTH, height=HEIGHT
        ),
        camera=camera,
        body=SKELETON.body,
        keyframes=tuple(Keyframe.of(SKELETON, motion.pose(f), f, f / 25) for f in KEYED),
    )
    path = folder / "session.json"
    save_session(session, path)
    results = Results()
    for first, last in pairwise(KEYED):
        results = results.with_result(_segment(session, motion, first, last))
    save_session(save_results(session, path, results), path)
    open_video_of(session, path).close()
    return path, results


def _segment(session: Session, motion: Trajectory, first: int, last: int) -> SegmentResult:
    rows, steps = slice(first, last + 1), last - first
    parts, dofs = SKELETON.part_count, SKELETON.dof_count
    nothing = Diagnostics(
        np.full(steps, dofs), np.ones((steps, dofs)), *(np.ones((steps, parts)) for _ in range(2))
    )
    path = Trajectory(first, motion.Rs_parent_part[rows], motion.ps_camera_root[rows])
    key = segment_key(session, first, last)
    return SegmentResult(path, GOOD, nothing, (1.0,), ("pass",), key=key)
