"""A GLB file played without our code: pygltflib reads the document, SciPy turns the nodes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from pygltflib import GLTF2
from scipy.spatial.transform import Rotation, Slerp

_TYPES = {5126: np.float32, 5123: np.uint16, 5125: np.uint32}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


@dataclass
class Player:
    """The first animation of a file."""

    gltf: Any

    @classmethod
    def of(cls, content: bytes) -> Player:
        return cls(GLTF2.load_from_bytes(content))

    def array(self, index: int) -> np.ndarray:  # type: ignore[type-arg]
        """An accessor's numbers."""
        accessor = self.gltf.accessors[index]
        view = self.gltf.bufferViews[accessor.bufferView]
        width = _WIDTHS[accessor.type]
        start = (view.byteOffset or 0) + (accessor.byteOffset or 0)
        flat = np.frombuffer(
            self.gltf.binary_blob(), _TYPES[accessor.componentType], accessor.count * width, start
        )
        return flat.reshape(accessor.count, width).astype(float)

    @property
    def times_s(self) -> np.ndarray:  # type: ignore[type-arg]
        (animation,) = self.gltf.animations
        (clock,) = {sampler.input for sampler in animation.samplers}
        return self.array(clock)[:, 0]

    def curves(self) -> dict[tuple[int, str], np.ndarray]:  # type: ignore[type-arg]
        """What every channel says, by node and path."""
        (animation,) = self.gltf.animations
        assert {sampler.interpolation for sampler in animation.samplers} == {"LINEAR"}
        return {
            (channel.target.node, channel.target.path): self.array(
                animation.samplers[channel.sampler].output
            )
            for channel in animation.channels
        }

    def places(self, times_s: np.ndarray) -> dict[str, np.ndarray]:  # type: ignore[type-arg]
        """Where each node is at these times: (T, 3) by name."""
        curves, clock = self.curves(), self.times_s
        found: dict[str, np.ndarray] = {}  # type: ignore[type-arg]

        def visit(index: int, R: Rotation, p: np.ndarray) -> None:  # type: ignore[type-arg]
            node = self.gltf.nodes[index]
            rest = np.array(node.translation or (0, 0, 0))
            moved = curves.get((index, "translation"))
            if moved is not None:
                rest = np.stack([np.interp(times_s, clock, moved[:, k]) for k in range(3)], axis=1)
            p = p + R.apply(np.zeros(p.shape) + rest)
            turned = curves.get((index, "rotation"))
            if turned is not None:
                R = R * Slerp(clock, Rotation.from_quat(turned))(times_s)
            found[node.name] = p
            for child in node.children or []:
                visit(child, R, p)

        start = np.zeros((len(times_s), 3))
        for index in self.gltf.scenes[self.gltf.scene].nodes:
            visit(index, Rotation.from_quat(np.tile([0.0, 0, 0, 1], (len(times_s), 1))), start)
        return found
