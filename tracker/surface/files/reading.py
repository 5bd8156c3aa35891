"""Reading meshes in a child process that may fail without harm.

Files of strangers can be made so that reading them takes all memory or never ends. So they are read
beside this program: the process that does it has little memory and little time, is ended when it
takes more, and started anew for the next file.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import weakref
from contextlib import suppress
from pathlib import Path
from typing import Any, Final, Self

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.errors import SurfaceError
from keypose.tracker.surface.files.parsing.raw import MOST_FACES, MOST_VERTICES, MeshRefused
from keypose.tracker.surface.files.wire import BrokenConnection, ask, receive
from keypose.tracker.surface.mesh import SurfaceMesh

MEMORY_BYTES: Final = 2 * 2**30
"""Memory of the child beyond what it starts with."""
SECONDS: Final = 30
"""For one file, of a processor as well as of the clock."""
_LONGEST_REFUSAL: Final = 500
"""Characters of a reason that the reading process gives."""


class MeshReader:
    """Asks a child process for meshes, one after the other; several threads may share it.

    The child is started by the first question, and ends with `close` or with this object.
    """

    def __init__(self, memory_bytes: int = MEMORY_BYTES, seconds: int = SECONDS) -> None:
        self._limits = (memory_bytes, seconds)
        self._lock = threading.Lock()
        self._child: subprocess.Popen[bytes] | None = None
        self._end: weakref.finalize[[subprocess.Popen[bytes]], MeshReader] | None = None

    def mesh(self, path: Path) -> SurfaceMesh:
        """The mesh of a file, in the file's frame and units. Refused, with the end of a sentence
        about the file, where there is none."""
        with self._lock:
            facts, arrays = self._exchange({"path": str(path), "kind": path.suffix.lower()})
            if facts.get("leaving"):
                self._stop()
        if "refused" in facts:
            raise MeshRefused(str(facts["refused"])[:_LONGEST_REFUSAL])
        return _mesh(arrays)

    def close(self) -> None:
        """End the child. A later question starts another."""
        with self._lock:
            self._stop()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def _exchange(self, question: dict[str, Any]) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
        child = self._running()
        assert child.stdin is not None
        assert child.stdout is not None
        late = threading.Event()
        clock = threading.Timer(self._limits[1], _end_late, (child, late))
        clock.daemon = True
        clock.start()
        try:
            ask(child.stdin, question)
            return receive(child.stdout)
        except (BrokenConnection, OSError) as error:
            self._stop()
            raise MeshRefused(self._failure(child.returncode, late.is_set())) from error
        except BaseException:
            self._stop()  # its late answer would be taken for the next one
            raise
        finally:
            clock.cancel()

    def _failure(self, code: int | None, late: bool) -> str:
        """Why the child ended without an answer."""
        if late or code == -getattr(signal, "SIGXCPU", 0):
            return f"takes longer than {self._limits[1]} s to read: simplify it."
        return "cannot be read: export it again."

    def _running(self) -> subprocess.Popen[bytes]:
        if self._child is not None and self._child.poll() is None:
            return self._child
        self._stop()
        try:
            self._child = _start(*self._limits)
        except OSError as error:
            raise SurfaceError(
                "The process that reads meshes could not be started: close other programs."
            ) from error
        self._end = weakref.finalize(self, _end_child, self._child)
        return self._child

    def _stop(self) -> None:
        if self._end is not None:
            self._end()
        self._child = self._end = None


def _start(memory_bytes: int, seconds: int) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        # -P: nothing that lies in the present folder may pass for a module.
        [
            sys.executable,
            "-P",
            "-m",
            "keypose.tracker.surface.files.child",
            str(memory_bytes),
            str(seconds),
        ],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        # Threads of linear algebra take much address space, and there is none to do.
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
        start_new_session=True,  # so that Ctrl+C reaches this program, which then ends it
    )


def _end_late(child: subprocess.Popen[bytes], late: threading.Event) -> None:
    """End a child that takes too long, and note that this was why."""
    late.set()
    child.kill()


def _end_child(child: subprocess.Popen[bytes]) -> None:
    child.kill()
    child.wait()
    for stream in (child.stdin, child.stdout):
        if stream is not None:
            with suppress(OSError):  # nobody reads what was still to be sent
                stream.close()


def _mesh(arrays: dict[str, NDArray[Any]]) -> SurfaceMesh:
    """The arrays of an answer, checked again: the file may have taken over the child."""
    vertices, faces = arrays.get("vertices"), arrays.get("faces")
    consistency = arrays.get("consistency")
    if (
        vertices is None
        or faces is None
        or vertices.ndim != 2
        or vertices.shape[1] != 3
        or not 0 < len(vertices) <= MOST_VERTICES
        or vertices.dtype.kind != "f"
        or not np.isfinite(vertices).all()
        or faces.ndim != 2
        or faces.shape[1] != 3
        or not 0 < len(faces) <= MOST_FACES
        or faces.dtype.kind != "i"
        or faces.min() < 0
        or faces.max() >= len(vertices)
        or not (consistency is None or _is_consistency(consistency, len(vertices)))
    ):
        raise MeshRefused("cannot be read: export it again.")
    return SurfaceMesh(vertices, faces.astype(np.int64), consistency)


def _is_consistency(values: NDArray[Any], count: int) -> bool:
    return values.shape == (count,) and bool((np.abs(values) <= 1).all())
