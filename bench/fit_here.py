"""Fit here: keyframes disturbed as a hand poses them, and how near the picture brings them."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.clips import clip
from bench.keeping import ROOT, Absent, digest, place_for
from bench.keyed import keyed
from bench.sequences import video_of
from bench.table import Expected, Pair, Report, Table
from bench.tracking import track
from keypose.tracker.body.pose import Pose, joint_positions, moved, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import joined
from keypose.tracker.fitting.pose import fit_pose_to_picture as fit
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.tracking.cues.sources import DetectedKeypoints, FrameSource
from keypose.tracker.tracking.tracker import Tracker
from keypose.tracker.video import Video
from tests.rendering.scenes import scene

STRETCHES = {"walk": (0, 72), "speech": (0, 72), "throw": (47, 119)}
INTERVAL = 24
TURN_RAD = np.radians(3.0)
SHIFT_M = 0.015
SEEDS = (1, 2, 3)
BESIDE = 10
MOST_PX = {"rendered": 0.5, "person": 5.0, "walk": 3.0}
REAL = (
    ("person", (15, 30, 45), 15),
    ("walk", (40, 50, 60), 10),
)
"""Frames that are fitted, and how far away the keyframes beside them are."""
CORRECT_PX = 1.0
COLUMNS = ("posed", "fitted", "worst", "in space", "across", "correct", "decided by", "s")


@dataclass(frozen=True, eq=False)
class _Subject:
    """A video and the poses at which it is known."""

    name: str
    video: Video
    camera: Camera
    skeleton: Skeleton
    poses: Mapping[int, Pose]
    frames: Sequence[int]
    interval: int
    source: FrameSource | None = None

    def rough(self, frame: int, seed: int) -> Pose:
        """The known pose as a hand would set it."""
        turns = self.skeleton.dof_turns == 1
        rng = np.random.default_rng([seed, frame])
        motion = rng.normal(size=len(turns)) * np.where(turns, TURN_RAD, SHIFT_M)
        return moved(self.skeleton, self.poses[frame], motion)

    def errors(self, frame: int, pose: Pose) -> Array:
        """Mean over the joints: pixels, cm, cm across the picture (without depth)."""
        ours, true = (
            joint_positions(self.skeleton, pose_transforms(self.skeleton, p))
            for p in (pose, self.poses[frame])
        )
        px = np.linalg.norm(self.camera.project(ours) - self.camera.project(true), axis=-1)
        away = 100 * (ours - true)
        across = np.linalg.norm(away[:, :2], axis=-1)
        return np.array([px.mean(), np.linalg.norm(away, axis=-1).mean(), across.mean()])


def fit_here(report: Report) -> None:
    """The whole group."""
    report.note("3° at every tracked joint angle, 1.5 cm at the hips; mean over all joints and")
    report.note("landmarks, px before and after, cm before/after; correct: px by which the known")
    report.note("pose is moved. known: the frames near were tracked while it was still right.")
    report.note("exact, rough: what the keyframes beside it are. tracked: it is a")
    report.note("new frame in a segment tracked between exact ones. alone: nothing is near.")
    table = report.table("by what lies beside it", *COLUMNS)
    for name in STRETCHES:
        try:
            subject = _rendered(name)
        except Absent as absent:
            report.note(f"left out: {absent} is not here")
            continue
        _rows(table, subject, "rendered")
    for name, frames, interval in REAL:
        try:
            person = clip(name)
        except Absent as absent:
            report.note(f"left out: {absent} is not here")
            continue
        hand = keyed(person, range(frames[0] - interval, frames[-1] + interval + 1, interval))
        with Video.open(person.video) as video:
            source = DetectedKeypoints(video, person.camera)
            subject = _Subject(
                name, video, person.camera, hand.skeleton, hand.poses, frames, interval, source
            )
            _rows(table, subject, name)


def _rendered(name: str) -> _Subject:
    """A motion in colour, its truth known at all frames."""
    try:
        shown = scene(name).cut(*STRETCHES[name])
    except FileNotFoundError:
        raise Absent(f"the recorded motion of {name!r}") from None
    truth = shown.truth.Rs_parent_part.tobytes() + shown.truth.ps_camera_root.tobytes()
    key = digest(ROOT / "tests" / "rendering", truth)
    place = place_for(f"{name}-colour", key, ".npy")
    if not place.is_file():
        unfinished = place.with_suffix(".part.npy")
        np.save(unfinished, shown.frames())
        unfinished.replace(place)
    pictures = np.load(place, mmap_mode="r")

    def picture(frame: int) -> NDArray[np.uint8]:
        return np.array(pictures[frame])

    poses = {k: shown.truth.pose(k) for k in range(len(pictures))}
    return _Subject(
        name,
        video_of(len(pictures), picture),
        shown.camera,
        shown.skeleton,
        poses,
        (INTERVAL, 2 * INTERVAL),
        INTERVAL,
    )


def _rows(table: Table, subject: _Subject, kind: str) -> None:
    for way in ("known", "exact", "rough", "tracked", "alone"):
        found = [_one(subject, way, f, s) for f in subject.frames for s in SEEDS]
        correct = [_moved(subject, way, f) for f in subject.frames]
        posed, fitted = (np.array([one[k] for one in found]) for k in (0, 1))
        ways = [one[2] for one in found]
        expected = [Expected("correct", max(correct), CORRECT_PX, "px")]
        if way != "alone":
            expected.insert(0, Expected("", float(fitted[:, 0].mean()), MOST_PX[kind], "px"))
        table.row(
            f"{subject.name}, {way}",
            float(posed[:, 0].mean()),
            float(fitted[:, 0].mean()),
            float(fitted[:, 0].max()),
            Pair(float(posed[:, 1].mean()), float(fitted[:, 1].mean()), ("posed", "fitted")),
            Pair(float(posed[:, 2].mean()), float(fitted[:, 2].mean()), ("posed", "fitted")),
            float(np.mean(correct)),
            " ".join(
                f"{ways.count(w)}{w[0]}" for w in ("joints", "neighbours", "outline", "nothing")
            ),
            float(np.median([one[3] for one in found])),
            expected=expected,
        )


def _one(subject: _Subject, way: str, frame: int, seed: int) -> tuple[Array, Array, str, float]:
    """Errors before and after, what decided, and seconds."""
    pose = subject.rough(frame, seed)
    keyposes, tracked = _beside(subject, way, frame, seed)
    began = time.perf_counter()
    found = fit(
        subject.video,
        subject.camera,
        subject.skeleton,
        frame,
        pose,
        keyposes,
        tracked,
        source=subject.source,
    )
    seconds = time.perf_counter() - began
    errors = subject.errors(frame, pose), subject.errors(frame, found.pose)
    return *errors, found.way, seconds


def _moved(subject: _Subject, way: str, frame: int) -> float:
    """Pixels by which the known pose is moved."""
    keyposes, tracked = _beside(subject, way, frame, 0)
    found = fit(
        subject.video,
        subject.camera,
        subject.skeleton,
        frame,
        subject.poses[frame],
        keyposes,
        tracked,
        source=subject.source,
    )
    return float(subject.errors(frame, found.pose)[0])


def _beside(
    subject: _Subject, way: str, frame: int, seed: int
) -> tuple[dict[int, Pose], dict[int, Pose]]:
    """The other keyframes and the tracked poses near."""
    frames = (frame - subject.interval, frame + subject.interval)
    exact = {k: subject.poses[k] for k in frames if k in subject.poses}
    if way == "alone":
        return {}, {}
    if way == "rough":
        return {k: subject.rough(k, 100 + seed) for k in exact}, {}
    if way == "exact":
        return exact, {}
    keyed = exact | {frame: subject.poses[frame]} if way == "known" else exact
    tracker = Tracker(subject.video, subject.camera, subject.skeleton, keyed)
    motion = joined(track(tracker).trajectories)
    return exact, {k: motion.pose(k) for k in range(frame - BESIDE, frame + BESIDE + 1)}
