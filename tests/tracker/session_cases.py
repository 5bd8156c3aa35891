"""A small session on disk, its video a folder of images, and a result a tracker might find."""

from __future__ import annotations

import json
import math
from collections import UserDict
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from keypose.tracker.body.body import Body, Part
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.shapes import Box, Cylinder
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory, interpolate
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import exp_rotation, rotation_from_euler
from keypose.tracker.session import Keyframe, Session, TrackSettings, VideoReference
from keypose.tracker.session.schema import PART_OF
from keypose.tracker.session.verdict import GOOD, Kind, Verdict
from keypose.tracker.storage.files import save_session
from keypose.tracker.tracking.result import Diagnostics, SegmentResult, TrackResult
from keypose.tracker.video import Video

WIDTH = 64
HEIGHT = 48
FRAMES = 9
KEYFRAMES = (0, 4, 8)
CAMERA = Camera(width=WIDTH, height=HEIGHT, fx=60.0, fy=60.0, cx=31.5, cy=23.5)


def body() -> Body:
    """A trunk with two arms, one of which has a hand with two named points."""
    trunk = Part(
        name="trunk",
        shape=Box(low_m=(-0.2, -0.3, -0.1), high_m=(0.2, 0.3, 0.1)),
        tracked=("tx", "ty", "tz", "rx", "ry", "rz"),
    )
    arm = Part(
        name="left_arm",
        parent="trunk",
        joint_m=(0.25, -0.2, 0.02),
        shape=Cylinder(end_m=0.4, radius_m=0.05),
        tracked=("rx", "rz"),
    )
    other = Part(
        name="right_arm",
        parent="trunk",
        joint_m=(-0.25, -0.2, 0.02),
        shape=Cylinder(end_m=-0.4, radius_m=0.05),
    )
    hand = Part(
        name="left_hand",
        parent="left_arm",
        joint_m=(0.0, 0.4, 0.01),
        shape=Box(low_m=(-0.04, 0.0, -0.02), high_m=(0.04, 0.18, 0.02)),
        landmarks={"thumb": (0.05, 0.1, 0.0), "tip": (0.0, 0.18, 0.03)},
    )
    return Body(name="small", parts=(trunk, other, arm, hand))


SKELETON = Skeleton.of(body())


def pose(share: float) -> Pose:
    """A pose that turns every part and moves the root as `share` grows."""
    turns = np.outer(np.arange(1, 5), [0.3, -0.2, 0.5]) * share * 0.4
    return Pose(exp_rotation(turns), np.array([0.1 * share, -0.05, 3.0 + 0.3 * share]))


def write_frames(folder: Path, brightness: int = 100) -> Path:
    """The video: a folder of images of some texture that wanders."""
    folder.mkdir(parents=True)
    texture = np.random.default_rng(0).integers(0, 60, (HEIGHT, WIDTH, 3))
    for i in range(FRAMES):
        picture = np.roll(texture, i, axis=1) + brightness
        good, content = cv2.imencode(".png", picture.astype(np.uint8))
        assert good
        (folder / f"{i:03}.png").write_bytes(content.tobytes())
    return folder


def session(video: Path | None = None, keyframes: tuple[int, ...] = KEYFRAMES) -> Session:
    """A session of the body; its video's fingerprint is known when the video is given."""
    fingerprint = ""
    if video is not None:
        with Video.open(video) as opened:
            fingerprint = opened.fingerprint()
    return Session.begin(
        video=VideoReference(
            path="frames",
            fingerprint=fingerprint,
            frame_count=FRAMES,
            width=WIDTH,
            height=HEIGHT,
        ),
        camera=CAMERA,
        body=body(),
        keyframes=tuple(
            Keyframe.of(SKELETON, pose(frame / FRAMES), frame, frame / 25) for frame in keyframes
        ),
    )


def write_session(folder: Path, keyframes: tuple[int, ...] = KEYFRAMES) -> Path:
    """The session file beside its video."""
    video = write_frames(folder / "frames")
    path = folder / "session.json"
    save_session(session(video, keyframes), path)
    return path


class Fields(UserDict[str, Any]):
    """The JSON of a session by the names of its fields, whichever of view, body and world they are
    of; in files of older versions they stand side by side."""

    def part(self, name: str) -> Any:
        places = {"view": ("views", 0), "subject": ("bodies", 0), "world": ("world",)}
        part: Any = self.data
        if "views" not in part:
            return part
        for step in places.get(PART_OF.get(name, "session"), ()):
            part = part[step]
        return part

    def __getitem__(self, name: str) -> Any:
        return self.part(name)[name]

    def __setitem__(self, name: str, value: Any) -> None:
        self.part(name)[name] = value

    def __delitem__(self, name: str) -> None:
        del self.part(name)[name]

    def __contains__(self, name: object) -> bool:
        return name in self.part(str(name))


def written(path: Path) -> Fields:
    """What a session's file holds."""
    fields = Fields()
    fields.data = json.loads(path.read_text("utf-8"))
    return fields


def flat(session: Session) -> dict[str, Any]:
    """The JSON of a session's fields by their names: `Session.begin` makes it of them again."""
    fields = Fields()
    fields.data = session.model_dump(mode="json")
    return {name: fields[name] for name in PART_OF if name in fields}


def flat_data(session: Session, version: int) -> dict[str, Any]:
    """The JSON of a session as versions 1 to 3 had it: its fields side by side."""
    fields = {"schema_version": version} | flat(session) | {"schema_version": version}
    if "up_world" in fields:
        fields["up_camera"] = fields.pop("up_world")
    return fields


def altered(path: Path, change: Any) -> Path:
    """The session file after `change(data)` on its JSON, written as a person would."""
    fields = written(path)
    change(fields)
    data = fields.data
    path.write_text(json.dumps(data), encoding="utf-8")
    return path


VERDICTS: Mapping[Kind, Verdict] = {
    "good": GOOD,
    "check": Verdict.check("diverged", (0, 4)),
    "lost": Verdict.not_followed(2),
}


def segment(first: int, last: int, kind: Kind = "good", bend: float = 0.1) -> SegmentResult:
    """A tracked segment: interpolation, bent between its keyframes."""
    straight = interpolate(pose(first / FRAMES), pose(last / FRAMES), first, last)
    shares = np.sin(np.linspace(0, np.pi, last - first + 1))
    bends = np.stack([rotation_from_euler(0.0, 0.0, bend * s) for s in shares])
    bends[0] = bends[-1] = np.eye(3)
    trajectory = Trajectory(
        first, straight.Rs_parent_part @ bends[:, None], straight.ps_camera_root
    )
    steps, parts, dofs = last - first, SKELETON.part_count, SKELETON.dof_count
    observability = np.full((steps, parts), 0.5)
    observability[:, 1] = np.nan
    return SegmentResult(
        trajectory=trajectory,
        scores=(3.0, 2.0, float("nan")),
        steps=("start", "pass 1", "pass 2"),
        best_pass=1,
        closing_error=1e-12,
        verdict=VERDICTS[kind],
        diagnostics=Diagnostics(
            rank=np.full(steps, 7),
            singular_values=np.arange(steps * dofs, dtype=float).reshape(steps, dofs),
            observability=observability,
            residual=np.full((steps, parts), 2.5),
        ),
    )


def result(*segments: SegmentResult) -> TrackResult:
    """A result of these segments; of both when none is given."""
    return TrackResult(SKELETON, TrackSettings(), segments or (segment(0, 4), segment(4, 8)))


def motion(skeleton: Skeleton, frames: int = 5, first: int = 7, size: float = 3.0) -> Trajectory:
    """Rotations of every kind, also past a right angle, about axes of every direction."""
    rng = np.random.default_rng(4)
    turns = rng.uniform(-size, size, (frames, skeleton.part_count, 3)) / math.sqrt(3)
    ps = rng.normal((0.3, -0.2, 4.0), size=(frames, 3))
    return Trajectory(first, exp_rotation(turns), ps)
