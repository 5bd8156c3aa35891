"""What is found from a clip's pictures, kept while these are ready.

When one keyframe is moved again and again, the clips beside it stay the same, and so does what
comes from them and the far keyframes alone.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from threading import Lock
from typing import Generic, TypeVar
from weakref import WeakKeyDictionary

from keypose.tracker.video.pyramid import Clip

Found = TypeVar("Found")


class PerClip(Generic[Found]):
    """The most recently used results of each clip, so many at most; for threads side by side."""

    def __init__(self, most: int) -> None:
        self._most, self._lock = most, Lock()
        self._kept: WeakKeyDictionary[Clip, OrderedDict[Hashable, Found]] = WeakKeyDictionary()

    def get(self, clip: Clip, key: Hashable, find: Callable[[], Found]) -> Found:
        """What is kept of a clip under a key, which says all else that decides it; found
        where nothing is."""
        with self._lock:
            kept = self._kept.setdefault(clip, OrderedDict())
            if key in kept:
                kept.move_to_end(key)
                return kept[key]
        value = find()
        with self._lock:
            kept[key] = value
            while len(kept) > self._most:
                kept.popitem(last=False)
        return value
