"""Getting the compiled loops ready before they are needed.

The first run on a machine compiles them, in several processes; later runs load them from disk.
`warm` does either by tracking a tiny grey box, so that it can be done while a person's video is
still being read.
"""

from __future__ import annotations

import hashlib
import os
from collections import deque
from collections.abc import Callable, Collection
from contextlib import suppress
from pathlib import Path
from threading import Lock, Thread
from typing import TYPE_CHECKING, Final

import numba
import numpy as np

from keypose.tracker import kernels
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import transform

if TYPE_CHECKING:
    from keypose.tracker.warming import BoxScene

_DONE, _HULLS_DONE = "warm", "warm-hulls"
MOST_PROCESSES: Final = 3
"""More would wait for the largest part."""


def is_warm() -> bool:
    """Return whether the loops, as their files lie here, were compiled on this machine before."""
    return _is_marked(_DONE)


def preparing_words(percent: int = 0) -> str:
    """Return what is said while `warm` compiles the loops, of which so much is done."""
    problem = kernels.FOLDER.problem
    if problem:
        return (
            f"Preparing the tracker: about a minute, and again at the next start, for {problem}. "
            "Make room there, or set XDG_CACHE_HOME to another folder of yours."
        )
    done = f"{percent} % done" if percent else "half a minute"
    return f"Preparing the tracker for this computer, once: {done}."


def warm() -> None:
    """Compile the loops, or load them."""
    from keypose.tracker.warming import PARTS, BoxScene

    if is_warm():
        _load(BoxScene.made())
    else:
        compiling = _Compiling(lambda percent: None)
        compiling.work(PARTS)
        compiling.finish()


def warm_tracking(report: Callable[[int], None]) -> None:
    """The same, but only until a segment can be tracked: the other loops are compiled beside.

    report: is told how many percent of that are done, on several threads, one at a time.
    """
    from keypose.tracker.warming import TRACKING, BoxScene

    if is_warm():
        _load(BoxScene.made())
    else:
        compiling = _Compiling(report)
        compiling.work(TRACKING)
        compiling.tell_no_more()
        Thread(target=compiling.finish, name="compiling", daemon=True).start()


def _load(box: BoxScene) -> None:
    """Load the loops; those for surfaces load in no time, should there be any at all."""
    from keypose.tracker.warming import PARTS

    for name, part in PARTS.items():
        if name != "surface":
            part.do(box)


class _Compiling:
    """Compiles parts in other processes, begun at once, and in this one.

    Where another process dies, what it was to compile is compiled when it is needed.
    """

    def __init__(self, report: Callable[[int], None]) -> None:
        from keypose.tracker.warming import PARTS, BoxScene

        self._parts, self._box = PARTS, BoxScene.made()
        self._waiting, self._done = deque(PARTS), 0
        self._report: Callable[[int], None] | None = report
        self._lock = Lock()
        self._threads = [Thread(target=self._work_beside, daemon=True) for _ in range(_helpers())]
        for thread in self._threads:
            thread.start()

    def work(self, among: Collection[str]) -> None:
        """Compile one after another of these, then load what others have compiled of them."""
        while (name := self._take(among)) is not None:
            self._parts[name].do(self._box)
            self._tell(name)
        if "track" in among:
            self._parts["track"].do(self._box)

    def tell_no_more(self) -> None:
        with self._lock:
            self._report = None

    def finish(self) -> None:
        """Wait until all are compiled."""
        for thread in self._threads:
            thread.join()
        self.work([name for name in self._parts if name != "track"])  # where there is no other
        _put_mark(_DONE)

    def _work_beside(self) -> None:
        from keypose.tracker.warming import Helper

        helper = Helper()
        try:
            while (name := self._take(self._parts)) is not None and helper.do(name):
                self._tell(name)
        finally:
            helper.close()

    def _take(self, among: Collection[str]) -> str | None:
        """The next part of these that nobody has taken."""
        with self._lock:
            name = next((name for name in self._waiting if name in among), None)
            if name is not None:
                self._waiting.remove(name)
            return name

    def _tell(self, name: str) -> None:
        """Report a part that is done, if it is one that tracking needs."""
        from keypose.tracker.warming import TRACKING

        with self._lock:
            if self._report is not None and name in TRACKING:
                self._done += TRACKING[name].share
                self._report(100 * self._done // sum(part.share for part in TRACKING.values()))


def _helpers() -> int:
    """How many processes to start besides this one; without a cache they would be of no use."""
    cores = os.cpu_count() or 1
    return 0 if kernels.FOLDER.path is None else min(cores, MOST_PROCESSES) - 1


def are_hulls_warm() -> bool:
    """Return whether the loops of visual hulls were compiled on this machine before."""
    return _is_marked(_HULLS_DONE)


def warm_hulls() -> None:
    """Compile these, or load them: on a ball that four cameras see as a disc."""
    from keypose.tracker.surface.cameras.footage import consistency
    from keypose.tracker.surface.cameras.hull import Silhouette, hull_field, hull_mesh
    from keypose.tracker.surface.cameras.rig import View

    camera = Camera(width=48, height=48, fx=48.0, fy=48.0, cx=23.5, cy=23.5)
    rows, columns = np.mgrid[:48, :48]
    disc = Silhouette(np.hypot(rows - 23.5, columns - 23.5) < 12)
    grey = (120 + 60 * np.sin(rows / 3) * np.sin(columns / 4)).astype(np.uint8)
    views = []
    for turn in np.arange(4) * np.pi / 2:
        R = np.array([[np.cos(turn), 0, np.sin(turn)], [0, 1, 0], [-np.sin(turn), 0, np.cos(turn)]])
        views.append(View(f"{turn:.0f}", camera, transform(R, np.array([0.0, 0.0, 2.0]))))
    mesh = hull_mesh(hull_field(views, [disc] * len(views), 0.08))
    consistency(mesh, views, [grey] * len(views))
    _put_mark(_HULLS_DONE)


def _is_marked(name: str) -> bool:
    return kernels.FOLDER.path is not None and _mark(name).exists()


def _put_mark(name: str) -> None:
    if kernels.FOLDER.path is not None:
        with suppress(OSError):  # the disk is full by now: they are compiled once more
            _mark(name).touch()


def _mark(name: str) -> Path:
    """A mark in the cache, valid for the loops' present files: numba compiles them again where
    their files are elsewhere or were rewritten, even with the same text."""
    files = sorted(Path(kernels.__file__).absolute().parent.glob("*.py"))
    stamps = [(str(file), (facts := file.stat()).st_mtime_ns, facts.st_size) for file in files]
    stamp = hashlib.sha256(repr(stamps).encode()).hexdigest()[:12]
    return Path(numba.config.CACHE_DIR) / f"{name}-{stamp}"  # type: ignore[attr-defined]
