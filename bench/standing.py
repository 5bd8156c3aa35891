"""Standing on the floor: feet, drafts and up, of filmed and of rendered people.

A film is drafted from one box, every thirtieth draft accepted as it is, tracked, and stood, by the
commands. Before it stands beside after. Rendered people whose truth is known stand, shuffle, jump,
squat and walk, tracked between keyframes at wrong distances. Others stride, walk and throw before a
camera that looks down by 12° and has no upright lines: what is up is found by how they stand.
"""

from __future__ import annotations

import contextlib
import io
from collections.abc import Iterator, Mapping
from dataclasses import astuple, dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from scipy.spatial.transform import Rotation

from bench.clips import Clip, clip
from bench.keeping import Absent
from bench.sequences import FPS, video_of
from bench.space import acceleration
from bench.standing_cases import CASES, made
from bench.standing_measures import COLUMNS, effect, expected, motion_of
from bench.table import Expected, Report, Table
from keypose.app.cli.main import main
from keypose.app.editor.documents import softened, with_drafts, with_keyframes
from keypose.app.words.standing import standing_words
from keypose.tracker.body.body import preset
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory, joined
from keypose.tracker.errors import SessionError
from keypose.tracker.fitting.draft import draft_from_keypoints
from keypose.tracker.fitting.draft.observed import Joints
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.geometry.up import combined
from keypose.tracker.keypoints.detect import Seed, detect
from keypose.tracker.keypoints.detectors import open_detector
from keypose.tracker.keypoints.keypoints import JOINTS
from keypose.tracker.keypoints.model_files import find_model
from keypose.tracker.operations.stand import stand
from keypose.tracker.session import Session
from keypose.tracker.session.pins import Pin
from keypose.tracker.space.contacts import proposed_pins
from keypose.tracker.space.level import HELD_LEVEL, evidence_of_standing
from keypose.tracker.space.soles import foot_heights
from keypose.tracker.storage.files import load_session, save_session
from keypose.tracker.storage.results import load_results
from tests.rendering.scenes import Scene, scene

FILMS: Mapping[str, tuple[tuple[float, float, float, float], int, tuple[int, int], float]] = {
    "walk": ((590, 275, 705, 510), 40, (10, 110), 38.7),
    "person": ((200, 200, 450, 800), 0, (0, 99), 59.4),
}
"""Box, its frame, frames, field of view in degrees."""
EVERY = 30
MOST_SOLES_CM = 1.5
MOST_SLIDE_CM = 0.5
MOST_MORE_PX = 0.3
RENDERED = ("walk", "stride", "throw")
TILT_DEG = 12.0
MOST_TILT_DEG = 1.5
MOST_LEAN_DEG = 3.0


@dataclass(frozen=True, eq=False)
class Stood:
    """A session with its motion."""

    session: Session
    motion: Trajectory

    @property
    def skeleton(self) -> Skeleton:
        return Skeleton.of(self.session.subject.body)


def standing(report: Report) -> None:
    """The whole group."""
    report.note("soles: range of the heights of pinned heels and toes; slide: farthest from the")
    report.note(
        "middle of a pin; turn: most a foot turns in a frame; marks: px, every marked joint"
    )
    columns = ("soles cm", "slide cm", "turn deg", "feet m/s²", "waist m/s²", "marks px")
    table = report.table("filmed, from one box", *columns)
    for name in FILMS:
        with contextlib.suppress(Absent):
            _film(name, table)
    table = report.table("rendered, keyframes at wrong distances: beside before", *COLUMNS)
    for name in CASES:
        _case(name, table, report)
    table = report.table(
        "rendered, looking down by 12°: drafts",
        "up found, deg off",
        "lean, deg",
        "feet deg",
        "hips deg",
        "mm",
    )
    for name in RENDERED:
        with contextlib.suppress(Absent):
            _rendered(name, table)


def _case(name: str, table: Table, report: Report) -> None:
    """A case, stood; of those that nobody can stand why, and with up known."""
    here = made(name)
    session = here.session
    try:
        done = stand(session, here.fitting)
    except SessionError as refused:
        report.note(f"{name}: {refused}")
        x, y, z = here.up.tolist()
        done = stand(session.changed({"up_world": (x, y, z)}), here.fitting)
    found = effect(here, done.session, motion_of(done.session, here))
    table.row(name, *astuple(found), expected=expected(found))
    report.note(standing_words(done))


def _film(name: str, table: Table) -> None:
    """One film, before and after."""
    here = clip(name)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "session.json"
        _drafted(here, name, path)
        before = _loaded(path)
        run_quietly("stand", str(path))
        after = _loaded(path)
    pins = after.session.subject.pins
    assert after.session.world.up_world is not None
    up = np.array(after.session.world.up_world)
    tracked = _figures(here, before, pins, up)
    table.row(f"{name}, tracked", *tracked)
    found = _figures(here, after, pins, up)
    expected = [
        Expected("soles", found[0], MOST_SOLES_CM, "cm"),
        Expected("slide", found[1], MOST_SLIDE_CM, "cm"),
        Expected("marks", found[-1], tracked[-1] + MOST_MORE_PX, "px"),
    ]
    table.row(f"{name}, stood", *found, expected=expected)


def _drafted(here: Clip, name: str, path: Path) -> None:
    """Draft, accept and track, in a session at this path."""
    box, at, (first, last), view = FILMS[name]
    run_quietly(
        "draft",
        str(here.video),
        "--box",
        ",".join(map(str, box)),
        "--frame",
        str(at),
        "--frames",
        f"{first}-{last}",
        "--field-of-view",
        str(view),
        "--body",
        here.body.name,
        "--out",
        str(path.parent),
    )
    session = load_session(path)
    frames = [draft.frame for draft in session.subject.drafts]
    keys = {*frames[::EVERY], frames[-1]}
    accepted = [
        softened(draft.model_copy(update={"drafted": False}), True)
        for draft in session.subject.drafts
        if draft.frame in keys
    ]
    rest = [draft for draft in session.subject.drafts if draft.frame not in keys]
    save_session(with_drafts(with_keyframes(session, accepted), rest), path)
    run_quietly("track", str(path))


def run_quietly(*words: str) -> None:
    """A command, without what it prints."""
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        main(words)


def _loaded(path: Path) -> Stood:
    session = load_session(path)
    found = load_results(session, path).fitting(session)
    return Stood(session, joined([found[span].trajectory for span in sorted(found)]))


def _figures(here: Clip, stood: Stood, pins: tuple[Pin, ...], up: Array) -> list[float]:
    skeleton, motion = stood.skeleton, stood.motion
    high = [foot_heights(skeleton, motion, pin, up).ravel() for pin in pins if pin.floor]
    slides = [_slide(skeleton, motion, pin) for pin in pins if pin.floor]
    rate = 60.0 if here.name == "person" else 30.0
    feet = [acceleration(skeleton, motion, f"{side}_foot", rate) for side in ("left", "right")]
    return [
        100 * float(np.ptp(np.concatenate(high))),
        100 * max(slides),
        _turn(skeleton, motion),
        max(feet),
        acceleration(skeleton, motion, "waist", rate),
        _marks_px(here, stood),
    ]


def _slide(skeleton: Skeleton, motion: Trajectory, pin: Pin) -> float:
    """Metres that a pinned end of a sole strays from its middle."""
    part = skeleton.body.index(pin.part)
    T = motion.transforms(skeleton)[:, part]
    T = T[pin.first_frame - motion.first_frame : pin.last_frame + 1 - motion.first_frame]
    strays = []
    for name in pin.landmarks:
        p = T[:, :3, :3] @ np.array(skeleton.body.parts[part].landmarks[name]) + T[:, :3, 3]
        strays.append(float(np.linalg.norm(p - p.mean(axis=0), axis=-1).max()))
    return max(strays)


def _turn(skeleton: Skeleton, motion: Trajectory) -> float:
    """Degrees that a foot turns in a frame at most."""
    Ts = motion.transforms(skeleton)
    feet = [skeleton.body.index(f"{side}_foot") for side in ("left", "right")]
    R = Ts[:, feet][..., :3, :3]
    steps = Rotation.from_matrix((np.swapaxes(R[:-1], -1, -2) @ R[1:]).reshape(-1, 3, 3))
    return float(np.degrees(steps.magnitude().max()))


def _marks_px(here: Clip, stood: Stood) -> float:
    """Mean distance of all marked joints."""
    uv = stood.session.view.camera.project(
        Joints.of(stood.skeleton).points.at(stood.motion.transforms(stood.skeleton))
    )
    away = [
        float(np.linalg.norm(uv[frame - stood.motion.first_frame, JOINTS.index(joint)] - mark))
        for frame, joint, mark in _marks(here)
        if stood.motion.first_frame <= frame <= stood.motion.last_frame
    ]
    return float(np.mean(away))


def _marks(here: Clip) -> Iterator[tuple[int, str, tuple[float, float]]]:
    """Frame, keypoint and pixel of every mark of an arm or a leg."""
    sides = {"L": "left_", "R": "right_"}
    for frame, joints in here.marks.items():
        for name, uv in joints.items():
            joint = sides.get(name[0], "") + name[1:].lower()
            if joint in JOINTS:
                yield frame, joint, uv


def _rendered(name: str, table: Table) -> None:
    """Drafts of a rendered person, up known, and what is up by how they stand, not known."""
    shown, up = tilted(name)
    pictures = shown.frames()
    uv = shown.camera.project(shown.truth.joints(shown.skeleton)[0])
    low, high = uv.min(axis=0), uv.max(axis=0)
    room = 0.08 * float(high[1] - low[1])
    size = (shown.camera.width - 1, shown.camera.height - 1)
    box = (*np.maximum(low - room, 0).tolist(), *np.minimum(high + room, size).tolist())
    seed = Seed.of_box(0, box, shown.camera.width, shown.camera.height)
    video = video_of(len(pictures), lambda n: pictures[n])
    detector = open_detector(find_model("thunder"))
    keypoints = detect(video.frame, (0, len(pictures) - 1), [seed], detector)
    draft = partial(draft_from_keypoints, keypoints, shown.camera, preset("adult_male"))
    unknown, known = draft(), draft(up_world=up)
    skeleton = Skeleton.of(unknown.body)
    motion = _motion(unknown.poses)
    stances = [pin for pin in proposed_pins(skeleton, motion, FPS, None) if pin.landmarks[1:]]
    level = combined(evidence_of_standing(skeleton, motion, stances), HELD_LEVEL)
    off = float("nan") if level is None else _angle_deg(level.up, up)
    figures = _of_drafts(shown, Skeleton.of(known.body), _motion(known.poses))
    expected = [
        Expected("up", off, MOST_TILT_DEG, "°"),
        Expected("lean", abs(figures[0]), MOST_LEAN_DEG, "°"),
    ]
    table.row(name, off, *figures, expected=expected)


def tilted(name: str) -> tuple[Scene, Array]:
    """The first hundred frames of a scene before a camera that looks down; what is up in it."""
    shown = scene(name)
    shown = shown.cut(0, min(110, len(shown.truth) - 1))
    R = Rotation.from_euler("x", TILT_DEG, degrees=True).as_matrix()
    Rs, ps = shown.truth.writable()
    middle = ps.mean(axis=0)
    Rs[:, 0], ps = R @ Rs[:, 0], (ps - middle) @ R.T + middle
    tipped = Scene(shown.name, shown.skeleton, Trajectory(0, Rs, ps), shown.camera, shown.settings)
    return tipped, R @ np.array([0.0, -1.0, 0.0])


def _motion(poses: Mapping[int, object]) -> Trajectory:
    frames = sorted(poses)
    some = [poses[frame] for frame in frames]
    R = np.stack([pose.Rs_parent_part for pose in some])  # type: ignore[attr-defined]
    return Trajectory(frames[0], R, np.stack([p.p_camera_root for p in some]))  # type: ignore[attr-defined]


def _of_drafts(shown: Scene, skeleton: Skeleton, motion: Trajectory) -> list[float]:
    """Lean beyond the truth's, directions of feet and hips, degrees, and joints, mm."""
    rows = slice(motion.first_frame, motion.last_frame + 1)
    truth = Trajectory(0, shown.truth.Rs_parent_part[rows], shown.truth.ps_camera_root[rows])
    p, q = (
        Joints.of(s).points.at(m.transforms(s))
        for s, m in ((skeleton, motion), (shown.skeleton, truth))
    )
    pairs = {
        joint: [JOINTS.index(f"{side}_{joint}") for side in ("left", "right")]
        for joint in ("shoulder", "hip", "ankle")
    }

    def lean(joints: Array) -> float:
        along = joints[:, pairs["shoulder"]].mean(axis=1) - joints[:, pairs["ankle"]].mean(axis=1)
        return float(np.degrees(np.median(np.arctan2(-along[:, 2], -along[:, 1]))))

    hips = [x[:, pairs["hip"][0]] - x[:, pairs["hip"][1]] for x in (p, q)]
    feet = [
        _angles_deg(
            *(
                m.transforms(s)[:, s.body.index(f"{side}_foot"), :3, 2]
                for s, m in ((skeleton, motion), (shown.skeleton, truth))
            )
        )
        for side in ("left", "right")
    ]
    from_hips = [x - x[:, pairs["hip"]].mean(axis=1, keepdims=True) for x in (p, q)]
    mm = 1e3 * float(np.linalg.norm(from_hips[0] - from_hips[1], axis=-1).mean())
    return [
        lean(p) - lean(q),
        float(np.median(np.concatenate(feet))),
        float(np.median(_angles_deg(*hips))),
        mm,
    ]


def _angles_deg(a: Array, b: Array) -> Array:
    """(N,) between directions (N, 3)."""
    a, b = (x / np.linalg.norm(x, axis=-1, keepdims=True) for x in (a, b))
    return np.asarray(np.degrees(np.arccos(np.clip((a * b).sum(axis=-1), -1, 1))))


def _angle_deg(a: Array, b: Array) -> float:
    return float(_angles_deg(a[None], b[None])[0])
