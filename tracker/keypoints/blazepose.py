"""A person's keypoints in one region of one picture, with depth: BlazePose.

V. Bazarevsky and others, *BlazePose: On-device Real-time Body Pose Tracking*, 2020; the network's
points in metres: I. Grishchenko and others, *BlazePose GHUM Holistic*, 2022.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.keypoints import other_side
from keypose.tracker.keypoints.model_files import FULL, Model, verified
from keypose.tracker.keypoints.person_mask import PersonMask
from keypose.tracker.keypoints.region import Region
from keypose.tracker.keypoints.runtimes import Runtime, open_runtime, runtime_name

_SIDES = ("left", "right")
NAMES: Final = (
    "nose",
    *(f"{side}_eye{where}" for side in _SIDES for where in ("_inner", "", "_outer")),
    *(f"{side}_ear" for side in _SIDES),
    "mouth_left",
    "mouth_right",
    *(
        f"{side}_{point}"
        for point in (
            *("shoulder", "elbow", "wrist", "pinky", "index", "thumb"),
            *("hip", "knee", "ankle", "heel", "foot_index"),
        )
        for side in _SIDES
    ),
)
"""MediaPipe's 33 names, in the network's order."""

SIDE: Final = 256
"""Pixels of the network's input, along a side."""

_EXCHANGED = [NAMES.index(other_side(name, NAMES)) for name in NAMES]
"""By point the index of its counterpart on the other side."""
_MIRROR = np.array([[-1.0, 0.0, SIDE - 1], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
"""From pixels of the square as the network is shown it to those of the square as it is."""

# What follows is as MediaPipe has it.
_POINTS = 39
"""Points that the network answers with: those of NAMES, then some of its own."""
_MIDDLE = 33
"""Index of the middle of the circle around the body."""
_RIM = 34
"""Index of a point on that circle."""
_HEAT_SIDE = 64
"""Pixels of a heat map along a side."""
_HEAT_WINDOW = 3
"""Pixels of a heat map to each side of a point, in which its peak is looked for."""
_LEAST_HEAT = 0.5
"""What the peak must reach."""
_OUTPUTS = ("Identity", "Identity_1", "Identity_2", "Identity_3", "Identity_4")
"""Points, presence, mask, heat maps and metres."""


@dataclass(frozen=True, eq=False)
class Seen:
    """What the network sees in one region.

    uv:         (33, 2) pixels of the whole picture, in the order of NAMES; of an animal those of
                AP_10K.
    visibility: (33,) from 0 to 1.
    p_hips:     (33, 3) metres in axes parallel to the picture's, the middle of the hips at 0.
    presence:   from 0 to 1, how sure it is that somebody is there.
    next:       the region around this body, to look at in the next frame.
    mask:       where in the region the person is; of several looks the plain one's. None where the
                network does not say it.
    """

    uv: Array
    visibility: Array
    p_hips: Array
    presence: float
    next: Region
    mask: PersonMask | None = None

    def exchanged(self) -> Seen:
        """Exchange left and right."""
        return replace(
            self,
            uv=self.uv[_EXCHANGED],
            visibility=self.visibility[_EXCHANGED],
            p_hips=self.p_hips[_EXCHANGED],
        )


class BlazePose:
    """A network that has been read. One thread at a time; the same input gives the same output."""

    def __init__(self, model: Model, runtime: Runtime) -> None:
        self.model = model
        self._runtime = runtime

    @classmethod
    def open(cls, model: Model = FULL, *, fast: bool | None = None) -> BlazePose:
        """Read a network's file; fast, and KeypointError, as of `open_runtime`."""
        return cls(model, open_runtime(model.file, verified(model), _OUTPUTS, fast=fast))

    @property
    def fingerprint(self) -> str:
        """Digest all that decides what it sees: the network and what runs it."""
        return f"{self.model.sha256[:16]}-{self._runtime.name}"

    def infer(self, picture: NDArray[np.uint8], region: Region, *, mirrored: bool = False) -> Seen:
        """The keypoints of the person in a region of a picture (H, W, 3), RGB.

        mirrored: the network is shown the region as in a mirror; what it sees is mirrored back.
        """
        to_picture = region.to_picture(SIDE) @ (_MIRROR if mirrored else np.eye(3))
        square = cv2.warpAffine(
            picture, to_picture, (SIDE, SIDE), flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        )
        points, presence, mask, heat, metres = self._runtime.run(
            np.ascontiguousarray(square.transpose(2, 0, 1), dtype=np.float32) / np.float32(255)
        )
        rows = points.reshape(_POINTS, 5).astype(float)
        uv = _sharpened(rows[:, :2], _channels_first(heat, _POINTS))
        uv = uv @ to_picture[:, :2].T + to_picture[:, 2]
        p = metres.reshape(_POINTS, 3)[: len(NAMES)].astype(float)
        p[:, 0] *= -1 if mirrored else 1
        p[:, :2] @= region.R_picture_body.T
        share = _sigmoid(mask.reshape(SIDE, SIDE)[:, :: -1 if mirrored else 1].astype(float))
        detection = Seen(
            uv[: len(NAMES)],
            _sigmoid(rows[: len(NAMES), 3]),
            p,
            float(presence.ravel()[0]),
            Region.of_circle(uv[_MIDDLE], uv[_RIM]),
            PersonMask.of(region, share),
        )
        return detection.exchanged() if mirrored else detection


def fingerprint_of(model: Model) -> str:
    """The `fingerprint` that a network would have once it is opened."""
    return f"{model.sha256[:16]}-{runtime_name(model.path.suffix)}"


def _channels_first(maps: NDArray[np.float32], channels: int) -> NDArray[np.float32]:
    """Maps (channels, H, W), which some runtimes list channels last."""
    first: NDArray[np.float32] = maps[0]
    return first if len(first) == channels else first.transpose(2, 0, 1)


def _sharpened(xy: Array, heat: NDArray[np.float32]) -> Array:
    """Points (39, 2) moved to the centre of their heat (39, 64, 64) around them, where that is hot.

    As MediaPipe does; in pixels of the square.
    """
    xy = xy.copy()
    scale = SIDE / _HEAT_SIDE
    for j in range(len(NAMES)):
        if not np.isfinite(xy[j]).all():
            continue
        x, y = (xy[j] / scale).astype(int)
        if not (0 <= x < _HEAT_SIDE and 0 <= y < _HEAT_SIDE):
            continue
        left, top = max(x - _HEAT_WINDOW, 0), max(y - _HEAT_WINDOW, 0)
        logits = heat[j, top : y + _HEAT_WINDOW + 1, left : x + _HEAT_WINDOW + 1]
        patch = _sigmoid(logits.astype(float))
        if patch.max() < _LEAST_HEAT:
            continue
        rows, columns = np.indices(patch.shape)
        total = patch.sum()
        xy[j] = (
            scale * (left + (columns * patch).sum() / total),
            scale * (top + (rows * patch).sum() / total),
        )
    return xy


def _sigmoid(x: Array) -> Array:
    return 1 / (1 + np.exp(-np.clip(x, -50, 50)))
