"""Limits of memory and time for a process that reads files of strangers."""

from __future__ import annotations

import ctypes
from contextlib import suppress
from pathlib import Path


def limit_memory(extra: int, written_bytes: int = 0) -> None:
    """Limit what the process may use beyond what it does now, and let it write no file larger than
    that."""
    try:
        import resource
    except ImportError:  # a system without such limits: the caps on sizes and time remain
        return
    try:
        pages = int(Path("/proc/self/statm").read_text().split()[0])
    except OSError:
        pages = 2**30 // resource.getpagesize()
    allowed = pages * resource.getpagesize() + extra
    for kind, value in (
        (resource.RLIMIT_AS, allowed),
        (resource.RLIMIT_FSIZE, written_bytes),
        (resource.RLIMIT_CORE, 0),
    ):
        _lower(kind, value)


def give_back() -> None:
    """Give memory that is free within the process back to the system: arrays of all sizes that
    come and go leave holes, 7 MB a tracked segment."""
    try:
        ctypes.CDLL(None).malloc_trim(0)
    except (OSError, TypeError, AttributeError):
        return  # a system without it


def limit_time(seconds: int) -> None:
    """Limit the seconds of a processor from now on; the process ends when they are over."""
    try:
        import resource
    except ImportError:
        return
    used = resource.getrusage(resource.RUSAGE_SELF)
    _lower(resource.RLIMIT_CPU, int(used.ru_utime + used.ru_stime) + seconds + 1)


def _lower(kind: int, value: int) -> None:
    """The soft limit, as low as this or as the hard one."""
    import resource

    hard = resource.getrlimit(kind)[1]
    if hard != resource.RLIM_INFINITY:
        value = min(value, hard)
    with suppress(ValueError, OSError):  # a system that knows the limit but does not let it be set
        resource.setrlimit(kind, (value, hard))
