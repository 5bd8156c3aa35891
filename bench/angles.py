"""What is expected to be off beside what is: centimetres of joints, degrees of bones and hinges.

Films that nobody posed are turned into motion as in `bench markers`, turned onto the truth as a
whole, and compared with what their own diagnostics say. What is expected is the median: of all that
are expected to be off by so much, half should be off by less, in every band. Films weigh alike,
whatever their length, and one of them, of another camera, nothing was ever fitted to.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np

from bench.keeping import DATA, Absent
from bench.markers import (
    ELBOWS,
    HIPS,
    JOINTS,
    KNEES,
    SHOULDERS,
    SIDES,
    Film,
    about_hips,
    angles_deg,
    joints_of,
    onto,
    opencap_squat,
    opencap_walk,
    person,
    run_film,
)
from bench.table import Expected, Report
from keypose.tracker.body.angle_errors import angle_errors, direction_errors, in_metres
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import joined
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.storage.files import load_session
from keypose.tracker.storage.results import load_results
from keypose.tracker.tracking.result import Diagnostics

MOST_ECE = 0.1
"""How far from a half the share that is off by less than expected may be, in the mean of bands."""
BANDS_DEG = (0, 4, 6, 8, 10, 13, 17, 90)
BANDS_CM = (0, 2.5, 3.5, 4.5, 6, 8, 12, 100)
_BONES: Mapping[str, tuple[int, int]] = {
    "thigh": (0, 2),
    "shin": (2, 4),
    "upper_arm": (6, 8),
    "forearm": (8, 10),
}
"""From joint to joint, of the right side; the left one's follow."""
_HINGES = {"knee": KNEES, "elbow": ELBOWS}


class Compared(NamedTuple):
    """(n,) what was expected and what was measured."""

    expected: Array
    measured: Array


@dataclass(frozen=True, eq=False)
class Found:
    """A film's joints beside the truth's (F, 12, 3), about the hips, and what was expected.

    joints_cm (F, P), directions_deg (F, P), hinges_deg: (F,) by joint.
    """

    p: Array
    truth: Array
    names: Sequence[str]
    joints_cm: Array
    directions_deg: Array
    hinges_deg: Mapping[str, Array]


def angles(report: Report) -> None:
    """The whole group."""
    found: dict[str, Found] = {}
    for film_of in (opencap_walk, opencap_squat, person, other_camera):
        with contextlib.suppress(Absent):
            film = film_of()
            found[film.name] = _found(film)
    if not found:
        raise Absent("films with joints in space")
    for what, compare, bands, unit in (
        ("joints about the hips", _joints, BANDS_CM, "cm"),
        ("directions of bones and lines", _directions, BANDS_DEG, "deg"),
        ("flexion of knees and elbows", _hinges, BANDS_DEG, "deg"),
    ):
        _calibration(report, what, {n: compare(f) for n, f in found.items()}, bands, unit)


def other_camera() -> Film:
    """The man on the beam as another camera sees him, whose pose to the truth is not known."""
    film = person()
    video = DATA / "several" / "single_cam02.mp4"
    if not video.is_file():
        raise Absent("the film of another camera in 'several' beside the checkout")
    return replace(film, name="person, another camera", video=video, view_deg=59.66, box=None)


def _calibration(
    report: Report, what: str, films: Mapping[str, Compared], bands: Sequence[float], unit: str
) -> None:
    table = report.table(what, "expected", "measured", "under", *films, wide=tuple(films))
    shares, errors = [], []
    for low, high in pairwise(bands):
        here = {name: _within(each, low, high) for name, each in films.items()}
        some = {name: each for name, each in here.items() if len(each.expected)}
        if not some:
            continue
        weights = [len(each.expected) / len(films[name].expected) for name, each in some.items()]
        under = [float((each.measured < each.expected).mean()) for each in some.values()]
        share = float(np.average(under, weights=weights))
        both = [np.concatenate([each[k] for each in some.values()]) for k in (0, 1)]
        shares.append(sum(weights) / len(films))
        errors.append(abs(share - 0.5))
        table.row(
            f"{low:g}–{high:g} {unit}",
            f"{np.median(both[0]):.1f}",
            f"{np.median(both[1]):.1f}",
            f"{share:.2f}",
            *(_share_under(each) for each in here.values()),
        )
    ece = float(np.average(errors, weights=shares))
    table.row(
        "calibration error",
        "",
        "",
        f"{ece:.3f}",
        *("" for _ in films),
        expected=[Expected("calibration error", ece, MOST_ECE)],
    )


def _share_under(found: Compared) -> str:
    """The share below what was expected, of how many."""
    if not len(found.expected):
        return ""
    return f"{(found.measured < found.expected).mean():.2f} of {len(found.expected)}"


def _within(found: Compared, low: float, high: float) -> Compared:
    here = (found.expected >= low) & (found.expected < high)
    return Compared(found.expected[here], found.measured[here])


def _joints(found: Found) -> Compared:
    """Knees, ankles, shoulders, elbows and wrists, each carried by the part before it."""
    pairs = []
    for k, name in enumerate(JOINTS):
        if name.endswith(("shin", "foot", "upper_arm", "forearm", "hand")):
            part = found.names.index(_CARRIERS[name.split("_", 1)[1]](name))
            off = 100 * np.linalg.norm(found.p[:, k] - found.truth[:, k], axis=-1)
            pairs.append((found.joints_cm[:, part], off))
    return _pooled(pairs)


_CARRIERS: Mapping[str, Callable[[str], str]] = {
    "shin": lambda name: name.replace("shin", "thigh"),
    "foot": lambda name: name.replace("foot", "shin"),
    "upper_arm": lambda _: "chest",
    "forearm": lambda name: name.replace("forearm", "upper_arm"),
    "hand": lambda name: name.replace("hand", "forearm"),
}


def _directions(found: Found) -> Compared:
    lines = {"waist": HIPS, "chest": SHOULDERS}
    for bone, (a, b) in _BONES.items():
        lines |= {f"{side}_{bone}": (a + n, b + n) for n, side in enumerate(SIDES)}
    pairs = []
    for part, ends in lines.items():
        u, v = (_unit(q[:, ends[1]] - q[:, ends[0]]) for q in (found.p, found.truth))
        off = np.degrees(np.arccos(np.clip((u * v).sum(-1), -1.0, 1.0)))
        pairs.append((found.directions_deg[:, found.names.index(part)], off))
    return _pooled(pairs)


def _hinges(found: Found) -> Compared:
    pairs = []
    for name, joints in _HINGES.items():
        for side, ends in zip(SIDES, joints, strict=True):
            off = np.abs(angles_deg(found.p, *ends) - angles_deg(found.truth, *ends))
            pairs.append((found.hinges_deg[f"{side}_{name}"], off))
    return _pooled(pairs)


def _pooled(pairs: Sequence[tuple[Array, Array]]) -> Compared:
    expected, measured = (np.concatenate(some) for some in zip(*pairs, strict=True))
    known = np.isfinite(expected)
    return Compared(expected[known], measured[known])


def _unit(v: Array) -> Array:
    return np.asarray(v / np.linalg.norm(v, axis=-1, keepdims=True))


def _found(film: Film) -> Found:
    with TemporaryDirectory() as folder:
        path = run_film(film, film.box, Path(folder))
        times_s, p = joints_of(path)
        session = load_session(path)
        results = load_results(session, path).fitting(session)
    known, truth = film.at(times_s - film.late_s)
    p, truth = about_hips(p[:, :12]), about_hips(truth[:, :12])
    tracks = [results[span] for span in sorted(results)]
    skeleton, motion = Skeleton.of(session.subject.body), joined([t.trajectory for t in tracks])
    parts = skeleton.part_count
    pieces = [(track.first - motion.first_frame, track.diagnostics) for track in tracks]
    seen = Diagnostics.side_by_side(pieces, len(motion), parts, skeleton.dof_count)
    assert seen.expected_error is not None
    assert seen.expected_depth is not None
    across_m = in_metres(seen.expected_error, session.view.camera, motion.ps_camera_root)
    observed = skeleton, motion, across_m, seen.expected_depth
    directions, errors = direction_errors(*observed), angle_errors(*observed)
    assert directions is not None
    assert errors is not None
    hinges = {joint.name: np.degrees(each[known, 0]) for joint, each in errors.items()}
    return Found(
        p[known] @ onto(p[known], truth).T,
        truth,
        skeleton.body.names,
        100 * np.hypot(across_m, seen.expected_depth)[known],
        np.degrees(directions)[known],
        hinges,
    )
