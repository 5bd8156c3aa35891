"""How loud a film is from moment to moment, on the clock of its pictures."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from av import AudioResampler

from keypose.tracker.errors import VideoError
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.video.container import PYAV_ERRORS, open_container

RATE_HZ = 8000
STEP_S = 0.005
"""Of a moment."""
QUIET = 1e-4
"""Of full scale: what is quieter is silence."""
LONGEST_S = 600.0
"""Of a film's sound that is listened to."""


@dataclass(frozen=True, eq=False)
class Loudness:
    """How loud (N,) a film is at moments STEP_S apart, in logarithms of its amplitude.

    begins_s: the first of them, seconds after the film's first picture.
    """

    begins_s: float
    levels: Array


def loudness_of(path: Path) -> Loudness | None:
    """The loudness of a film; None where it has no sound, or none that can be decoded."""
    if not path.is_file():
        return None
    try:
        pieces = _samples(path)
    except (VideoError, *PYAV_ERRORS):
        return None  # pictures count all the same
    if pieces is None:
        return None
    begins_s, samples = pieces
    step = round(RATE_HZ * STEP_S)
    count = len(samples) // step
    if count < 2:
        return None
    # differences leave out wind and rumble, which is each microphone's own
    sharp = np.diff(samples[: count * step], prepend=samples[0]).reshape(count, step)
    return Loudness(begins_s, np.log(np.sqrt((sharp**2).mean(axis=1)) + QUIET))


def _samples(path: Path) -> tuple[float, Array] | None:
    """When the first sample is heard, seconds after the first picture, and all of them."""
    with open_container(path) as container:
        if not container.streams.audio or not container.streams.video:
            return None
        sound, pictures = container.streams.audio[0], container.streams.video[0]
        first_picture_s = float((pictures.start_time or 0) * (pictures.time_base or 0))
        resampler, begins_s = AudioResampler("flt", "mono", RATE_HZ), None
        blocks: list[Array] = []
        heard = 0
        for frame in container.decode(sound):
            if begins_s is None:
                begins_s = float(frame.time or 0.0) - first_picture_s
            for block in resampler.resample(frame):
                blocks.append(block.to_ndarray().astype(np.float64).ravel())
                heard += len(blocks[-1])
            if heard > LONGEST_S * RATE_HZ:
                break
    return None if begins_s is None or not blocks else (begins_s, np.concatenate(blocks))
