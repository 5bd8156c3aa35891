"""Motions of the bundled samples to write out, with what tracking might have said of them."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory, interpolate, joined
from keypose.tracker.formats.bvh import bvh
from keypose.tracker.formats.recording import RecordedSegment, Recording
from keypose.tracker.formats.rigs import OWN
from keypose.tracker.formats.rigs.rig import rig_of
from keypose.tracker.formats.units import FileUnit
from keypose.tracker.geometry.rotations import exp_rotation, transform
from keypose.tracker.session import Session
from keypose.tracker.session.verdict import GOOD, Verdict
from keypose.tracker.storage.files import load_session
from keypose.tracker.storage.tracks import Tracks
from keypose.tracker.tracking.result import Diagnostics

SAMPLES = Path(__file__).parents[3] / "sample_videos"
NAMES = ("person", "box", "balance", "twirl")
"""The samples, and the person's with the whole body turning over and over."""

TO_FILE = np.diag([1.0, -1.0, -1.0])
"""Camera frame (y down, z forward) to a file with y up and z toward the viewer."""

VERDICTS = (GOOD, Verdict.check("not_seen", (3, 4), "left_hand"), Verdict.not_followed(7))


def session(name: str) -> Session:
    """The session of a sample."""
    return load_session(SAMPLES / name.replace("twirl", "person") / "session.json")


def trajectory(name: str) -> Trajectory:
    """The true motion of a sample, or the one that leads evenly through its keyframes."""
    if name == "twirl":
        return _twirled(trajectory("person"))
    truth = SAMPLES / name / "truth.npz"
    if truth.exists():
        with np.load(truth) as arrays:
            Rs, ps = arrays["Rs_parent_part"], arrays["ps_camera_root"]
            return Trajectory(int(arrays["first_frame"]), Rs, ps)
    made = session(name)
    skeleton = Skeleton.of(made.subject.body)
    neighbours = pairwise(made.subject.keyframes)
    return joined(
        [interpolate(a.pose(skeleton), b.pose(skeleton), a.frame, b.frame) for a, b in neighbours]
    )


def _twirled(motion: Trajectory) -> Trajectory:
    turn = np.outer(np.linspace(0, 5 * np.pi, len(motion)), [0.6, 0.64, 0.48])
    Rs = motion.Rs_parent_part.copy()
    Rs[:, 0] = Rs[:, 0] @ exp_rotation(turn)
    return Trajectory(motion.first_frame, Rs, motion.ps_camera_root)


def uneven_times(count: int) -> np.ndarray:  # type: ignore[type-arg]
    """Times as of a video whose rate changes."""
    steps = np.where(np.arange(count) % 7 < 4, 1 / 30, 1 / 24)
    return np.concatenate([[0.0], np.cumsum(steps)[:-1]])


def recording(name: str, *, without: tuple[int, ...] = (), first_key: int = 0) -> Recording:
    """A sample's motion as it is written.

    without: segments, by number, that are not tracked.  first_key: by number, earlier ones are not
    set.
    """
    made, motion = session(name), trajectory(name)
    made = made.changed({"keyframes": made.subject.keyframes[first_key:]})
    keyframes = [keyframe.frame for keyframe in made.subject.keyframes]
    spans = list(pairwise(keyframes))
    tracked = [span for i, span in enumerate(spans) if i not in without]
    rows = np.zeros(keyframes[-1] + 1, dtype=bool)
    for first, last in tracked:
        rows[first : last + 1] = True
    segments = [
        RecordedSegment(first, last, VERDICTS[i % 3])
        for i, (first, last) in enumerate(spans)
        if i not in without
    ]
    tracks = _tracks(made, motion, rows)
    return Recording.of(made, tracks, segments, uneven_times(made.view.video.frame_count))


def with_depth(made: Recording, px: float = 2.0, along_m: float = 0.05) -> Recording:
    """The same with what every joint is expected to be off by."""
    known = made.tracks.diagnostics
    shape = (len(made), made.skeleton.part_count)
    known = replace(
        known, expected_error=np.full(shape, px), expected_depth=np.full(shape, along_m)
    )
    return replace(made, tracks=replace(made.tracks, diagnostics=known))


def recorded(skeleton: Skeleton, motion: Trajectory, fps: float) -> Recording:
    """Any motion as it is written, all of it tracked, the camera's own up."""
    n, parts, dofs = len(motion), skeleton.part_count, skeleton.dof_count
    nothing = Diagnostics(
        np.full(n - 1, -1), np.zeros((n - 1, dofs)), *(np.zeros((n - 1, parts)) for _ in range(2))
    )
    tracks = Tracks(0, skeleton.body.names, motion.Rs_parent_part, motion.ps_camera_root, nothing)
    camera = session("person").view.camera
    times_s, up = np.arange(n) / fps, np.array([0.0, -1.0, 0.0])
    return Recording(skeleton, camera, tracks, (), times_s, up, rate=fps)


def _tracks(made: Session, motion: Trajectory, rows: np.ndarray) -> Tracks:  # type: ignore[type-arg]
    """Of the frames from the first tracked one to the last, with evidence where both ends are."""
    skeleton = Skeleton.of(made.subject.body)
    first, last = np.flatnonzero(rows)[[0, -1]]
    keep, own = rows[first : last + 1], slice(*np.array([first, last + 1]) - motion.first_frame)
    Rs = np.where(keep[:, None, None, None], motion.Rs_parent_part[own], np.nan)
    ps = np.where(keep[:, None], motion.ps_camera_root[own], np.nan)
    steps = keep[1:] & keep[:-1]
    rng = np.random.default_rng(1)
    observability = rng.uniform(size=(len(steps), skeleton.part_count))
    observability[~steps] = np.nan
    return Tracks(
        int(first),
        made.subject.body.names,
        Rs,
        ps,
        Diagnostics(
            np.where(steps, np.arange(len(steps)) % 5, -1),
            rng.uniform(size=(len(steps), skeleton.dof_count)),
            observability,
            10 * observability,
        ),
    )


def joints_in_file(made: Recording) -> np.ndarray:  # type: ignore[type-arg]
    """Where joints and landmarks are by our own forward kinematics (N, J, 3), y up, metres."""
    return made.trajectory.joints(made.skeleton) @ TO_FILE.T


def at_rest(made: Recording) -> Recording:
    """The recording with every part as the rest pose has it."""
    Rs = np.broadcast_to(np.eye(3), made.tracks.Rs_parent_part.shape).copy()
    return replace(made, tracks=replace(made.tracks, Rs_parent_part=Rs))


def bvh_of(
    skeleton: Skeleton,
    motion: Trajectory,
    seconds_per_frame: float,
    rig: str = OWN,
    unit: FileUnit = "m",
) -> str:
    """A BVH file whose world is the camera frame turned upright."""
    Ts_world_part = transform(TO_FILE, np.zeros(3)) @ motion.transforms(skeleton)
    Ts_world_part[..., :3, :3] = Ts_world_part[..., :3, :3] @ TO_FILE
    return bvh(rig_of(skeleton, rig, parallel=True), Ts_world_part, seconds_per_frame, unit)
