"""What tracking saw of each joint, against how far the joint is off its mark: is *good* true, and
which joints are told from wrong ones.

Evidence is collected once on the marked clips, between many keyframes, and kept: another way to
weigh it is a matter of seconds. Every weighing is fitted on all clips but one and judged on that
one. A joint is wrong that is more than 10 px off on a person 400 px tall. A segment is right whose
marked joints are at most 6 px off in the mean, in the picture or on a person 400 px tall: 5 px, and
the 3 to 4 px by which marks differ from one person to the next.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any
from unittest.mock import patch

import numpy as np
from numpy.typing import NDArray
from scipy.stats import rankdata

from bench.clips import TALL, clip
from bench.keeping import ROOT, Absent, digest, place_for
from bench.keyed import keyed
from bench.keypoints import SHORT
from bench.measures import FAR_PX, TALL_PX
from bench.real import BOTH, NETWORK, Posed, with_settings
from bench.table import Expected, Report
from keypose.tracker.body.trajectory import joined
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.blazepose import NAMES
from keypose.tracker.keypoints.on_body import points_on_body
from keypose.tracker.session.settings import TrackSettings
from keypose.tracker.solver.posed import BodyPoints
from keypose.tracker.tracking.cues.joint_evidence import (
    FEW,
    LEAST,
    LEAST_DRIFT,
    NEAR,
    JointEvidence,
)
from keypose.tracker.tracking.cues.joint_evidence import TALL_PX as TALL_LEAST
from keypose.tracker.tracking.diagnostics import judge
from keypose.tracker.video import Video

CASES: dict[str, tuple[tuple[int, ...], ...]] = {
    "person": ((0, 15, 30, 45, 60, 75, 90), (0, 30, 60, 90), (15, 45, 75), (0, 45, 90), (0, 60),
               (30, 90), (0, 90)),
    "walk": ((30, 40, 50, 60, 70, 80, 90), (30, 50, 70, 90), (40, 60, 80), (30, 60, 90),
             (30, 70), (50, 90)),
    "arms": ((20, 40, 60), (20, 60), (20, 30, 50, 60)),
    "camera4": ((0, 30, 60, 90), (15, 45, 75), (0, 45, 90), (0, 60), (30, 90)),
}  # fmt: skip
"""By clip the sets of keyframes that are posed on their marks."""
JITTERS = 2
WRONG, RIGHT_PX = FAR_PX / TALL_PX, 6.0
SURE_MARK = 0.015
"""Errors below it, a share of the height, count as no more: marks by hand are good to no less."""
TALL_CAMERA4 = 810.0
JOINT = ("wrong_by", "apart", "drift", "away", "distance", "visibility", "expected")
"""Columns of a joint: what it is off by, the evidence, and the error expected of it."""
WEIGHED: dict[str, tuple[str, ...]] = {
    "apart, drift, away": ("apart", "drift", "away"),
    "  and distance": ("apart", "drift", "away", "distance"),
    "  and visibility": ("apart", "drift", "away", "visibility"),
    "  and both": ("apart", "drift", "away", "distance", "visibility"),
}
GOOD_OFTEN, GOOD_TRUE, AUROC = 0.60, 0.97, 0.80


@dataclass(frozen=True, eq=False)
class Evidence:
    """What was seen of J marked joints in G segments.

    joints (J, 7): see JOINT.  of (J,): the segment each is of.  clips (G,): names.
    good (G,): whether it was said to be.
    """

    joints: Array
    of: NDArray[np.int64]
    clips: NDArray[np.str_]
    good: NDArray[np.bool_]

    def column(self, name: str) -> Array:
        return np.asarray(self.joints[:, JOINT.index(name)])

    @property
    def wrong(self) -> NDArray[np.bool_]:
        return np.asarray(self.column("wrong_by") > WRONG)

    @property
    def clip_of_joint(self) -> NDArray[np.str_]:
        return np.asarray(self.clips[self.of])


def evidence(report: Report) -> None:
    """The whole group."""
    seen = _kept()
    known = [name for name in CASES if (seen.clips == name).any()]
    table = report.table("area under the curve of wrong joints", *known, "all")
    _auroc_row(table, "as it is expected now", seen, seen.column("expected"), known)
    for name, columns in WEIGHED.items():
        _auroc_row(table, name, seen, _left_out(seen, columns, known), known)
    table = report.table("good", "segments", "good", "right", "right of good")
    px = seen.column("wrong_by") * [min(TALL.get(c, TALL_PX), TALL_PX) for c in seen.clip_of_joint]
    right = np.array([px[seen.of == k].mean() <= RIGHT_PX for k in range(len(seen.clips))])
    for name in known:
        _good_row(table, name, seen.good, right, seen.clips == name)
    _good_row(table, "all", seen.good, right, np.ones(len(right), np.bool_))
    expected = [seen.column("expected")[seen.of == k] for k in range(len(seen.clips))]
    doubt = np.array([np.quantile(each, 1 - FEW) for each in expected])
    doubt *= [min(TALL.get(name, TALL_LEAST), TALL_LEAST) for name in seen.clips]
    area = auroc(~right, doubt)
    report.expect(
        "segments, wrong from right: area under the curve short of 0.80 by", AUROC - area, 0
    )


def _good_row(table: Any, name: str, good: Array, right: Array, rows: Array) -> None:
    said, true = (
        float(good[rows].mean()),
        float(right[rows & good].mean()) if good[rows].any() else 1.0,
    )
    expected = []
    if name == "all":
        expected = [
            Expected("not said", 1 - said, 1 - GOOD_OFTEN),
            Expected("wrongly said", 1 - true, 1 - GOOD_TRUE),
        ]
    cells = int(rows.sum()), f"{said:.0%}", f"{right[rows].mean():.0%}", f"{true:.0%}"
    table.row(name, *cells, expected=expected)


def _auroc_row(table: Any, name: str, seen: Evidence, doubt: Array, known: Sequence[str]) -> None:
    rows = {each: seen.clip_of_joint == each for each in known}
    found = [auroc(seen.wrong[at], doubt[at]) for at in rows.values()]
    mean = float(np.nanmean(found))
    table.row(name, *found, mean, expected=[Expected("short of", AUROC - mean, 0.0)])


def auroc(wrong: NDArray[np.bool_], doubt: Array) -> float:
    """Area under the curve: how often a wrong joint is doubted more than a right one."""
    bad = int(wrong.sum())
    if not 0 < bad < len(wrong):
        return float("nan")
    return float((rankdata(doubt)[wrong].sum() - bad * (bad + 1) / 2) / (bad * (len(wrong) - bad)))


def _left_out(seen: Evidence, columns: Sequence[str], known: Sequence[str]) -> Array:
    """(J,) log error expected by weights fitted on the other clips, each clip counting alike."""
    logs = np.stack([*(_log(seen, name) for name in columns), np.ones(len(seen.of))], axis=1)
    true = np.log(np.maximum(seen.column("wrong_by"), SURE_MARK))
    expected = np.full(len(true), np.nan)
    for name in known:
        others = seen.clip_of_joint != name
        count = {each: (seen.clip_of_joint == each).sum() for each in known}
        weight = np.array([count[each] ** -0.5 for each in seen.clip_of_joint[others]])
        fitted, *_ = np.linalg.lstsq(
            logs[others] * weight[:, None], true[others] * weight, rcond=None
        )
        here = ~others
        expected[here] = logs[here] @ fitted
    return expected


def _log(seen: Evidence, name: str) -> Array:
    values = seen.column(name)
    if name == "away":
        return np.log(values + 1)
    if name == "visibility":
        return np.log(1 - values + LEAST)
    return np.log(np.nan_to_num(values, nan=WRONG) + (LEAST_DRIFT if name == "drift" else LEAST))


# --- collecting


def _kept() -> Evidence:
    sources = [ROOT / "tracker" / name for name in ("keypoints", "solver", "tracking")]
    sources += [ROOT / "bench" / name for name in ("evidence.py", "clips.py", "real_marks.json")]
    kept = place_for("evidence", digest(*sources), ".npz")
    if not kept.is_file():
        joints: list[tuple[float, ...]] = []
        of: list[int] = []
        segments: list[tuple[str, bool]] = []
        for name in CASES:
            try:
                for found, good in _of_clip(name):
                    joints += found
                    of += [len(segments)] * len(found)
                    segments.append((name, good))
            except Absent:
                continue
        if not segments:
            raise Absent("a marked clip")
        clips, good = zip(*segments, strict=True)
        np.savez(kept, joints=joints, of=of, clips=clips, good=good)
    with np.load(kept) as found:
        return Evidence(**found)


def _of_clip(name: str) -> Iterator[tuple[list[tuple[float, ...]], bool]]:
    """Of each segment with marks inside, its marked joints and whether it was said to be good."""
    shown, way = clip(name), with_settings(TrackSettings(cues=BOTH, network=NETWORK))
    tall = TALL.get(name, TALL_CAMERA4)
    for keyframes in CASES[name]:
        hand = keyed(shown, keyframes)
        reference = shown.reference(hand.skeleton.body)
        points = BodyPoints(hand.skeleton, reference.places)
        on_body = points_on_body(hand.skeleton.body, NAMES).indices
        column = {NAMES[index]: k for k, index in enumerate(on_body.tolist())}
        with Video.open(shown.video) as video:
            posed = Posed(shown, video, hand.skeleton, hand.poses)
            for seed in range(JITTERS):
                with _judged() as judged:
                    motion = joined(way(posed.disturbed(seed)).trajectories)
                T = motion.transforms(hand.skeleton)
                for first, last, joints, good in judged:
                    found = []
                    marks = zip(reference.frames.tolist(), reference.positions, strict=True)
                    for frame, known in marks:
                        if not first < frame < last:
                            continue
                        uv = shown.camera.project(points.at(T[frame - motion.first_frame]))
                        off = np.linalg.norm(uv - known, axis=-1) / tall
                        found += [
                            (px, *_evidence(joints, frame - first, column[SHORT[joint]]))
                            for joint, px in zip(reference.names, off.tolist(), strict=True)
                            if joint in SHORT and np.isfinite(px)
                        ]
                    if found:
                        yield found, good


def _evidence(joints: JointEvidence, row: int, column: int) -> tuple[float, ...]:
    """All columns but the first of a joint."""
    near = slice(max(row - NEAR, 0), row + NEAR + 1)
    distance = joints.distance[near, column]
    return (
        float(joints.apart[near, column].mean()),
        float(joints.drift[near, column].mean()),
        float(min(row, len(joints.distance) - 1 - row)),
        float(np.nanmax(distance)) if np.isfinite(distance).any() else np.nan,
        float(joints.visibility[near, column].mean()),
        float(joints.error[row, column]),
    )


@contextmanager
def _judged() -> Iterator[list[tuple[int, int, JointEvidence, bool]]]:
    """All segments judged meanwhile by their joints: first and last frame, evidence, and whether
    each is good."""
    found: list[tuple[int, int, JointEvidence, bool]] = []
    before = judge._judge_joints

    def noting(scene: Any, segment: Any, joints: JointEvidence) -> Any:
        verdict = before(scene, segment, joints)
        found.append((segment.first_frame, segment.last_frame, joints, verdict.kind == "good"))
        return verdict

    with patch.object(judge, "_judge_joints", noting):
        yield found
