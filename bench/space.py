"""The motion in space: planted feet, absolute depth, accelerations, peak speeds, proposed pins.

Side by side are interpolation, the motion as it was tracked, a zero-phase 6 Hz Butterworth of it
that meets the keyframes, and the last solve: smooth alone, with pins and exact keyframes, with pins
and soft ones.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
from scipy.signal import butter, sosfiltfilt
from scipy.spatial.transform import Rotation

from bench.clips import Clip, clip
from bench.keeping import ROOT, Absent
from bench.keyed import Keyed, jittered, keyed
from bench.measures import figures
from bench.sequences import FPS, sequence
from bench.sequences import Sequence as Shown
from bench.table import Expected, Report, Table
from bench.tracking import keyframes_every, linear, track
from keypose.tracker.body.modify import scaled
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory, joined
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, exp_rotation
from keypose.tracker.session.pins import Pin
from keypose.tracker.space.contacts import proposed_pins
from keypose.tracker.space.pinned import PinnedPoint
from keypose.tracker.space.solve import SpaceProblem, solve_space
from keypose.tracker.storage.files import load_session
from keypose.tracker.tracking.cues.sources import DetectedKeypoints
from keypose.tracker.tracking.tracker import Tracker
from keypose.tracker.video import Video

UP = np.array([0.0, -1.0, 0.0])
CUTOFF_HZ = 6.0
HELD = {"whole foot": ("left_heel", "left_toe"), "ankle": ()}
ACCELERATED = ("waist", "head", "left_foot")


@dataclass(frozen=True, eq=False)
class Motion:
    """A tracked motion with all that the last solve is given."""

    problem: SpaceProblem
    linear: Trajectory

    @property
    def skeleton(self) -> Skeleton:
        return self.problem.skeleton

    def solved(self, pins: Sequence[Pin] = (), soft: bool = False) -> Trajectory:
        """In space, with these pins."""
        points = [
            PinnedPoint(self.skeleton.body.index(pin.part), p, *pin.span)
            for pin in pins
            for p in pin.points(self.skeleton.body)
        ]
        held = self.problem.keyframes if soft else ()
        return solve_space(replace(self.problem, pins=points, soft=held)).motion

    def filtered(self) -> Trajectory:
        """The Butterworth, what it misses at the keyframes taken out linearly between them."""
        tracked, rate = self.problem.motion, self.problem.frames_per_second
        keys = [frame - tracked.first_frame for frame in sorted(self.problem.keyframes)]
        sos = butter(2, CUTOFF_HZ, fs=rate, output="sos")
        R0 = self.linear.Rs_parent_part
        turns = _log(np.swapaxes(R0, -1, -2) @ tracked.Rs_parent_part)
        shifts = tracked.ps_camera_root - self.linear.ps_camera_root
        rows = np.arange(len(tracked))

        def smooth(x: Array) -> Array:
            flat = x.reshape(len(x), -1)
            y = sosfiltfilt(sos, flat, axis=0)
            missed = np.stack([np.interp(rows, keys, (y - flat)[keys, k]) for k in range(len(y.T))])
            return np.asarray((y - missed.T).reshape(x.shape))

        R = R0 @ exp_rotation(smooth(turns))
        p = self.linear.ps_camera_root + smooth(shifts)
        return Trajectory(tracked.first_frame, R, p)

    def proposed(self, motion: Trajectory) -> tuple[Pin, ...]:
        return proposed_pins(self.skeleton, motion, self.problem.frames_per_second, UP)

    def ways(self, pins: Sequence[Pin]) -> dict[str, Trajectory]:
        """All that is compared."""
        return {
            "interpolation": self.linear,
            "as tracked": self.problem.motion,
            "Butterworth": self.filtered(),
            "smooth": self.solved(),
            "pinned, exact": self.solved(pins),
            "pinned, soft": self.solved(pins, soft=True),
        }


def space(report: Report) -> None:
    """The whole group."""
    works = [
        partial(_person, report),
        partial(_balance, report),
        partial(_walk, report),
        partial(_peaks, report),
        partial(_proposals, report),
    ]
    for work in works:
        try:
            work()
        except Absent as absent:
            report.note(f"left out: {absent} is not here")


def _person(report: Report) -> None:
    """The man on the beam, his left foot planted."""
    here = clip("person")
    columns = ("px", "median", "depth_mm", "root_mm", "slide_mm", "path_mm", *ACCELERATED)
    assert here.space is not None
    title = "person, left foot pinned 0-60; acceleration m/s² RMS, the reference's {}"
    for keys in ((0, 60), (0, 30, 60, 90)):
        motion = _tracked(here, keyed(here, keys))
        heading = title.format("/".join(f"{a:.1f}" for a in _reference(here, 0, keys[-1])))
        table = report.table(f"{heading}, keyframes {keys}", *columns)
        ways = {}
        for held, landmarks in HELD.items():
            pin = Pin(part="left_foot", landmarks=landmarks, first_frame=0, last_frame=60)
            ways |= {
                f"{way}, {held}" if "pinned" in way else way: one
                for way, one in motion.ways([pin]).items()
            }
        ways["proposals, soft"] = motion.solved(motion.proposed(ways["smooth"]), soft=True)
        tracked = _person_row(here, motion.skeleton, ways["as tracked"], keys)["mean"]
        for way, one in ways.items():
            _write_person(table, way, _person_row(here, motion.skeleton, one, keys), tracked)


def _person_row(
    here: Clip, skeleton: Skeleton, motion: Trajectory, keys: Sequence[int]
) -> dict[str, float]:
    found = figures(here, skeleton, motion, keys)
    slide, path = _slide(skeleton, motion, "left_foot", 0, 60)
    rates = {part: acceleration(skeleton, motion, part, 60.0) for part in ACCELERATED}
    return {**found, "slide": slide, "path": path, **rates}


def _write_person(table: Table, way: str, row: Mapping[str, float], tracked: float) -> None:
    expected = []
    if way.startswith("pinned, soft"):
        expected = [Expected("slide", row["slide"], 5.0, "mm"), Expected("path", row["path"], 30.0)]
        expected.append(Expected("px", row["mean"], tracked + 0.2))
    if way.startswith("proposals"):
        expected = [Expected("slide", row["slide"], 16.0, "mm")]
    names = ("mean", "median", "depth_mm", "root_mm", "slide", "path", *ACCELERATED)
    table.row(way, *(row[name] for name in names), expected=expected)


def _tracked(here: Clip, posed: Keyed) -> Motion:
    with Video.open(here.video) as video:
        tracker = Tracker(
            video,
            here.camera,
            posed.skeleton,
            posed.poses,
            keypoints=DetectedKeypoints(video, here.camera),
        )
        return _motion(tracker, here.camera, 60.0, cues=("brightness", "keypoints"))


def _motion(tracker: Tracker, camera: Camera, rate: float, **settings: object) -> Motion:
    found = track(tracker, **settings)
    observability = [segment.diagnostics.observability for segment in found.segments]
    problem = SpaceProblem(
        skeleton=tracker.skeleton,
        camera=camera.without_distortion(),
        motion=joined(found.trajectories),
        observability=np.concatenate(observability),
        keyframes=tuple(tracker.keyposes),
        frames_per_second=rate,
    )
    return Motion(problem, joined(linear(tracker)))


def _balance(report: Report) -> None:
    """The bundled clip, with its own keyframes."""
    here = clip("person")
    session = load_session(ROOT / "sample_videos" / "balance" / "session.json")
    skeleton = Skeleton.of(session.subject.body)
    poses = {keyframe.frame: keyframe.pose(skeleton) for keyframe in session.subject.keyframes}
    with Video.open(Path(ROOT / "sample_videos" / "balance" / "balance.mp4")) as video:
        tracker = Tracker(
            video,
            session.view.camera,
            skeleton,
            poses,
            static_camera=True,
            keypoints=DetectedKeypoints(video, session.view.camera),
        )
        motion = _motion(tracker, session.view.camera, 60.0, cues=("brightness", "keypoints"))
    theirs = _reference(here, 0, 60)
    title = "balance: acceleration m/s² RMS, the reference's "
    table = report.table(title + "/".join(f"{a:.1f}" for a in theirs), *ACCELERATED, "slide_mm")
    pin = Pin(part="left_foot", landmarks=HELD["whole foot"], first_frame=0, last_frame=60)
    for way, one in motion.ways([pin]).items():
        ours = [acceleration(skeleton, one, part, 60.0) for part in ACCELERATED]
        expected = [
            Expected(part, mine, 1.3 * true)
            for part, mine, true in zip(ACCELERATED, ours, theirs, strict=True)
            if way in ("smooth", "pinned, soft")
        ]
        table.row(way, *ours, _slide(skeleton, one, "left_foot", 0, 60)[0], expected=expected)


def _reference(here: Clip, first: int, last: int) -> list[float]:
    """m/s² of hips, shoulders and left ankle of the four-view reference, which stand for waist,
    head and foot."""
    assert here.space is not None
    names, joints = here.space
    groups = (("LHip", "RHip"), ("LShoulder", "RShoulder"), ("LAnkle",))
    return [
        _rms(joints[first : last + 1, [names.index(n) for n in group]].mean(axis=1), 60.0)
        for group in groups
    ]


def _walk(report: Report) -> None:
    """The rendered walk: how far an ankle slides in its stances."""
    shown = sequence("walk")
    frames = keyframes_every(30, 0, len(shown.grey) - 1)
    stances = proposed_pins(shown.skeleton, shown.truth, FPS, UP)
    stances = tuple(pin for pin in stances if pin.last_frame <= frames[-1] and _length(pin) > 5)
    columns = ("truth", "interpolation", "as tracked", "smooth", "pinned, exact", "pinned, soft")
    table = report.table("rendered walk, keyframes every 30: slide of an ankle, mm", *columns)
    for name, skeleton, poses in _keyings(shown, frames):
        tracker = Tracker(shown.video(), shown.camera, skeleton, poses)
        motion = _motion(tracker, shown.camera, FPS)
        ways = motion.ways(motion.proposed(motion.solved()))
        slides = [_stance_slide(shown.skeleton, shown.truth, stances)]
        slides += [_stance_slide(skeleton, ways[way], stances) for way in columns[1:]]
        most = [
            Expected(way, mm, 18.0, "mm") for way, mm in zip(columns[4:], slides[4:], strict=True)
        ]
        table.row(name, *slides, expected=most)


def _keyings(shown: Shown, frames: list[int]) -> list[tuple[str, Skeleton, Mapping[int, Pose]]]:
    true = shown.keyposes(frames)
    rng = np.random.default_rng(0)
    parts = shown.skeleton.part_count

    def disturbed(pose: Pose) -> Pose:
        turns = exp_rotation(rng.normal(0, np.radians(1.0), (parts, 3)))
        return Pose(pose.Rs_parent_part @ turns, pose.p_camera_root + rng.normal(0, 0.005, 3))

    noisy = {frame: disturbed(pose) for frame, pose in true.items()}
    larger = Skeleton.of(scaled(shown.skeleton.body, 1.05))
    farther = {f: Pose(p.Rs_parent_part, 1.05 * p.p_camera_root) for f, p in true.items()}
    jitters = jittered(shown.skeleton, true, 1)
    return [
        ("exact keyframes", shown.skeleton, true),
        ("disturbed, 0.5° and 3 mm", shown.skeleton, jitters),
        ("disturbed, 1° and 5 mm", shown.skeleton, noisy),
        ("sizes 5 % wrong", larger, farther),
    ]


def _stance_slide(skeleton: Skeleton, motion: Trajectory, stances: Sequence[Pin]) -> float:
    return float(np.mean([_slide(skeleton, motion, pin.part, *pin.span)[0] for pin in stances]))


def _peaks(report: Report) -> None:
    """Peak speeds of fast rendered motions, which smoothing must not cut."""
    columns = ("part", "truth m/s", "tracked", "Butterworth", "smooth")
    table = report.table("peak speed beside the truth's, percent", *columns)
    for name, parts in (("throw", ("right_hand",)), ("jump", ("waist", "left_foot"))):
        shown = sequence(name)
        frames = keyframes_every(30, 0, len(shown.grey) - 1)
        tracker = Tracker(shown.video(), shown.camera, shown.skeleton, shown.keyposes(frames))
        motion = _motion(tracker, shown.camera, FPS)
        ways = (motion.problem.motion, motion.filtered(), motion.solved())
        for part in parts:
            true = _peak(shown.skeleton, shown.truth, part, frames[-1])
            tracked, low, smooth = (_peak(shown.skeleton, w, part, frames[-1]) for w in ways)
            shares = [100 * (one / true - 1) for one in (tracked, low, smooth)]
            most = Expected("cut", 100 * (1 - smooth / tracked), 3.0, "%")
            table.row(name, part, true, *shares, expected=[most])


def _proposals(report: Report) -> None:
    """Frames proposed as planted against those of the truth, with noise as tracked feet have."""
    table = report.table("proposed pins: frames of both feet", "F1", "in the air")
    scores = []
    for name in ("walk", "stride", "crossing", "jump", "throw", "jumping_jacks"):
        shown = sequence(name)
        rng = np.random.default_rng(0)
        noise = rng.normal(0, (0.003, 0.003, 0.015), shown.truth.ps_camera_root.shape)
        tracked = replace(shown.truth, ps_camera_root=shown.truth.ps_camera_root + noise)
        pins = proposed_pins(shown.skeleton, tracked, FPS, UP)
        planted, high = _planted(shown)
        proposed = np.zeros_like(planted)
        for pin in pins:
            foot = ("left_foot", "right_foot").index(pin.part)
            proposed[pin.first_frame : pin.last_frame + 1, foot] = True
        hits = (proposed & planted).sum()
        f1 = 2 * hits / (proposed.sum() + planted.sum())
        scores.append(f1)
        table.row(name, float(f1), int((proposed & high).sum()))
    report.expect("1 − mean F1 of the proposals", 1 - float(np.mean(scores)), 1 - 0.93)


def _planted(shown: Shown) -> tuple[Array, Array]:
    """(N, 2) whether each foot stands: its ankle slower than 0.35 m/s and low; and whether it is
    more than 20 cm above its lowest."""
    T = shown.truth.transforms(shown.skeleton)
    feet = [shown.skeleton.body.index(f"{side}_foot") for side in ("left", "right")]
    p = T[:, feet][..., :3, 3]
    speed = np.linalg.norm(np.gradient(p, axis=0), axis=-1) * FPS
    height = (p @ UP) - (p @ UP).min(axis=0)
    return (speed < 0.35) & (height < 0.12), height > 0.2


def _slide(
    skeleton: Skeleton, motion: Trajectory, part: str, first: int, last: int
) -> tuple[float, float]:
    """How far a joint strays from its mean over these frames, and its path's length, mm."""
    p = motion.transforms(skeleton)[:, skeleton.body.index(part), :3, 3]
    p = p[max(first - motion.first_frame, 0) : last + 1 - motion.first_frame]
    away = np.linalg.norm(p - p.mean(axis=0), axis=-1)
    return 1000 * float(away.max()), 1000 * float(np.linalg.norm(np.diff(p, axis=0), axis=1).sum())


def acceleration(skeleton: Skeleton, motion: Trajectory, part: str, rate: float) -> float:
    """Root mean square of a joint's, m/s²."""
    return _rms(motion.transforms(skeleton)[:, skeleton.body.index(part), :3, 3], rate)


def _rms(p: Array, rate: float) -> float:
    a = np.diff(p, 2, axis=0) * rate**2
    return float(np.sqrt((a**2).sum(axis=-1).mean()))


def _peak(skeleton: Skeleton, motion: Trajectory, part: str, last: int) -> float:
    p = motion.transforms(skeleton)[: last + 1, skeleton.body.index(part), :3, 3]
    return float(np.linalg.norm(np.diff(p, axis=0), axis=1).max() * FPS)


def _length(pin: Pin) -> int:
    return pin.last_frame - pin.first_frame


def _log(R: Array) -> Array:
    """Continuous rotation vectors (N, P, 3) of (N, P, 3, 3)."""
    flat = Rotation.from_matrix(R.reshape(-1, 3, 3)).as_rotvec()
    return np.asarray(flat.reshape(*R.shape[:-2], 3))
