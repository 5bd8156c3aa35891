"""A person's seventeen joints in one region of one picture: MoveNet Thunder.

R. Votel and N. Li, *Next-Generation Pose Detection with MoveNet and TensorFlow.js*, 2021. The
person whose centre is hottest near the middle is taken; from there each joint is regressed, and
lies where its heat near by is greatest, moved by the offset there.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.layouts import LAYOUTS
from keypose.tracker.keypoints.model_files import THUNDER, Model, verified
from keypose.tracker.keypoints.region import Region
from keypose.tracker.keypoints.runtimes import Runtime, open_runtime, runtime_name

SIDE: Final = 256
"""Pixels of the network's input, along a side."""
NEARER: Final = 0.8
"""Its square by the side of BlazePose's region: it was trained on larger people."""
_OUTPUTS = ("heat", "reg", "center", "off")
"""Logits (17, 64, 64); rows and columns from a centre to each joint (34, 64, 64); logits of centres
(1, 64, 64); rows and columns from a cell to the joint in it (34, 64, 64)."""
_CELLS, _SOFTEST = 64, 1.8
"""Cells along a side; how many of them a peak of heat may lie off before it counts half."""
_CELL_PX, _SHIFT_PX = SIDE / _CELLS, -0.25


@dataclass(frozen=True, eq=False)
class SeenJoints:
    """What a network of joints sees: uv (K, 2) pixels of the whole picture, in the order of its
    names; confidence (K,) from 0 to 1."""

    uv: Array
    confidence: Array


class MoveNet:
    """A network that has been read. One thread at a time; the same input gives the same output."""

    names = LAYOUTS["COCO_17"]

    def __init__(self, model: Model, runtime: Runtime) -> None:
        self.model = model
        self._runtime = runtime

    @classmethod
    def open(cls, model: Model = THUNDER, *, fast: bool | None = None) -> MoveNet:
        """Read a network's file; fast, and KeypointError, as of `open_runtime`."""
        return cls(model, open_runtime(verified(model), _OUTPUTS, fast=fast))

    @property
    def fingerprint(self) -> str:
        """Digest all that decides what it sees: the network and what runs it."""
        return f"{self.model.sha256[:16]}-{self._runtime.name}"

    def infer(self, picture: NDArray[np.uint8], region: Region) -> SeenJoints:
        """The joints of the person in BlazePose's region of a picture (H, W, 3), RGB."""
        to_picture = replace(region, side=NEARER * region.side).to_picture(SIDE)
        square = cv2.warpAffine(
            picture, to_picture, (SIDE, SIDE), flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        )
        image = np.ascontiguousarray(square.transpose(2, 0, 1), dtype=np.float32)
        heat, reg, center, off = (
            maps[0] for maps in self._runtime.run(image / np.float32(127.5) - np.float32(1))
        )
        xy, confidence = _decoded(heat, reg, center[0], off)
        return SeenJoints(xy @ to_picture[:, :2].T + to_picture[:, 2], confidence)


def movenet_fingerprint(model: Model) -> str:
    """Return what the network would have as `MoveNet.fingerprint`, which is not read for it."""
    return f"{model.sha256[:16]}-{runtime_name(model.path.suffix)}"


def _decoded(heat: Array, reg: Array, center: Array, off: Array) -> tuple[Array, Array]:
    """Joints (17, 2) in pixels of the square, and their heat (17,)."""
    rows, columns = np.indices(center.shape)
    middle = (_CELLS - 1) / 2
    near_middle = 1 / (np.hypot(columns - middle, rows - middle) + _SOFTEST)
    row, column = _peak(_sigmoid(center) * near_middle)
    xy, confidence = np.empty((len(heat), 2)), np.empty(len(heat))
    for k, hot in enumerate(_sigmoid(heat)):
        to_row, to_column = reg[2 * k : 2 * k + 2, row, column]
        near = 1 / (np.hypot(columns - column - to_column, rows - row - to_row) + _SOFTEST)
        r, c = _peak(hot * near)
        xy[k] = c + off[2 * k + 1, r, c], r + off[2 * k, r, c]
        confidence[k] = hot[r, c]
    return _CELL_PX * xy + _SHIFT_PX, confidence


def _peak(values: Array) -> tuple[int, int]:
    row, column = np.unravel_index(int(values.argmax()), values.shape)
    return int(row), int(column)


def _sigmoid(x: Array) -> Array:
    return np.asarray(1 / (1 + np.exp(-np.clip(x, -50, 50))))
