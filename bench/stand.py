"""What the page is measured with: films of any length and size, and what processes spend."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from fractions import Fraction
from pathlib import Path

import av
import cv2

from bench.keeping import ROOT
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.video import Video
from tests.app.serving import Keypose

FPS = 30


@contextmanager
def serving(session: Path) -> Iterator[Keypose]:
    """The page's server for a session."""
    keypose = Keypose(str(session), "--workspace", str(session.parent / "workspace"))
    try:
        yield keypose
    finally:
        keypose.end()


def sample(folder: Path) -> Path:
    """The person sample in a folder of its own."""
    folder.mkdir()
    for name in ("person.mp4", "session.json"):
        shutil.copy(ROOT / "sample_videos" / "person" / name, folder)
    return folder / "session.json"


def film(folder: Path, size: tuple[int, int], turns: int, **settings: object) -> Path:
    """The sample's film there, back, there … so many times, in another size, with its session."""
    session = sample(folder)
    values = json.loads(session.read_text())
    with Video.open(str(folder / "person.mp4")) as video:
        pictures = [picture for _, picture in video.frames(0, video.info.frame_count)]
    there = [cv2.resize(picture, size) for picture in pictures if picture is not None]
    last = len(there) - 1
    way = [last - abs(frame % (2 * last) - last) for frame in range(turns * last + 1)]
    _encode(folder / "person.mp4", [there[i] for i in way])
    shape = {"width": size[0], "height": size[1]}
    centre = {"cx": (size[0] - 1) / 2, "cy": (size[1] - 1) / 2}
    view, subject = values["views"][0], values["bodies"][0]
    scale = size[0] / view["camera"]["width"]
    focus = {name: scale * view["camera"][name] for name in ("fx", "fy")}
    view["camera"] |= shape | centre | focus
    values["settings"] |= settings
    view["video"] |= shape | {"fingerprint": "", "frame_count": len(way)}
    poses = {keyframe["frame"]: keyframe for keyframe in subject["keyframes"]}
    subject["keyframes"] = [
        {**poses[i], "frame": frame, "time_s": frame / FPS}
        for frame, i in enumerate(way)
        if i in poses
    ]
    session.write_text(json.dumps(values))
    return session


def _encode(path: Path, pictures: list[Array]) -> None:
    with av.open(str(path), "w") as file:
        stream = file.add_stream("h264", rate=Fraction(FPS))
        stream.height, stream.width = pictures[0].shape[:2]
        stream.pix_fmt = "yuv420p"
        for picture in pictures:
            file.mux(stream.encode(av.VideoFrame.from_ndarray(picture, "rgb24")))
        file.mux(stream.encode())


def family(pid: int) -> set[int]:
    """A process and all below it."""
    tasks = Path(f"/proc/{pid}/task").glob("*/children")
    children = [int(child) for task in tasks for child in task.read_text().split()]
    return {pid}.union(*(family(child) for child in children))


def cpu_s(pids: set[int]) -> float:
    """Seconds of computing that these processes have done."""
    ticks = 0
    for pid in pids:
        fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
        ticks += int(fields[11]) + int(fields[12])
    return ticks / os.sysconf("SC_CLK_TCK")
