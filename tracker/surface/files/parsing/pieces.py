"""The meshes of a GLB scene, piece by piece, and what moves their vertices.

A piece is one primitive of one node. Its vertices move with the node, or with the joints of a
skin, after its morph targets were added.  glTF 2.0, 3.7
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.surface.files.parsing.channels import Channel
from keypose.tracker.surface.files.parsing.glb import Glb, at, damaged
from keypose.tracker.surface.files.parsing.raw import Refused, require_counts
from keypose.tracker.surface.files.parsing.tidying import require_range

_MOST_TARGETS: Final = 500


@dataclass(frozen=True, eq=False)
class Skin:
    """The file's skin of this number.

    joints: (J,) nodes. Ts_joint_mesh: (J, 4, 4) from the mesh at rest to each joint.
    """

    number: int
    joints: NDArray[np.int64]
    Ts_joint_mesh: Array


@dataclass(frozen=True, eq=False)
class Piece:
    """One primitive of one node.

    p_mesh:   (V, 3) at rest.
    faces:    (F, 3) vertex indices.
    targets:  per morph target (V, 3), what is added with the target's weight.
    weights:  (T,) resting weights of the targets.
    skin:     None where the vertices move with the node.
    joint:    (V, K) numbers of the skin's joints; share: (V, K) how much each counts, sum 1.
    """

    node: int
    p_mesh: Array
    faces: NDArray[np.int64]
    targets: list[NDArray[np.float32]]
    weights: Array
    skin: Skin | None
    joint: NDArray[np.int64]
    share: Array

    def posed(self, Ts_world_node: Array, channels: list[Channel], time_s: float) -> Array:
        """(V, 3) in the scene's frame at a time."""
        p_mesh = self._morphed(channels, time_s)
        if self.skin is None:
            return _transform(p_mesh, Ts_world_node[self.node])
        Ts = Ts_world_node[self.skin.joints] @ self.skin.Ts_joint_mesh
        p_world = np.zeros_like(p_mesh)
        for joint, share in zip(self.joint.T, self.share.T, strict=True):
            p_world += share[:, None] * _transform(p_mesh, Ts[joint])
        return p_world

    def is_mirrored(self, Ts_world_node: Array) -> bool:
        """Whether the node mirrors the piece, so that its faces show their backs."""
        return self.skin is None and bool(np.linalg.det(Ts_world_node[self.node, :3, :3]) < 0)

    def marks(self) -> Array:
        """(V, M) numbers; vertices with equal ones move alike, whatever happens."""
        # A node's own transform does not move vertices that move with joints.
        owner = float(self.node)
        if self.skin is not None and not self.targets:
            owner = -1.0 - self.skin.number
        shift = np.zeros_like(self.p_mesh)
        for number, target in enumerate(self.targets):
            shift += np.sqrt(number + 2.0) * target  # so that different sets of targets differ
        known = np.full((len(self.p_mesh), 1), owner)
        return np.hstack([known, self.p_mesh, shift, self.joint, self.share])

    def _morphed(self, channels: list[Channel], time_s: float) -> Array:
        weights = self.weights
        for channel in channels:
            if channel.target == "weights" and channel.node == self.node:
                weights = channel.value(time_s)
        p_mesh = self.p_mesh
        for weight, target in zip(weights, self.targets, strict=False):
            if weight != 0:
                p_mesh = p_mesh + weight * target
        return p_mesh


def pieces_of(glb: Glb) -> list[Piece]:
    """The pieces of the scene that is shown. Refused where there are none, or too many faces."""
    shown = _shown_nodes(glb)
    _require_counts(glb, shown)
    pieces = []
    for number in shown:
        node = glb.items("nodes")[number]
        mesh = at(glb.items("meshes"), node["mesh"])
        for primitive in mesh["primitives"]:
            if _mode(primitive) in _CORNERS_TO_FACES:
                weights = node.get("weights", mesh.get("weights", []))
                pieces.append(_piece(glb, number, node, primitive, weights))
    return pieces


def _shown_nodes(glb: Glb) -> list[int]:
    """The nodes with a mesh that hang in the scene."""
    nodes, scenes = glb.items("nodes"), glb.items("scenes")
    number = glb.document.get("scene", 0)
    waiting = list(at(scenes, number).get("nodes", [])) if scenes else [*range(len(nodes))]
    seen: set[int] = set()
    while waiting:
        number = waiting.pop()
        if number not in seen:
            waiting.extend(at(nodes, number).get("children", []))
            seen.add(number)
    return sorted(number for number in seen if "mesh" in nodes[number])


def _require_counts(glb: Glb, shown: list[int]) -> None:
    """Before any number is read: a document may name one array a million times."""
    vertices = faces = 0
    for number in shown:
        mesh = at(glb.items("meshes"), glb.items("nodes")[number]["mesh"])
        for primitive in mesh["primitives"]:
            if _mode(primitive) not in _CORNERS_TO_FACES:
                continue
            if "KHR_draco_mesh_compression" in primitive.get("extensions", {}):
                raise Refused("holds a compressed mesh: export it without mesh compression.")
            if len(primitive.get("targets", [])) > _MOST_TARGETS:
                raise Refused(f"has more than {_MOST_TARGETS} morph targets: export it without.")
            count = glb.count(primitive["attributes"]["POSITION"])
            corners = glb.count(primitive["indices"]) if "indices" in primitive else count
            vertices += count
            faces += corners // 3 if _mode(primitive) == 4 else max(corners - 2, 0)
    require_counts(vertices, faces)


def _mode(primitive: dict[str, Any]) -> Any:
    return primitive.get("mode", 4)


def _piece(
    glb: Glb, number: int, node: dict[str, Any], primitive: dict[str, Any], weights: list[float]
) -> Piece:
    attributes = primitive["attributes"]
    p_mesh = glb.numbers(attributes["POSITION"], 3).astype(np.float64)
    corners = np.arange(len(p_mesh))
    if "indices" in primitive:
        corners = glb.numbers(primitive["indices"], 1)[:, 0].astype(np.int64)
    faces = _CORNERS_TO_FACES[_mode(primitive)](corners)
    require_range(faces, len(p_mesh))
    targets = [
        glb.numbers(t["POSITION"], 3) for t in primitive.get("targets", []) if "POSITION" in t
    ]
    if any(len(target) != len(p_mesh) for target in targets):
        raise damaged()
    skin = _skin(glb, node["skin"]) if "skin" in node and "JOINTS_0" in attributes else None
    joint, share = _shares(glb, attributes, skin, len(p_mesh))
    resting = np.array(weights or [0.0] * len(targets), dtype=np.float64)
    return Piece(number, p_mesh, faces, targets, resting, skin, joint, share)


def _skin(glb: Glb, number: Any) -> Skin:
    facts = at(glb.items("skins"), number)
    joints = np.array(facts["joints"], dtype=np.int64)
    if len(joints) == 0 or joints.min() < 0 or joints.max() >= len(glb.items("nodes")):
        raise damaged()
    Ts = np.tile(np.eye(4), (len(joints), 1, 1))
    if "inverseBindMatrices" in facts:
        stated = glb.numbers(facts["inverseBindMatrices"], 16)
        if len(stated) < len(joints):
            raise damaged()
        Ts = stated[: len(joints)].reshape(-1, 4, 4).swapaxes(1, 2).astype(np.float64)
    return Skin(number, joints, Ts)


def _shares(
    glb: Glb, attributes: dict[str, Any], skin: Skin | None, vertices: int
) -> tuple[NDArray[np.int64], Array]:
    """Which joints move each vertex, and how much; nothing where there is no skin."""
    joints: list[NDArray[Any]] = []
    shares: list[NDArray[Any]] = []
    while skin is not None and f"JOINTS_{len(joints)}" in attributes:
        which = len(joints)
        joints.append(glb.numbers(attributes[f"JOINTS_{which}"], 4))
        shares.append(glb.numbers(attributes[f"WEIGHTS_{which}"], 4))
        if not len(joints[-1]) == len(shares[-1]) == vertices:
            raise damaged()
    if skin is None or not joints:
        return np.zeros((vertices, 0), np.int64), np.zeros((vertices, 0))
    joint = np.hstack(joints).astype(np.int64)
    share = np.hstack(shares).astype(np.float64)
    if joint.min() < 0 or joint.max() >= len(skin.joints):
        raise damaged()
    total = share.sum(axis=1, keepdims=True)
    # A vertex that no joint moves would fall into the origin: the first joint keeps it.
    share[:, 0] += np.where(total[:, 0] > 0, 0.0, 1.0)
    return joint, share / np.where(total > 0, total, 1.0)


def _transform(p_mesh: Array, Ts: Array) -> Array:
    """(V, 3) points moved by one (4, 4) transform, or each by its own (V, 4, 4)."""
    return np.asarray(np.einsum("...ij,...j->...i", Ts[..., :3, :3], p_mesh) + Ts[..., :3, 3])


def _triangles(corners: NDArray[np.int64]) -> NDArray[np.int64]:
    return corners[: len(corners) // 3 * 3].reshape(-1, 3)


def _strip(corners: NDArray[np.int64]) -> NDArray[np.int64]:
    """Every second triangle of a strip runs the other way."""
    faces = np.stack([corners[:-2], corners[1:-1], corners[2:]], axis=1)
    faces[1::2] = faces[1::2, [1, 0, 2]]
    return faces


def _fan(corners: NDArray[np.int64]) -> NDArray[np.int64]:
    middle = np.full(max(len(corners) - 2, 0), corners[0])
    return np.stack([middle, corners[1:-1], corners[2:]], axis=1)


_CORNERS_TO_FACES: Final = {4: _triangles, 5: _strip, 6: _fan}
