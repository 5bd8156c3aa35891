"""Keep how fast this computer drafts, in this user's cache folder: seconds a frame, by network.

Measured by inference at noise before the first draft, then by the drafts themselves. Whatever is
wrong with the file, it is as if there was none.
"""

from __future__ import annotations

import json
import time
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import Final

import numpy as np

from keypose.tracker.errors import KeyposeError
from keypose.tracker.files import read_own
from keypose.tracker.keypoints.detect import Detector
from keypose.tracker.keypoints.model_files import cache_folder, find_model
from keypose.tracker.keypoints.region import Region
from keypose.tracker.storage.atomic import make_folder, write_file

NETWORK_SHARE: Final = 0.9
"""Of the time that a draft takes, the network's."""
PASSES: Final = 3
"""Inference passes at a picture of noise; the quickest counts, as the first has to get ready."""
SIDE_PX: Final = 480
MOST_BYTES: Final = 2**14
SLOWEST_S: Final = 600.0


def seconds_a_frame(network: str) -> float | None:
    """How long a frame of a draft takes by the network of this name; None where nobody
    knows."""
    path = _path()
    try:
        stamp = path.stat().st_mtime_ns
    except OSError:
        return None
    return _paces(path, stamp).get(network)


def keep_seconds_a_frame(network: str, seconds: float) -> None:
    """Keep what a frame took, if that can be done."""
    if not 0.0 < seconds < SLOWEST_S:
        return
    path = _path()
    with suppress(OSError, KeyposeError):
        seconds_of_network = _read(path) | {network: round(seconds, 5)}
        make_folder(path.parent, error=KeyposeError)
        write_file(
            path, json.dumps(seconds_of_network).encode(), overwrite=True, error=KeyposeError
        )


def known_or_measured(network: str) -> float:
    """Seconds a frame by the network of this name; measured and kept where nobody knows.
    KeypointError as of `open_detector`."""
    from keypose.tracker.keypoints import detectors  # loads what only this needs

    kept_seconds = seconds_a_frame(network)
    if kept_seconds is not None:
        return kept_seconds
    model = find_model(network)
    opened = detectors.open_animal_detector if model.of_animals else detectors.open_detector
    seconds = measured_seconds_a_frame(opened(model))
    keep_seconds_a_frame(network, seconds)
    return seconds


def measured_seconds_a_frame(detector: Detector) -> float:
    """Measure how long a frame of a draft will take, by inference at noise."""
    shape = (SIDE_PX, SIDE_PX, 3)
    noise = np.random.default_rng(0).integers(0, 256, shape).astype(np.uint8)
    region = Region.of_box((0.0, 0.0, float(SIDE_PX), float(SIDE_PX)), SIDE_PX, SIDE_PX)
    took = []
    for _ in range(PASSES):
        began = time.perf_counter()
        detector.infer(noise, region)
        took.append(time.perf_counter() - began)
    return min(took) / NETWORK_SHARE


def _path() -> Path:
    return cache_folder() / "draft-pace.json"


@lru_cache(maxsize=2)
def _paces(path: Path, _stamp: int) -> dict[str, float]:
    return _read(path)


def _read(path: Path) -> dict[str, float]:
    try:
        content = json.loads(read_own(path, MOST_BYTES))
        return {
            str(name): float(seconds)
            for name, seconds in content.items()
            if 0.0 < float(seconds) < SLOWEST_S
        }
    except (OSError, ValueError, TypeError, AttributeError):
        return {}
