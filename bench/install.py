"""From the wheel to the open page on a computer that has never seen Keypose, part by part.

The wheel is built, installed into an environment of its own and used outside the checkout, with an
empty cache. Each part is told in seconds by the clock and of processors: beside other work the
clock says little.
"""

from __future__ import annotations

import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import urljoin
from urllib.request import HTTPCookieProcessor, ProxyHandler, build_opener

from bench.keeping import ROOT
from bench.table import Pair, Report, Table

TO_THE_PAGE_S = 60.0
ANSWERS_S = 0.3
AGAIN_S = 2.0
LONGEST_S = 3600.0


class Stopwatch:
    """What child processes take within its block: by the clock, and of processors."""

    def __enter__(self) -> Stopwatch:
        self._clock, self._processors = time.perf_counter(), _children_s()
        return self

    def lap(self) -> float:
        """Seconds by the clock until now."""
        return time.perf_counter() - self._clock

    def __exit__(self, *_: object) -> None:
        self.spent = Pair(self.lap(), _children_s() - self._processors, ("clock", "processors"))


@dataclass(frozen=True)
class Place:
    """An environment that Keypose is installed into, and a folder to work in."""

    folder: Path
    environ: Mapping[str, str]

    @property
    def python(self) -> Path:
        return self.folder / "venv" / ("Scripts" if os.name == "nt" else "bin") / "python"

    def keypose(self, *words: str) -> list[str]:
        return [str(self.python.with_name("keypose")), *words]

    def seconds(self, command: list[str]) -> Pair:
        """How long a command takes; CalledProcessError when it fails."""
        with Stopwatch() as watch:
            subprocess.run(
                command,
                cwd=self.folder,
                env=self.environ,
                check=True,
                capture_output=True,
                timeout=LONGEST_S,
            )
        return watch.spent


def install(report: Report) -> None:
    """The whole group."""
    report.note(f"load when this began: {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
    uv = shutil.which("uv")
    report.note(f"installed by {'uv' if uv else 'pip'}, with the wheels that it has kept")
    with tempfile.TemporaryDirectory() as kept:
        wheel = _built(Path(kept))
        report.note(f"{wheel.name}: {wheel.stat().st_size / 1e6:.1f} MB")
        with tempfile.TemporaryDirectory() as folder:
            _measure(report, _place(Path(folder)), wheel, sys.executable, uv)


def _measure(report: Report, place: Place, wheel: Path, python: str, uv: str | None) -> None:
    asked = [python, "-c", "import platform; print(platform.python_version())"]
    name = subprocess.run(asked, check=True, capture_output=True, text=True).stdout.strip()
    table = report.table(f"Python {name}: seconds by the clock/of processors", "first", "again")
    installed = _install(place, wheel, python, uv)
    table.row("install", installed, "")
    clip = shutil.copy(ROOT / "sample_videos" / "box" / "box.mp4", place.folder)
    first = _until_the_page(place, clip)
    again = _until_the_page(place, clip)
    table.row("open, until the page is served", first, again)
    _twice(table, place, "--version", place.keypose("--version"))
    _twice(table, place, "doctor", place.keypose("doctor"))
    session = ROOT / "sample_videos" / "box" / "session.json"
    track = place.keypose("track", str(session), "--out", "tracked", "--overwrite")
    _twice(table, place, "track the box", track)
    whole = installed.first + first.first
    answers = place.seconds(place.keypose("--version"))
    report.expect(f"{name}: install and open", whole, TO_THE_PAGE_S, "s")
    report.expect(f"{name}: open again, of processors", again.second, AGAIN_S, "s")
    report.expect(f"{name}: --version, of processors", answers.second, ANSWERS_S, "s")


def _twice(table: Table, place: Place, name: str, command: list[str]) -> None:
    first = place.seconds(command)
    table.row(name, first, place.seconds(command))


def _built(folder: Path) -> Path:
    command = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", "."]
    subprocess.run([*command, str(ROOT)], cwd=folder, check=True, capture_output=True)
    (wheel,) = folder.glob("*.whl")
    return wheel


def _place(folder: Path) -> Place:
    """With a cache, a configuration and a home that hold nothing."""
    hidden = ("PYTHONPATH", "PYTHONDONTWRITEBYTECODE", "PYTHONPYCACHEPREFIX", "NUMBA_CACHE_DIR")
    environ = {name: value for name, value in os.environ.items() if name not in hidden}
    environ |= {"XDG_CACHE_HOME": str(folder / "cache"), "KEYPOSE_CONFIG": str(folder / "none")}
    return Place(folder, environ)


def _children_s() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _install(place: Place, wheel: Path, python: str, uv: str | None) -> Pair:
    own = dict(os.environ)  # the installer keeps its own cache
    venv = place.folder / "venv"
    if uv:
        made = [uv, "venv", "--quiet", "--python", python, str(venv)]
        filled = [uv, "pip", "install", "--quiet", "--compile-bytecode", "--python"]
        filled += [str(place.python), str(wheel)]
    else:
        made = [python, "-m", "venv", str(venv)]
        filled = [str(place.python), "-m", "pip", "install", "--quiet", str(wheel)]
    with Stopwatch() as watch:
        for command in (made, filled):
            subprocess.run(command, cwd=place.folder, env=own, check=True, capture_output=True)
    return watch.spent


def _until_the_page(place: Place, clip: str | Path) -> Pair:
    """Until the page is had by the link that the command prints; of processors, until the server
    ended."""
    with Stopwatch() as watch, _served(place, clip) as link:
        browser = build_opener(ProxyHandler({}), HTTPCookieProcessor())
        browser.open(link, timeout=LONGEST_S).close()  # lets it in
        with browser.open(urljoin(link, "/"), timeout=LONGEST_S) as answer:
            assert b"page.js" in answer.read()
        clock = watch.lap()
    return Pair(clock, watch.spent.second, watch.spent.names)


@contextmanager
def _served(place: Place, clip: str | Path) -> Iterator[str]:
    """The link to the page of a server, which ends with the block."""
    command = place.keypose("open", str(clip), "--port", "0", "--no-browser", "--workspace", "w")
    with subprocess.Popen(
        command,
        cwd=place.folder,
        env={**place.environ, "PYTHONUNBUFFERED": "1"},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    ) as keypose:
        assert keypose.stdout is not None
        printed = ""
        try:
            while "http://" not in printed:
                line = keypose.stdout.readline()
                assert line, printed
                printed += line
            yield next(word for word in printed.split() if word.startswith("http://"))
        finally:
            keypose.terminate()
            keypose.communicate()
