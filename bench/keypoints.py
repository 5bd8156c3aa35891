"""Networks against marks: what each sees of filmed people, alone and together, and what it costs.

Every look is taken once and kept, so that another way to put looks together is a matter of seconds.
All are taken where BlazePose, looking once a frame, follows the person from a box around the marks
of the first marked frame. Pixels are those of a person 400 px tall. `own place` is what is left of
them when each joint's median offset on the clip's other frames is taken off: a detector's places of
joints are not those of a person who marks. Jitter is that of ankles that stand still.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import TypeAlias

import cv2
import numpy as np

from bench.clips import TALL, beam_camera, clip, passes
from bench.keeping import ROOT, Absent, digest, place_for
from bench.measures import FAR_PX, TALL_PX, jitter_px
from bench.table import Expected, Report
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.augmented import VARIATIONS, Variation
from keypose.tracker.keypoints.blazepose import NAMES, BlazePose
from keypose.tracker.keypoints.detect import LOOK_PARTS, Rows
from keypose.tracker.keypoints.joint_network import JointNetwork
from keypose.tracker.keypoints.keypoints import JOINTS, other_side
from keypose.tracker.keypoints.model_files import THUNDER
from keypose.tracker.keypoints.paired import APART, down_trunk, weighted_mean
from keypose.tracker.keypoints.region import Region
from keypose.tracker.video import Video

Joints: TypeAlias = Mapping[str, tuple[float, float]]
CLIPS = {
    "person": (0, 99), "walk": (30, 90), "arms": (20, 90),
    "camera1": (0, 99), "camera2": (0, 99), "camera4": (0, 99),
}  # fmt: skip
"""First and last frame by clip. Of the beam's cameras the rough joints of four views are the marks,
good to 5–10 px; `camera2` sees the man from behind, and BlazePose exchanges his sides."""
MARKED = ("person", "walk", "arms")
STANDS = {
    "person": ("left_ankle", 0, 75),
    "walk": ("left_ankle", 40, 55),
    "arms": ("left_ankle", 20, 60),
    "camera1": ("left_ankle", 0, 75),
    "camera2": ("left_ankle", 0, 75),
    "camera4": ("left_ankle", 0, 75),
}
SHORT = {
    f"{side[0].upper()}{joint.title()}": f"{side}_{joint}"
    for side in ("left", "right")
    for joint in ("shoulder", "elbow", "wrist", "hip", "knee", "ankle")
}
LOOKS = (Variation(), *VARIATIONS)
REGION_HEIGHTS = 4 / 3
"""Side of BlazePose's region over the body's height, about."""
OTHER_SIDE = [JOINTS.index(other_side(name, JOINTS)) for name in JOINTS]
MOST_COST = 0.5
MOST_BETTER = 0.9
"""Of two networks, as shares of five looks of one: processor time, and pixels at marks."""


@dataclass(frozen=True, eq=False)
class Looks:
    """All looks at F frames of a clip.

    uv (F, L, 12, 2): joints of BlazePose's plain look and its variations, sides as each has them.
    thunder (F, 12, 2), heat (F, 12): of MoveNet.  marks (F, 12, 2): NaN where none.
    tall_px (F,).  seconds (2,): processor time of a look of BlazePose, and of MoveNet.
    """

    frames: Array
    uv: Array
    thunder: Array
    heat: Array
    seconds: Array
    marks: Array
    tall_px: Array


Way: TypeAlias = Callable[[Looks], Array]
"""From looks to joints (F, 12, 2)."""


def keypoints(report: Report) -> None:
    """The whole group."""
    here = [name for name in CLIPS if _is_here(name)]
    for name in set(MARKED) & set(here):
        apart = [np.linalg.norm(uv - uv.mean(axis=0), axis=1).mean() for uv in _passes(name)]
        report.note(
            f"{name}: {len(apart)} joints marked by several people, "
            f"{2 * float(np.mean(apart)) * TALL_PX / TALL[name]:.1f} px from one to the other"
        )
    columns = ("cost", *(f"{name}{what}" for name in here for what in ("", " own")), "over 10")
    table = report.table("px at marks, and seen from each joint's own place", *columns)
    first: Array | None = None
    for way, (cost, joints) in WAYS.items():
        figures = np.array([_figures(name, joints(looks(name))) for name in here])
        marked = figures[[here.index(name) for name in MARKED if name in here], 0]
        share = cost(looks(here[0]).seconds) / FIVE(looks(here[0]).seconds)
        expected = []
        if way == DEFAULT and first is not None:
            better = float((marked / first).mean())
            expected = [
                Expected("cost", share, MOST_COST),
                Expected("px of five looks'", better, MOST_BETTER),
            ]
        first = marked if way == "full, five looks" else first
        cells = [f"{value:.1f}" for px, own, _, _ in figures for value in (px, own)]
        table.row(way, share, *cells, f"{figures[:, 2].mean():.0f} %", expected=expected)
    jitter = report.table("jitter of standing ankles, px", *here)
    for way, (_, joints) in WAYS.items():
        jitter.row(way, *(_figures(name, joints(looks(name)))[3] for name in here))
    sides = report.table("frames in which left and right are exchanged", *here)
    for way, (_, joints) in WAYS.items():
        sides.row(way, *(_exchanged(looks(name), joints(looks(name))) for name in here))


def _exchanged(seen: Looks, uv: Array) -> int:
    """How many marked frames lie nearer to their marks with all sides exchanged."""
    off = [np.linalg.norm(each - seen.marks, axis=-1) for each in (uv, uv[:, OTHER_SIDE])]
    known = np.isfinite(off[0]) & np.isfinite(off[1])
    plain, exchanged = (np.where(known, each, 0.0).sum(axis=1) for each in off)
    return int((exchanged < plain).sum())


def _is_here(name: str) -> bool:
    try:
        looks(name)
    except Absent:
        return False
    return True


def _passes(name: str) -> list[Array]:
    return [uv for joints in passes(name).values() for uv in joints.values()]


# --- ways


def _cost(blazepose: int, thunder: int) -> Callable[[Array], float]:
    return lambda seconds: float(blazepose * seconds[0] + thunder * seconds[1])


FIVE = _cost(5, 0)


def _by_blazepose(*variations: int) -> Way:
    """The median of the plain look and others, which take its sides."""

    def way(looks: Looks) -> Array:
        plain = looks.uv[:, 0]
        others = [_with_sides_of(plain, looks.uv[:, k]) for k in variations]
        return np.asarray(np.median([plain, *others], axis=0))

    return way


def _together(*variations: int) -> Way:
    """As `PairedNetwork` puts them together."""

    def way(looks: Looks) -> Array:
        other = _with_sides_of(looks.thunder, _by_blazepose(*variations)(looks))
        uv = looks.thunder - down_trunk(JOINTS)[:, None] * _trunk(other)
        return weighted_mean(uv, other, APART * REGION_HEIGHTS * looks.tall_px[:, None])

    return way


def _trunk(uv: Array) -> Array:
    """(F, 1, 2) from the middle of the hips to that of the shoulders."""
    at = [JOINTS.index(name) for name in ("left_hip", "right_hip")]
    shoulders = [JOINTS.index(name) for name in ("left_shoulder", "right_shoulder")]
    return np.asarray((uv[:, shoulders].mean(axis=1) - uv[:, at].mean(axis=1))[:, None])


def _with_sides_of(one: Array, other: Array) -> Array:
    """Exchange all sides of the other (F, 12, 2) in frames where it is nearer to the one then."""
    exchanged = other[:, OTHER_SIDE]
    near = [np.linalg.norm(each - one, axis=-1).sum(axis=1) for each in (other, exchanged)]
    return np.where((near[1] < near[0])[:, None, None], exchanged, other)


DEFAULT = "Thunder and full"
WAYS: dict[str, tuple[Callable[[Array], float], Way]] = {
    "full, one look": (_cost(1, 0), _by_blazepose()),
    "full, five looks": (FIVE, _by_blazepose(1, 2, 3, 4)),
    "Thunder alone": (_cost(1, 1), lambda looks: looks.thunder),
    DEFAULT: (_cost(1, 1), _together()),
    "  three looks of full": (_cost(3, 1), _together(1, 2)),
}


# --- looks and figures


def _figures(name: str, uv: Array) -> tuple[float, float, float, float]:
    """Pixels at marks, from own places, percent of joints over 10 px, and jitter."""
    seen = looks(name)
    off, scale = uv - seen.marks, (TALL_PX / seen.tall_px)[:, None]
    px = np.linalg.norm(off, axis=-1) * scale
    own = np.linalg.norm(off - _own_places(off), axis=-1) * scale
    known = np.isfinite(px)
    joint, first, last = STANDS[name]
    rows = slice(first - int(seen.frames[0]), last + 1 - int(seen.frames[0]))
    still = uv[rows, JOINTS.index(joint)] * scale[rows]
    over = 100 * float((px[known] > FAR_PX).mean())
    return float(px[known].mean()), float(own[known].mean()), over, jitter_px([still])


def _own_places(off: Array) -> Array:
    """(F, 12, 2) each joint's median offset on other frames, drawn to none where those are few."""
    places = np.zeros_like(off)
    for joint in range(off.shape[1]):
        rows = np.flatnonzero(np.isfinite(off[:, joint]).all(axis=1))
        for row in rows:
            others = rows[rows != row]
            if len(others):
                median = np.median(off[others, joint], axis=0)
                places[row, joint] = median * len(others) / (len(others) + 1)
    return places


@cache
def looks(name: str) -> Looks:
    """All looks at a clip, taken or as kept; Absent when its film is not here."""
    film, known, tall = _marked(name)
    networks = ROOT / "tracker" / "keypoints"
    sources = [networks / file for file in ("blazepose.py", "joint_network.py", "augmented.py")]
    kept = place_for(f"looks-{name}", digest(*sources), ".npz")
    if not kept.is_file():
        np.savez(kept, **_looked(film, known, CLIPS[name]))
    with np.load(kept) as found:
        frames = found["frames"].tolist()
        marks = np.full((len(frames), len(JOINTS), 2), np.nan)
        for row, frame in enumerate(frames):
            for joint, uv in known.get(frame, {}).items():
                marks[row, JOINTS.index(joint)] = uv
        return Looks(**found, marks=marks, tall_px=np.array([tall(frame) for frame in frames]))


def _marked(name: str) -> tuple[str, dict[int, Joints], Callable[[int], float]]:
    """A clip's film, its marks by frame and joint, and how tall the person is in a frame, px."""
    if name in MARKED:
        shown = clip(name)
        known = {
            frame: {SHORT[n]: uv for n, uv in joints.items() if n in SHORT}
            for frame, joints in shown.marks.items()
        }
        return str(shown.video), known, lambda frame: TALL[name]
    film, camera, names, p = beam_camera(int(name[-1]))
    uv = np.stack([camera.project(joints) for joints in p])
    rough = {
        frame: {SHORT[n]: (u, v) for n, (u, v) in zip(names, at, strict=True) if np.isfinite(u)}
        for frame, at in enumerate(uv.tolist())
    }
    return str(film), rough, lambda frame: 1.7 * camera.fy / float(np.nanmean(p[frame, :, 2]))


def _looked(film: str, known: Mapping[int, Joints], ends: tuple[int, int]) -> dict[str, Array]:
    blazepose, movenet = BlazePose.open(), JointNetwork.open(THUNDER)
    first = min(known)
    rows: dict[int, tuple[Array, ...]] = {}
    spent: list[tuple[float, float]] = []
    cv2.setNumThreads(1)
    with Video.open(film) as video:
        box = _box_around(known[first])
        picture = video.frame(first)
        drawn = Region.of_box(box, picture.shape[1], picture.shape[0])
        begun = Rows.begun(drawn, blazepose, picture, 3).region
        for way in (range(first, ends[1] + 1), range(first - 1, ends[0] - 1, -1)):
            region = begun
            for frame in way:
                picture, here = video.frame(frame), region.rounded(LOOK_PARTS)
                began = time.process_time()
                seen = [
                    blazepose.infer(picture, each.of(here), mirrored=each.mirrored)
                    for each in LOOKS
                ]
                between = time.process_time()
                other = movenet.infer(picture, here)
                spent.append(((between - began) / len(LOOKS), time.process_time() - between))
                uv = np.stack([each.uv[_of(NAMES)] for each in seen])
                at = _of(movenet.names)
                rows[frame] = uv, other.uv[at], other.confidence[at]
                region = seen[0].next
    frames = sorted(rows)
    uv, thunder, heat = (np.stack([rows[frame][k] for frame in frames]) for k in range(3))
    seconds = np.median(spent, axis=0)
    return {
        "frames": np.array(frames),
        "uv": uv,
        "thunder": thunder,
        "heat": heat,
        "seconds": seconds,
    }


def _of(names: tuple[str, ...]) -> list[int]:
    return [names.index(joint) for joint in JOINTS]


def _box_around(joints: Joints) -> tuple[float, float, float, float]:
    uv = np.array(list(joints.values()))
    (left, top), (right, bottom) = uv.min(axis=0).tolist(), uv.max(axis=0).tolist()
    room = max(right - left, bottom - top)
    return left - 0.05 * room, top - 0.22 * room, right + 0.05 * room, bottom + 0.08 * room
