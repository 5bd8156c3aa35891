"""How loops are compiled, and where what was compiled is kept.

Without the interpreter's lock, so that segments run side by side in threads; kept on disk between
runs; IEEE comparisons intact (a NaN stays a NaN), sums free to be reordered so that they vectorise.
The disk cache is keyed by the kernels' own text, because numba looks only at the file of the
outermost function.
"""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar

import numba
from numba.core import types

from keypose.tracker.kernels.folder import loop_folder

F = TypeVar("F", bound=Callable[..., Any])

_FREEDOM = {"reassoc", "contract", "nsz", "arcp"}


def _version() -> str:
    """Digest the loops' text, and what compiles it."""
    text = b"".join(path.read_bytes() for path in sorted(Path(__file__).parent.glob("*.py")))
    version = f"{numba.__version__}-{hashlib.sha256(text).hexdigest()[:16]}"
    return f"{sys.implementation.cache_tag}-{version}"


FOLDER = loop_folder(_version(), numba.config.CACHE_DIR)  # type: ignore[attr-defined]
numba.config.CACHE_DIR = str(FOLDER.path or "")  # type: ignore[attr-defined]


def compiled(function: F) -> F:
    """Compile a loop with the settings above."""
    kept = FOLDER.path is not None
    loop: Any = numba.njit(cache=kept, nogil=True, error_model="numpy", fastmath=_FREEDOM)(function)
    if numba.config.DISABLE_JIT:  # type: ignore[attr-defined]
        return loop
    called = loop.get_call_template
    loop.get_call_template = lambda args, kws: called(*_of_any_value(args, kws))
    if kept:
        save = loop._cache.save_overload
        loop._cache.save_overload = lambda *given: _if_there_is_room(save, *given)
    return loop


def _of_any_value(args: tuple[Any, ...], kws: dict[str, Any]) -> tuple[tuple[Any, ...], Any]:
    """The types of what another loop passes, without the values of constants: numba would compile
    a loop once more for each of them."""
    plain = {name: types.unliteral(kind) for name, kind in kws.items()}
    return tuple(map(types.unliteral, args)), plain


def _if_there_is_room(save: Callable[..., None], *given: Any) -> None:
    """A disk that is full by now stops nothing: the loop is compiled once more the next time.

    One process at a time: numba gives two that save a loop for different arguments one file name,
    and the one's code would be run for the other's.
    """
    from filelock import FileLock  # what is compiled already needs none

    with suppress(OSError), FileLock(f"{numba.config.CACHE_DIR}/saving.lock"):  # type: ignore[attr-defined]
        save(*given)
