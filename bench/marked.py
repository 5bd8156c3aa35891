"""Real people: their marked joints, and the body sized and posed on them."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from bench.keeping import ROOT, data_folder, digest, place_for
from bench.measured_person import person_reference
from bench.posing import MARKS, Marked, fit
from keypose.tracker.body.body import Body, preset
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.evaluate import JointReference
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.posed import BodyPoint

FITTED_FROM = ("body", "geometry")


@dataclass(frozen=True, eq=False)
class Person:
    """A clip, the sized body and its pose at every marked frame.

    marks: joints marked in the picture.  space: rough joints in metres, where they are known.
    """

    video: Path
    camera: Camera
    skeleton: Skeleton
    poses: dict[int, Pose]
    marks: JointReference
    space: JointReference | None = None


@dataclass(frozen=True, eq=False)
class _Given:
    """What a clip's folder holds."""

    folder: Path
    video: str
    camera: Camera
    marked: list[Marked]
    body: Body
    depth_m: float


def load_person() -> Person:
    """The man on the balance beam."""
    folder = data_folder("person")
    video, camera, names, joints = person_reference(folder)
    known = {n: joints[:, names.index(n)] for n in (*MARKS, "Head") if n in names}
    given = _Given(
        folder, video, camera, _marked(folder, known), preset("adult_male"),
        float(np.nanmean(joints[0, :, 2])),
    )  # fmt: skip
    person = _posed(given)
    limbs = [n for n in MARKS if n in names]
    places = tuple(_place(person.skeleton.body, n) for n in limbs)
    positions = np.stack([known[n] for n in limbs], axis=1)
    space = JointReference(tuple(limbs), places, positions, np.arange(len(positions)))
    return replace(person, space=space)


def load_walk() -> Person:
    """The woman who walks from right to left; about as far away as she is tall in the picture."""
    folder = data_folder("walk")
    K = _json(folder / "meta.json")["K"]
    camera = Camera(width=960, height=540, fx=K[0][0], fy=K[1][1], cx=K[0][2], cy=K[1][2])
    marked = _marked(folder, {})
    return _posed(_Given(folder, "walk_960x540.mp4", camera, marked, preset("adult_female"), 10.5))


def _json(path: Path) -> Any:
    return json.loads(path.read_text(encoding="utf-8"))


def _marked(folder: Path, known: dict[str, Array]) -> list[Marked]:
    frames = _json(folder / "marked_joints.json")["frames"]
    return [
        Marked(
            int(frame),
            {name: (float(u), float(v)) for name, (u, v) in joints.items()},
            {n: tuple(p[int(frame)]) for n, p in known.items() if np.isfinite(p[int(frame)]).all()},
        )
        for frame, joints in frames.items()
    ]


def _posed(given: _Given) -> Person:
    """Sized and posed on all marked frames together, which takes a minute, or as kept of it."""
    sources = [ROOT / "tracker" / name for name in FITTED_FROM]
    inputs = [given.folder / "meta.json", given.folder / "marked_joints.json"]
    key = digest(ROOT / "bench" / "posing.py", *sources, *inputs)
    place = place_for(f"posed-{given.folder.name}", key, ".npz")
    if not place.is_file():
        posed = fit(given.body, given.camera, given.marked, given.depth_m)
        frames = [m.frame for m in given.marked]
        np.savez(
            place,
            body=posed.skeleton.body.model_dump_json(),
            frames=frames,
            Rs=np.stack([posed.poses[f].Rs_parent_part for f in frames]),
            ps=np.stack([posed.poses[f].p_camera_root for f in frames]),
        )
    with np.load(place) as kept:
        skeleton = Skeleton.of(Body.model_validate_json(str(kept["body"])))
        poses = zip(kept["frames"].tolist(), kept["Rs"], kept["ps"], strict=True)
        by_frame = {frame: Pose(R, p) for frame, R, p in poses}
    marks = _marks(skeleton.body, given.marked)
    return Person(given.folder / given.video, given.camera, skeleton, by_frame, marks)


def _marks(body: Body, marked: list[Marked]) -> JointReference:
    names = sorted({name for m in marked for name in m.uv})
    nowhere = (np.nan, np.nan)
    positions = np.array([[m.uv.get(name, nowhere) for name in names] for m in marked])
    frames = np.array([m.frame for m in marked])
    return JointReference(tuple(names), tuple(_place(body, n) for n in names), positions, frames)


def _place(body: Body, name: str) -> BodyPoint:
    """Where on the body a mark lies, as it was posed."""
    if name == "hip":
        return tuple((body.index(f"{side}_thigh"), (0.0, 0.0, 0.0)) for side in ("left", "right"))
    if name == "Head":
        head = body.index("head")
        return ((head, next(iter(body.parts[head].landmarks.values()))),)
    return ((body.index(MARKS[name]), (0.0, 0.0, 0.0)),)
