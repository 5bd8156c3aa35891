"""Sixty frames between keyframes, by one film and by two.

Keyframes are exact, or as somebody poses them who sees one film: each joint's depth off by 8 cm
(σ).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np

from bench.films.man import BESIDE, FIRST, FRAMES, Man
from bench.table import Expected, Report
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.films.mend import SeenInFilm, mended
from keypose.tracker.geometry.film_clock import FilmClock
from keypose.tracker.geometry.rotations import (
    Array,
)
from keypose.tracker.keypoints.keypoints import JOINTS
from keypose.tracker.keypoints.on_body import points_on_body
from keypose.tracker.session.settings import TrackSettings
from keypose.tracker.solver.fit_joints import fit_motion
from keypose.tracker.tracking.cues.sources import GivenKeypoints
from keypose.tracker.tracking.film_beside import FilmBeside
from keypose.tracker.tracking.tracker import Tracker

SPANS: Final = ((0, 60), (20, 80), (39, 99))
SEEDS: Final = (5, 6, 7)
DEPTH_OFF_M: Final = 0.08
MOST_MM: Final = {"exact": 20.0, "mended": 28.0, "absolute": 30.0}


def keyed(report: Report, man: Man) -> None:
    columns = ("about hips mm", "least", "most", "in space mm")
    table = report.table("sixty frames between keyframes", *columns)
    rows: dict[str, list[tuple[float, float]]] = {}
    for span in SPANS:
        exact = {frame: man.motion.pose(frame) for frame in span}
        kinds = [("exact", exact)]
        for seed in SEEDS:
            posed = _posed_in_one(man, exact, seed)
            kinds += [("posed in one film", posed), ("the same, mended", _mended(man, posed))]
        for kind, keys in kinds:
            truth = man.truth[span[0] : span[1] + 1]
            for count in (1, 2):
                motion = _tracked(man, keys, count)
                rows.setdefault(f"{kind}, {count} film{'s' * (count > 1)}", []).append(
                    man.errors_mm(motion, truth)
                )
    most = {"exact, 2 films": MOST_MM["exact"], "the same, mended, 2 films": MOST_MM["mended"]}
    for name, figures in rows.items():
        about, space = np.array(figures).T
        expected = []
        if name in most:
            expected.append(Expected("about hips", float(about.mean()), most[name], "mm"))
            expected.append(Expected("in space", float(space.mean()), MOST_MM["absolute"], "mm"))
        table.row(
            name,
            float(about.mean()),
            float(about.min()),
            float(about.max()),
            float(space.mean()),
            expected=expected,
        )


def _posed_in_one(man: Man, keys: Mapping[int, Pose], seed: int) -> dict[int, Pose]:
    """Keyframes as posed over the first film: each joint where it is seen, its depth off."""
    rng, skeleton = np.random.default_rng(seed), man.skeleton
    _, parts, points = points_on_body(skeleton.body, JOINTS)
    places = [
        ((int(part), tuple(map(float, point))),) for part, point in zip(parts, points, strict=True)
    ]
    posed = {}
    for frame, pose in keys.items():
        joints = man.places.at(pose_transforms(skeleton, pose))
        joints = joints * (1 + rng.normal(0.0, DEPTH_OFF_M, (len(joints), 1)) / joints[:, 2:])
        fit = fit_motion(skeleton.body, places, joints[None], frame, near=[pose])  # type: ignore[arg-type]
        posed[frame] = fit.trajectory.pose(frame)
    return posed


def _mended(man: Man, keys: Mapping[int, Pose]) -> dict[int, Pose]:
    """The same mended by both films."""
    after = {}
    for frame, pose in keys.items():
        seen = [_seen(man, FIRST, frame, np.eye(4)), _seen(man, BESIDE, frame, man.T_beside_first)]
        found = mended(man.skeleton.body, pose, seen)
        after[frame] = pose if found is None else found.pose
    return after


def _seen(man: Man, number: int, frame: int, T: Array) -> SeenInFilm:
    view = man.views[number]
    index = [view.keypoints.names.index(name) for name in JOINTS]
    ideal = view.camera.without_distortion()
    uv = ideal.project(view.camera.back_project(view.keypoints.uv[frame, index], 1.0))
    return SeenInFilm(ideal, T, uv, view.keypoints.visibility[frame, index])


def _tracked(man: Man, keys: Mapping[int, Pose], count: int) -> Trajectory:
    """The motion between two keyframes, by so many films."""
    first, other = man.views[FIRST], man.views[BESIDE]
    beside: list[FilmBeside] = []
    if count > 1:
        prepared = Tracker(other.video, other.camera, man.skeleton, dict(keys)).prepared
        Ts = np.broadcast_to(man.T_beside_first, (FRAMES, 4, 4))
        beside = [FilmBeside(prepared, FilmClock(), Ts, Ts, other.keypoints)]
    tracker = Tracker(
        first.video,
        first.camera,
        man.skeleton,
        keys,
        keypoints=GivenKeypoints(first.keypoints),
        films=beside,
    )
    (span,) = tracker.spans
    return tracker.run_segment(
        span, TrackSettings(cues=("brightness", "keypoints")), lambda *_: None
    ).trajectory
