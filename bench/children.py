"""Work that is measured in a process of its own: peak memory, and the time from a cold start.

`python -m bench.children SESSION [MB]` tracks a session and prints its peak memory.
"""

from __future__ import annotations

import json
import os
import re
import resource
import subprocess
import sys
import tempfile
import time
import urllib.request
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

from bench.keeping import ROOT

if TYPE_CHECKING:
    from keypose.tracker.geometry.camera import Camera

IMPORTS = (
    "import keypose.app.cli.main, keypose.app.cli.follow, keypose.tracker.storage.files, "
    "keypose.tracker.storage.tracks"
)
FPS = 30


def peak_mb(session_path: Path, memory_mb: int | None) -> float:
    """Peak memory of a process that tracks a session within a limit."""
    command = [sys.executable, "-m", "bench.children", str(session_path)]
    command += [str(memory_mb)] if memory_mb else []
    return float(_output(command).split()[-1])


def start_seconds(repeats: int) -> dict[str, list[float]]:
    """Seconds from the start of a process, by what had happened by then."""
    spent: dict[str, list[float]] = {
        "imports alone": [],
        "to the first trajectory": [],
        "to the end": [],
    }
    for turn in range(repeats + 1):
        began = time.perf_counter()
        _output([sys.executable, "-c", IMPORTS])
        imports = time.perf_counter() - began
        first, end = _track_box()
        if turn:  # the first time compiles and fills the disk's cache
            for what, seconds in zip(spent, (imports, first, end), strict=True):
                spent[what].append(seconds)
    return spent


def open_seconds(repeats: int) -> list[float]:
    """Seconds from the start of `keypose open` to its first answer."""
    return [_open() for _ in range(repeats + 1)][1:]


def cold_seconds() -> float:
    """Seconds from the start of the page's worker until a segment can be tracked, on a computer
    where nothing is compiled."""
    code = "from keypose.tracker.warm import warm_tracking; warm_tracking(lambda percent: None)"
    with tempfile.TemporaryDirectory() as folder:
        began = time.perf_counter()
        _output([sys.executable, "-c", code], NUMBA_CACHE_DIR=folder)
        return time.perf_counter() - began


def _environment(**more: str) -> dict[str, str]:
    """With bytecode kept, as that of an installed package is."""
    from bench.keeping import kept_folder

    bytecode = {"PYTHONPYCACHEPREFIX": str(kept_folder() / "bytecode")}
    environment = {**os.environ, **bytecode, **more}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    return environment


def _output(command: list[str], **environment: str) -> str:
    given = {"cwd": ROOT, "env": _environment(**environment)}
    return subprocess.run(command, check=True, capture_output=True, text=True, **given).stdout


def _open() -> float:
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "keypose.app", "open", "--no-browser"]
        command += ["--workspace", folder]
        began, pipe = time.perf_counter(), subprocess.PIPE
        with subprocess.Popen(
            command, cwd=ROOT, env=_environment(), stdout=pipe, text=True
        ) as child:
            assert child.stdout is not None
            link = next(m for line in child.stdout if (m := re.search(r"http://\S+", line)))
            with urllib.request.urlopen(link.group()) as answer:
                answer.read()
            spent = time.perf_counter() - began
            child.terminate()
    return spent


def _track_box() -> tuple[float, float]:
    """Seconds until the first trajectory was told, and until the process ended."""
    session = ROOT / "sample_videos" / "box" / "session.json"
    with tempfile.TemporaryDirectory() as folder:
        command = [
            sys.executable,
            "-m",
            "keypose.app",
            "track",
            str(session),
            "--json",
            "--out",
            folder,
        ]
        began, first = time.perf_counter(), None
        with subprocess.Popen(
            command, cwd=ROOT, env=_environment(), stdout=subprocess.PIPE, text=True
        ) as child:
            assert child.stdout is not None
            for line in child.stdout:
                if first is None and json.loads(line)["event"] == "pass_finished":
                    first = time.perf_counter() - began
        end = time.perf_counter() - began
    return first if first is not None else float("nan"), end


def looped_film(frames: int, scale: int, interval: int) -> Path:
    """A session beside its film, kept: the walk there and back again, over and over, enlarged."""
    import cv2
    import numpy as np

    from bench.keeping import digest, place_for
    from bench.sequences import walking
    from keypose.tracker.session import Session
    from keypose.tracker.session.keyframe import Keyframe
    from keypose.tracker.video.encode import FilmWriter

    shown = walking()
    turn = len(shown.grey) - 1
    order = [turn - abs(frame % (2 * turn) - turn) for frame in range(frames)]
    key = digest(ROOT / "bench" / "children.py", shown.grey.tobytes())
    film = place_for(f"looped-{frames}-{scale}", key, ".mp4")
    wide = scaled(shown.camera, scale)
    if not film.is_file():
        part = film.with_suffix(".part")
        with FilmWriter(part, (wide.width, wide.height), Fraction(1, FPS), Fraction(FPS)) as writer:
            for pts, frame in enumerate(order):
                picture = cv2.resize(shown.picture(frame), (wide.width, wide.height))
                writer.add(np.asarray(picture, np.uint8), pts)
        part.replace(film)
    facts = {"path": str(film), "frame_count": frames, "width": wide.width, "height": wide.height}
    keyframes = [
        Keyframe.of(shown.skeleton, shown.truth.pose(order[frame]), frame, frame / FPS)
        for frame in range(0, frames, interval)
    ]
    session = Session.begin(
        video={**facts, "fingerprint": "", "repeats": {"frames": []}},
        camera=wide,
        body=shown.skeleton.body,
        keyframes=keyframes,
        settings={"cues": ["brightness"], "static_camera": False},
    )
    place = film.with_suffix(f".{interval}.json")
    place.write_text(session.model_dump_json(), encoding="utf-8")
    return place


def scaled(camera: Camera, scale: int) -> Camera:
    """The camera of enlarged pictures; pixel centres stay at integers."""
    update = {name: getattr(camera, name) * scale for name in ("fx", "fy", "width", "height")}
    update |= {name: (getattr(camera, name) + 0.5) * scale - 0.5 for name in ("cx", "cy")}
    return camera.model_copy(update=update)


def _track(session_path: Path, memory_mb: int | None) -> None:
    """Track a session as its command does, its clips within a limit."""
    from keypose.tracker.operations.track import tracker_of
    from keypose.tracker.storage.files import load_session, open_for_work, video_path
    from keypose.tracker.tracking.pool import run
    from keypose.tracker.video.clip_loader import ONCE, Memory

    session = load_session(session_path)
    memory = Memory(memory_mb * 1_000_000, kept=0) if memory_mb else ONCE
    path = video_path(session, session_path)
    with open_for_work(session, path, session_path.parent) as video:
        for _ in run(tracker_of(session, video, memory), session.settings):
            pass


def _main(session_path: Path, memory_mb: int | None) -> None:
    _track(session_path, memory_mb)
    print(peak_bytes() / 1e6)


def peak_bytes() -> int:
    """The most memory this process held; getrusage may count what its parent held before it."""
    status = Path("/proc/self/status")
    if status.is_file():
        lines = status.read_text(encoding="ascii").splitlines()
        return 1024 * next(int(line.split()[1]) for line in lines if line.startswith("VmHWM"))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else 1024 * peak


if __name__ == "__main__":
    _main(Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else None)
