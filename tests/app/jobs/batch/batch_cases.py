"""Small sessions for batches, and a pool that does the work on the spot."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from threading import Event
from typing import Any

from keypose.app.jobs.batch.pool import News
from keypose.app.jobs.batch.run_one import run_task
from keypose.app.jobs.batch.task import Step, Task
from tests.tracker import session_cases as cases

Befalls = Callable[[int, Task], News | None]


def write_sessions(root: Path, *names: str) -> list[Path]:
    """Sessions of nine frames, each in a folder of its own with its video."""
    paths = []
    for i, name in enumerate(names):
        folder = root / name
        folder.mkdir(parents=True)
        path = cases.write_session(folder)
        deeper = 0.001 * i
        cases.altered(path, lambda data, z=deeper: _move(data, z))  # type: ignore[misc]
        paths.append(path)
    return paths


def bytes_of(paths: list[Path]) -> list[bytes]:
    """Of the sessions, what was there before, and the tracks they name."""
    return [file.read_bytes() for path in paths for file in sorted(path.parent.glob("*.[jn]*"))]


def _move(data: dict[str, Any], z: float) -> None:
    data["keyframes"][0]["root_m"][2] += z


class Here:
    """One worker: this process. `befalls` may tell of a task what happens instead of the work."""

    def __init__(self, processes: int = 1, befalls: Befalls = lambda number, task: None) -> None:
        self.processes = processes
        self.given: list[tuple[int, Task]] = []
        self.closed = False
        self._befalls = befalls
        self._waiting: list[tuple[int, Task]] = []
        self._stop = Event()

    def free_slots(self) -> int:
        return self.processes - len(self._waiting)

    def submit(self, number: int, task: Task) -> None:
        self.given.append((number, task))
        self._waiting.append((number, task))

    def wait(self, seconds: float) -> list[News]:
        number, task = self._waiting.pop(0)
        news: list[News] = []

        def report(step: Step) -> None:
            news.append((number, step))

        end = self._befalls(number, task) or (number, run_task(task, report, self._stop))
        return [*news, end]

    def stop(self) -> None:
        self._stop.set()

    def close(self) -> None:
        self.closed = True
