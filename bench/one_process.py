"""Run one command and say what it took: `python one_process.py JSON`.

It is small, since a process inherits the peak memory of the one that starts it. Asked are
`command`, and `until`: a word that is printed, after which the command is ended, or `page`, by
whose link it is read first, or null, until the end. The answer is a line of JSON: seconds of
processors and by the clock until then, and MB of peak memory.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from pathlib import Path
from tempfile import TemporaryFile
from typing import IO
from urllib.request import ProxyHandler, build_opener

PAGE = "page"
TICKS = os.sysconf("SC_CLK_TCK")
LONGEST_S = 600.0


def taken(command: list[str], until: str | None) -> dict[str, float]:
    """Seconds of processors, seconds by the clock, and MB of peak memory."""
    began = time.perf_counter()
    with TemporaryFile("w+") as said:
        child = subprocess.Popen(
            command,
            stdout=subprocess.PIPE if until else said,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        )
        spent = {}
        if until:
            assert child.stdout is not None
            _wait(child.stdout, until)
            spent = {"cpu": _cpu_s(child.pid), "wall": time.perf_counter() - began}
            child.terminate()
            child.stdout.read()
        _, status, used = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        if not until and child.returncode > 1:
            said.seek(0)
            raise RuntimeError(f"{command}: {said.read()[-2000:]}")
    whole = {"cpu": used.ru_utime + used.ru_stime, "wall": time.perf_counter() - began}
    return {**whole, **spent, "peak_mb": used.ru_maxrss / 1024}


def _wait(printed: IO[str], until: str) -> None:
    """Until the word is printed, or the page is there by the link that is printed."""
    lines = ""
    for line in printed:
        lines += line
        links = [word for word in line.split() if word.startswith("http://127.0.0.1")]
        if until == PAGE and links:
            build_opener(ProxyHandler({})).open(links[0], timeout=LONGEST_S).close()
            return
        if until != PAGE and until in line:
            return
    raise RuntimeError(f"it ended before {until!r}: {lines[-2000:]}")


def _cpu_s(session: int) -> float:
    """Seconds of processors that the processes of a session have taken, and those they ended."""
    ticks = 0
    for place in Path("/proc").glob("[0-9]*/stat"):
        try:
            facts = place.read_text().rpartition(")")[2].split()
        except (FileNotFoundError, ProcessLookupError):  # ended since it was listed
            continue
        if int(facts[3]) == session:
            ticks += sum(map(int, facts[11:15]))
    return ticks / TICKS


if __name__ == "__main__":
    print(json.dumps(taken(**json.loads(sys.argv[1]))))
