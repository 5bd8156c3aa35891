"""Work that is measured in a process of its own: peak memory, and the time from a cold start.

`python -m bench.children FRAMES [MB]` tracks so many frames and prints its peak memory.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from bench.keeping import ROOT

IMPORTS = (
    "import keypose.app.cli.main, keypose.app.cli.follow, keypose.tracker.storage.files, "
    "keypose.tracker.storage.tracks"
)
INTERVAL = 12


def peak_mb(frames: int, memory_mb: int | None) -> float:
    """Peak memory of a process that tracks so many frames, its clips within a limit."""
    command = [sys.executable, "-m", "bench.children", str(frames)]
    command += [str(memory_mb)] if memory_mb else []
    return float(_output(command).split()[-1])


def start_seconds(repeats: int) -> dict[str, list[float]]:
    """Seconds from the start of a process, by what had happened by then."""
    spent: dict[str, list[float]] = {
        "imports alone": [], "to the first trajectory": [], "to the end": [],
    }  # fmt: skip
    for turn in range(repeats + 1):
        began = time.perf_counter()
        _output([sys.executable, "-c", IMPORTS])
        imports = time.perf_counter() - began
        first, end = _track_box()
        if turn:  # the first time compiles and fills the disk's cache
            for what, seconds in zip(spent, (imports, first, end), strict=True):
                spent[what].append(seconds)
    return spent


def _output(command: list[str]) -> str:
    return subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout


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
        with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True) as child:
            assert child.stdout is not None
            for line in child.stdout:
                if first is None and json.loads(line)["event"] == "pass_finished":
                    first = time.perf_counter() - began
        end = time.perf_counter() - began
    return first if first is not None else float("nan"), end


def _track_looped(frames: int, memory_mb: int | None) -> None:
    """Track the walk there and back again, over and over."""
    from bench.sequences import video_of, walking
    from keypose.tracker.session.settings import TrackSettings
    from keypose.tracker.tracking.pool import run
    from keypose.tracker.tracking.tracker import Tracker
    from keypose.tracker.video.clip_loader import MEMORY_BYTES

    shown = walking()
    turn = len(shown.grey) - 1

    def there_and_back(frame: int) -> int:
        return turn - abs(frame % (2 * turn) - turn)

    video = video_of(frames, lambda frame: shown.picture(there_and_back(frame)))
    keyposes = {f: shown.truth.pose(there_and_back(f)) for f in range(0, frames, INTERVAL)}
    memory = memory_mb * 1_000_000 if memory_mb else MEMORY_BYTES
    tracker = Tracker(video, shown.camera, shown.skeleton, keyposes, memory=memory)
    for _ in run(tracker, TrackSettings()):
        pass


def _main(frames: int, memory_mb: int | None) -> None:
    _track_looped(frames, memory_mb)
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
    _main(int(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else None)
