"""Make the filmed walk anew:  python -m keypose.sample_videos.make_walk [demo.mp4]

With the original clip named, it is first trimmed and scaled down; otherwise the clip stays as it
is. Then the commands do what a person does in the page: draft every frame from one box, keep the
drafts of a few frames as keyframes, track, accept the pins that are proposed, and let the keyframes
give way in depth to them.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Mapping
from fractions import Fraction
from math import cos, radians, sin
from pathlib import Path

import av
import numpy as np
from av.video.reformatter import Interpolation

from keypose.app.cli.main import main as keypose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.session import Keyframe, Session
from keypose.tracker.session.pins import Pin
from keypose.tracker.space.level import up_from_places
from keypose.tracker.storage.atomic import write_file
from keypose.tracker.storage.files import load_session, save_session, session_json
from keypose.tracker.storage.results import load_results
from keypose.tracker.storage.tracks import load_trajectory

FOLDER = Path(__file__).parent / "walk"
WIDTH, HEIGHT, FPS = 1280, 720, 30
FIRST, LAST = 40, 192
"""Frames of the original: from where she comes out behind a tree to where she leaves."""
CRF = 25

BOX = "640,365,830,680"
BOX_FRAME = 60
FIELD_OF_VIEW = 38.7
"""Degrees: upstream's estimate of the focal length, 2520 pixels of a width of 1768."""
KEYED = (12, 32, 52, 72, 92, 112, 130, 146)
NECK_DEG, HEAD_DEG = 28.0, -21.0
"""How she carries her head, forward and level. In profile the network sees it thrown back."""


def main() -> None:
    video = FOLDER / "walk.mp4"
    if len(sys.argv) > 1:
        trim(Path(sys.argv[1]), video)
    with tempfile.TemporaryDirectory(dir=FOLDER) as folder:
        path = Path(folder) / "session.json"
        _run("draft", video, "--box", BOX, "--frame", BOX_FRAME, "--out", folder,
             "--body", "adult_female", "--field-of-view", FIELD_OF_VIEW)  # fmt: skip
        save_session(keyed(load_session(path)), path)
        _run("track", path)
        session = on_its_floor(load_session(path), path)
    reference = session.video.model_copy(update={"path": video.name})
    session = session.model_copy(update={"video": reference, "results": None})
    write_file(FOLDER / "session.json", session_json(session), overwrite=True)


def trim(original: Path, path: Path) -> None:
    """The frames of the walk, smaller and without sound."""
    options = {"crf": str(CRF), "preset": "medium", "g": "30", "x264-params": "threads=1"}
    container = {"fflags": "+bitexact", "movflags": "+faststart"}
    with av.open(str(original)) as source, av.open(str(path), "w", options=container) as file:
        stream = file.add_stream("libx264", rate=FPS, options=options)
        stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, "yuv420p"
        stream.time_base = stream.codec_context.time_base = Fraction(1, FPS)
        for number, picture in enumerate(source.decode(video=0)):
            if not FIRST <= number <= LAST:
                continue
            frame = picture.reformat(WIDTH, HEIGHT, "yuv420p", interpolation=Interpolation.AREA)
            frame.pts, frame.time_base, frame.pict_type = number - FIRST, Fraction(1, FPS), 0
            file.mux(stream.encode(frame))
        file.mux(stream.encode())


def keyed(drafted: Session) -> Session:
    """Some of the drafts as keyframes, with the head set right; the other drafts are not kept."""
    drafts = {draft.frame: draft for draft in drafted.drafts}
    settings = drafted.settings.model_copy(update={"static_camera": True})
    return drafted.model_copy(
        update={
            "keyframes": tuple(_with_level_head(drafts[frame]) for frame in KEYED),
            "drafts": (),
            "drafted": None,
            "keypoints": None,
            "settings": settings,
            "up_camera": (0.0, -1.0, 0.0),
        }
    )


def on_its_floor(tracked: Session, path: Path) -> Session:
    """With the pins that were proposed, soft keyframes, and up so that all feet stand level."""
    pins = [pin for one in load_results(tracked, path).space(tracked) for pin in one.proposed]
    keyframes = [key.model_copy(update={"soft": True}) for key in tracked.keyframes]
    return tracked.model_copy(
        update={
            "pins": tuple(pins),
            "keyframes": tuple(keyframes),
            "up_camera": _up(tracked, path, pins),
            "up_from": ("feet", "set"),
        }
    )


def _up(tracked: Session, path: Path, pins: list[Pin]) -> tuple[float, float, float]:
    """So that she stands level wherever she steps."""
    motion = load_trajectory(tracked, path)
    p_camera_joint = motion.joints(Skeleton.of(tracked.body))
    feet = []
    for pin in pins:
        rows = slice(pin.first_frame - motion.first_frame, pin.last_frame - motion.first_frame + 1)
        feet.append(p_camera_joint[rows, tracked.body.index(pin.part)].mean(axis=0))
    x, y, z = up_from_places(np.array(feet)).up
    return (round(float(x), 5), round(float(y), 5), round(float(z), 5))


def _with_level_head(draft: Keyframe) -> Keyframe:
    turns: Mapping[str, tuple[float, float, float, float]] = {
        "neck": _about_x(NECK_DEG),
        "head": _about_x(HEAD_DEG),
    }
    rotations = {**draft.rotations_wxyz, **turns}
    return draft.model_copy(update={"rotations_wxyz": rotations})


def _about_x(angle_deg: float) -> tuple[float, float, float, float]:
    half = radians(angle_deg) / 2
    return (cos(half), sin(half), 0.0, 0.0)


def _run(*words: object) -> None:
    if keypose([str(word) for word in words]) not in (0, 1):
        raise SystemExit(f"keypose {words[0]} failed")


if __name__ == "__main__":
    main()
