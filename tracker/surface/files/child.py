"""The child process that reads files of strangers, within limits of memory and time.

    python -m keypose.tracker.surface.files.child MEMORY_BYTES SECONDS

It answers the questions of `reading` on its standard input until that ends: with a mesh, or with
the end of a sentence that says why there is none. Its limits are
MEMORY_BYTES beyond what it needs to start, and SECONDS of a processor for one question; it may
write no file.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, BinaryIO, Final

from keypose.tracker.limits import limit_memory, limit_time
from keypose.tracker.surface.files.parsing.glb import read_glb
from keypose.tracker.surface.files.parsing.obj import read_obj
from keypose.tracker.surface.files.parsing.ply import read_ply
from keypose.tracker.surface.files.parsing.raw import MeshRefused, RawMesh, open_mesh_file
from keypose.tracker.surface.files.parsing.tidying import tidy
from keypose.tracker.surface.files.wire import answer, question_of

READERS: Final[dict[str, Callable[[BinaryIO], RawMesh]]] = {
    ".ply": read_ply,
    ".obj": read_obj,
    ".glb": read_glb,
}


def main() -> None:
    memory, seconds = int(sys.argv[1]), int(sys.argv[2])
    # Whatever a library prints must not get between the answers.
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    limit_memory(memory)
    for line in sys.stdin.buffer:
        limit_time(seconds)
        try:
            _send(answers, _mesh(question_of(line)))
        except MeshRefused as why:
            answer(answers, {"refused": str(why)})
        except MemoryError:
            # Memory that was full is in pieces; the next question goes to a fresh process.
            refusal = "needs too much memory to be read: simplify it."
            answer(answers, {"refused": refusal, "leaving": True})
            return
        except Exception:  # noqa: BLE001 — a parser met something unforeseen
            answer(answers, {"refused": "cannot be read: export it again."})


def _mesh(question: dict[str, Any]) -> RawMesh:
    with open_mesh_file(Path(question["path"])) as file:
        return tidy(READERS[question["kind"]](file))


def _send(answers: BinaryIO, mesh: RawMesh) -> None:
    arrays = {"vertices": mesh.vertices, "faces": mesh.faces}
    if mesh.consistency is not None:
        arrays["consistency"] = mesh.consistency
    answer(answers, {}, arrays)


if __name__ == "__main__":
    main()
