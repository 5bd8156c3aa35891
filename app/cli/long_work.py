"""Prepare long work by compiling the loops, report it, and let Ctrl+C or SIGTERM end it."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from keypose.tracker.session import Session


def warm_tracker(session: Session | None = None) -> None:
    """The first run on a computer takes its time, and says so.

    session: what is tracked; None where it is not known yet.
    """
    from keypose.tracker.warm import OF_FILMS, is_warm, needed, preparing_words, warm

    parts = OF_FILMS if session is None else needed(session)
    if not is_warm(parts):
        print(preparing_words(), file=sys.stderr)
        warm(parts)


def warm_hull_kernels() -> None:
    """The same for surfaces from silhouettes."""
    from keypose.tracker.warm import are_hulls_warm, warm_hulls

    if not are_hulls_warm():
        print("Preparing hulls for this computer, once: some ten seconds.", file=sys.stderr)
        warm_hulls()


@contextmanager
def share_reporter(as_json: bool) -> Iterator[Callable[[float], None]]:
    """JSON lines, a bar at a terminal, or nothing: a log needs no progress."""
    if as_json:
        from keypose.app.cli.json_output import print_json

        said = -1

        def report(share: float) -> None:
            nonlocal said
            if int(100 * share) > said:
                said = int(100 * share)
                print_json({"event": "progress", "percent": said})

        yield report
    elif sys.stderr.isatty():
        from tqdm import tqdm

        with tqdm(total=100, unit="%", file=sys.stderr, dynamic_ncols=True) as bar:

            def draw(share: float) -> None:
                bar.n = round(100 * share)
                bar.refresh()

            yield draw
    else:
        yield lambda share: None


Handler: TypeAlias = Callable[[int, FrameType | None], None]


@contextmanager
def set_when_interrupted(stop: threading.Event) -> Iterator[None]:
    """Within, the first such signal sets the event and the next one raises KeyboardInterrupt."""

    def handle(*_: object) -> None:
        if stop.is_set():
            raise KeyboardInterrupt
        stop.set()

    with _handlers(handle, signal.SIGINT, signal.SIGTERM):
        yield


@contextmanager
def sigterm_as_ctrl_c() -> Iterator[None]:
    """Within, SIGTERM raises KeyboardInterrupt, so that what is half done is cleared away."""

    def handle(*_: object) -> None:
        raise KeyboardInterrupt

    with _handlers(handle, signal.SIGTERM):
        yield


@contextmanager
def _handlers(handle: Handler, *numbers: signal.Signals) -> Iterator[None]:
    """A signal that is ignored stays so: whoever started this program wants that."""
    before = {number: signal.getsignal(number) for number in numbers}
    before = {n: handler for n, handler in before.items() if handler not in (signal.SIG_IGN, None)}
    if threading.current_thread() is not threading.main_thread():  # no other may set handlers
        before = {}
    for number in before:
        signal.signal(number, handle)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
