"""A network of animals that sees a dot of its own colour for each of AP-10K's keypoints."""

from __future__ import annotations

from itertools import product

import numpy as np

from keypose.tracker.keypoints.joint_kinds import IMAGENET
from tests.tracker.keypoints.tiny_networks import Array, between, model, node

COLOURS = np.array(
    [levels for levels in product((0, 128, 255), repeat=3) if np.ptp(levels) >= 127][:17]
)
"""(17, 3) RGB of the dots, none of them grey."""
SIDE = 256
NARROW = 1.0
"""How fast a map falls with the distance from its colour."""
SPREAD = 7
"""Pixels over which a map is averaged, so that a dot has one peak."""


def dot_network() -> bytes:
    """As ViTPose: a map of each keypoint, 1 where a picture has its colour."""
    mean, std = (np.array(each) for each in (IMAGENET.mean, IMAGENET.std))
    colours = ((COLOURS - mean) / std).astype(np.float32)
    cells = SIDE // 4
    weights: dict[str, Array] = {
        "like": (2 * NARROW * colours)[:, :, None, None],
        "own": (1 - NARROW * (colours**2).sum(axis=1)).astype(np.float32),
        "less": np.full((len(colours), 3, 1, 1), -NARROW, np.float32),
        "none": np.zeros(len(colours), np.float32),
        "rows": between(SIDE, np.linspace(0, SIDE - 1, cells)).T.copy(),
        "columns": between(SIDE, np.linspace(0, SIDE - 1, cells)),
    }
    half = SPREAD // 2
    nodes = [
        node("Mul", ["image", "image"], "squares"),
        node("Conv", ["image", "like", "own"], "near"),
        node("Conv", ["squares", "less", "none"], "far"),
        node("Add", ["near", "far"], "levels"),
        node("Relu", ["levels"], "dots"),
        node(
            "AveragePool",
            ["dots"],
            "spread",
            kernel_shape=[SPREAD, SPREAD],
            pads=[half] * 4,
            strides=[1, 1],
        ),
        node("MatMul", ["spread", "columns"], "narrow"),
        node("MatMul", ["rows", "narrow"], "heatmaps"),
    ]
    shape = (1, 3, SIDE, SIDE)
    return model(nodes, weights, {"image": shape}, {"heatmaps": (1, len(COLOURS), cells, cells)})
