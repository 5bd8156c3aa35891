"""Compiling the loops before the work, so that a person knows what takes a minute."""

from __future__ import annotations

import sys


def warm_tracker() -> None:
    """The first run on a computer takes its time, and says so."""
    from keypose.tracker.warm import is_warm, preparing_words, warm

    if not is_warm():
        print(preparing_words(), file=sys.stderr)
        warm()


def warm_hull_kernels() -> None:
    """The same for surfaces from silhouettes."""
    from keypose.tracker.warm import are_hulls_warm, warm_hulls

    if not are_hulls_warm():
        print("Preparing hulls for this computer, once: some ten seconds.", file=sys.stderr)
        warm_hulls()
