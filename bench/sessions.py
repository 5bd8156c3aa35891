"""What is never lost, and what long films cost: kills, long sessions, an hour of video."""

from __future__ import annotations

import asyncio
import json
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from bench.keeping import DATA, ROOT, Absent
from bench.stand import film
from bench.table import Expected, Report
from keypose.app.document.library import Library
from keypose.app.store.store import Store
from tests.app.killing import kill_once

KILLS = 200
FRAMES, KEYFRAMES = 3000, 100
OPEN_S, DURABLE_MS, MEMORY_MIB = 2.0, 50.0, 1024.0
EDITS = 60


def sessions(report: Report) -> None:
    """The group."""
    with tempfile.TemporaryDirectory() as kept:
        folder = Path(kept)
        _kills(report, folder)
        table = report.table("long films", "open, s", "edit, ms", "90 %", "memory, MiB")
        path = _long_session(folder)
        _row(table, f"{FRAMES} frames, {KEYFRAMES} keyframes", path)
        _row(table, "the same, after 1,000 edits", path)
        _row(table, "an hour of video", _hour(folder))


def _kills(report: Report, folder: Path) -> None:
    path = folder / "killed" / "person" / "session.json"
    shutil.copytree(ROOT / "sample_videos" / "person", path.parent)
    deaths = [kill_once(path, 1000 + seed) for seed in range(KILLS)]
    acknowledged = sum(death.acknowledged for death in deaths)
    lost = sum(death.lost for death in deaths)
    table = report.table("killed while it edits, saves and tracks", "kills", "edits", "lost")
    expected = [Expected("lost", float(lost), 0.0)]
    table.row("SIGKILL", KILLS, acknowledged, lost, expected=expected)


def _long_session(folder: Path) -> Path:
    """A film of the sample there and back, with keyframes all along it."""
    path = film(folder / "long", (640, 360), FRAMES // 72 + 1)
    session = json.loads(path.read_text())
    first, fps = session["keyframes"][0], 30
    frames = np.linspace(0, FRAMES - 1, KEYFRAMES).astype(int)
    session["keyframes"] = [
        {**first, "frame": int(frame), "time_s": int(frame) / fps} for frame in frames
    ]
    path.write_text(json.dumps(session))
    return path


def _hour(folder: Path) -> Path:
    found = sorted(DATA.glob("broken_videos/*1h*"))
    if not found:
        raise Absent("an hour of video")
    place = folder / "hour"
    place.mkdir()
    (place / found[0].name).symlink_to(found[0])
    return place / found[0].name


def _row(table: Any, name: str, path: Path) -> None:
    command = [sys.executable, "-m", "bench.sessions", str(path)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    measured = json.loads(done.stdout.splitlines()[-1])
    edits = measured["edits_ms"]
    expected = [
        Expected("open", measured["open_s"], OPEN_S, "s"),
        Expected("edit", float(np.median(edits)), DURABLE_MS, "ms"),
        Expected("memory", measured["memory_mib"], MEMORY_MIB, "MiB"),
    ]
    spread = float(np.median(edits)), float(np.percentile(edits, 90))
    table.row(name, measured["open_s"], *spread, measured["memory_mib"], expected=expected)


# --- in a process of its own


async def _measured(path: Path, edits: int) -> dict[str, Any]:
    began = time.perf_counter()
    library = Library(path.parent.parent / "work", [path.parent])
    store = Store(asyncio.get_running_loop(), lambda *_: None, library)
    await store.open(path)
    tab = store.join()
    await tab.next()
    open_s = time.perf_counter() - began
    spent = []
    for number in range(1, edits + 1):
        at = time.perf_counter()
        action = {"do": "angles", "part": "left_forearm", "x": -0.01 * number, "n": number}
        store.receive(tab, action)
        while max(m.get("ack", 0) for m in await tab.next()) < number:
            pass
        spent.append(1000 * (time.perf_counter() - at))
    await store.stop()
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return {"open_s": open_s, "edits_ms": spent, "memory_mib": memory}


if __name__ == "__main__":
    place = Path(sys.argv[1])
    again = (place.parent / "journal.jsonl").exists()
    print(json.dumps(asyncio.run(_measured(place, EDITS if again else 1000))))
