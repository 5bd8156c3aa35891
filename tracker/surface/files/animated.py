"""A GLB file as surfaces over time: node motion, skins and morph targets, worked out step by step.

It runs in the child process. Lengths are metres and +y is up, as glTF prescribes.

Own code: short of a game engine nothing in Python plays skins and morph targets.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.surface.files.parsing.channels import Channel, channels_of
from keypose.tracker.surface.files.parsing.glb import Glb
from keypose.tracker.surface.files.parsing.nodes import Nodes
from keypose.tracker.surface.files.parsing.pieces import Piece, pieces_of
from keypose.tracker.surface.files.parsing.raw import RawMesh, Refused
from keypose.tracker.surface.files.parsing.tidying import require_surface, same_rows, tidy

FPS: Final = 30.0
"""Steps a second at which an animation is looked at."""
_MOST_STEPS: Final = 1_000_000


@dataclass(frozen=True, eq=False)
class AnimatedScene:
    """The meshes of a scene as one, at every step of its first animation.

    pieces: what the vertices belong to. Those that move alike became one, for files split them at
            the seams of a texture; the first piece that has them keeps them.
    faces:  (F, 3) vertex numbers, counted through all pieces; piece_of_face: (F,).
    """

    nodes: Nodes
    pieces: list[Piece]
    channels: list[Channel]
    faces: NDArray[np.int64]
    piece_of_face: NDArray[np.int64]

    @classmethod
    def read(cls, file: BinaryIO) -> AnimatedScene:
        """Refused where the file is no GLB, damaged, too large or without a mesh."""
        glb = Glb.read(file)
        pieces, faces, piece_of_face = _merge_pieces(pieces_of(glb))
        scene = cls(Nodes.of(glb), pieces, channels_of(glb), faces, piece_of_face)
        if scene._length_s * FPS >= _MOST_STEPS:
            raise Refused("has an animation of many hours: cut out what is to be followed.")
        return scene

    @property
    def animated(self) -> bool:
        """Whether anything happens in it."""
        return self._length_s > 0

    @property
    def frame_count(self) -> int:
        """The first step is at the first time of the animation."""
        return int(self._length_s * FPS + 1e-4) + 1

    def mesh(self, step: int) -> RawMesh:
        """The surface at a step, as the scene states it."""
        time_s = self._start_s + step / FPS
        Ts_world_node = self.nodes.worlds(self.channels, time_s)
        p_world = [piece.posed(Ts_world_node, self.channels, time_s) for piece in self.pieces]
        over = np.array([piece.is_mirrored(Ts_world_node) for piece in self.pieces])
        faces = self.faces.copy()
        turned = over[self.piece_of_face]
        faces[turned] = faces[turned][:, ::-1]
        return RawMesh(np.concatenate(p_world), faces)

    def tidy_mesh(self, step: int) -> RawMesh:
        """The surface at a step. Refused where it is nonsense.

        Vertices of an animation keep their numbers through all steps, also where they meet.
        """
        mesh = self.mesh(step)
        return require_surface(mesh) if self.animated else tidy(mesh)

    @property
    def _start_s(self) -> float:
        return min((float(channel.times_s[0]) for channel in self.channels), default=0.0)

    @property
    def _length_s(self) -> float:
        end = max((float(channel.times_s[-1]) for channel in self.channels), default=0.0)
        return end - self._start_s


def read_resting(file: BinaryIO) -> RawMesh:
    """The mesh of a GLB file that is one step of several: as it begins."""
    return AnimatedScene.read(file).mesh(0)


def _merge_pieces(
    pieces: list[Piece],
) -> tuple[list[Piece], NDArray[np.int64], NDArray[np.int64]]:
    """The pieces with only the vertices that remain; all faces between them; each face's piece."""
    marks = [piece.marks() for piece in pieces]
    width = max(mark.shape[1] for mark in marks)
    table = np.vstack([np.pad(mark, ((0, 0), (0, width - mark.shape[1]))) for mark in marks])
    first = same_rows(table)
    offsets = np.cumsum([0, *(len(piece.p_mesh) for piece in pieces)])
    faces = np.vstack([first[p.faces + offset] for p, offset in zip(pieces, offsets, strict=False)])
    piece_of_face = np.repeat(np.arange(len(pieces)), [len(piece.faces) for piece in pieces])
    a, b, c = faces.T
    whole = (a != b) & (b != c) & (c != a)
    faces, piece_of_face = faces[whole], piece_of_face[whole]
    used = np.zeros(len(table), dtype=bool)
    used[faces] = True
    number = np.cumsum(used) - 1
    kept = [
        _select_vertices(piece, used[start:end])
        for piece, start, end in zip(pieces, offsets, offsets[1:], strict=False)
    ]
    return kept, number[faces], piece_of_face


def _select_vertices(piece: Piece, kept: NDArray[np.bool_]) -> Piece:
    """The piece with some of its vertices; its own faces no longer hold."""
    return replace(
        piece,
        p_mesh=piece.p_mesh[kept],
        faces=np.empty((0, 3), np.int64),
        targets=[target[kept] for target in piece.targets],
        joint=piece.joint[kept],
        share=piece.share[kept],
    )
