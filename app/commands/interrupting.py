"""Ctrl+C while something long is at work: once to let it come to rest, twice to break it off."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def set_by_ctrl_c(stop: threading.Event) -> Iterator[None]:
    """Within, the first Ctrl+C sets the event and the next one raises KeyboardInterrupt."""
    before = signal.getsignal(signal.SIGINT)
    on_main = threading.current_thread() is threading.main_thread()
    if before in (signal.SIG_IGN, None) or not on_main:  # whoever ignores Ctrl+C goes on doing so
        yield
        return

    def handle(*_: object) -> None:
        if stop.is_set():
            raise KeyboardInterrupt
        stop.set()

    signal.signal(signal.SIGINT, handle)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
