"""The mask of the person against outlines drawn by hand.

The person is followed from a box around the first outline of a clip, one look a frame, to the last.
`bench/outlines.json` has rings of pixels by clip and frame, by two people who drew other frames
each; a pixel is inside where an odd number of rings is around it.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

from bench.clips import clip
from bench.table import Report
from keypose.tracker.keypoints.blazepose import BlazePose
from keypose.tracker.keypoints.detect import Seed, detect
from keypose.tracker.video import Video

Rings: TypeAlias = Sequence[Sequence[tuple[float, float]]]

OUTLINES = Path(__file__).with_name("outlines.json")
LEAST_IOU = 0.90
SHARES = 16
"""Of a pixel, to which corners are drawn."""


def mask(report: Report) -> None:
    """Intersection over union, frame by frame; a figure is what is missing to 1."""
    table = report.table("mask of the person, outlines by hand", "frame", "px tall", "IoU")
    network, found = BlazePose.open(), list[float]()
    for name, frames in json.loads(OUTLINES.read_text()).items():
        outlines = {int(frame): rings for frame, rings in frames.items()}
        first, last = min(outlines), max(outlines)
        with Video.open(clip(name).video) as video:
            height, width = video.frame(first).shape[:2]
            left, top, right, bottom = _ends(outlines[first]).ravel().tolist()
            seed = Seed.of_box(first, (left, top, right, bottom), width, height)
            seen = detect(video.frame, (first, last), [seed], network)
        for frame, rings in outlines.items():
            one, drawn = seen.mask(frame), _drawn(rings, (height, width))
            shown = np.zeros_like(drawn) if one is None else one.in_picture(width, height) > 0.5
            found.append(float((shown & drawn).sum() / (shown | drawn).sum()))
            tall = float(np.ptp(_ends(rings), axis=0)[1])
            table.row(name, frame, tall, found[-1])
    report.expect("1 − IoU in the mean", 1 - float(np.mean(found)), 1 - LEAST_IOU)


def _ends(rings: Rings) -> NDArray[np.float64]:
    """The corners of the box around rings: left and top, right and bottom."""
    places = np.array([place for ring in rings for place in ring])
    return np.stack([places.min(axis=0), places.max(axis=0)])


def _drawn(rings: Rings, shape: tuple[int, int]) -> NDArray[np.bool_]:
    inside = np.zeros(shape, np.bool_)
    for ring in rings:
        corners = np.round(np.array(ring) * SHARES).astype(np.int32)
        inside ^= cv2.fillPoly(np.zeros(shape, np.uint8), [corners], 1, shift=4) > 0
    return inside
