"""What each part of the method gains: it is switched off, and the same rows are measured again.

A switch is a name and what "off" means: functions or constants that others take the place of. It is
tried on the rows of its kinds: motion between keyframes, limbs keyed alone, drafts, drafts that
learn, *Fit pose*, and mutated films. Where one disturbance gives exactly what it gives with the
part, the row is left at that. Keypoints are found once a row. What was found is in the method's
README.

A part gains where the mean is better with it by more than the spread, which is the standard
deviation of the figure over the disturbances. Two clips, `camera2` and `above`, had no say when
these parts were made.
"""

from __future__ import annotations

import hashlib
import json
import pickle
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field, replace
from functools import cache, lru_cache, partial
from itertools import islice, pairwise
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np

from bench.clips import Clip, beam_camera, clip, place
from bench.keeping import ROOT, Absent, digest, place_for
from bench.keyed import jittered, keyed
from bench.limbs import LIMBS, errors, on_marks, worst
from bench.measures import marks_between
from bench.sequences import video_of
from bench.table import Report
from bench.tracking import track
from keypose.tracker.body.body import preset
from keypose.tracker.body.pose import Pose, joint_positions, moved, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory, joined
from keypose.tracker.fitting.draft import clip as draft_module
from keypose.tracker.fitting.draft import first_poses, refit
from keypose.tracker.fitting.draft.clip import ClipDraft, draft_from_keypoints
from keypose.tracker.fitting.draft.depth_signs import PLANE, tilt
from keypose.tracker.fitting.draft.observed import LIMBS as DRAFT_LIMBS
from keypose.tracker.fitting.draft.observed import Joints
from keypose.tracker.fitting.pose import fit_pose_to_picture
from keypose.tracker.fitting.pose import keyframe as fit_pose
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, exp_rotation
from keypose.tracker.keypoints.augmented import AugmentedNetwork
from keypose.tracker.keypoints.crossings import person_changes
from keypose.tracker.keypoints.detect import DetectionWindow, Seed, detect
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.session.settings import TrackSettings
from keypose.tracker.solver.least_squares import Criteria, Damping, least_squares
from keypose.tracker.solver.one_pose import OnePose
from keypose.tracker.solver.pose_terms import PointsInPicture, PosePrior, RootPosition
from keypose.tracker.solver.posed import BodyPoints, free_skeleton
from keypose.tracker.solver.projection import image_points
from keypose.tracker.tracking import anchored_cycle
from keypose.tracker.tracking import method as method_module
from keypose.tracker.tracking.cues import anchors as anchors_module
from keypose.tracker.tracking.cues.sources import DetectedKeypoints
from keypose.tracker.tracking.initial import choose
from keypose.tracker.tracking.initial.templates import follow_point, tracks
from keypose.tracker.tracking.initial.templates import patch as patches
from keypose.tracker.tracking.parts import limb_segment
from keypose.tracker.tracking.parts.limb_keyframes import KeyedParts
from keypose.tracker.tracking.segment import NEAREST_M, Segment
from keypose.tracker.tracking.tracker import Tracker
from keypose.tracker.video import Video, damage
from tests.rendering.scenes import scene
from tests.tracker.damage_cases import FILMS, Tally, greys, mutants, write_film

OUT = ROOT / "out" / "bench" / "gains.jsonl"
DISTURBANCES = 4
PITCH_RAD = np.radians(35.0)
"""By how much the camera looks down at the rendered motions."""
SIDES = ("left", "right")


@dataclass(frozen=True)
class Switch:
    """A part of the method, and what takes its place: (module, name, replacement) each."""

    name: str
    kinds: tuple[str, ...]
    patches: tuple[tuple[Any, str, Any], ...]

    @contextmanager
    def off(self) -> Iterator[None]:
        with ExitStack() as stack:
            for module, name, other in self.patches:
                stack.enter_context(patch.object(module, name, other))
            yield


@dataclass(frozen=True)
class Row:
    """One clip with its keyframes, or the like. measure: the figures of a disturbance, and bytes
    that are equal where nothing was changed. The first figure decides."""

    name: str
    clip: str
    kind: str
    measure: Callable[[int], tuple[dict[str, float], bytes]]


def gains(report: Report) -> None:
    """The whole group."""
    known = _earlier()
    for row in rows():
        try:
            _measure(row, DISTURBANCES, known)
        except Absent as absent:
            report.note(f"{row.name} left out: {absent} is not here")
    _write(report, known)


Known = dict[tuple[str, str, int], dict[str, Any]]


def _measure(row: Row, count: int, known: Known) -> None:
    """All switches of one row. One that changes nothing is run once."""
    acting = [switch for switch in SWITCHES if row.kind in switch.kinds]
    for seed in range(count if acting else 0):
        with_it = _run(row, None, seed, known)
        for switch in list(acting):
            off = _run(row, switch, seed, known)
            if not seed and off["digest"] == with_it["digest"]:
                acting.remove(switch)
            print(row.name, switch.name, seed, with_it["figures"], off["figures"], flush=True)
        if not acting:
            break


def _run(row: Row, switch: Switch | None, seed: int, known: Known) -> dict[str, Any]:
    name = "" if switch is None else switch.name
    key = row.name, name, seed
    if key not in known:
        began = time.process_time()
        with ExitStack() as stack:
            if switch is not None:
                stack.enter_context(switch.off())
            figures, motion = row.measure(seed)
        known[key] = {
            "tracker": _tracker(),
            "row": row.name,
            "clip": row.clip,
            "switch": name,
            "seed": seed,
            "figures": {k: round(v, 4) for k, v in figures.items()},
            "digest": hashlib.sha256(motion).hexdigest()[:16],
            "cpu_s": round(time.process_time() - began, 2),
        }
        OUT.parent.mkdir(parents=True, exist_ok=True)
        with OUT.open("a", encoding="utf-8") as lines:
            lines.write(json.dumps(known[key]) + "\n")
    return known[key]


@cache
def _tracker() -> str:
    return digest(ROOT / "tracker")


def _earlier() -> Known:
    """What was measured before of the tracker as it is."""
    if not OUT.is_file():
        return {}
    lines = map(json.loads, OUT.read_text(encoding="utf-8").splitlines())
    some = (one for one in lines if one["tracker"] == _tracker())
    return {(one["row"], one["switch"], one["seed"]): one for one in some}


def _write(report: Report, known: Known) -> None:
    columns = ("with", "without", "gain", "spread", "better")
    for switch in SWITCHES:
        found = defaultdict(list)
        for (row, name, seed), one in known.items():
            if name == switch.name:
                found[row].append((known[row, "", seed], one))
        table = report.table(f"without {switch.name}", *columns)
        for row, pairs in found.items():
            if all(a["digest"] == b["digest"] for a, b in pairs):
                continue
            times = [np.sum([pair[k]["cpu_s"] for pair in pairs]) for k in (0, 1)]
            table.row(f"{row}: processor, s", *times, times[1] - times[0], "", "")
            for figure in pairs[0][0]["figures"]:
                on, off = (np.array([p[k]["figures"][figure] for p in pairs]) for k in (0, 1))
                gain, spread = float(off.mean() - on.mean()), float(on.std())
                better = "yes" if gain > spread else "worse" if -gain > spread else "–"
                table.row(
                    f"{row}: {figure}", float(on.mean()), float(off.mean()), gain, spread, better
                )
        same = [
            row for row, pairs in found.items() if pairs[0][0]["digest"] == pairs[0][1]["digest"]
        ]
        report.note(f"  nothing changes: {', '.join(same) or '–'}")


# ---- What is switched off ----


def _in_frames_alone(seen: Keypoints, *given: Any) -> Keypoints | None:
    """Left and right set right in single frames, as *Fit pose* looks at them."""
    return None if len(seen) > 1 else _EXCHANGED(seen, *given)


def _constant_missing(anchors: Any, segment: Any, scene: Any, set_right: Sequence[int]) -> Any:
    """What keypoints miss a limb by in the mean of the frames at which it was set right."""
    own = np.isin(anchors.parts, segment.parts)[:, None]
    seen = image_points(scene.camera, anchors.where(segment.given.transforms(scene.skeleton)))
    missing = np.where(own, (anchors.uv - seen)[set_right].mean(axis=0), 0.0)
    return replace(anchors, uv=anchors.uv - (anchors.scale > 0)[..., None] * missing)


def _each_alone(forward: Any, backward: Any, offset: Array) -> tuple[Array, Array]:
    """Two courses that do not confirm each other."""
    uv = np.stack([forward.uv, backward.uv])
    return uv, np.stack([forward.sigma_px, backward.sigma_px])


_EXCHANGED = anchors_module.exchanged_sides
BETWEEN = ("between",)
TRACKED = ("between", "limb")
STILL = 1e-6
_THIS = sys.modules[__name__]

SWITCHES = (
    Switch("bit readers", ("film",), ((damage, "is_misread", lambda *_: False),)),
    Switch("doubt of shoulders", ("draft",), ((first_poses, "SHOULDER_DOUBT", first_poses.DOUBT),)),
    Switch("drift scale", BETWEEN, ((anchored_cycle, "increment_scale", lambda *_: 1.0),)),
    Switch("meeting of starts", BETWEEN, ((anchored_cycle, "MEETS", 0.0),)),
    Switch("half the points", BETWEEN, ((method_module, "WITH_KEYPOINTS", method_module.FULL),)),
    Switch("steady", BETWEEN, ((anchored_cycle, "_steadied", lambda c, *_: c),)),
    Switch("crossings", ("draft",), ((_THIS, "_changes", lambda *_: ()),)),
    Switch("third motion", BETWEEN, ((anchored_cycle, "_is_misled", lambda *_: False),)),
    Switch("exchanged sides", TRACKED, ((anchors_module, "exchanged_sides", _in_frames_alone),)),
    Switch(
        "templates",
        ("brightness",),
        ((choose, "_by_templates", lambda *_: choose.Starts(())),),
    ),
    Switch(
        "templates, turning",
        ("brightness",),
        (
            (follow_point, "SPREAD_RAD", 0.0),
            (patches, "PATCH_STRAY", patches.PATCH_STRAY * (1.0, 1.0, STILL, STILL)),
        ),
    ),
    Switch(
        "templates, fractions of a pixel",
        ("brightness",),
        ((patches, "PATCH_STRAY", patches.PATCH_STRAY * (STILL, STILL, 1.0, 1.0)),),
    ),
    Switch(
        "templates, courses combined", ("brightness",), ((tracks, "combine_courses", _each_alone),)
    ),
    Switch("neighbours' texture", ("fit",), ((fit_pose, "textures_near", lambda *_: []),)),
    Switch(
        "Gaussian process of limbs",
        ("limb",),
        ((limb_segment, "_missing_as_near", _constant_missing),),
    ),
    Switch(
        "offsets of limbs",
        ("limb",),
        ((limb_segment, "_missing_as_near", lambda anchors, *_: anchors),),
    ),
    Switch(
        "sides over time in drafts",
        ("draft", "learn"),
        (
            (draft_module, "consistent_sides", lambda *_: None),
            (refit, "consistent_sides", lambda *_: None),
        ),
    ),
)


# ---- What is measured ----


def rows() -> list[Row]:
    """All of them."""
    found: list[Row] = []
    for clip_name, keyframes in BETWEEN_KEYFRAMES:
        spacing = min(b - a for a, b in pairwise(keyframes))
        name = f"{clip_name}-{spacing}" + ("-mid" if keyframes == (40, 60) else "")
        for kind in ("between", "brightness"):
            found.append(
                Row(
                    f"{name} {kind}", clip_name, kind, partial(_between, clip_name, keyframes, kind)
                )
            )
    for clip_name, ends in LIMB_SPANS:
        found.append(
            Row(
                f"{clip_name}-{ends[1] - ends[0]} limb",
                clip_name,
                "limb",
                partial(_limb, clip_name, ends),
            )
        )
    singles = {"draft": (DRAFTED, _drafts), "learn": (LEARNED, _learn), "fit": (FITTED, _fit)}
    for kind, (names, measure) in singles.items():
        found += [Row(f"{name} {kind}", name, kind, partial(measure, name)) for name in names]
    found += [
        Row(f"{film.name} {width}", film.codec, "film", partial(_film, i, width))
        for width in (352, 480)
        for i, film in enumerate(FILMS)
    ]
    return found


_PERSON = (0, 30, 60, 90)
RENDERED = (
    "above wash",
    "above pirouette",
    "rendered walk",
    "rendered throw",
    "rendered stride",
)
ALSO_RENDERED = (
    "rendered speech",
    "rendered jump",
    "rendered shelf",
    "rendered jumping_jacks",
)
BETWEEN_KEYFRAMES: tuple[tuple[str, tuple[int, ...]], ...] = (
    ("person", _PERSON),
    ("person", (0, 60)),
    ("person", (0, 90)),
    ("walk", (30, 50, 70)),
    ("walk", (40, 60)),
    ("walk", (30, 70)),
    ("arms", (20, 40, 60)),
    ("arms", (20, 60)),
    ("camera4", _PERSON),
    ("camera4", (0, 60)),
    ("camera2", _PERSON),
    ("camera2", (0, 60)),
    *((name, (0, 24, 48)) for name in (*RENDERED, *ALSO_RENDERED)),
)
LIMB_SPANS = (
    ("walk", (30, 70)), ("person", (0, 60)), ("person", (0, 90)), ("arms", (20, 60)),
    ("camera4", (0, 60)), ("camera2", (0, 60)),
)  # fmt: skip
DRAFTED = (
    "person",
    "walk",
    "arms",
    "camera4",
    "camera2",
    "camera1",
    *RENDERED,
    "two people",
)
LEARNED = ("person", "walk", "arms", "camera4", "camera2", "above wash")
FITTED = ("rendered throw", "rendered walk", "above wash")
CLIPS = ("person", "walk", "arms", "camera4", "camera2", "camera1")
CUES: dict[str, TrackSettings] = {
    "between": TrackSettings(cues=("brightness", "keypoints")),
    "brightness": TrackSettings(cues=("brightness",)),
}


@dataclass(frozen=True, eq=False)
class Shown:
    """A film with the truth about it. truth: the motion of what is rendered."""

    name: str
    video: Video
    camera: Camera
    clip: Clip | None = None
    truth: Trajectory | None = None
    skeleton: Skeleton = field(default_factory=lambda: Skeleton.of(preset("adult_male")))
    others: tuple[Trajectory, ...] = ()

    def poses(self, frames: Sequence[int]) -> tuple[Skeleton, dict[int, Pose]]:
        if self.clip is not None:
            hand = keyed(self.clip, frames)
            return hand.skeleton, dict(hand.poses)
        assert self.truth is not None
        return self.skeleton, {frame: self.truth.pose(frame) for frame in frames}

    def errors(
        self, skeleton: Skeleton, motion: Trajectory, keyframes: Sequence[int]
    ) -> dict[str, float]:
        """Mean and worst decile of pixels between keyframes, and mm seen from the hips."""
        if self.clip is not None:
            px = np.array([m.px for m in marks_between(self.clip, skeleton, motion, keyframes)])
            return {"px": float(px.mean()), "p90": float(np.percentile(px, 90))}
        assert self.truth is not None
        frames = range(motion.first_frame, motion.last_frame + 1)
        inner = [f for f in frames if f not in keyframes and f < len(self.truth)]
        both = [
            np.stack([joint_positions(s, pose_transforms(s, m.pose(f))) for f in inner])
            for s, m in ((skeleton, motion), (self.skeleton, self.truth))
        ]
        px = np.linalg.norm(np.subtract(*(self.camera.project(p) for p in both)), axis=-1)
        return {"px": float(px.mean()), "p90": float(np.percentile(px, 90))}


@lru_cache(maxsize=2)
def shown(name: str) -> Shown:
    """A film by its name, open as long as this runs."""
    if name == "camera2":
        one = _beam_clip(2)
    elif name == "camera1":
        one = _beam_clip(1)
    elif name == "two people":
        return _two_people()
    elif name not in CLIPS:
        how, motion = name.split()
        return _rendered(name, motion, from_above=how == "above")
    else:
        one = clip(name)
    return Shown(name, Video.open(one.video), one.camera, one)


def _beam_clip(number: int) -> Clip:
    """As `camera4`, from another side; which way he faces follows from his hips."""
    video, camera, limbs, joints = beam_camera(number)
    marks = {
        frame: dict(zip(limbs, map(tuple, camera.project(joints[frame]).tolist()), strict=True))
        for frame in range(0, 91, 15)
    }
    x, _, z = joints[0, limbs.index("LHip")] - joints[0, limbs.index("RHip")]
    facing = float(np.degrees(np.arctan2(-z, x)))
    return Clip(
        f"camera{number}",
        video,
        camera,
        preset("adult_male"),
        facing,
        marks,
        (),
        space=(limbs, joints),
    )


def _rendered(name: str, motion: str, from_above: bool) -> Shown:
    try:
        whole = scene(motion)
    except FileNotFoundError:
        raise Absent(f"the recorded motion of {motion!r}") from None
    plain = whole.cut(0, min(96, len(whole.truth) // 24 * 24 - 1))
    truth = _from_above(plain.truth) if from_above else plain.truth
    seen = replace(plain, truth=truth)
    pictures = _pictures(f"gains-{name.replace(' ', '-')}", seen.frames, truth)
    video = video_of(len(pictures), lambda n: np.array(pictures[n]))
    return Shown(name, video, seen.camera, None, truth, seen.skeleton)


def _from_above(truth: Trajectory) -> Trajectory:
    """As a camera sees it that is higher and looks down at the middle of the motion."""
    R, p = truth.writable()
    pitch = exp_rotation(np.array([PITCH_RAD, 0.0, 0.0]))
    middle = (p.min(axis=0) + p.max(axis=0)) / 2
    R[:, 0] = pitch @ R[:, 0]
    ahead = np.array([0.0, 0.0, 1.1 * middle[2]])
    return Trajectory(truth.first_frame, R, (p - middle) @ pitch.T + ahead)


def _pictures(name: str, frames: Callable[[], Array], truth: Trajectory) -> Any:
    key = digest(ROOT / "tests" / "rendering", truth.ps_camera_root.tobytes())
    kept = place_for(name, key, ".npy")
    if not kept.is_file():
        np.save(kept, frames())
    return np.load(kept, mmap_mode="r")


def _two_people() -> Shown:
    """One walks to the left, another one behind to the right."""
    try:
        one, other = scene("walk"), scene("stride")
    except FileNotFoundError:
        raise Absent("the recorded motion of 'walk'") from None
    R, p = other.truth.writable()
    turned = exp_rotation(np.array([0.0, np.pi, 0.0]))
    R[:, 0] = turned @ R[:, 0]
    middle = np.array([0.0, 0.0, p[:, 2].mean()])
    p = (p - middle) @ turned.T + middle + np.array([0.0, 0.0, 1.2])
    behind = Trajectory(0, R, p)
    woman = replace(other, truth=behind)
    away = replace(one, truth=Trajectory(0, R, p + np.array([500.0, 0.0, 0.0])))

    def frames() -> Any:
        count = min(len(one.truth), len(behind))
        empty, seen, front = (each.cut(0, count - 1).frames() for each in (away, woman, one))
        return np.where((front != empty).any(axis=-1, keepdims=True), front, seen)

    pictures = _pictures("gains-two-people", frames, one.truth)
    video = video_of(len(pictures), lambda n: np.array(pictures[n]))
    return Shown("two people", video, one.camera, None, one.truth, one.skeleton, (behind,))


class Once:
    """Keypoints of each span, and of each frame, found once for all disturbances."""

    def __init__(self, film: Shown) -> None:
        self.film = film
        name, key = film.name.replace(" ", "-"), digest(ROOT / "tracker" / "keypoints")
        self.place = place_for(f"gains-{name}", key, ".pickle")
        self.found: dict[Any, Any] = {}
        if self.place.is_file():
            self.found = pickle.loads(self.place.read_bytes())

    def once(self, key: tuple[Any, ...], find: Callable[[], Any]) -> Any:
        if key not in self.found:
            self.found[key] = find()
            self.place.write_bytes(pickle.dumps(self.found))
        return self.found[key]

    @property
    def network(self) -> DetectedKeypoints:
        return DetectedKeypoints(self.film.video, self.film.camera)

    def over(self, segment: Segment, skeleton: Skeleton, report: Any) -> Keypoints | None:
        span = segment.first_frame, segment.last_frame
        found: Keypoints | None = self.once(
            span, lambda: self.network.over(segment, skeleton, report)
        )
        return found

    def at(self, frame: int, skeleton: Skeleton, pose: Pose) -> Keypoints | None:
        found: Keypoints | None = self.once(
            ("at", frame), lambda: self.network.at(frame, skeleton, pose)
        )
        return found

    def beyond(self, *_: Any) -> Keypoints | None:
        raise NotImplementedError


@lru_cache(maxsize=2)
def once(name: str) -> Once:
    return Once(shown(name))


@lru_cache(maxsize=2)
def _prepared(name: str, frames: tuple[int, ...]) -> Tracker:
    film = shown(name)
    skeleton, poses = film.poses(frames)
    return Tracker(film.video, film.camera, skeleton, poses)


def _bytes(motion: Trajectory) -> bytes:
    return motion.Rs_parent_part.tobytes() + motion.ps_camera_root.tobytes()


def _between(
    name: str, frames: tuple[int, ...], kind: str, seed: int
) -> tuple[dict[str, float], bytes]:
    film, settings = shown(name), CUES[kind]
    skeleton, poses = film.poses(frames)
    plain = _prepared(name, frames)
    source = once(name) if "keypoints" in settings.cues_used else None
    tracker = plain.renewed(skeleton, jittered(skeleton, poses, seed), keypoints=source)
    motion = joined(track(tracker, **settings.model_dump()).trajectories)
    return film.errors(skeleton, motion, frames), _bytes(motion)


_CASES: dict[Any, tuple[str, int]] = {}
"""Limb and frame that are corrected, by row and disturbance: as without a switch."""


def _limb(name: str, ends: tuple[int, int], seed: int) -> tuple[dict[str, float], bytes]:
    """The limb that is worst is laid on its marks where it is worst, and tracked alone."""
    film = shown(name)
    assert film.clip is not None
    frames = _PERSON if name.startswith(("person", "camera")) else ends
    skeleton, poses = film.poses(frames)
    given = jittered(skeleton, {frame: poses[frame] for frame in ends}, seed)
    plain = _prepared(name, frames)

    def tracked(limbs: tuple[KeyedParts, ...] = ()) -> Trajectory:
        tracker = plain.renewed(skeleton, given, keypoints=once(name), keyed_parts=limbs)
        return tracker.run_segment(ends, CUES["between"], lambda *_: None).trajectory

    base = tracked()
    limb, frame = _CASES.setdefault((name, ends, seed), worst(film.clip, skeleton, base, ends))
    pose = on_marks(film.clip, skeleton, base.pose(frame), frame, LIMBS[limb])
    motion = tracked((KeyedParts.of(skeleton, frame, LIMBS[limb], pose),))
    own, rest = errors(film.clip, skeleton, motion, (*ends, frame), LIMBS[limb])
    return {"limb px": float(np.mean(own)), "rest px": float(np.mean(rest))}, _bytes(motion)


class _Remembered(dict[str, DetectionWindow]):
    """What the network found before, as the program keeps it on disk."""

    def put(self, key: str, stretch: DetectionWindow) -> None:
        self[key] = stretch


@cache
def _network() -> AugmentedNetwork:
    return AugmentedNetwork.open()


def _box(film: Shown, first: int, seed: int) -> tuple[float, float, float, float]:
    """Around the person at a frame, as somebody draws it."""
    if film.clip is not None:
        uv = np.array(list(film.clip.marks[first].values()))
    else:
        assert film.truth is not None
        T = pose_transforms(film.skeleton, film.truth.pose(first))
        uv = film.camera.project(joint_positions(film.skeleton, T))
    low, high = uv.min(axis=0), uv.max(axis=0)
    tall = float(high[1] - low[1])
    room = tall * (0.08 + 0.03 * np.random.default_rng((seed, first)).normal(size=4))
    left, top = np.maximum(low - room[:2], 0).tolist()
    right, bottom = np.minimum(
        high + room[2:], (film.camera.width - 1, film.camera.height - 1)
    ).tolist()
    return left, top, right, bottom


def _span(film: Shown) -> tuple[int, int]:
    if film.clip is not None:
        return min(film.clip.marks), max(film.clip.marks)
    return 0, film.video.info.frame_count - 1


def _drafted(name: str, seed: int, proportions: bool = True) -> tuple[ClipDraft, tuple[int, ...]]:
    film, keep, ends = shown(name), once(name), _span(shown(name))
    box, picture = _box(film, ends[0], seed), film.video.frame

    def found() -> Keypoints:
        start = Seed.of_box(ends[0], box, film.camera.width, film.camera.height)
        pieces = keep.found.setdefault("pieces", _Remembered())
        return detect(picture, ends, [start], _network(), film=name, kept=pieces)

    keypoints: Keypoints = keep.once(("draft", seed), found)
    changes = _changes(keep, seed, (picture, keypoints, [ends[0]], _network().plain))
    body = film.clip.body if film.clip is not None else film.skeleton.body
    draft = draft_from_keypoints(
        keypoints, film.camera, body, changes=changes, proportions=proportions
    )
    return draft, changes


def _drafts(name: str, seed: int) -> tuple[dict[str, float], bytes]:
    """Joints in space seen from the hips, pixels, and limbs that point the wrong way in depth."""
    film, (draft, _) = shown(name), _drafted(name, seed)
    frames = sorted(draft.poses)
    every = b"".join(pose.Rs_parent_part.tobytes() for _, pose in sorted(draft.poses.items()))
    skeleton = Skeleton.of(draft.body)
    if film.clip is not None and film.clip.space is None:
        return {"px": _px_of(film, skeleton, draft.poses)}, every
    joints = Joints.of(skeleton)
    p = np.stack([joints.points.at(pose_transforms(skeleton, draft.poses[f])) for f in frames])
    figures = []
    for true in _true_joints(film, frames):
        ours, theirs = (q - q[:, [6, 7]].mean(axis=1, keepdims=True) for q in (p, true))
        mm = 1e3 * np.linalg.norm(ours - theirs, axis=-1).mean(axis=-1)
        px = np.linalg.norm(film.camera.project(p) - film.camera.project(true), axis=-1).mean(-1)
        ideal = film.camera.without_distortion()
        a, b = (np.stack([tilt(ideal, q, bone) for bone in joints.bones], 1) for q in (p, true))
        steep = np.minimum(np.abs(a), np.abs(b)) >= PLANE
        figures.append(np.stack([mm, px, ((a * b < 0) & steep).sum(axis=1)], axis=1))
    nearer = np.argmin([one[:, 1] for one in figures], axis=0)  # of two people
    whole = np.stack(figures)[nearer, np.arange(len(frames))]
    mm, px, mirrored = np.nanmean(whole, axis=0).tolist()
    return {"mm": mm, "px": px, "mirrored": mirrored}, every


def _true_joints(film: Shown, frames: Sequence[int]) -> list[Array]:
    """(F, 12, 3) each, in the order of a draft's joints."""
    if film.clip is not None and film.clip.space is not None:
        names, joints = film.clip.space
        order = [
            f"{side[0].upper()}{joint.title()}"
            for limb in DRAFT_LIMBS
            for joint in limb
            for side in SIDES
        ]
        return [joints[list(frames)][:, [names.index(name) for name in order]]]
    points = Joints.of(film.skeleton).points
    truths = [film.truth, *film.others]
    return [
        np.stack([points.at(pose_transforms(film.skeleton, t.pose(f))) for f in frames])
        for t in truths
        if t is not None
    ]


def _px_of(film: Shown, skeleton: Skeleton, poses: Mapping[int, Pose]) -> float:
    """At all marks of these frames, or at all joints."""
    px: list[float] = []
    for frame, pose in poses.items():
        T = pose_transforms(skeleton, pose)
        if film.clip is None:
            assert film.truth is not None
            true = pose_transforms(film.skeleton, film.truth.pose(frame))
            both = [
                film.camera.project(joint_positions(s, t))
                for s, t in ((skeleton, T), (film.skeleton, true))
            ]
            px += np.linalg.norm(both[0] - both[1], axis=-1).tolist()
        elif frame in film.clip.marks:
            marks = film.clip.marks[frame]
            points = BodyPoints(skeleton, tuple(place(skeleton.body, name) for name in marks))
            away = film.camera.project(points.at(T)) - np.array(list(marks.values()))
            px += np.linalg.norm(away, axis=-1).tolist()
    return float(np.nanmean(px))


def _changes(keep: Once, seed: int, given: tuple[Any, ...]) -> tuple[int, ...]:
    found: tuple[int, ...] = keep.once(("changes", seed), lambda: person_changes(*given))
    return found


def _learn(name: str, seed: int) -> tuple[dict[str, float], bytes]:
    """Drafts of which some are set right, on their marks, and pixels of the others near them."""
    film, (draft, changes) = shown(name), _drafted(name, 0, proportions=name in CLIPS)
    skeleton = Skeleton.of(draft.body)
    known = film.clip.marks if film.clip is not None else range(0, _span(film)[1], 8)
    frames = [frame for frame in sorted(known) if frame in draft.poses]
    posed_frames = frames[seed % 2 :: 2]
    if film.clip is not None:
        posed = {f: _on_marks(film, skeleton, f, draft.poses[f]) for f in posed_frames}
    else:
        assert film.truth is not None
        posed = {f: film.truth.pose(f) for f in posed_frames}
    posed = jittered(skeleton, posed, seed)
    found = refit.refit_drafts(
        draft.keypoints, film.camera, draft.body, draft.poses, posed, posed_frames, changes
    )
    others = {f: found[f] for f in frames if f not in posed and f in found}
    if film.clip is None:
        others = {f: pose for f, pose in found.items() if f not in posed}
    before = _px_of(film, skeleton, {f: draft.poses[f] for f in others})
    every = b"".join(pose.Rs_parent_part.tobytes() for _, pose in sorted(found.items()))
    return {"px": _px_of(film, skeleton, others), "as drafted": before}, every


def _on_marks(film: Shown, skeleton: Skeleton, frame: int, pose: Pose) -> Pose:
    """A draft set right on the marks of its frame."""
    assert film.clip is not None
    marks = film.clip.marks[frame]
    free, ideal = free_skeleton(skeleton.body), film.camera.without_distortion()
    uv = ideal.project(film.camera.back_project(np.array(list(marks.values())), 1.0))
    points = BodyPoints(free, tuple(place(free.body, name) for name in marks))
    turns = np.where(free.dof_turns == 1, np.radians(20.0) ** -2.0, 0.0)
    terms = (
        PointsInPicture(points, ideal, uv, np.ones(len(uv)), NEAREST_M),
        PosePrior.of(pose, turns),
        RootPosition.depth(pose.p_camera_root, 0.02),
    )
    return least_squares(OnePose(free, terms), pose, MANY).state


MANY = Criteria(most_steps=60, longest_step=0.3, settled=1e-6, damping=Damping(most=1e6))
TURN_RAD = np.radians(3.0)
SHIFT_M = 0.015
BESIDE = 10
"""By how much a pose is off that is to be fitted, and the tracked frames beside it."""
FIT_FRAMES = (0, 24, 48)


def _fit(name: str, seed: int) -> tuple[dict[str, float], bytes]:
    """Rough poses fitted between rough neighbours, and where the frames near are tracked between
    exact ones: pixels from the known pose at all joints. No detector takes part."""
    film, (a, frame, b) = shown(name), FIT_FRAMES
    skeleton, poses = film.poses(FIT_FRAMES)
    rough = {f: _rough(skeleton, poses[f], (seed, f)) for f in FIT_FRAMES}
    tracker = _prepared(name, FIT_FRAMES).renewed(skeleton, {f: poses[f] for f in (a, b)})
    motion = tracker.run_segment((a, b), CUES["brightness"], lambda *_: None).trajectory
    tracked = {f: motion.pose(f) for f in range(frame - BESIDE, frame + BESIDE + 1)}
    known = film.camera.project(joint_positions(skeleton, pose_transforms(skeleton, poses[frame])))
    figures, found = {}, b""
    for way, near, beside in (("rough", rough, {}), ("tracked", poses, tracked)):
        keys = {f: near[f] for f in (a, b)}
        pose = fit_pose_to_picture(
            film.video, film.camera, skeleton, frame, rough[frame], keys, beside
        ).pose
        found += pose.Rs_parent_part.tobytes()
        uv = film.camera.project(joint_positions(skeleton, pose_transforms(skeleton, pose)))
        figures[f"{way} px"] = float(np.linalg.norm(uv - known, axis=-1).mean())
    return figures, found


def _rough(skeleton: Skeleton, pose: Pose, seed: tuple[int, int]) -> Pose:
    turns = skeleton.dof_turns == 1
    motion = np.random.default_rng(seed).normal(size=len(turns))
    return moved(skeleton, pose, motion * np.where(turns, TURN_RAD, SHIFT_M))


MUTANTS = 10


def _film(which: int, width: int, seed: int) -> tuple[dict[str, float], bytes]:
    """Of the wrong frames of mutants, the percentage that is not marked damaged."""
    tally = Tally()
    with tempfile.TemporaryDirectory() as folder:
        film = write_film(Path(folder), FILMS[which], width, {352: 192, 480: 144}[width])
        sound = greys(film)
        some = islice(mutants(film, MUTANTS * DISTURBANCES), MUTANTS * seed, MUTANTS * (seed + 1))
        for mutant in some:
            tally.add(mutant, sound)
    missed = tally.wrong - tally.known
    return {"missed": float(missed), "wrong": float(tally.wrong)}, repr(tally).encode()
