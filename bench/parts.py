"""One limb keyed alone against a keyframe of the whole body, on real clips with marked joints.

A segment is tracked; of the limb whose marks are worst, the frame at which they are worst is taken,
and the limb is laid on its marks there, on the body as it was tracked. Reported are pixels at the
marks of the other frames, of that limb and of the rest: as tracked; with the limb keyed alone; and
with keyframes of the whole body, whose rest is as it was tracked, or posed by eye, wrong by 2° a
joint and 2 px at the root. Median (least–most) over keyframes disturbed by 0.5° and 3 mm.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from bench.clips import Clip, clip, place
from bench.keeping import Absent
from bench.keyed import jittered, keyed
from bench.measures import Over, marks_between
from bench.real import ROWS, Row
from bench.table import Report
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory, joined
from keypose.tracker.geometry.rotations import exp_rotation
from keypose.tracker.keypoints.stretch import Stretch
from keypose.tracker.session.settings import TrackSettings
from keypose.tracker.solver.least_squares import Criteria, Damping, least_squares
from keypose.tracker.solver.one_pose import OnePose
from keypose.tracker.solver.pose_terms import PointsInPicture, PosePrior
from keypose.tracker.solver.posed import BodyPoints
from keypose.tracker.tracking.cues.sources import DetectedKeypoints
from keypose.tracker.tracking.parts.keyed import KeyedParts, turning
from keypose.tracker.tracking.pool import never
from keypose.tracker.tracking.segment import NEAREST_M
from keypose.tracker.tracking.tracker import Tracker
from keypose.tracker.video import Video

CASES = ("walk-40", "person-60", "person-90")
LIMBS = {
    f"{side} {limb}": tuple(f"{side}_{part}" for part in parts)
    for limb, parts in (
        ("arm", ("upper_arm", "forearm", "hand")),
        ("leg", ("thigh", "shin", "foot")),
    )
    for side in ("left", "right")
}
EYE_RAD, EYE_PX = np.radians(2.0), 2.0
"""By how much the rest of a whole pose is wrong that is posed by eye."""
MARK_PX, TURN_RAD = 1.0, np.radians(30.0)
"""Standard deviations of a limb laid on its marks: of these, and of its turns from where it was."""
COLUMNS = ("limb px", "rest px", "cpu s")
WAYS = ("as tracked", "limb alone", "whole, rest tracked", "whole, rest by eye")


class Remembered(dict[str, Stretch]):
    """What the network found before, as the program keeps it on disk."""

    def put(self, key: str, stretch: Stretch) -> None:
        self[key] = stretch


@dataclass(frozen=True, eq=False)
class Scene:
    """A clip between two keyframes, tracked in one way."""

    shown: Clip
    video: Video
    skeleton: Skeleton
    settings: TrackSettings
    plain: Tracker
    remembered: Remembered

    def track(
        self, poses: Mapping[int, Pose], limbs: tuple[KeyedParts, ...] = (), key: str = ""
    ) -> Trajectory:
        """Through these keyframes and limbs; key: under which what is tracked without is kept."""
        source = None
        if "keypoints" in self.settings.cues_used:
            source = DetectedKeypoints(
                self.video, self.shown.camera, self.shown.name, self.remembered
            )
        frames = sorted(poses)
        keys = {(frames[0], frames[-1]): key} if key else {}
        tracker = self.plain.renewed(
            self.skeleton, poses, keypoints=source, keyed_parts=limbs, keys=keys
        )
        spans = tracker.spans
        found = [tracker.run_segment(span, self.settings, lambda *_: never()) for span in spans]
        return joined([segment.trajectory for segment in found])

    def on_marks(self, pose: Pose, frame: int, limb: tuple[str, ...]) -> Pose:
        """A pose whose limb lies on its marks."""
        body = self.skeleton.body
        parts = [body.index(name) for name in limb]
        free = turning(self.skeleton, tuple(parts))
        known = self.shown.marks[frame]
        names = [n for n in known if place(body, n)[0][0] in parts[1:] and len(place(body, n)) == 1]
        ideal = self.shown.camera.without_distortion()
        uv = np.array([known[name] for name in names])
        uv = ideal.project(self.shown.camera.back_project(uv, 1.0))
        points = BodyPoints(free, tuple(place(body, name) for name in names))
        scale = np.full(len(names), 1 / MARK_PX)
        terms = (
            PointsInPicture(points, ideal, uv, scale, NEAREST_M),
            PosePrior.of(pose, np.full(free.dof_count, TURN_RAD**-2.0)),
        )
        many = Criteria(most_steps=60, longest_step=0.3, settled=1e-6, damping=Damping(most=1e6))
        return least_squares(OnePose(free, terms), pose, many).state

    def by_eye(self, pose: Pose, seed: int) -> Pose:
        """The rest of a pose as somebody poses it."""
        rng = np.random.default_rng((seed, 77))
        turn = exp_rotation(rng.normal(0.0, EYE_RAD, (self.skeleton.part_count, 3)))
        z = pose.p_camera_root[2]
        shift = rng.normal(0.0, EYE_PX * z / self.shown.camera.fx, 3)
        return Pose(pose.Rs_parent_part @ turn, pose.p_camera_root + shift)

    def errors(
        self, motion: Trajectory, keyframes: tuple[int, ...], limb: tuple[str, ...]
    ) -> tuple[list[float], list[float]]:
        """Pixels at the marks of the limb, without its first joint, and at all others."""
        body = self.skeleton.body
        own: list[float] = []
        rest: list[float] = []
        for mark in marks_between(self.shown, self.skeleton, motion, keyframes):
            part = body.names[place(body, mark.joint)[0][0]]
            (own if part in limb[1:] else rest).append(mark.px)
        return own, rest


def parts(report: Report) -> None:
    """The whole group."""
    options = report.options
    report.note("px at marked joints of the other frames, mean; seconds of the processor")
    rows = [row for row in ROWS if row.name in (options.rows or CASES)]
    for cues in (("brightness",), ("brightness", "keypoints")):
        settings = TrackSettings(cues=cues)  # type: ignore[arg-type]
        table = report.table(" and ".join(cues), *COLUMNS, wide=COLUMNS)
        for row in rows:
            try:
                found = _measured(row, settings, options.jitters)
            except Absent as absent:
                report.note(f"{row.name} left out: {absent} is not here")
                continue
            for way in WAYS:
                table.row(f"{row.name}: {way}", *found.over(way))
            report.note(f"  corrected: {', '.join(dict.fromkeys(found.where))}")


@dataclass(eq=False)
class Found:
    """Figures by way, one for every disturbance. where: the limb and the frame that was chosen."""

    figures: dict[str, list[tuple[float, float, float]]]
    where: list[str]

    def over(self, way: str) -> tuple[Over, ...]:
        """Of the limb, of the rest, and seconds."""
        return tuple(Over(tuple(values)) for values in zip(*self.figures[way], strict=True))


def _measured(row: Row, settings: TrackSettings, jitters: int) -> Found:
    shown, hand = clip(row.clip), keyed(clip(row.clip), row.keyframes)
    ends = {frame: hand.poses[frame] for frame in (row.keyframes[0], row.keyframes[-1])}
    found = Found({way: [] for way in WAYS}, [])
    with Video.open(shown.video) as video:
        plain = Tracker(video, shown.camera, hand.skeleton, ends)
        scene = Scene(shown, video, hand.skeleton, settings, plain, Remembered())
        for seed in range(jitters):
            _disturbed(scene, jittered(hand.skeleton, ends, seed), seed, found)
    return found


def _disturbed(scene: Scene, ends: dict[int, Pose], seed: int, found: Found) -> None:
    """One disturbance of the keyframes, every way."""
    first, last = sorted(ends)
    key = f"{first}-{last}-{seed}"
    began = time.process_time()
    base = scene.track(ends, key=key)
    spent = [time.process_time() - began]
    name, frame = _worst(scene, base, (first, last))
    limb = LIMBS[name]
    pose = scene.on_marks(base.pose(frame), frame, limb)
    by_eye = scene.on_marks(scene.by_eye(pose, seed), frame, limb)
    alone = (KeyedParts.of(scene.skeleton, frame, limb, pose),)
    given = [(ends, alone, key), ({**ends, frame: pose}, (), ""), ({**ends, frame: by_eye}, (), "")]
    motions = [base]
    for poses, limbs, kept in given:
        began = time.process_time()
        motions.append(scene.track(poses, limbs, kept))
        spent.append(time.process_time() - began)
    found.where.append(f"{name} at {frame}")
    for way, motion, seconds in zip(WAYS, motions, spent, strict=True):
        own, rest = scene.errors(motion, (first, frame, last), limb)
        found.figures[way].append((float(np.mean(own)), float(np.mean(rest)), seconds))


def _worst(scene: Scene, motion: Trajectory, ends: tuple[int, int]) -> tuple[str, int]:
    """The limb whose marks are worst, and the frame at which they are, of those with two marks."""
    body, found = scene.skeleton.body, {}
    marks = marks_between(scene.shown, scene.skeleton, motion, ends)
    for name, limb in LIMBS.items():
        own = [m for m in marks if body.names[place(body, m.joint)[0][0]] in limb[1:]]
        by_frame = {m.frame: [o.px for o in own if o.frame == m.frame] for m in own}
        whole = {frame: float(np.mean(px)) for frame, px in by_frame.items() if len(px) > 1}
        if len(whole) > 1:
            found[name] = (float(np.mean(list(whole.values()))), max(whole, key=whole.__getitem__))
    name = max(found, key=lambda limb: found[limb][0])
    return name, found[name][1]
