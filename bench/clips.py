"""Real clips: what was marked on them, and what else a person would know before posing them.

Of a clip are known its camera, which preset resembles the person, roughly which way the person
faces, and where a foot stands still. `space` is for measuring alone and never used for posing.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any, TypeAlias
from xml.etree import ElementTree
from zipfile import ZipFile

import numpy as np

from bench.keeping import Absent, data_folder, kept_folder
from keypose.sample_videos.posing import MARKS
from keypose.tracker.body.body import Body, preset
from keypose.tracker.evaluate import JointReference
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.posed import BodyPoint

Marks: TypeAlias = Mapping[int, Mapping[str, tuple[float, float]]]

MORE_MARKS = Path(__file__).with_name("real_marks.json")
ARMS_MARKS = Path(__file__).with_name("arms_marks.json")
SAME_MARK = 0.015
"""A share of the person's height: a joint counts as marked where no pass is farther than that from
their mean."""
TALL = {"person": 405.0, "walk": 216.0, "arms": 265.0}
"""Pixels of the standing person."""
WHEEL = "pose2sim-0.10.49-py3-none-any.whl"


@dataclass(frozen=True)
class Stance:
    """A joint that stands still, from one frame to another, both included."""

    joint: str
    first: int
    last: int


@dataclass(frozen=True, eq=False)
class Clip:
    """A real clip.

    marks: pixels (u, v) by frame and name.  also_posed: points marked for posing alone.
    facing_deg: turn about the camera's y axis from facing the camera.
    space: names and rough joints (F, J, 3), metres, camera frame, of every frame.
    """

    name: str
    video: Path
    camera: Camera
    body: Body
    facing_deg: float
    marks: Marks
    stances: tuple[Stance, ...]
    also_posed: Marks = field(default_factory=dict)
    space: tuple[tuple[str, ...], Array] | None = None

    def posed_on(self, frame: int) -> dict[str, tuple[float, float]]:
        """What a keyframe is posed on."""
        return {**self.marks[frame], **self.also_posed.get(frame, {})}

    def reference(self, body: Body) -> JointReference:
        """The marks, on a body sized for them."""
        names = tuple(sorted({name for joints in self.marks.values() for name in joints}))
        frames = sorted(self.marks)
        nowhere = (np.nan, np.nan)
        uv = np.array([[self.marks[f].get(name, nowhere) for name in names] for f in frames])
        return JointReference(names, tuple(place(body, n) for n in names), uv, np.array(frames))


def place(body: Body, name: str) -> BodyPoint:
    """Where on the body a mark lies: one point of one part, so that sizes move it along.

    "hip" is the middle between the hips, on the root.
    """
    if name == "hip":
        thighs = [body.parts[body.index(f"{side}_thigh")].joint_m for side in ("left", "right")]
        x, y, z = np.mean(thighs, axis=0).tolist()
        return ((0, (x, y, z)),)
    if name == "Head":
        head = body.index("head")
        return ((head, next(iter(body.parts[head].landmarks.values()))),)
    if name in MARKS:
        return ((body.index(MARKS[name]), (0.0, 0.0, 0.0)),)
    landmarks = {n: (i, p) for i, part in enumerate(body.parts) for n, p in part.landmarks.items()}
    return (landmarks[name],)


@cache
def clip(name: str) -> Clip:
    """A clip by its name; Absent when its folder is not here."""
    clips = {"person": _person, "walk": _walk, "arms": _arms, "camera4": _camera4}
    return clips[name]()


def _person() -> Clip:
    """The man on the balance beam, seen from behind."""
    folder = data_folder("person")
    video, camera, names, joints = person_reference(folder)
    limbs = tuple(n for n in MARKS if n in names)
    space = limbs, joints[:, [names.index(n) for n in limbs]]
    marks = _marked("person", folder / "marked_joints.json")
    still = (Stance("LAnkle", 0, 75),)
    also = _pixels(_json(MORE_MARKS)["also_posed"]["person"])
    return Clip(
        "person", folder / video, camera, preset("adult_male"), 150.0, marks, still, also, space
    )


def person_reference(folder: Path) -> tuple[str, Camera, list[str], Array]:
    """Of the man on the balance beam: his video's name, its camera, the joints that were measured
    beside it, and where they were: (frames, joints, 3), metres, camera frame."""
    meta = _json(folder / "meta.json")
    lens, K = meta["camera"], meta["camera"]["K"]
    camera = Camera(
        width=lens["width"],
        height=lens["height"],
        fx=K[0][0],
        fy=K[1][1],
        cx=K[0][2],
        cy=K[1][2],
        distortion=(*lens["dist_k1k2p1p2"], 0.0),
    )
    with np.load(folder / "reference.npz") as reference:
        names, world = [str(n) for n in reference["names"]], reference["xyz_world"]
    joints = world @ np.array(lens["R_world_to_cam"]).T + np.array(lens["t_world_to_cam_m"])
    return meta["video"], camera, names, joints


def _walk() -> Clip:
    """The woman who walks from right to left."""
    folder = data_folder("walk")
    K = _json(folder / "meta.json")["K"]
    camera = Camera(width=960, height=540, fx=K[0][0], fy=K[1][1], cx=K[0][2], cy=K[1][2])
    marks = _marked("walk", folder / "marked_joints.json")
    still = (Stance("LAnkle", 40, 55), Stance("RAnkle", 57, 70))
    video = folder / "walk_960x540.mp4"
    return Clip("walk", video, camera, preset("adult_female"), 90.0, marks, still)


def _arms() -> Clip:
    """A woman on one leg who raises both arms; the camera is guessed."""
    video, side = data_folder("arms") / "arms_576x576.mp4", 576
    marks = _marked("arms", ARMS_MARKS)
    still = (Stance("LAnkle", 20, 60),)
    return Clip("arms", video, Camera.guess(side, side), preset("adult_female"), 0.0, marks, still)


def _camera4() -> Clip:
    """The man on the balance beam from a camera at his other side, twice as large.

    Its marks are the rough joints of four views, seen by this camera, good to about 10 px, which
    are 5 px of the smaller film.
    """
    video, camera, limbs, joints = beam_camera(4)
    marks = {
        frame: dict(zip(limbs, map(tuple, camera.project(joints[frame]).tolist()), strict=True))
        for frame in range(0, 91, 15)
    }
    still, man = (Stance("LAnkle", 0, 75),), preset("adult_male")
    return Clip("camera4", video, camera, man, -147.0, marks, still, space=(limbs, joints))


def beam_camera(number: int) -> tuple[Path, Camera, tuple[str, ...], Array]:
    """The man on the balance beam from one of four cameras, 1 to 4: film, camera, and names and
    rough joints (F, J, 3), metres, camera frame. Films and calibration are upstream's."""
    wheel, films = kept_folder() / WHEEL, "Pose2Sim/Demo_SinglePerson/"
    if not wheel.is_file():
        raise Absent(f"{wheel} (pip download --no-deps pose2sim==0.10.49)")
    video = kept_folder() / f"camera{number}.mp4"
    with ZipFile(wheel) as packed:
        video.write_bytes(packed.read(f"{films}videos/cam{number:02}.mp4"))
        rig = ElementTree.fromstring(packed.read(films + "calibration/Calib.qca.txt"))
    one = next(c for c in rig.iter("camera") if c.get("serial") == f"cam{number:02}")
    camera, R_camera_world, p_world_camera = _calibrated(one, _WIDTHS[number])
    with np.load(data_folder("person") / "reference.npz") as reference:
        names, world = [str(n) for n in reference["names"]], reference["xyz_world"]
    joints = (world - p_world_camera) @ R_camera_world.T
    limbs = tuple(n for n in MARKS if n in names)
    return video, camera, limbs, joints[:, [names.index(n) for n in limbs]]


_CALIBRATED_WIDTH = 1088
_WIDTHS = {1: 1080, 2: 1080, 3: 1088, 4: 1088}
"""Of the films: the narrower ones lack as much on either side."""


def _calibrated(one: ElementTree.Element, width: int) -> tuple[Camera, Array, Array]:
    """Camera, R_camera_world, and where the camera stands, metres, of an entry of a QTM file: axes
    there are right, up and back, places millimetres, and pixels 64ths."""
    lens, placed = (one.find(name) for name in ("intrinsic", "transform"))
    assert lens is not None
    assert placed is not None
    values = {name: float(value) for name, value in (lens.attrib | placed.attrib).items()}
    names = [f"r{row}{column}" for row in (1, 2, 3) for column in (1, 2, 3)]
    R = np.diag([1.0, -1.0, -1.0]) @ np.reshape([values[name] for name in names], (3, 3))
    k1, k2 = values["radialDistortion1"], values["radialDistortion2"]
    p1, p2 = values["tangentalDistortion1"], values["tangentalDistortion2"]
    camera = Camera(
        width=width,
        height=1920,
        fx=values["focalLengthU"] / 64,
        fy=values["focalLengthV"] / 64,
        cx=values["centerPointU"] / 64 - (_CALIBRATED_WIDTH - width) / 2,
        cy=values["centerPointV"] / 64,
        distortion=(k1, k2, p1, p2, 0.0),
    )
    return camera, R, np.array([values[name] for name in "xyz"]) / 1000


def _marked(name: str, path: Path) -> Marks:
    """A clip's marks: those beside its film, those marked once, and the means of several passes."""
    more = _json(MORE_MARKS)
    marks = {int(f): dict(js) for f, js in {**_json(path)["frames"], **more[name]}.items()}
    for frame, joints in passes(name).items():
        means = {joint: tuple(uv.mean(axis=0)) for joint, uv in joints.items()}
        marks[frame] = {**marks.get(frame, {}), **means}
    return _pixels(marks)


def passes(name: str) -> dict[int, dict[str, Array]]:
    """By frame and joint the marks (P, 2) of those who marked it, where they agree on it."""
    found = {
        int(frame): {joint: np.array(uv) for joint, uv in joints.items()}
        for frame, joints in _json(MORE_MARKS)["passes"][name].items()
    }
    most = SAME_MARK * TALL[name]
    return {f: {j: uv for j, uv in js.items() if _agree(uv, most)} for f, js in found.items()}


def _agree(uv: Array, most_px: float) -> bool:
    return len(uv) > 1 and float(np.linalg.norm(uv - uv.mean(axis=0), axis=1).max()) <= most_px


def _pixels(frames: Mapping[Any, Mapping[str, Any]]) -> Marks:
    return {
        int(frame): {joint: (float(u), float(v)) for joint, (u, v) in joints.items()}
        for frame, joints in frames.items()
    }


def _json(path: Path) -> Any:
    return json.loads(path.read_text(encoding="utf-8"))
