"""The compiled inner loops. Each has a plain numpy twin in the tests that it must agree with.

`compiled` is how every loop is compiled: without the interpreter's lock, so that segments run side
by side in threads; kept on disk between runs; IEEE comparisons intact (a NaN stays a NaN), sums
free to be reordered so that they vectorise. The disk cache is keyed by the kernels' own text,
because numba looks only at the file of the outermost function.
"""

from __future__ import annotations

import hashlib
import os
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import numba

F = TypeVar("F", bound=Callable[..., Any])

_FREEDOM = {"reassoc", "contract", "nsz", "arcp"}


def _cache_folder() -> Path:
    """A folder of this user's for the compiled loops, one for each version of their text."""
    text = b"".join(path.read_bytes() for path in sorted(Path(__file__).parent.glob("*.py")))
    version = f"{numba.__version__}-{hashlib.sha256(text).hexdigest()[:16]}"
    version = f"{sys.implementation.cache_tag}-{version}"
    base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    for folder in (base, Path(tempfile.gettempdir()) / f"keypose-{os.getuid()}"):
        place = folder / "keypose" / "kernels" / version
        try:
            place.mkdir(parents=True, exist_ok=True)
        except OSError:  # a read-only home: the next place will do
            continue
        return place
    raise OSError("No folder can be written for the compiled loops; set NUMBA_CACHE_DIR to one.")


if not numba.config.CACHE_DIR:  # type: ignore[attr-defined]
    numba.config.CACHE_DIR = str(_cache_folder())  # type: ignore[attr-defined]


def compiled(function: F) -> F:
    """Compile a loop with the settings above."""
    loop: Any = numba.njit(cache=True, nogil=True, error_model="numpy", fastmath=_FREEDOM)(function)
    return loop
