"""The man on the balance beam, filmed by two of four cameras, and his joints by all four.

They are 15 to 25 mm good and run ahead of the films by the better part of a frame. The published
calibration misses its own films by a degree or two, so each camera is refined by its film's
keypoints of the whole motion.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from functools import cached_property
from io import StringIO
from pathlib import Path
from typing import Final
from xml.etree import ElementTree

import numpy as np
from scipy.optimize import least_squares

from bench.keeping import DATA, ROOT, Absent
from keypose.app.cli.main import main
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.films.sightings import Sightings
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.film_clock import sampled
from keypose.tracker.geometry.rotations import Array, exp_rotation
from keypose.tracker.keypoints.keypoints import JOINTS, Keypoints
from keypose.tracker.keypoints.on_body import points_on_body
from keypose.tracker.solver.fit_joints import fit_motion
from keypose.tracker.solver.posed import BodyPoints
from keypose.tracker.storage.files import load_session
from keypose.tracker.storage.sidecars import keypoints_of_session
from keypose.tracker.video import Video

FRAMES: Final = 100
FPS: Final = 60.0
AHEAD: Final = 0.7
"""Frames by which the measured joints run before the films."""
WIDTHS: Final = {2: 1080, 3: 1088}
SENSOR_WIDTH: Final = 1088
FIRST: Final = 3
BESIDE: Final = 2
_COCO: Final = "LShoulder RShoulder LElbow RElbow LWrist RWrist LHip RHip LKnee RKnee LAnkle RAnkle"


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
    def truth(self) -> Array:
        """(N, 12, 3) joints of the body that was fitted to what was measured."""
        return self.places.at(self.motion.transforms(self.skeleton))

    @cached_property
    def places(self) -> BodyPoints:
        """His joints on the body."""
        _, parts, points = points_on_body(self.skeleton.body, JOINTS)
        return BodyPoints.single(self.skeleton, parts, points)

    def errors_mm(self, motion: Trajectory, truth: Array) -> tuple[float, float]:
        """Mean distance of joints about the hips' middle, and in space, between the ends."""
        found = self.places.at(motion.transforms(self.skeleton))
        about = about_hips(found) - about_hips(truth)
        off = [np.linalg.norm(each, axis=-1)[1:-1].mean() for each in (about, found - truth)]
        return 1000 * float(off[0]), 1000 * float(off[1])


def about_hips(joints: Array) -> Array:
    hips = [JOINTS.index("left_hip"), JOINTS.index("right_hip")]
    return np.asarray(joints - joints[:, hips].mean(axis=1, keepdims=True))


def man_on_the_beam(folder: Path, numbers: Sequence[int] = (BESIDE, FIRST)) -> Man:
    """The man as the films of these numbers show him, the first one among them; drafted below a
    folder."""
    source, truth = DATA / "several", DATA / "person" / "reference.npz"
    if not source.is_dir() or not truth.is_file():
        raise Absent("the films of several cameras beside the checkout")
    reference = np.load(truth)
    names = [str(name) for name in reference["names"]]
    room = reference["xyz_world"][:, [names.index(name) for name in _COCO.split()]]
    room = sampled(room, np.clip(np.arange(FRAMES) - AHEAD, 0, FRAMES - 1))
    published = _published(source / "qca.txt")
    views, folders = {}, {}
    for number in numbers:
        film, out = source / f"single_cam0{number}.mp4", folder / f"film-{number}"
        quietly("draft", str(film), "--out", str(out))
        session = load_session(out / "session.json")
        keypoints = keypoints_of_session(session, out)
        assert keypoints is not None
        camera, T = published[number]
        views[number] = View(
            Video.open(film), camera, keypoints, _refined(camera, T, keypoints, room)
        )
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


def _refined(camera: Camera, T: Array, keypoints: Keypoints, room: Array) -> Array:
    """The camera moved to where its film shows known joints, from where it was published."""
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


def quietly(*words: str) -> None:
    """A command, whose words are shown only where it fails."""
    said = StringIO()
    with redirect_stdout(said), redirect_stderr(said):
        code = main(list(words))
    if code not in (0, 1):
        raise RuntimeError(said.getvalue())
