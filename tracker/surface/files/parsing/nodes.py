"""The tree of a scene's nodes, and where each of them lies."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.surface.files.parsing.channels import Channel
from keypose.tracker.surface.files.parsing.glb import Glb, at, damaged
from keypose.tracker.surface.files.parsing.raw import Refused

_MOST_NODES: Final = 20_000


@dataclass(frozen=True, eq=False)
class Nodes:
    """Every node's parent (−1: none) and resting place, parents before children in `order`.

    translations (N, 3); rotations (N, 4) quaternions x, y, z, w; scales (N, 3); matrices: the
    nodes that state a 4×4 matrix instead.
    """

    parents: list[int]
    order: list[int]
    translations: Array
    rotations: Array
    scales: Array
    matrices: dict[int, Array]

    @classmethod
    def of(cls, glb: Glb) -> Nodes:
        """Refused where the nodes form no tree."""
        nodes = glb.items("nodes")
        if len(nodes) > _MOST_NODES:
            raise Refused(f"has {len(nodes):,} nodes: join its objects before you export it.")
        parents = _parents(nodes)
        return cls(
            parents,
            _order(nodes, parents),
            _stack(nodes, "translation", [0, 0, 0]),
            _stack(nodes, "rotation", [0, 0, 0, 1]),
            _stack(nodes, "scale", [1, 1, 1]),
            {
                number: np.array(node["matrix"], dtype=np.float64).reshape(4, 4).T
                for number, node in enumerate(nodes)
                if "matrix" in node
            },
        )

    def worlds(self, channels: Iterable[Channel], time_s: float) -> Array:
        """(N, 4, 4) Ts_world_node at a time."""
        moved = {
            "translation": self.translations.copy(),
            "rotation": self.rotations.copy(),
            "scale": self.scales.copy(),
        }
        for channel in channels:
            if channel.target != "weights":
                moved[channel.target][channel.node] = channel.value(time_s)
        Ts = compose(moved["translation"], moved["rotation"], moved["scale"])
        animated = {channel.node for channel in channels if channel.target != "weights"}
        for number, matrix in self.matrices.items():
            if number not in animated:
                Ts[number] = matrix
        for number in self.order:
            if self.parents[number] >= 0:
                Ts[number] = Ts[self.parents[number]] @ Ts[number]
        return Ts


def compose(translations: Array, rotations: Array, scales: Array) -> Array:
    """(N, 4, 4) first scaled, then turned, then moved."""
    lengths = np.linalg.norm(rotations, axis=1, keepdims=True)
    x, y, z, w = (rotations / np.where(lengths > 0, lengths, 1.0)).T
    R = np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ])  # fmt: skip
    Ts = np.zeros((len(translations), 4, 4))
    Ts[:, :3, :3] = np.moveaxis(R, -1, 0) * scales[:, None, :]
    Ts[:, :3, 3] = translations
    Ts[:, 3, 3] = 1.0
    return Ts


def _stack(nodes: list[Any], name: str, otherwise: list[float]) -> Array:
    rows = [node.get(name, otherwise) for node in nodes]
    return np.array(rows, dtype=np.float64).reshape(len(nodes), len(otherwise))


def _parents(nodes: list[Any]) -> list[int]:
    parents = [-1] * len(nodes)
    for number, node in enumerate(nodes):
        for child in node.get("children", []):
            if at(parents, child) != -1:
                raise damaged()
            parents[child] = number
    return parents


def _order(nodes: list[Any], parents: list[int]) -> list[int]:
    order = [number for number, parent in enumerate(parents) if parent < 0]
    for number in order:  # grows while it is walked
        order.extend(nodes[number].get("children", []))
    if len(order) != len(nodes):
        raise damaged()  # some are each other's parents
    return order
