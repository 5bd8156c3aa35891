"""The names of pictures that are written of a film's frames."""

from __future__ import annotations

from collections.abc import Iterable

from keypose.tracker.video import VideoInfo


def picture_names(info: VideoInfo, frames: Iterable[int]) -> list[str]:
    """The names of the pictures of these frames, with the numbers of the film's own
    pictures where these are numbered."""
    numbers = info.file_numbers or range(info.frame_count)
    digits = max(4, len(str(numbers[-1])))
    return [f"frame{numbers[frame]:0{digits}}.png" for frame in frames]
