"""Compiled inner loops: arrays in, arrays out.

Each has a plain numpy twin in the tests that it must agree with; that of terms is what compares
one pose (`solver/plain_placed.py`). `compiled` is how every loop is compiled, see `compiling`;
numba is loaded with the first of them, and not with `layout`.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from keypose.tracker.kernels.compiling import FOLDER, compiled

__all__ = ["FOLDER", "compiled"]


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module("keypose.tracker.kernels.compiling"), name)
