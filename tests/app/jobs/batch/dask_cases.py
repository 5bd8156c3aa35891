"""A Dask cluster on this computer, as a person would start one, and an accident to befall it."""

from __future__ import annotations

import re
import subprocess
import sys
import time
from collections import deque
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from threading import Thread

from keypose.app.document.folder_lock import NAME
from tests.app.serving import LONGEST_S, ROOT

HERE = ("--host", "127.0.0.1", "--no-dashboard", "--dashboard-address", "127.0.0.1:0")
ALONE = ("--no-nanny", "--nthreads", "1", "--memory-limit", "0")


@contextmanager
def dask(program: str, *arguments: str, ready: str) -> Iterator[tuple[int, str]]:
    """A program of Dask as soon as it is ready: its pid, and what it said then. Ends by kill."""
    process = subprocess.Popen(
        [sys.executable, "-m", f"distributed.cli.dask_{program}", *HERE, *arguments],
        cwd=ROOT,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stderr is not None
    lines = process.stderr
    drain = Thread(target=deque, args=(lines, 0), daemon=True)
    try:
        reported = []
        for line in lines:
            reported.append(line)
            if found := re.search(ready, line):
                break
        else:
            raise AssertionError("".join(reported))
        drain.start()
        yield process.pid, found[1]
    finally:
        process.kill()
        process.wait()
        if drain.ident is not None:
            drain.join()
        lines.close()


@contextmanager
def cluster(folder: Path, workers: int) -> Iterator[tuple[str, list[int]]]:
    """A scheduler's address, and the processes of so many workers of one thread."""
    with ExitStack() as stack:
        at = dask("scheduler", "--port", "0", ready=r"Scheduler at:\s+(tcp://\S+)")
        address = stack.enter_context(at)[1]
        own = (*ALONE, "--local-directory", str(folder / "dask"))
        hired = [dask("worker", address, *own, ready="(Registered) to") for _ in range(workers)]
        yield address, [stack.enter_context(one)[0] for one in hired]


def holders(paths: list[Path]) -> list[int]:
    """Which processes worked on these sessions last."""
    locks = [path.with_name(NAME) for path in paths]
    return [int(lock.read_text() or 0) for lock in locks if lock.exists()]


def kill_at_work(pid: int, paths: list[Path]) -> None:
    """Kill a worker as soon as it has taken up a session: it still has its loops to load."""
    end = time.monotonic() + LONGEST_S
    while pid not in holders(paths):
        assert time.monotonic() < end, "it never began"
        time.sleep(0.005)
    subprocess.run(["kill", "-9", str(pid)], check=True)
