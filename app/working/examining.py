"""Look for damaged and for repeated frames, behind all else."""

from __future__ import annotations

import asyncio
import os
import sys
import threading
from collections.abc import Callable
from typing import TypeVar

from keypose.tracker.errors import VideoError
from keypose.tracker.session.references import Repeats
from keypose.tracker.video import Video, VideoInfo

T = TypeVar("T")

_NICENESS = 10
_PAUSE_S = 2.0
"""Before it begins: the page that a person waits for comes first, and a low priority does not free
the interpreter. And before it looks again: reading may show that frames are numbered otherwise."""
_SECONDS_TO_END = 5.0
"""Until what was cancelled is left to itself."""


class Examiner:
    """Decodes the whole video once, in a thread of its own, and again where reading numbers its
    frames anew; `show_damage` receives what is damaged, `show_repeats` which frames are repeated.
    """

    def __init__(
        self,
        loop: asyncio.AbstractEventLoop,
        video: Video,
        show_damage: Callable[[VideoInfo], None],
        show_repeats: Callable[[Repeats], None],
    ) -> None:
        """Both are called on the loop: `show_damage` as often as more is known to be damaged or
        missing, `show_repeats` when every frame has been decoded, where there are any."""
        self._loop, self._video = loop, video
        self._show_damage, self._show_repeats = show_damage, show_repeats
        self._known = Repeats()
        self._ended, self._reported = threading.Event(), video.info
        self._thread = threading.Thread(target=self._run, name="examining", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """End it, soon; nothing is reported any more."""
        self._ended.set()
        self._thread.join(_SECONDS_TO_END)

    def _run(self) -> None:
        _lower_priority()
        while not self._ended.wait(_PAUSE_S):
            try:
                self._examine()
            except VideoError:
                return  # closed or gone meanwhile: whoever reads frames gets the error

    def _examine(self) -> None:
        """Examine what is not examined yet: at first everything, then nothing or what has become of
        it.

        Until all of that is, what was found before still counts.
        """
        for _ in self._video.examine(0, self._video.info.frame_count - 1):
            if self._ended.is_set():
                return
            if _unusable(self._video.info) > _unusable(self._reported):
                self._pass_on(self._video.info)
        if _unusable(self._video.info) != _unusable(self._reported):
            self._pass_on(self._video.info)
        if (repeats := self._video.repeats()) != self._known:
            self._known = repeats
            self._loop.call_soon_threadsafe(self._report, self._show_repeats, repeats)

    def _pass_on(self, info: VideoInfo) -> None:
        self._reported = info
        self._loop.call_soon_threadsafe(self._report, self._show_damage, info)

    def _report(self, show: Callable[[T], None], news: T) -> None:
        if not self._ended.is_set():
            show(news)


def _unusable(info: VideoInfo) -> frozenset[int]:
    return frozenset((*info.damaged, *info.missing))


def _lower_priority() -> None:
    """Let others go first, where threads have a priority of their own."""
    if sys.platform == "linux":
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), _NICENESS)
