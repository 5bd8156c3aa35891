"""Motion in space against markers: films that nobody posed, beside what rivals found of them.

Each film is turned into motion by `keypose run`, from boxes disturbed by 2 % of their height, and
stood on its floor; then a scripted person works on it for a minute (`human/minute.py`), and it is
tracked and stood again. The truth of the phone's films are joint centres of OpenSim's model, fitted
to markers; of the man on the beam, joints from four views, good to 15–25 mm. Joints are defined
otherwise by every maker, so 30–40 mm root-relative is near what can be told at all.
"""

from __future__ import annotations

import contextlib
import io
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from bench.clips import person_reference
from bench.human.clips import Watched, noisy, of_poses
from bench.human.counting import KINDS
from bench.human.minute import Worked, worked
from bench.keeping import DATA, Absent, data_folder
from bench.measures import Over
from bench.table import Expected, Report, Table
from keypose.app.cli.main import main
from keypose.tracker.body.pose import joint_names
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory, joined
from keypose.tracker.fitting.draft.first_poses import first_pose, landmark_axes
from keypose.tracker.fitting.draft.observed import Joints
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.keypoints import JOINTS as KEYPOINTS
from keypose.tracker.storage.files import load_session, open_video_of
from keypose.tracker.storage.results import load_results
from keypose.tracker.video import Video

SIDES = ("right", "left")
JOINTS = tuple(
    f"{side}_{part}"
    for part in ("thigh", "shin", "foot", "upper_arm", "forearm", "hand")
    for side in SIDES
)
"""Parts, each of which begins at its joint: hip, knee, ankle, shoulder, elbow, wrist."""
JOINT_OF_PART = {
    "hip": "thigh",
    "knee": "shin",
    "ankle": "foot",
    "shoulder": "upper_arm",
    "elbow": "forearm",
    "wrist": "hand",
}
_BONES = ("femur", "tibia", "talus", "humerus", "ulna", "hand")
OPENSIM = (
    *(f"{bone}_{side}" for bone in _BONES for side in ("r", "l")),
    *("calcn_r", "toes_r", "calcn_l", "toes_l"),
)
_POINTS = ("Hip", "Knee", "Ankle", "Shoulder", "Elbow", "Wrist")
BODY_25 = (
    *(f"{side}{joint}" for joint in _POINTS for side in ("R", "L")),
    *("RHeel", "RBigToe", "LHeel", "LBigToe"),
)
HIPS = (0, 1)
SHOULDERS = (6, 7)
KNEES = ((0, 2, 4), (1, 3, 5))
ELBOWS = ((6, 8, 10), (7, 9, 11))
FEET = ((12, 13), (14, 15))
"""Heel and toe of the right and of the left foot, after the joints."""
LATE_S = 0.0165
"""The phone's films are so much behind the markers, measured against keypoints."""
PHONE_DEG = 70.05
"""The phone's own lens, along the longer side."""
BOXES = 3
DISTURBED = 0.02
COLUMNS = (
    "root-rel mm",
    "Procrustes",
    "rigid",
    "across",
    "along",
    "hips deg",
    "shoulders",
    "knees",
    "elbows",
    "feet",
)


SPENT = (
    "mm gained",
    "offered",
    "looked at",
    "corrected",
    "keyframes",
    "clicks",
    "keys",
    "drags",
    "looks",
    "seconds",
)
SEEN_PX = 2.0
"""How far off a person sees a joint."""


@dataclass(frozen=True)
class Expectation:
    """The most a film's figures should be once it stands. by_hand_mm: root-relative, after a minute
    of a hand."""

    root_relative_mm: float
    knees_deg: float = 6.0
    hips_deg: float = 5.0
    rigid_mm: float = 50.0
    along_over_across: float = 1.4
    by_hand_mm: float = 35.0


@dataclass(frozen=True, eq=False)
class Film:
    """A film, the person's box in one frame, or None where they are found, and where the joints
    were.

    height_cm: with which the body is as long from ankles to shoulders as the truth's: what a person
    is asked for, and the rivals were told.  frames: those that are drafted, all where None.
    R_camera_truth, t_camera_truth: from the axes of the truth to the camera's.  lens: by which the
    truth is seen where the film shows it, as it was solved; what is measured knows it not.
    rivals: what others found.
    """

    name: str
    video: Path
    view_deg: float
    height_cm: float
    box: tuple[float, float, float, float] | None
    frame: int
    frames: str | None
    R_camera_truth: Array
    times_s: Array
    p_truth: Array
    expected: Expectation
    lens: Camera
    t_camera_truth: Array
    late_s: float = 0.0
    rivals: Mapping[str, Path] | None = None

    def at(self, times_s: Array) -> tuple[Array, Array]:
        """Which of these times the truth has, and its joints then, in the camera's axes."""
        known = (times_s >= self.times_s[0]) & (times_s <= self.times_s[-1])
        return known, _at(times_s[known], self.times_s, self.p_truth) @ self.R_camera_truth.T

    def watched(self, path: Path) -> Watched:
        """The film as a person sees it who works on a session of it.

        Makers put joints elsewhere: bones point as the truth has them, and are as long as those of
        the session's body, which is put where the truth is seen.
        """
        session = load_session(path)
        camera, joints = session.view.camera, Joints.of(Skeleton.of(session.subject.body))
        with open_video_of(session, path) as video:
            times_s, film = video.info.times_s, video.info.path
        known, p = self.at(times_s - self.late_s)
        p = p[:, [JOINTS.index(_part_of(name)) for name in KEYPOINTS]] + self.t_camera_truth
        sure, poses = np.ones(len(KEYPOINTS)), {}
        for frame, p_camera in zip(np.flatnonzero(known).tolist(), p, strict=True):
            uv = self.lens.project(p_camera)
            axes = landmark_axes(camera, uv, sure > 0)
            hips = [KEYPOINTS.index(f"{side}_hip") for side in SIDES]
            about_hips = (p_camera - p_camera[hips].mean(axis=0)) @ axes
            poses[frame] = first_pose(joints, camera, uv, sure, about_hips)
        clip = of_poses(self.name, film, session, poses)
        names = sorted(set(clip.places) - {"head_top"})
        seen = {f: {n: at[n] for n in names} for f, at in clip.seen.items()}
        places = {n: clip.places[n] for n in names}
        return replace(clip, seen=seen, places=places)


def _part_of(keypoint: str) -> str:
    """The part that begins at a joint of keypoints."""
    side, _, joint = keypoint.partition("_")
    return f"{side}_{JOINT_OF_PART[joint]}"


def markers(report: Report) -> None:
    """The whole group."""
    report.note("12 joints, the whole clip turned onto the truth about the hips; Procrustes: each")
    report.note("frame by itself, scaled; rigid: the clip as one, hips and all; across, along: rms")
    report.note("in the view; hips, shoulders: mean turn of their line in the horizontal, degrees;")
    report.note("feet: mean degrees between the lines from heel to toe")
    report.note("a minute of a hand: where the review and N lead, by the times of `bench effort`;")
    report.note(
        "as the hand sees it: bones of the body's lengths, which point as the truth has them"
    )
    table = report.table("against markers", *COLUMNS, wide=COLUMNS)
    work = report.table("what a minute of a hand is spent on", *SPENT, wide=SPENT)
    for found in (opencap_walk, opencap_squat, person):
        with contextlib.suppress(Absent):
            _film(found(), table, work)


def _film(film: Film, table: Table, work: Table) -> None:
    for name, path in (film.rivals or {}).items():
        times_s, p = _opensim(path)
        known, truth = film.at(times_s)
        table.row(f"{film.name}, {name}", *(f"{v:.1f}" for v in _figures(p[known], truth)))
    before, after, hands = [], [], []
    for seed, box in enumerate(_boxes(film)):
        with TemporaryDirectory() as folder:
            session = run_film(film, box, Path(folder))
            before.append(_measured(film, session))
            _command("stand", str(session))
            after.append(_measured(film, session))
            hands.append(_after_a_minute(film, session, seed))
    table.row(f"{film.name}, tracked", *_over(before))
    stood, most = _over(after), film.expected
    expected = [
        Expected("root-relative", stood[0].median, most.root_relative_mm, "mm"),
        Expected("rigid", stood[2].median, most.rigid_mm, "mm"),
        Expected("along", stood[4].median, most.along_over_across * stood[3].median, "mm"),
        Expected("hips", stood[5].median, most.hips_deg, "deg"),
        Expected("knees", stood[7].median, most.knees_deg, "deg"),
    ]
    table.row(f"{film.name}, stood", *stood, expected=expected)
    _minute(film, table, work, hands, stood)


@dataclass(frozen=True)
class AfterAMinute:
    """What a person did in a minute, the figures of the motion then, and those of all frames as
    they see them: what is left of these nobody can mend."""

    done: Worked
    figures: list[float]
    least: list[float]


def _after_a_minute(film: Film, session: Path, seed: int) -> AfterAMinute:
    clip = film.watched(session)
    done = worked(noisy(clip, SEEN_PX, seed), session, seed)
    _command("track", str(session))
    _command("stand", str(session))
    return AfterAMinute(done, _measured(film, session), _figures_of(film, clip))


def _figures_of(film: Film, clip: Watched) -> list[float]:
    """Of the poses as a person understands them."""
    frames = sorted(clip.poses)
    skeleton = Skeleton.of(clip.session.subject.body)
    poses = [clip.poses[frame] for frame in frames]
    Rs = np.stack([pose.Rs_parent_part for pose in poses])
    motion = Trajectory(frames[0], Rs, np.stack([pose.p_camera_root for pose in poses]))
    with Video.open(clip.video) as video:
        times_s = video.info.times_s[frames]
    _, truth = film.at(times_s - film.late_s)
    return _figures(_points(skeleton, motion), truth)


def _minute(
    film: Film, table: Table, work: Table, hands: Sequence[AfterAMinute], stood: list[Over]
) -> None:
    """Rows of what a minute of a hand brings, what it was spent on, and what is left at best."""
    found = _over([hand.figures for hand in hands])
    expected = [Expected("root-relative", found[0].median, film.expected.by_hand_mm, "mm")]
    table.row(f"{film.name}, a minute of a hand", *found, expected=expected)
    table.row(f"{film.name}, as the hand sees it", *_over([hand.least for hand in hands]))
    spent = [
        [
            stood[0].median - hand.figures[0],
            hand.done.offered,
            hand.done.looked,
            hand.done.wrong,
            hand.done.keyframes,
            *(hand.done.effort.count(kind) for kind in KINDS[:4]),
            hand.done.effort.seconds,
        ]
        for hand in hands
    ]
    work.row(film.name, *_over(spent))


def _boxes(film: Film) -> Iterator[tuple[float, ...]]:
    """The box, and boxes whose edges are disturbed."""
    assert film.box is not None
    rng = np.random.default_rng(0)
    height = film.box[3] - film.box[1]
    for n in range(BOXES):
        edges = np.array(film.box) + (n > 0) * DISTURBED * height * rng.normal(size=4)
        yield tuple(round(float(edge), 1) for edge in edges)


def run_film(film: Film, box: Sequence[float] | None, folder: Path) -> Path:
    """Turn a film into motion that does not stand yet; the session's file."""
    more = () if film.frames is None else ("--frames", film.frames)
    if box is not None:
        more = (*more, "--box", ",".join(map(str, box)), "--frame", str(film.frame))
    _command(
        "run",
        str(film.video),
        "--out",
        str(folder),
        "--field-of-view",
        str(film.view_deg),
        "--height",
        str(film.height_cm),
        "--stand",
        "no",
        *more,
    )
    return next(folder.glob("*.keypose")) / "session.json"


def _command(*words: str) -> None:
    """A command, without what it prints."""
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        main(words)


def _measured(film: Film, path: Path) -> list[float]:
    times_s, p_camera = joints_of(path)
    known, truth = film.at(times_s - film.late_s)
    return _figures(p_camera[known], truth)


def joints_of(path: Path) -> tuple[Array, Array]:
    """Of a session's motion the seconds (F,) and, in the camera's frame, the twelve joints with
    heels and toes (F, 16, 3)."""
    session = load_session(path)
    found = load_results(session, path).fitting(session)
    motion = joined([found[span].trajectory for span in sorted(found)])
    skeleton = Skeleton.of(session.subject.body)
    with open_video_of(session, path) as video:
        times_s = video.info.times_s[motion.first_frame : motion.last_frame + 1]
    return times_s, _points(skeleton, motion)


def _points(skeleton: Skeleton, motion: Trajectory) -> Array:
    """(F, 16, 3) the twelve joints of a motion, with heels and toes."""
    names = joint_names(skeleton)
    p = motion.joints(skeleton)[:, [names.index(name) for name in JOINTS]]
    Ts = motion.transforms(skeleton)
    for side in SIDES:
        part = skeleton.body.index(f"{side}_foot")
        ends = [
            skeleton.body.parts[part].landmarks[name] for name in (f"{side}_heel", f"{side}_toe")
        ]
        there = np.array(ends) @ np.swapaxes(Ts[:, part, :3, :3], -1, -2) + Ts[:, part, None, :3, 3]
        p = np.concatenate([p, there], axis=1)
    return np.asarray(p)


def _over(figures: Sequence[Sequence[float]]) -> list[Over]:
    return [Over(tuple(values)) for values in zip(*figures, strict=True)]


def _figures(p: Array, truth: Array) -> list[float]:
    """The figures of a motion, (F, 16, 3) in any axes, beside the truth in the camera's."""
    feet, true_feet = p[:, 12:], truth[:, 12:]
    p, truth = p[:, :12], truth[:, :12]
    about, true = about_hips(p), about_hips(truth)
    R = onto(about, true)
    turned = about @ R.T
    off = turned - true
    rigid = _turned_onto(p - p.mean((0, 1)), truth - truth.mean((0, 1))) - truth
    rigid += truth.mean((0, 1))
    return [
        1000 * float(np.linalg.norm(off, axis=-1).mean()),
        1000 * float(np.mean([_procrustes(a, b) for a, b in zip(p, truth, strict=True)])),
        1000 * float(np.linalg.norm(rigid, axis=-1).mean()),
        1000 * float(np.sqrt((off[..., :2] ** 2).sum(-1).mean())),
        1000 * float(np.sqrt((off[..., 2] ** 2).mean())),
        _line_deg(turned, true, HIPS),
        _line_deg(turned, true, SHOULDERS),
        _bent_deg(p, truth, KNEES),
        _bent_deg(p, truth, ELBOWS),
        _apart_deg(_soles(feet @ R.T), _soles(true_feet)),
    ]


def _soles(feet: Array) -> Array:
    """(F, 2, 3) from heel to toe of both feet."""
    return np.asarray(feet[:, 1::2] - feet[:, ::2])


def _apart_deg(a: Array, b: Array) -> float:
    """Mean degrees between directions."""
    cosine = (a * b).sum(-1) / np.linalg.norm(a, axis=-1) / np.linalg.norm(b, axis=-1)
    return float(np.nanmean(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))))


def about_hips(p: Array) -> Array:
    return np.asarray(p - p[:, HIPS].mean(axis=1, keepdims=True))


def _turned_onto(p: Array, truth: Array) -> Array:
    """All points, turned by the one rotation that brings them nearest to the truth."""
    return np.asarray(p @ onto(p, truth).T)


def onto(p: Array, truth: Array) -> Array:
    """(3, 3) the rotation that brings points nearest to the truth."""
    R = Rotation.align_vectors(truth.reshape(-1, 3), p.reshape(-1, 3))[0]
    return np.asarray(R.as_matrix())


def _procrustes(p: Array, truth: Array) -> float:
    """Mean metres of one frame after the best rotation, place and scale."""
    a, b = p - p.mean(axis=0), truth - truth.mean(axis=0)
    turned = _turned_onto(a, b)
    scale = float((turned * b).sum() / (turned**2).sum())
    return float(np.linalg.norm(scale * turned - b, axis=-1).mean())


def _line_deg(p: Array, truth: Array, ends: tuple[int, int]) -> float:
    """Mean degrees between two joints' lines as seen from above, the camera's x and z."""
    a, b = (q[:, ends[1]] - q[:, ends[0]] for q in (p, truth))
    turn = np.arctan2(a[:, 2], a[:, 0]) - np.arctan2(b[:, 2], b[:, 0])
    return float(np.degrees(np.abs((turn + np.pi) % (2 * np.pi) - np.pi)).mean())


def _bent_deg(p: Array, truth: Array, joints: Sequence[tuple[int, int, int]]) -> float:
    """Mean degrees by which these joints are bent more or less than they were."""
    return float(np.mean([np.abs(angles_deg(p, *j) - angles_deg(truth, *j)) for j in joints]))


def angles_deg(p: Array, above: int, joint: int, below: int) -> Array:
    a, b = p[:, above] - p[:, joint], p[:, below] - p[:, joint]
    cosine = (a * b).sum(-1) / np.linalg.norm(a, axis=-1) / np.linalg.norm(b, axis=-1)
    return np.asarray(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))))


def _at(times_s: Array, known_s: Array, p: Array) -> Array:
    """Points (F, J, 3) at other times."""
    flat = p.reshape(len(p), -1)
    found = [np.interp(times_s, known_s, values) for values in flat.T]
    return np.stack(found, axis=-1).reshape(len(times_s), *p.shape[1:])


# --- the films


def opencap_walk() -> Film:
    return _opencap("walk", 163.5, (360, 550, 626, 1023), 25, None, Expectation(42.0))


def opencap_squat() -> Film:
    return _opencap("squat", 171.6, (148, 547, 475, 1130), 269, "0-330", Expectation(55.0))


def _opencap(
    name: str,
    height_cm: float,
    box: tuple[float, float, float, float],
    frame: int,
    frames: str | None,
    expected: Expectation,
) -> Film:
    """A film of one phone with markers; Absent when it is not here."""
    folder = DATA / "opencap" / name
    if not folder.is_dir():
        raise Absent(f"the data folder 'opencap/{name}' beside the checkout")
    times_s, p = _opensim(folder / "mocap.json")
    solved = json.loads((folder / "camera_solved.json").read_text())
    R, t = (np.array(solved[key]) for key in ("R_camera_ground", "t_camera_ground_m"))
    lens = Camera(**{key: solved[key] for key in ("width", "height", "fx", "fy", "cx", "cy")})
    rivals = {"OpenCap Monocular": folder / "mono.json", "WHAM": folder / "wham.json"}
    return Film(
        name,
        folder / "video.mp4",
        PHONE_DEG,
        height_cm,
        box,
        frame,
        frames,
        R,
        times_s,
        p,
        expected,
        lens,
        t,
        LATE_S,
        rivals,
    )


def _opensim(path: Path) -> tuple[Array, Array]:
    """Seconds (F,) and joints with heels and toes (F, 16, 3), metres, of a motion of OpenSim's
    model."""
    motion: dict[str, Any] = json.loads(path.read_text())
    p = [np.array(motion["bodies"][bone]["translation"]) for bone in OPENSIM]
    return np.array(motion["time"]), np.stack(p, axis=1)


def person() -> Film:
    """The man on the balance beam, whom four cameras measured."""
    folder = data_folder("person")
    video, camera, names, joints = person_reference(folder)
    p = joints[:, [names.index(name) for name in BODY_25]]
    view_deg = 2 * np.degrees(np.arctan(camera.height / 2 / camera.fy))
    return Film(
        "person",
        folder / video,
        round(float(view_deg), 2),
        169.1,
        (118, 184, 402, 658),
        33,
        None,
        np.eye(3),
        np.arange(len(p)) / 60.0,
        p,
        Expectation(60.0),
        camera,
        np.zeros(3),
    )
