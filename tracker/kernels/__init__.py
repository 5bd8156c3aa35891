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
    chosen = numba.config.CACHE_DIR  # type: ignore[attr-defined]
    if chosen:
        return Path(chosen) / version
    home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    place = home / "keypose" / "kernels" / version
    if _is_writable(place):
        return place
    # A home that cannot be written: a fresh private folder, for what lies in it is executed.
    return Path(tempfile.mkdtemp(prefix="keypose-loops-"))


def _is_writable(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


numba.config.CACHE_DIR = str(_cache_folder())  # type: ignore[attr-defined]


def compiled(function: F) -> F:
    """Compile a loop with the settings above."""
    loop: Any = numba.njit(cache=True, nogil=True, error_model="numpy", fastmath=_FREEDOM)(function)
    return loop
