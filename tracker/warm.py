"""Getting the compiled loops ready before they are needed.

The first run on a machine compiles them, in several processes and as far as they are needed; later
runs load them from disk. Tracking a tiny grey box does either, so that it can be done while a
person's video is still being read.
"""

from __future__ import annotations

import hashlib
import os
from collections import deque
from collections.abc import Callable, Collection, Sequence
from contextlib import suppress
from pathlib import Path
from threading import Lock, Thread
from typing import TYPE_CHECKING, Final

import numba
import numpy as np

from keypose.tracker import kernels
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import transform
from keypose.tracker.keypoints.on_body import is_persons
from keypose.tracker.session.evidence import ByEvidence, FilmEvidence, SurfaceEvidence

if TYPE_CHECKING:
    from keypose.tracker.session import Session
    from keypose.tracker.warming import BoxScene

_DONE = "warm"
_HULLS_DONE = "warm-hulls"
MOST_PROCESSES: Final = 3
"""More would wait for the largest part."""
BY_KEYPOINTS = ("passes", "keypoints", "refinement", "chains", "observation")
BY_BRIGHTNESS = ("passes", "drift", "refinement", "chains", "observation", "templates")
OF_FILMS = tuple(dict.fromkeys(BY_KEYPOINTS + BY_BRIGHTNESS))
"""Parts in `warming` that tracking needs, what takes longest and needs no other first."""


def needed(session: Session) -> Sequence[str]:
    """The parts of the loops that a session is tracked with; another one that is needed all
    the same is compiled then."""
    return _NEEDED.of(session)(session)


def _of_film(session: Session) -> Sequence[str]:
    by_keypoints = "keypoints" in session.settings.cues_used and is_persons(session.subject.body)
    return BY_KEYPOINTS if by_keypoints else BY_BRIGHTNESS


_NEEDED: ByEvidence[Callable[[Session], Sequence[str]]] = ByEvidence(
    {FilmEvidence: _of_film, SurfaceEvidence: lambda session: ("surface",)}
)


def is_warm(parts: Collection[str] = (_DONE,)) -> bool:
    """Whether the loops, all or these parts, as their files lie here, were compiled on this
    machine before."""
    return _is_marked(_DONE) or all(_is_marked(_mark_of(part)) for part in parts)


def preparing_words(percent: int = 0) -> str:
    """What is said while `warm` compiles the loops, of which so much is done."""
    problem = kernels.FOLDER.problem
    if problem:
        return (
            f"Preparing the tracker: about a minute, and again at the next start, for {problem}. "
            "Make room there, or set XDG_CACHE_HOME to another folder of yours."
        )
    done = f"{percent} % done" if percent else "half a minute"
    return f"Preparing the tracker for this computer, once: {done}."


def warm(parts: Collection[str]) -> None:
    """Compile these parts where they are not; what is compiled is loaded once it is used."""
    missing = [part for part in parts if not is_warm((part,))]
    if missing:
        compiling = _Compiling(missing, lambda percent: None)
        compiling.work(missing)
        compiling.finish()


def warm_all() -> None:
    """Compile all loops but those of hulls, wherever they are not."""
    from keypose.tracker.warming import PARTS

    if not is_warm():
        compiling = _Compiling(PARTS, lambda percent: None)
        compiling.work(PARTS)
        compiling.finish_all()


def warm_tracking(report: Callable[[int], None]) -> None:
    """Compile or load all loops, but wait only until a segment can be tracked.

    report: is told how many percent of that are done, on several threads, one at a time.
    """
    from keypose.tracker.warming import PARTS, TRACKING, BoxScene

    if is_warm():
        _load(BoxScene.made())
    else:
        compiling = _Compiling(PARTS, report)
        compiling.work(TRACKING)
        compiling.load_tracking()
        Thread(target=compiling.finish_all, name="compiling", daemon=True).start()


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

    def __init__(self, parts: Collection[str], report: Callable[[int], None]) -> None:
        from keypose.tracker.warming import PARTS, BoxScene

        self._parts, self._box = PARTS, BoxScene.made()
        self._waiting, self._done, self._shares = deque(parts), set[str](), 0
        self._report: Callable[[int], None] | None = report
        self._lock = Lock()
        helpers = min(_helpers(), len(parts) - 1)
        self._threads = [Thread(target=self._work_beside, daemon=True) for _ in range(helpers)]
        for thread in self._threads:
            thread.start()

    def work(self, among: Collection[str]) -> None:
        """Compile one after another of these that nobody has begun."""
        from keypose.tracker.warming import rarely_tidied

        with rarely_tidied():
            while (name := self._take(among)) is not None:
                self._parts[name].do(self._box)
                self._tell(name)

    def load_tracking(self) -> None:
        """Load what others have compiled, and say no more."""
        self._parts["track"].do(self._box)
        with self._lock:
            self._report = None

    def finish(self) -> None:
        """Wait until all are compiled."""
        for thread in self._threads:
            thread.join()
        self.work(self._parts)  # where there is no other process

    def finish_all(self) -> None:
        """The same, where these are all that there are."""
        self.finish()
        if self._done.issuperset(self._parts):
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
        """Remember a part that is done, and report it if it is one that tracking needs."""
        from keypose.tracker.warming import TRACKING

        _put_mark(_mark_of(name))
        with self._lock:
            self._done.add(name)
            if self._report is not None and name in TRACKING:
                self._shares += TRACKING[name].share
                self._report(100 * self._shares // sum(part.share for part in TRACKING.values()))


def _helpers() -> int:
    """How many processes to start besides this one; without a cache they would be of no use."""
    cores = os.cpu_count() or 1
    return 0 if kernels.FOLDER.path is None else min(cores, MOST_PROCESSES) - 1


def are_hulls_warm() -> bool:
    """Whether the loops of visual hulls were compiled on this machine before."""
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


def _mark_of(part: str) -> str:
    return part if part == _DONE else f"{_DONE}-{part}"


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
