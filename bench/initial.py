"""Where a segment starts from: templates beside interpolation, where that fails (INITIAL §4)."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import cv2
import numpy as np

from bench.arms import load_arms
from bench.contact_sheet import contact_sheet
from bench.keeping import ROOT, Absent
from bench.marked import Person, load_walk
from bench.sequences import Sequence, sequence
from bench.sheets import OUT, Shown, beside_linear, evaluation, pair, sheet
from bench.table import Expected, Pair, Report, Table
from bench.tracking import Tracked, against, linear, mean_errors, track
from keypose.app.render.pictures import overlay
from keypose.tracker.body.body import preset
from keypose.tracker.body.trajectory import Trajectory, joined
from keypose.tracker.kernels.matching import find_exhaustively, find_sequentially
from keypose.tracker.tracking.initial.templates.search import GreyPicture, Template, cut, outwards
from keypose.tracker.tracking.tracker import Tracker
from keypose.tracker.video import Video
from keypose.tracker.video.pyramid import prepare

EXPERIMENTS: dict[str, tuple[str, ...]] = {"shelf": (), "crossing": ("right_hand",)}
"""The two motions of INITIAL §4, and what it left out."""
WAYS: dict[str, dict[str, Any]] = {
    "paper": {"method": "paper"},
    "p templates": {"method": "paper", "initial": "templates"},
    "no templates": {"left_out": preset("adult_male").names},
    "templates": {"initial": "templates"},
    "auto": {"initial": "auto"},
}
HALF, REACH = 10, 16
"""Of the templates by which the searches are compared, and how far they look, pixels."""
FOLLOWED = ("left_hand", "left_foot", "right_foot", "head")
EVERY = 3
PEOPLE: dict[str, tuple[Callable[[], Person], tuple[int, ...]]] = {
    "walk": (load_walk, (20, 40)),
    "arms": (load_arms, (40,)),
}


def initial(report: Report) -> None:
    """The whole group."""
    _searches(report)
    _experiments(report)
    _people(report)


def _searches(report: Report) -> None:
    """The sequential search, the exhaustive one and OpenCV's on the same templates, in turn."""
    report.note(f"templates of {2 * HALF + 1}² pixels over ±{REACH} about where they last were;")
    report.note("rows: looked at by the sequential search, of all; times relative to exhaustive")
    table = report.table("searches", "searches", "rows %", "time %", "cv2 time %", "cv2 same %")
    for name in EXPERIMENTS:
        shown = sequence(name)
        seconds, rows, different, alike, count = np.zeros(3), np.zeros(2), 0, 0, 0
        for template, picture, at in _templates(shown):
            found = _searched(template, picture, at)
            seconds += [took for _, took in found]
            one, other, theirs = (result for result, _ in found)
            rows += one[3], other[3]
            different += one[:3] != other[:3]
            alike += theirs == other[:2]
            count += 1
        share = 100 * rows[0] / rows[1]
        table.row(
            name, count, float(share), *(float(100 * s / seconds[1]) for s in seconds[[0, 2]]),
            float(100 * alike / count), expected=[Expected("different minima", different, 0)],
        )  # fmt: skip


def _templates(shown: Sequence) -> list[tuple[Template, GreyPicture, tuple[int, int]]]:
    """Pieces of every third frame about the followed parts, and the frame after it to search."""
    pictures = [prepare(np.array(grey), None, 1)[0] for grey in shown.grey[:60]]
    searched = [GreyPicture.of(picture) for picture in pictures]
    Ts = shown.truth.transforms(shown.skeleton)
    found = []
    for n in range(0, len(pictures) - 1, EVERY):
        for name in FOLLOWED:
            uv = shown.camera.project(Ts[n, shown.skeleton.body.index(name), :3, 3])
            template = cut(pictures[n], uv, HALF)
            if template is not None:
                column, row = np.rint(uv - template.offset).astype(int)
                found.append((template, searched[n + 1], (int(row), int(column))))
    return found


def _searched(
    template: Template, shown: GreyPicture, at: tuple[int, int]
) -> list[tuple[tuple[int, ...], float]]:
    """What each search finds, and the seconds it takes; the third one row and column only."""
    around, most = outwards(REACH), 255
    rows, wanted = template.rows, np.ones_like(template.wanted)
    grey = np.pad(shown.grey, 3 * REACH + 2 * HALF, mode="edge")
    row, column = at[0] + 3 * REACH + 2 * HALF, at[1] + 3 * REACH + 2 * HALF
    area = grey[row - REACH :, column - REACH :]
    side = 2 * (HALF + REACH) + 1
    area, small = area[:side, :side].astype(np.float32), template.grey.astype(np.float32)

    def theirs() -> tuple[int, ...]:
        scores = cv2.matchTemplate(area, small, cv2.TM_SQDIFF)
        _, _, (u, v), _ = cv2.minMaxLoc(scores)
        return row + v - REACH, column + u - REACH

    return [
        _timed(
            lambda: find_sequentially(grey, template.grey, wanted, rows, row, column, around, most)
        ),
        _timed(lambda: find_exhaustively(grey, template.grey, wanted, row, column, REACH, most)),
        _timed(theirs),
    ]


def _timed(search: Callable[[], tuple[int, ...]]) -> tuple[tuple[int, ...], float]:
    search()
    began = time.perf_counter()
    found = search()
    return found, time.perf_counter() - began


def _experiments(report: Report) -> None:
    """Both motions of INITIAL §4 between keyframes at their two ends only."""
    report.note("keyframes at the two ends only; mean error between them, cm/px; start:")
    report.note("interpolation; p: the method as published, then ours. In `crossing` the far arm")
    report.note("is not followed by templates, as in the paper, yet counts here")
    table = report.table("two keyframes", "start", *WAYS)
    for name, left_out in EXPERIMENTS.items():
        shown = sequence(name)
        last = len(shown.grey) - 1
        tracker = Tracker(
            shown.video(), shown.camera, shown.skeleton, shown.keyposes([0, last])
        )  # fmt: skip
        measure = against(shown.skeleton, shown.camera, shown.truth)
        plain = mean_errors(measure, linear(tracker))
        found = {
            way: track(tracker, **{"left_out": left_out, **settings})
            for way, settings in WAYS.items()
        }
        errors = {way: mean_errors(measure, found[way].trajectories) for way in WAYS}
        table.row(name, plain, *errors.values(), expected=_succeeds(errors))
        _report(report, name, found["p templates"])
        motions = {way: found[way].trajectories[0] for way in ("paper", "p templates")}
        _strip(report, name, shown, motions)


def _succeeds(errors: dict[str, Pair]) -> list[Expected]:
    """Templates make the published method work where interpolation does not, and ours no worse."""
    plain, templates = errors["paper"], errors["p templates"]
    best = errors["no templates"].second
    return [
        Expected("half of interpolation", templates.first, plain.first / 2, "cm"),
        Expected("", templates.second, plain.second / 2, "px"),
        Expected("others", errors["templates"].second, 1.05 * best, "px"),
        Expected("auto", errors["auto"].second, 1.05 * best, "px"),
    ]


def _report(report: Report, name: str, found: Tracked) -> None:
    for segment in found.segments:
        for note in segment.notes:
            report.note(f"  {name}: {note}")


def _strip(report: Report, name: str, shown: Sequence, motions: dict[str, Trajectory]) -> None:
    """The tracked body over six pictures between the keyframes, a line for each motion."""
    frames = np.linspace(0, len(shown.grey) - 1, 8).astype(int)[1:-1].tolist()
    pictures = [
        np.asarray(
            overlay(shown.picture(n), shown.camera, shown.skeleton, motion.pose(n), style="wire")
        )
        for motion in motions.values()
        for n in frames
    ]
    labels = [f"{n} {way}" for way in motions for n in frames]
    OUT.mkdir(parents=True, exist_ok=True)
    sheet = contact_sheet(pictures, len(frames), labels)
    cv2.imwrite(str(OUT / f"initial_{name}.png"), sheet[..., ::-1])
    report.note(f"written: out/bench/initial_{name}.png")


def _people(report: Report) -> None:
    """Real people, at their marked joints between the keyframes."""
    report.note(
        "px at marked joints strictly between keyframes, mean/median; the marks of the arms"
    )
    report.note("were set by eye, at one frame between")
    table = report.table("real people", "start", *WAYS)
    for name, (load, intervals) in PEOPLE.items():
        try:
            person = load()
        except Absent as absent:
            report.note(f"left out: {absent} is not here")
            continue
        for interval in intervals:
            _person(report, table, f"{name} {interval}", person, interval)


def _person(report: Report, table: Table, name: str, person: Person, interval: int) -> None:
    frames = range(min(person.poses), max(person.poses) + 1, interval)
    keyposes = {frame: person.poses[frame] for frame in frames}
    with Video.open(person.video) as video:
        tracker = Tracker(video, person.camera, person.skeleton, keyposes)
        found = {way: track(tracker, **settings) for way, settings in WAYS.items()}
        segments = zip(found["auto"].segments, linear(tracker), strict=True)
        plain = Tracked([replace(segment, trajectory=motion) for segment, motion in segments])
    evaluated = [evaluation(person, f, person.marks).estimate for f in (plain, *found.values())]
    table.row(name, *(pair(e.pixels.overall) for e in evaluated))
    _report(report, name, found["templates"])
    lines = beside_linear(joined(found["templates"].trajectories), list(frames))
    shown = Shown(person.video, person.camera, person.skeleton)
    place = sheet(
        f"initial_{name.replace(' ', '_')}",
        shown,
        lines,
        list(frames),
        person.marks.frames.tolist(),
    )
    report.note(f"written: {place.relative_to(ROOT)}")
