"""The kinds of networks of joints: what each is shown, and how its outputs are decoded.

movenet: R. Votel and N. Li, *Next-Generation Pose Detection with MoveNet and TensorFlow.js*, 2021.
simcc:   T. Jiang and others, *RTMPose: Real-Time Multi-Person Pose Estimation based on MMPose*,
         2023; RTMW is the same with hands and face.
rtmo:    P. Lu and others, *RTMO: Towards High-Performance One-Stage Real-Time Multi-Person Pose
         Estimation*, 2024.
maps:    Y. Xu and others, *ViTPose: Simple Vision Transformer Baselines for Human Pose
         Estimation*, 2022.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Final, NamedTuple, TypeAlias

import cv2
import numpy as np

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.model_files import JointHeads, JointKind, Levels
from keypose.tracker.keypoints.runtimes import Tensor

Size: TypeAlias = tuple[int, int]
"""Width and height of a network's input, pixels."""


class Kind(NamedTuple):
    """What is particular to one kind.

    title:    what its networks are called.
    outputs:  their names; of none there is one, called anyhow.
    prepared: the input of levels (3, H, W), RGB from 0 to 255.
    decoded:  joints (K, 2) in pixels of the input, and confidence (K,) from 0 to 1.
    share:    of the region's side, what the input's shorter side shows.
    outside:  the level beyond the picture's edges.
    needs_fast: whether ONNX Runtime alone can run it.
    doubted:  mean confidence of the joints up to which they are not believed, and from which on
              they wholly are.
    everybody: the same as `decoded` of each person in the input; None where a kind shows one alone.
    """

    title: str
    outputs: tuple[str, ...]
    prepared: Callable[[Tensor], Tensor]
    decoded: Callable[[Sequence[Tensor], Size], tuple[Array, Array]]
    share: float
    outside: Sequence[float] = (0.0, 0.0, 0.0)
    needs_fast: bool = False
    doubted: tuple[float, float] = (0.0, 0.0)
    everybody: Callable[[Sequence[Tensor], Size], list[tuple[Array, Array]]] | None = None


_CIRCLE: Final = 0.8
"""The circle around the body, around which BlazePose's region leaves a margin. In an input of 3 : 4
an upright person then is 0.71 of its height. Those networks were trained on boxes × 1.25, thus 0.8
of the height, by up to a half larger and smaller; that much would cut off arms stretched out."""
IMAGENET: Final = Levels(mean=(123.675, 116.28, 103.53), std=(58.395, 57.12, 57.375), rgb=True)
"""Of the levels in ImageNet."""


def shown(levels: Levels, picture: Tensor) -> Tensor:
    """A picture (3, H, W), RGB from 0 to 255, as a network is shown it."""
    mean, std = (np.array(each, np.float32)[:, None, None] for each in (levels.mean, levels.std))
    channels = np.ascontiguousarray(picture if levels.rgb else picture[::-1])
    return np.asarray((channels - mean) / std, dtype=np.float32)


def prepared(heads: JointHeads, picture: Tensor) -> Tensor:
    """The input of a network, of a picture (3, H, W), RGB from 0 to 255."""
    if heads.levels is None:
        return KINDS[heads.kind].prepared(picture)
    return shown(heads.levels, picture)


def _standardised(levels: Tensor) -> Tensor:
    return shown(IMAGENET, levels)


def _from_bins(outputs: Sequence[Tensor], size: Size) -> tuple[Array, Array]:
    """Of each joint how likely every column (K, n·W) and every row (K, n·H) is."""
    likely = [each[0].astype(float) for each in outputs]
    xy = [_peaks(each) * side / each.shape[1] for each, side in zip(likely, size, strict=True)]
    confidence = np.minimum(*(each.max(axis=1) for each in likely))
    return np.column_stack(xy), np.clip(confidence, 0.0, 1.0)


def _from_maps(outputs: Sequence[Tensor], size: Size) -> tuple[Array, Array]:
    """Heat (K, h, w), whose outermost cells lie at the outermost pixels."""
    heat = outputs[0][0].astype(float)
    count, height, width = heat.shape
    each = np.arange(count)
    row, column = np.divmod(heat.reshape(count, -1).argmax(axis=1), width)
    xy = np.column_stack([_peaks(heat[each, row]), _peaks(heat[each, :, column])])
    scale = (np.array(size) - 1) / (width - 1, height - 1)
    return xy * scale, np.clip(heat[each, row, column], 0.0, 1.0)


def _peaks(rows: Array) -> Array:
    """Where each row (K, N) is greatest: the top of the parabola through that value and its
    neighbours."""
    each, peak = np.arange(len(rows)), rows.argmax(axis=1)
    inner = np.clip(peak, 1, rows.shape[1] - 2)
    before, top, after = (rows[each, inner + step] for step in (-1, 0, 1))
    bend = before - 2 * top + after
    offset = np.divide(before - after, 2 * bend, out=np.zeros(len(rows)), where=bend < 0)
    return np.asarray(peak + np.where(peak == inner, offset, 0.0))


_LEAST_SCORE: Final = 0.1
"""Of a person in the picture."""


def _from_people(outputs: Sequence[Tensor], size: Size) -> tuple[Array, Array]:
    """Boxes with a score (N, 5) and joints with theirs (N, K, 3) of all people; the surest near
    the middle is taken."""
    boxes, people = (each[0].astype(float) for each in outputs)
    middle = (boxes[:, :2] + boxes[:, 2:4]) / 2
    away = np.linalg.norm(middle - np.array(size) / 2, axis=1) / min(size)
    score = np.where(boxes[:, 4] >= _LEAST_SCORE, boxes[:, 4] / (away + 0.1), 0.0)
    if not score.any():
        return np.full((people.shape[1], 2), np.nan), np.zeros(people.shape[1])
    person = people[score.argmax()]
    return person[:, :2], np.clip(person[:, 2], 0.0, 1.0)


_SOFTEST: Final = 1.8
"""How many cells a peak of heat may lie off before it counts half."""
_SHIFT: Final = -0.25 / 256
"""Of MoveNet's joints, a share of its input's side."""


LEAST_CENTRE: Final = 0.3
"""How likely a cell must be a person's centre: of people in films it is 0.4 to 0.97, of trees and
poles 0.2 to 0.5, whose joints then are unlikely."""
CENTRES_APART: Final = 7
"""Cells across, in which one centre alone is taken."""


def _from_heads(outputs: Sequence[Tensor], size: Size) -> tuple[Array, Array]:
    """The person whose centre is hottest near the middle; outputs as of `_joints_of_centre`."""
    (center, *_) = outputs[2][0]
    rows, columns = np.indices(center.shape)
    middle = (len(center) - 1) / 2
    near_middle = 1 / (np.hypot(columns - middle, rows - middle) + _SOFTEST)
    return _joints_of_centre(outputs, size, _hottest(_sigmoid(center) * near_middle))


def _all_from_heads(outputs: Sequence[Tensor], size: Size) -> list[tuple[Array, Array]]:
    """Every person whose centre is likely; outputs as of `_joints_of_centre`."""
    (center, *_) = _sigmoid(outputs[2][0])
    hottest_near = cv2.dilate(center, np.ones((CENTRES_APART, CENTRES_APART)))
    centres = np.argwhere((center >= LEAST_CENTRE) & (center == hottest_near))
    return [_joints_of_centre(outputs, size, (row, column)) for row, column in centres.tolist()]


def _joints_of_centre(
    outputs: Sequence[Tensor], size: Size, centre: tuple[int, int]
) -> tuple[Array, Array]:
    """Logits (17, c, c); rows and columns from a centre to each joint (34, c, c); logits of
    centres (1, c, c); rows and columns from a cell to the joint in it (34, c, c).

    From the person's centre each joint is regressed; it lies where its heat near by is greatest,
    moved by the offset there.
    """
    heat, reg, (center, *_), off = (maps[0] for maps in outputs)
    (row, column), (rows, columns) = centre, np.indices(center.shape)
    xy, confidence = np.empty((len(heat), 2)), np.empty(len(heat))
    for k, hot in enumerate(_sigmoid(heat)):
        to_row, to_column = reg[2 * k : 2 * k + 2, row, column]
        near = 1 / (np.hypot(columns - column - to_column, rows - row - to_row) + _SOFTEST)
        r, c = _hottest(hot * near)
        xy[k] = c + off[2 * k + 1, r, c], r + off[2 * k, r, c]
        confidence[k] = hot[r, c]
    return size[0] * (xy / len(center) + _SHIFT), confidence


def _hottest(values: Array) -> tuple[int, int]:
    row, column = np.unravel_index(int(values.argmax()), values.shape)
    return int(row), int(column)


def _sigmoid(x: Array) -> Array:
    return np.asarray(1 / (1 + np.exp(-np.clip(x, -50, 50))))


_RENDERED = 0.65
_FILMED = 0.75
"""Mean confidence of MoveNet on drawn figures, whose joints it puts elsewhere and whose sides it
exchanges: 0.61 to 0.69, from above 0.36. On films of people it is 0.77 to 0.85, and below 0.70 to
0.79 in one frame of twenty."""

KINDS: Final[Mapping[JointKind, Kind]] = {
    "movenet": Kind(
        "MoveNet",
        ("heat", "reg", "center", "off"),
        lambda levels: levels / np.float32(127.5) - np.float32(1),
        _from_heads,
        _CIRCLE,
        doubted=(_RENDERED, _FILMED),
        everybody=_all_from_heads,
    ),
    "simcc": Kind("RTMPose and RTMW", ("simcc_x", "simcc_y"), _standardised, _from_bins, _CIRCLE),
    "rtmo": Kind(
        "RTMO",
        ("dets", "keypoints"),
        lambda levels: np.ascontiguousarray(levels[::-1]),
        _from_people,
        1.0,
        outside=(114.0, 114.0, 114.0),
        needs_fast=True,
    ),
    "maps": Kind("ViTPose", (), _standardised, _from_maps, _CIRCLE),
}
