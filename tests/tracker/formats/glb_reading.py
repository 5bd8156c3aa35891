"""A GLB file played without our code: pygltflib reads the document, SciPy turns the nodes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pygltflib import GLTF2
from scipy.spatial.transform import Rotation, Slerp

Numbers: TypeAlias = NDArray[Any]

_TYPES = {5126: np.float32, 5123: np.uint16, 5125: np.uint32}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


@dataclass
class Player:
    """The first animation of a file."""

    gltf: Any

    @classmethod
    def of(cls, content: bytes) -> Player:
        return cls(GLTF2.load_from_bytes(content))

    def array(self, index: int) -> Numbers:
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
    def times_s(self) -> Numbers:
        (animation,) = self.gltf.animations
        (clock,) = {sampler.input for sampler in animation.samplers}
        return self.array(clock)[:, 0]

    @property
    def bones(self) -> list[str]:
        """The names of the only skin's joints."""
        (skin,) = self.gltf.skins
        return [self.gltf.nodes[index].name for index in skin.joints]

    def curves(self) -> dict[tuple[int, str], Numbers]:
        """What every channel says, by node and path."""
        (animation,) = self.gltf.animations
        assert {sampler.interpolation for sampler in animation.samplers} == {"LINEAR"}
        return {
            (channel.target.node, channel.target.path): self.array(
                animation.samplers[channel.sampler].output
            )
            for channel in animation.channels
        }

    def transforms(self, times_s: Numbers | None) -> dict[str, Numbers]:
        """T_world_node (T, 4, 4) of every node by name at these times; None: before it plays."""
        curves, clock = ({}, np.zeros(1)) if times_s is None else (self.curves(), self.times_s)
        at = clock if times_s is None else times_s
        found: dict[str, Numbers] = {}

        def visit(index: int, above: Numbers) -> None:
            node, T = self.gltf.nodes[index], np.tile(np.eye(4), (len(at), 1, 1))
            T[:, :3, 3] = node.translation or (0, 0, 0)
            T[:, :3, :3] = Rotation.from_quat(node.rotation or (0, 0, 0, 1)).as_matrix()
            if (moved := curves.get((index, "translation"))) is not None:
                T[:, :3, 3] = np.stack([np.interp(at, clock, p) for p in moved.T], axis=1)
            if (turned := curves.get((index, "rotation"))) is not None:
                T[:, :3, :3] = Slerp(clock, Rotation.from_quat(turned))(at).as_matrix()
            found[node.name] = above @ T
            for child in node.children or []:
                visit(child, found[node.name])

        for index in self.gltf.scenes[self.gltf.scene].nodes:
            visit(index, np.eye(4))
        return found

    def places(self, times_s: Numbers) -> dict[str, Numbers]:
        """Where each node is at these times: (T, 3) by name."""
        return {name: T[:, :3, 3] for name, T in self.transforms(times_s).items()}

    def skinned(self, times_s: Numbers | None) -> dict[str, Numbers]:
        """Where the vertices on each bone are (T, V, 3), by the bone's name."""
        (skin,), (mesh,) = self.gltf.skins, self.gltf.meshes
        binds = self.array(skin.inverseBindMatrices).reshape(-1, 4, 4).swapaxes(1, 2)
        nodes, found = self.transforms(times_s), dict[str, list[Numbers]]()
        for primitive in mesh.primitives:
            vertices = self.array(primitive.attributes.POSITION)
            joints = self.array(primitive.attributes.JOINTS_0).astype(int)
            weights = self.array(primitive.attributes.WEIGHTS_0)
            assert (weights == [1, 0, 0, 0]).all()
            assert (joints[:, 1:] == 0).all()
            for joint in np.unique(joints[:, 0]):
                own = vertices[joints[:, 0] == joint]
                T = nodes[self.bones[joint]] @ binds[joint]
                moved = own @ T[:, :3, :3].swapaxes(1, 2) + T[:, None, :3, 3]
                found.setdefault(self.bones[joint], []).append(moved)
        return {name: np.concatenate(pieces, axis=1) for name, pieces in found.items()}

    def solids(self) -> dict[str, tuple[Numbers, Numbers]]:
        """Vertices (V, 3) before it plays and triangles (F, 3) on each bone, by its name."""
        (mesh,) = self.gltf.meshes
        found: dict[str, tuple[Numbers, Numbers]] = {}
        for primitive in mesh.primitives:
            vertices = self.array(primitive.attributes.POSITION)
            joints = self.array(primitive.attributes.JOINTS_0).astype(int)[:, 0]
            faces = self.array(primitive.indices).astype(int).reshape(-1, 3)
            for joint in np.unique(joints):
                found[self.bones[joint]] = (vertices, faces[joints[faces[:, 0]] == joint])
        return found
