"""Two films of one motion beside one: the man on the balance beam, filmed by two of four cameras.

Truth are his joints by four views, 15 to 25 mm good, which run ahead of the films by the better
part of a frame. The published calibration misses its own films by a degree or two, so each camera
is laid onto its film's keypoints of the whole motion. Keyframes lie sixty frames apart: exact, or
as somebody poses them who sees one film, each joint's depth off by 8 cm (σ).
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from functools import cached_property
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final
from xml.etree import ElementTree

import cv2
import numpy as np
from scipy.optimize import least_squares

from bench.keeping import DATA, ROOT, Absent, digest, place_for
from bench.sequences import Sequence, sequence
from bench.table import Expected, Report
from keypose.app.cli.main import main
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.resampling import resampled
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory, joined
from keypose.tracker.films.cameras import at_scale_of, joints_of_pose, lengths_of
from keypose.tracker.films.mend import SeenInFilm, mended
from keypose.tracker.films.offset import FoundOffset, OffsetSearch, find_offsets
from keypose.tracker.films.sightings import Sightings
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.film_clock import FilmClock, sampled
from keypose.tracker.geometry.rotations import (
    Array,
    exp_rotation,
    log_rotation,
    rotation_from_euler,
    transform,
)
from keypose.tracker.keypoints.keypoints import JOINTS, Keypoints
from keypose.tracker.keypoints.on_body import points_on_body
from keypose.tracker.session.settings import TrackSettings
from keypose.tracker.solver.fit_joints import fit_motion
from keypose.tracker.solver.posed import BodyPoints
from keypose.tracker.storage.files import load_session
from keypose.tracker.storage.results import load_results
from keypose.tracker.storage.sidecars import keypoints_of_session
from keypose.tracker.tracking.cues.sources import GivenKeypoints
from keypose.tracker.tracking.film_beside import FilmBeside
from keypose.tracker.tracking.tracker import Tracker
from keypose.tracker.video import Video
from tests.rendering.render import render
from tests.rendering.settings import RenderSettings

FRAMES: Final = 100
FPS: Final = 60.0
AHEAD: Final = 0.7
"""Frames by which the measured joints run before the films."""
WIDTHS: Final = {2: 1080, 3: 1088}
SENSOR_WIDTH: Final = 1088
FIRST: Final = 3
BESIDE: Final = 2
SPANS: Final = ((0, 60), (20, 80), (39, 99))
SEEDS: Final = (5, 6, 7)
DEPTH_OFF_M: Final = 0.08
CUTS: Final = (0, 3, 11)
"""Frames that the second film is begun later by."""
MOST_MM: Final = {"exact": 20.0, "mended": 28.0, "absolute": 30.0}
MOST_OFFSET: Final = 0.5
RENDERED: Final = ("throw", "wash")
ASIDE_DEG: Final = 60.0
LATE: Final = 3.4
APART: Final = 48
BESIDE_SHARE: Final = 0.004
SHAKES_SHARE: Final = 0.004
"""Of the rendered films; by how much a detector puts a joint aside for good, and from frame to
frame, shares of the body's height."""
MOST_OFF_RENDERED: Final = 0.1
MOST_TURNED_DEG: Final = 0.5
MOST_JOINTS_CM: Final = 1.0
_COCO: Final = "LShoulder RShoulder LElbow RElbow LWrist RWrist LHip RHip LKnee RKnee LAnkle RAnkle"


def films(report: Report) -> None:
    """The figures of one film and of two."""
    _rendered(report)
    with TemporaryDirectory() as folder:
        man = _man(Path(folder))
        _cameras(report, man)
        _keyed(report, man)
        _unattended(report, man, Path(folder))


@dataclass(frozen=True, eq=False)
class View:
    """One film: its camera, its keypoints, and where the room is for it."""

    video: Video
    camera: Camera
    keypoints: Keypoints
    T_camera_room: Array


@dataclass(frozen=True, eq=False)
class Man:
    """Both films, the body, and his joints (N, 12, 3) in the first camera's frame."""

    views: Mapping[int, View]
    skeleton: Skeleton
    joints: Array
    motion: Trajectory
    folders: Mapping[int, Path]

    @cached_property
    def T_beside_first(self) -> Array:
        """(4, 4) from the first camera's frame to the other's."""
        there, here = (self.views[n].T_camera_room for n in (BESIDE, FIRST))
        return np.asarray(there @ np.linalg.inv(here))

    @cached_property
    def places(self) -> BodyPoints:
        """His joints on the body."""
        _, parts, points = points_on_body(self.skeleton.body, JOINTS)
        return BodyPoints.single(self.skeleton, parts, points)

    def errors_mm(self, motion: Trajectory, truth: Array) -> tuple[float, float]:
        """Mean distance of joints about the hips' middle, and in space, between the ends."""
        found = self.places.at(motion.transforms(self.skeleton))
        about = _about_hips(found) - _about_hips(truth)
        off = [np.linalg.norm(each, axis=-1)[1:-1].mean() for each in (about, found - truth)]
        return 1000 * float(off[0]), 1000 * float(off[1])


def _about_hips(joints: Array) -> Array:
    hips = [JOINTS.index("left_hip"), JOINTS.index("right_hip")]
    return np.asarray(joints - joints[:, hips].mean(axis=1, keepdims=True))


def _man(folder: Path) -> Man:
    source, truth = DATA / "several", DATA / "person" / "reference.npz"
    if not source.is_dir() or not truth.is_file():
        raise Absent("the films of several cameras beside the checkout")
    reference = np.load(truth)
    names = [str(name) for name in reference["names"]]
    room = reference["xyz_world"][:, [names.index(name) for name in _COCO.split()]]
    room = sampled(room, np.clip(np.arange(FRAMES) - AHEAD, 0, FRAMES - 1))
    published = _published(source / "qca.txt")
    views, folders = {}, {}
    for number in (BESIDE, FIRST):
        film, out = source / f"single_cam0{number}.mp4", folder / f"film-{number}"
        _quietly("draft", str(film), "--out", str(out))
        session = load_session(out / "session.json")
        keypoints = keypoints_of_session(session, out)
        assert keypoints is not None
        camera, T = published[number]
        views[number] = View(Video.open(film), camera, keypoints, _laid(camera, T, keypoints, room))
        folders[number] = out
    body = load_session(ROOT / "sample_videos" / "balance" / "session.json").subject.body
    T = views[FIRST].T_camera_room
    joints = room @ T[:3, :3].T + T[:3, 3]
    _, parts, points = points_on_body(body, JOINTS)
    places = [
        ((int(part), tuple(map(float, point))),) for part, point in zip(parts, points, strict=True)
    ]
    motion = fit_motion(body, places, joints, 0).trajectory  # type: ignore[arg-type]
    return Man(views, Skeleton.of(body), joints, motion, folders)


def _published(path: Path) -> dict[int, tuple[Camera, Array]]:
    """The published cameras, and the room in their frames."""
    cameras = {}
    for each in ElementTree.parse(path).iter("camera"):
        number = int(str(each.get("serial"))[3:])
        lens, placed = each.find("intrinsic"), each.find("transform")
        assert lens is not None
        assert placed is not None
        v = {name: float(text) for name, text in (lens.attrib | placed.attrib).items()}
        if number not in WIDTHS:
            continue
        R = np.reshape([v[f"r{i}{j}"] for i in (1, 2, 3) for j in (1, 2, 3)], (3, 3))
        R = np.diag([1.0, -1.0, -1.0]) @ R
        place = np.array([v["x"], v["y"], v["z"]]) / 1000
        width = WIDTHS[number]
        radial = v["radialDistortion1"], v["radialDistortion2"]
        camera = Camera(
            width=width,
            height=1920,
            fx=v["focalLengthU"] / 64,
            fy=v["focalLengthV"] / 64,
            cx=v["centerPointU"] / 64 - (SENSOR_WIDTH - width) / 2,
            cy=v["centerPointV"] / 64,
            distortion=(*radial, v["tangentalDistortion1"], v["tangentalDistortion2"], 0.0),
        )
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = R, -R @ place
        cameras[number] = camera, T
    return cameras


def _laid(camera: Camera, T: Array, keypoints: Keypoints, room: Array) -> Array:
    """The camera laid onto what its film shows of known joints, from where it was published."""
    seen = Sightings.of(keypoints, camera, FRAMES)

    def moved(x: Array) -> Array:
        there = T.copy()
        there[:3, :3] = exp_rotation(x[:3]) @ T[:3, :3]
        there[:3, 3] += x[3:]
        return there

    def off(x: Array) -> Array:
        there = moved(x)
        p = room @ there[:3, :3].T + there[:3, 3]
        return np.asarray(((p[..., :2] / p[..., 2:] - seen.xy) * seen.scale[..., None]).ravel())

    return moved(least_squares(off, np.zeros(6), loss="cauchy").x)


# --- rendered, with exact truth


def _rendered(report: Report) -> None:
    """Two rendered films, one of which began later, as a detector sees them that shakes."""
    columns = ("offset", "turn °", "place cm", "1 film cm", "2 films cm", "exact cm")
    table = report.table(
        f"rendered, {ASIDE_DEG:.0f}° aside and {LATE:g} frames later, keyframes every {APART}",
        *columns,
    )
    for name in RENDERED:
        shown = sequence(name)
        T, clock = _aside(shown.truth), FilmClock(LATE)
        film = _later(name, shown, T, clock)
        keypoints = [
            _shaken(each.skeleton, each.truth, each.camera, seed)
            for seed, each in enumerate((shown, film))
        ]
        sightings = [
            Sightings.of(each, shown.camera, len(pictures.truth))
            for each, pictures in zip(keypoints, (shown, film), strict=True)
        ]
        lengths_m = lengths_of(shown.skeleton.body)
        frames = list(range(0, len(shown.truth), APART))
        keyed = {frame: joints_of_pose(shown.skeleton, shown.truth.pose(frame)) for frame in frames}
        best, *_ = find_offsets(OffsetSearch(*sightings, 30.0, lengths_m, keyed=keyed), 1.0)
        count = np.arange(len(shown.truth))
        camera = at_scale_of(best.camera, sightings[1].at(best.clock, count), keyed)
        found_T = camera.T_camera_first
        turn = np.degrees(np.linalg.norm(log_rotation(found_T[:3, :3] @ T[:3, :3].T)))
        there, here = (-each[:3, :3].T @ each[:3, 3] for each in (found_T, T))
        off = abs(best.clock.begins - LATE)
        errors = [
            _off_cm(shown, film, keypoints, frames, beside)
            for beside in (None, (best.clock, found_T), (clock, T))
        ]
        table.row(
            name,
            float(off),
            float(turn),
            float(100 * np.linalg.norm(there - here)),
            *errors,
            expected=[
                Expected("offset", float(off), MOST_OFF_RENDERED, "frames"),
                Expected("turn", float(turn), MOST_TURNED_DEG, "°"),
                Expected("joints", errors[1], MOST_JOINTS_CM, "cm"),
            ],
        )


def _aside(truth: Trajectory) -> Array:
    """(4, 4) from the first camera's frame to that of one beside it."""
    middle = truth.ps_camera_root.mean(axis=0)
    R = rotation_from_euler(0.05, np.radians(ASIDE_DEG), 0.08)
    return transform(R, middle - R @ middle + np.array([0.2, 0.1, 0.3]))


def _later(name: str, shown: Sequence, T: Array, clock: FilmClock) -> Sequence:
    """The same motion as the other camera films it, at its own moments."""
    times = np.arange(len(shown.truth), dtype=float)
    moments = clock.moments_of(np.arange(int(len(shown.truth) - 1 - clock.begins)))
    Rs, ps = resampled(shown.truth.Rs_parent_part, shown.truth.ps_camera_root, times, moments)
    truth = Trajectory(0, Rs, ps).carried(np.broadcast_to(T, (len(moments), 4, 4)))
    place = place_for(
        f"beside-{name}", digest(truth.Rs_parent_part.tobytes(), ROOT / "tests/rendering"), ".npy"
    )
    if not place.is_file():
        pictures = render(shown.skeleton, truth, shown.camera, RenderSettings(seed=3))
        np.save(place, np.stack([cv2.cvtColor(each, cv2.COLOR_RGB2GRAY) for each in pictures]))
    return Sequence(shown.skeleton, shown.camera, truth, np.load(place))


def _shaken(skeleton: Skeleton, truth: Trajectory, camera: Camera, seed: int) -> Keypoints:
    """What a detector says that puts each joint beside where it is, and shakes."""
    rng = np.random.default_rng(seed)
    frames = range(truth.first_frame, truth.last_frame + 1)
    joints = np.stack([joints_of_pose(skeleton, truth.pose(frame)) for frame in frames])
    tall = camera.fy * 1.7 / float(np.median(joints[..., 2]))
    uv = camera.project(joints) + rng.normal(0.0, BESIDE_SHARE * tall, (1, len(JOINTS), 2))
    uv = uv + rng.normal(0.0, SHAKES_SHARE * tall, uv.shape)
    hips = _about_hips(joints) + rng.normal(0.0, 0.05, joints.shape)
    return Keypoints(0, JOINTS, uv, np.ones(uv.shape[:2]), hips)


def _off_cm(
    shown: Sequence,
    film: Sequence,
    keypoints: list[Keypoints],
    frames: list[int],
    beside: tuple[FilmClock, Array] | None,
) -> float:
    """Mean distance of joints in space between keyframes, by one film or with another beside it."""
    films: list[FilmBeside] = []
    keyposes = shown.keyposes(frames)
    if beside is not None:
        clock, T = beside
        prepared = Tracker(film.video(), film.camera, film.skeleton, keyposes).prepared
        Ts = [np.broadcast_to(T, (len(each.truth), 4, 4)) for each in (film, shown)]
        films = [FilmBeside(prepared, clock, *Ts, keypoints[1])]
    tracker = Tracker(
        shown.video(),
        shown.camera,
        shown.skeleton,
        keyposes,
        keypoints=GivenKeypoints(keypoints[0]),
        films=films,
    )
    settings = TrackSettings(cues=("brightness", "keypoints"))
    off = []
    for span in tracker.spans:
        motion = tracker.run_segment(span, settings, lambda *_: None).trajectory
        truth = shown.truth.joints(shown.skeleton)[span[0] : span[1] + 1]
        away = np.linalg.norm(motion.joints(shown.skeleton) - truth, axis=-1)
        off.append(away[1:-1].mean())
    return 100 * float(np.mean(off))


# --- cameras and clocks, from the body alone


def _cameras(report: Report, man: Man) -> None:
    columns = ("offset", "±", "turn °", "± °", "place cm", "± cm", "lens %")
    table = report.table("the second film's clock and camera, found from the body", *columns)
    lengths_m = lengths_of(man.skeleton.body)
    for known in (True, False):
        for cut in CUTS:
            found, focal = _found(man, lengths_m, cut, known)
            off = found.clock.begins - cut
            T, true = found.camera.T_camera_first, man.T_beside_first
            turn = np.degrees(np.linalg.norm(log_rotation(T[:3, :3] @ true[:3, :3].T)))
            there, here = (-each[:3, :3].T @ each[:3, 3] for each in (T, true))
            table.row(
                f"{'lenses known' if known else 'lenses guessed'}, {cut} frames later",
                float(off),
                found.sigma,
                float(turn),
                float(np.degrees(found.camera.sigma_rad)),
                float(100 * np.linalg.norm(there - here)),
                100 * found.camera.sigma_m,
                focal,
                expected=[Expected("offset", abs(float(off)), MOST_OFFSET, "frames")],
            )


def _found(man: Man, lengths_m: Array, cut: int, known: bool) -> tuple[FoundOffset, float]:
    """The likeliest offset, and by how many per cent the worse lens is off then."""
    sightings, cameras = {}, {}
    for number, view in man.views.items():
        guess = load_session(man.folders[number] / "session.json").view.camera
        cameras[number] = view.camera if known else guess
        sightings[number] = Sightings.of(view.keypoints, cameras[number], FRAMES)
    film = sightings[BESIDE].at(FilmClock(), np.arange(cut, FRAMES))
    free = not known, not known
    best, *_ = find_offsets(OffsetSearch(sightings[FIRST], film, FPS, lengths_m, free), 1.0)
    ratios = {FIRST: best.camera.first_focal, BESIDE: best.camera.focal}
    off = [
        100 * abs(cameras[n].fx * ratios[n] / man.views[n].camera.fx - 1) for n in (FIRST, BESIDE)
    ]
    return best, float(max(off))


# --- sixty frames between keyframes


def _keyed(report: Report, man: Man) -> None:
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
            truth = _truth(man, span)
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


def _truth(man: Man, span: tuple[int, int]) -> Array:
    """The joints of the body that was fitted to what was measured."""
    rows = slice(span[0], span[1] + 1)
    return man.places.at(man.motion.transforms(man.skeleton)[rows])


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


# --- without a hand


def _unattended(report: Report, man: Man, folder: Path) -> None:
    table = report.table(
        "drafts accepted and tracked without a hand, lenses and cameras unknown", "about hips mm"
    )
    source = DATA / "several" / f"single_cam0{BESIDE}.mp4"
    for count in (1, 2):
        out = folder / f"alone-{count}"
        film = DATA / "several" / f"single_cam0{FIRST}.mp4"
        _quietly("draft", str(film), "--accept", "--out", str(out))
        if count > 1:
            _quietly("add-film", str(out), str(source))
        _quietly("track", str(out))
        session = load_session(out / "session.json")
        fitting = load_results(session, out / "session.json").fitting(session)
        motion = joined([fitting[span].trajectory for span in sorted(fitting)])
        skeleton = Skeleton.of(session.subject.body)
        _, parts, points = points_on_body(skeleton.body, JOINTS)
        places = BodyPoints.single(skeleton, parts, points)
        found = places.at(motion.transforms(skeleton))
        rows = slice(motion.first_frame, motion.last_frame + 1)
        truth = man.places.at(man.motion.transforms(man.skeleton)[rows])
        off = np.linalg.norm(_about_hips(found) - _about_hips(truth), axis=-1)
        table.row(f"{count} film{'s' * (count > 1)}", 1000 * float(off.mean()))


def _quietly(*words: str) -> None:
    """A command, whose words are shown only where it fails."""
    said = StringIO()
    with redirect_stdout(said), redirect_stderr(said):
        code = main(list(words))
    if code not in (0, 1):
        raise RuntimeError(said.getvalue())
