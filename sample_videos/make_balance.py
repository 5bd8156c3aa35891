"""Make the filmed sample anew:  python -m keypose.sample_videos.make_balance [cam03.mp4]

With the original clip named, it is first trimmed and halved; otherwise the clip stays as it is.
Then one body is sized and posed on the joints that were marked by hand in marks.json.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
from av.video.reformatter import Interpolation

from keypose.sample_videos.posing import HUMAN, Habit, Marked, Posed, fit
from keypose.tracker.body.body import Body, Point, preset
from keypose.tracker.body.modify import resized
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.session import Keyframe, Session, VideoReference
from keypose.tracker.session.settings import ALL_CUES, TrackSettings
from keypose.tracker.storage.atomic import write_file
from keypose.tracker.storage.files import session_json
from keypose.tracker.video import Video

FOLDER = Path(__file__).parent / "balance"
WIDTH, HEIGHT, FPS, FRAMES = 544, 960, 60, 61
CRF = 20
DEPTH_M = 3.5
"""About how far away the man is."""

# Upstream's calibration of cam03, for 1088 × 1920 pixels: its numbers are in 64ths of a pixel.
FOCAL = (107622.296875 / 64, 107616.632813 / 64)
CENTRE = (32845.335938 / 64, 61120.328125 / 64)
DISTORTION = (-0.046705, 0.137622, -0.000542, -0.000517, 0.0)
UP_CAMERA = (-0.0441, -0.913479, -0.40449)
"""The upright axis of the calibrated room."""

JOINTS = {
    "shoulder": "upper_arm",
    "elbow": "forearm",
    "wrist": "hand",
    "hip": "thigh",
    "knee": "shin",
    "ankle": "foot",
}
"""The part that begins at a marked joint."""

POINTS: Mapping[str, tuple[str, Point]] = {
    "chin": ("head", (0.0, 0.03, -0.095)),
    "c7": ("chest", (0.0, -0.42, 0.05)),
    "head_middle": ("head", (0.0, -0.05, 0.0)),
    "left_knuckles": ("left_hand", (0.0, 0.09, 0.0)),
    "right_knuckles": ("right_hand", (0.0, 0.09, 0.0)),
}
"""Marked points that the preset has no name for: their part, and where in it they are."""

THICKNESS = {"waist": 1.1, "left_thigh": 1.15, "left_shin": 1.12}
HAND_LENGTH = 0.75

HABITS: Mapping[str, Habit] = {
    **HUMAN,
    "neck": ((0, 0, 0), (15, 12, 15)),
    "head": ((0, 0, 0), (20, 40, 30)),
    "hand": ((0, 0, 0), (20, 15, 30)),
    "foot": ((0, 0, 0), (15, 15, 30)),
}
"""Head, hands and feet are marked here, so they need not stay near their rest."""


def main() -> None:
    video = FOLDER / "balance.mp4"
    if len(sys.argv) > 1:
        trim(Path(sys.argv[1]), video)
    content = session_json(session_of(video, pose(marks())))
    write_file(FOLDER / "session.json", content, overwrite=True)


def trim(original: Path, path: Path) -> None:
    """The first frames at half the size, pixels averaged two by two, without sound."""
    options = {"crf": str(CRF), "preset": "slower", "g": "30", "x264-params": "threads=1"}
    container = {"fflags": "+bitexact", "movflags": "+faststart"}
    with av.open(str(original)) as source, av.open(str(path), "w", options=container) as file:
        stream = file.add_stream("libx264", rate=FPS, options=options)
        stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, "yuv420p"
        stream.time_base = stream.codec_context.time_base = Fraction(1, FPS)
        for number, picture in zip(range(FRAMES), source.decode(video=0), strict=False):
            frame = picture.reformat(WIDTH, HEIGHT, "yuv420p", interpolation=Interpolation.AREA)
            frame.pts, frame.time_base, frame.pict_type = number, Fraction(1, FPS), 0
            file.mux(stream.encode(frame))
        file.mux(stream.encode())


def camera() -> Camera:
    """Upstream's calibration for pictures of half the size; pixel centres are at integers."""
    (fx, fy), (cx, cy) = FOCAL, CENTRE
    return Camera(
        width=WIDTH,
        height=HEIGHT,
        fx=fx / 2,
        fy=fy / 2,
        cx=(cx + 0.5) / 2 - 0.5,
        cy=(cy + 0.5) / 2 - 0.5,
        distortion=DISTORTION,
    )


def marks() -> list[Marked]:
    """The marks of every frame, named as the body's joints and landmarks are."""
    frames = json.loads((FOLDER / "marks.json").read_text("utf-8"))["frames"]
    return [_marked(int(frame), found) for frame, found in frames.items()]


def pose(marked: list[Marked]) -> Posed:
    """One body for all marked frames, and its pose in each."""
    return fit(_with_points(_build()), camera(), marked, DEPTH_M, HABITS)


def session_of(path: Path, posed: Posed) -> Session:
    """The session of the clip, a keyframe wherever there are marks."""
    with Video.open(path) as video:
        info, fingerprint = video.info, video.fingerprint()
    keyframes = [
        Keyframe.of(posed.skeleton, pose, frame, float(info.times_s[frame]))
        for frame, pose in posed.poses.items()
    ]
    return Session(
        video=VideoReference(
            path=path.name,
            fingerprint=fingerprint,
            frame_count=info.frame_count,
            width=info.width,
            height=info.height,
        ),
        camera=camera(),
        body=_without_points(posed.skeleton.body),
        keyframes=tuple(keyframes),
        up_camera=UP_CAMERA,
        settings=TrackSettings(static_camera=True, cues=ALL_CUES, smooth=True),
    )


def _build() -> Body:
    """The preset with this man's strong legs, and hands as short as half-closed ones look."""
    body = preset("adult_male")
    for part, ratio in THICKNESS.items():
        body = resized(body, part, thickness_factor=ratio)
    return resized(body, "left_hand", length_factor=HAND_LENGTH)


def _marked(frame: int, found: Mapping[str, list[float]]) -> Marked:
    """Marks [u, v] or [u, v, depth] of one frame; a depth makes a rough 3D joint."""
    uv = {_joint(name): (mark[0], mark[1]) for name, mark in found.items()}
    deep = {_joint(name): mark for name, mark in found.items() if len(mark) == 3}
    xyz = {n: camera().back_project(np.array(m[:2]), m[2]).tolist() for n, m in deep.items()}
    return Marked(frame, uv, xyz)


def _joint(name: str) -> str:
    side, _, joint = name.partition("_")
    return f"{side}_{JOINTS[joint]}" if joint in JOINTS else name


def _with_points(body: Body) -> Body:
    for name, (part_name, place) in POINTS.items():
        part = body.parts[body.index(part_name)]
        landmarks = {**part.landmarks, name: place}
        body = body.with_part(part.model_copy(update={"landmarks": landmarks}))
    return body


def _without_points(body: Body) -> Body:
    for part in body.parts:
        landmarks = {n: place for n, place in part.landmarks.items() if n not in POINTS}
        body = body.with_part(part.model_copy(update={"landmarks": landmarks}))
    return body


if __name__ == "__main__":
    main()
