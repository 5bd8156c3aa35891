"""Real people, posed on hand-marked joints: pixels at the marked joints between keyframes."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import cv2
import numpy as np

from app.render.pictures import contact_sheet, overlay
from tests.benchmarks.keeping import ROOT, Absent
from tests.benchmarks.marked import Person, load_person, load_walk
from tests.benchmarks.table import Expected, Pair, Report, Table
from tests.benchmarks.tracking import Tracked, linear, track
from tracker.body.pose import joint_positions, pose_transforms
from tracker.body.trajectory import Trajectory, interpolate, joined
from tracker.errors import FormatError
from tracker.evaluate import Evaluation, JointReference, Spread, evaluate_joints
from tracker.formats.verdict_words import verdict_words
from tracker.tracking.tracker import Tracker
from tracker.video import Video

INTERVALS = {"person": (15, 30, 60), "walk": (10, 20, 40)}
LOADERS = {"person": load_person, "walk": load_walk}
MEDIAN_PX = {
    ("person", 30): 3.0,
    ("person", 60): 6.5,
    ("walk", 10): 5.5,
    ("walk", 20): 6.0,
    ("walk", 40): 8.0,
}
BEFORE_PX = {
    ("person", 15): (6.3, 5.8),
    ("person", 30): (5.3, 4.3),
    ("person", 60): (13.2, 9.6),
    ("walk", 10): (3.5, 3.5),
    ("walk", 20): (4.5, 3.7),
    ("walk", 40): (9.9, 5.2),
}
"""Mean and median as they were recorded before steps knew their doubt (commit 40369e8)."""
HALF_OF_LINEAR = (("person", 30), ("walk", 20))
SHEETS = (("person", 30), ("person", 60), ("walk", 20), ("walk", 40))
OUT = ROOT / "out" / "bench"
WAYS: dict[str, dict[str, Any]] = {
    "paper": {"method": "paper"},
    "fast": {"quality": "fast"},
    "templates": {"initial": "templates"},
    "both ways": {"initial": "both-ways"},
    "keypose": {},
    "static": {"static_camera": True},
}


def real(report: Report) -> None:
    """The whole group."""
    report.note("px at marked joints strictly between keyframes, mean/median; marks are good to")
    report.note("2 px. static: keypose with static_camera. Body sizes are fitted once for a clip.")
    report.note("before: as recorded before steps of a chain knew their doubt")
    columns = ("linear", "before", *WAYS, "kept", "verdicts")
    table = report.table("by keyframe interval", *columns, wide=("verdicts",))
    tracked: dict[tuple[str, int], dict[str, Tracked]] = {}
    people: dict[str, Person] = {}
    for name, load in LOADERS.items():
        try:
            people[name] = load()
        except Absent as absent:
            report.note(f"left out: {absent} is not here")
            continue
        for interval in INTERVALS[name]:
            found = _tracked(people[name], interval)
            tracked[name, interval] = found
            _write(table, name, interval, people[name], found)
    for (name, interval), found in tracked.items():
        _words(report, f"{name} {interval}", people[name], found["keypose"])
    if "person" in people:
        _in_space(report, people["person"], tracked)
    for name, interval in SHEETS:
        if name in people:
            _sheet(report, name, interval, people[name], tracked[name, interval]["keypose"])


def _tracked(person: Person, interval: int) -> dict[str, Tracked]:
    """The clip tracked every way between keyframes so far apart."""
    frames = range(min(person.poses), max(person.poses) + 1, interval)
    keyposes = {frame: person.poses[frame] for frame in frames}
    found = {}
    with Video.open(person.video) as video:
        for static in (False, True):
            tracker = Tracker(
                video, person.camera, person.skeleton, keyposes, static_camera=static
            )  # fmt: skip
            for way, settings in WAYS.items():
                if settings.get("static_camera", False) == static:
                    found[way] = track(tracker, **settings)
            if not static:
                segments = [
                    replace(segment, trajectory=trajectory)
                    for segment, trajectory in zip(
                        found["keypose"].segments, linear(tracker), strict=True
                    )
                ]
                found["linear"] = Tracked(segments)
    return found


def _evaluation(person: Person, found: Tracked, reference: JointReference) -> Evaluation:
    keyframes = [found.trajectories[0].first_frame, *(t.last_frame for t in found.trajectories)]
    whole = joined(found.trajectories)
    known = reference.frames <= whole.last_frame
    reference = replace(
        reference, frames=reference.frames[known], positions=reference.positions[known]
    )
    return evaluate_joints(person.skeleton, person.camera, whole, reference, keyframes)


def _reference(person: Person, interval: int) -> tuple[JointReference, str]:
    """What to compare with: the marks, or where all marks are keyframes the rough 3D joints."""
    between = [f for f in person.marks.frames if (f - person.marks.frames[0]) % interval]
    if between or person.space is None:
        return person.marks, ""
    return person.space, ", rough 3D projected"


def _write(
    table: Table, name: str, interval: int, person: Person, found: dict[str, Tracked]
) -> None:
    reference, remark = _reference(person, interval)
    ways = ("linear", *WAYS)
    px = {w: _evaluation(person, found[w], reference).estimate.pixels.overall for w in ways}
    ours, plain = px["keypose"], px["linear"]
    expected = [
        Expected("linear", ours.mean, plain.mean, "px"),
        Expected("", ours.median, plain.median, "px"),
    ]
    if (name, interval) in HALF_OF_LINEAR:
        expected = [
            Expected("half of linear", ours.mean, plain.mean / 2, "px"),
            Expected("", ours.median, plain.median / 2, "px"),
        ]
    if (name, interval) in MEDIAN_PX:
        most = MEDIAN_PX[name, interval]
        expected.append(Expected("median", ours.median, most, "px"))
        expected.append(Expected("static", px["static"].median, most, "px"))
    cells = [_pair(px[w]) for w in ways]
    cells.insert(1, Pair(*BEFORE_PX[name, interval], ("mean", "median"), digits=1))
    kept, verdicts = found["keypose"].kept, found["keypose"].verdicts
    table.row(f"{name} {interval}{remark}", *cells, kept, verdicts, expected=expected)


def _pair(spread: Spread, factor: float = 1.0) -> Pair:
    return Pair(factor * spread.mean, factor * spread.median, ("mean", "median"), digits=1)


def _words(report: Report, name: str, person: Person, found: Tracked) -> None:
    """Each segment's verdict beside its error, its candidates' scores and the joints worst off."""
    report.note(f"\n{name}: segments as they were judged")
    for segment in found.segments:
        first, last = segment.trajectory.first_frame, segment.trajectory.last_frame
        scores = " ".join(
            f"{'*' if k == segment.best_pass else ''}{step[0]}{score:.0f}"
            for k, (step, score) in enumerate(zip(segment.steps, segment.scores, strict=True))
        )
        error = _worst(person, Tracked([segment]), last - first)
        report.note(f"  {first}–{last}: {error}; {verdict_words(segment.verdict)}; scores {scores}")


def _worst(person: Person, found: Tracked, interval: int) -> str:
    """A segment's error in words, with the joints that are furthest off."""
    reference, _ = _reference(person, interval)
    try:
        pixels = _evaluation(person, found, reference).estimate.pixels
    except FormatError:
        return "nothing marked between"
    known = {n: s.mean for n, s in pixels.each.items() if s.count}
    worst = sorted(known, key=lambda n: -known[n])[:4]
    return f"{_pair(pixels.overall)} px, {', '.join(f'{n} {known[n]:.0f}' for n in worst)}"


def _in_space(report: Report, person: Person, tracked: dict[tuple[str, int], Any]) -> None:
    """The person in metres."""
    assert person.space is not None
    report.note("\nthe person in space, cm, mean/median over 12 joints; the reference is itself")
    report.note("only good to 1–3 cm and runs 0.4–1.0 frame ahead of the video")
    table = report.table("in space", "linear", *WAYS)
    for interval in INTERVALS["person"]:
        found = tracked["person", interval]
        errors = [
            _evaluation(person, found[w], person.space).estimate for w in ("linear", *WAYS)
        ]  # fmt: skip
        wholes = [_pair(e.distance_m.overall, 100.0) for e in errors if e.distance_m]
        depths = [_pair(e.depth_m.overall, 100.0) for e in errors if e.depth_m]
        table.row(f"person {interval}, distance", *wholes)
        table.row(f"person {interval}, depth alone", *depths)


def _sheet(report: Report, name: str, interval: int, person: Person, found: Tracked) -> None:
    """The tracked body over the pictures, interpolation below it, for a person to look at."""
    ours = joined(found.trajectories)
    keys = sorted({t.first_frame for t in found.trajectories} | {ours.last_frame})
    frames = sorted({(a + b) // 2 for a, b in pairwise(keys)} | set(keys))
    frames += [f for f in person.marks.frames.tolist() if f <= ours.last_frame]
    frames = sorted(set(frames))
    plain = joined(_interpolated(person, keys))
    box = _box(person, ours, frames)
    pictures, labels = [], []
    with Video.open(person.video) as video:
        for way, motion in (("keypose", ours), ("linear", plain)):
            for frame in frames:
                pictures.append(_cell(person, video, motion, frame, box))
                labels.append(f"{frame} {'keyframe' if frame in keys else way}")
    OUT.mkdir(parents=True, exist_ok=True)
    sheet = contact_sheet(pictures, len(frames), labels)
    cv2.imwrite(str(OUT / f"{name}_{interval}.png"), sheet[..., ::-1])
    report.note(f"written: out/bench/{name}_{interval}.png")


def _interpolated(person: Person, keys: list[int]) -> list[Trajectory]:
    return [interpolate(person.poses[a], person.poses[b], a, b) for a, b in pairwise(keys)]


def _box(person: Person, motion: Trajectory, frames: list[int]) -> tuple[int, int]:
    """Width and height of a cut-out in which the body fits at all frames."""
    joints = motion.joints(person.skeleton)[np.array(frames) - motion.first_frame]
    extent = np.ptp(person.camera.project(joints), axis=1).max(axis=0)
    return int(1.25 * extent[0] + 40), int(1.2 * extent[1] + 40)


def _cell(
    person: Person, video: Video, motion: Trajectory, frame: int, box: tuple[int, int]
) -> np.ndarray:
    """The body over the picture, cut out around where it is."""
    camera, pose = person.camera.without_distortion(), motion.pose(frame)
    picture = overlay(
        person.camera.rectify(video.frame(frame)), camera, person.skeleton, pose, style="wire"
    )
    joints = joint_positions(person.skeleton, pose_transforms(person.skeleton, pose))
    centre = np.nanmean(camera.project(joints), axis=0)
    size = np.minimum(box, (camera.width, camera.height))
    left, top = np.clip(centre - size / 2, 0, (camera.width, camera.height) - size).astype(int)
    cut = picture[top : top + size[1], left : left + size[0]]
    return np.asarray(cv2.resize(cut, None, fx=1.5, fy=1.5, interpolation=cv2.INTER_CUBIC))
