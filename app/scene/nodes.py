"""The nodes of viser's scene that a body is made of, and how they look in each view.

The camera view shows a part as a translucent solid with light lines, the three small views as an
opaque one with dark lines.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray
from viser import FrameHandle, GlbHandle, LineSegmentsHandle, MeshHandle, SceneApi

from keypose.app.render.palette import WHITE, Colour
from keypose.app.scene.figure import Segments, hull_mesh, part_mesh, rim_lines, wire_lines
from keypose.tracker.body.shapes import Shape
from keypose.tracker.geometry.rotations import Array

Mode: TypeAlias = Literal["wire", "solid", "both"]
Bytes: TypeAlias = NDArray[np.uint8]

ROOT = "/camera"
"""The node whose frame is the camera's: x right, y down, z away."""

SELECTED: Colour = (169, 155, 255)

LINE_PX = 1.5
SELECTED_LINE_PX = 2.5
WIRE_PX = 1.0
GHOST_PX = 1.0

OVERLAY_ONLY = ("overlay", "rims", "wires")
"""Children of a part that only the camera view shows."""
SOLID_ONLY = ("edges",)
"""Children of a part that only the small views show. The page draws the opaque solids in the camera
view too, for their depth alone, which makes the overlay one sheet and hides the lines behind it."""

FREE_ONLY = ("hull",)
"""Children of a part that only the free view shows: the inside of a slightly larger solid, which
is its outline from wherever one looks."""

HULL_M = 0.004

_TOO_FEW: Segments = np.zeros((1, 2, 3), dtype=np.float32)


@dataclass(frozen=True, eq=False)
class PartNodes:
    """One part: its frame, and below it two solids, a hull and three kinds of line."""

    frame: FrameHandle
    overlay: MeshHandle
    solid: MeshHandle
    rims: LineSegmentsHandle
    wires: LineSegmentsHandle
    edges: LineSegmentsHandle
    hull: MeshHandle

    @classmethod
    def add(cls, scene: SceneApi, name: str, shape: Shape) -> Self:
        vertices, faces = part_mesh(shape)
        frame = scene.add_frame(name, show_axes=False)
        overlay, solid = (
            scene.add_mesh_simple(
                f"{name}/{child}",
                vertices,
                faces,
                opacity=0.5 if child == "overlay" else None,
                cast_shadow=False,
                receive_shadow=False,
            )
            for child in ("overlay", "solid")
        )
        rims, edges = (
            add_lines(scene, f"{name}/{child}", rim_lines(shape), WHITE, LINE_PX)
            for child in ("rims", "edges")
        )
        wires = add_lines(scene, f"{name}/wires", wire_lines(shape), WHITE, WIRE_PX)
        hull = scene.add_mesh_simple(
            f"{name}/hull",
            *hull_mesh(shape, HULL_M),
            side="back",
            cast_shadow=False,
            receive_shadow=False,
        )
        return cls(frame, overlay, solid, rims, wires, edges, hull)

    def set_shape(self, shape: Shape) -> None:
        vertices, faces = part_mesh(shape)
        for mesh in (self.overlay, self.solid):
            mesh.vertices, mesh.faces = vertices, faces
        self.hull.vertices, self.hull.faces = hull_mesh(shape, HULL_M)
        self.rims.points = self.edges.points = _some(rim_lines(shape))
        self.wires.points = _some(wire_lines(shape))

    def set_look(self, colour: Colour, selected: bool, mode: Mode, opacity: float) -> None:
        """A selected part keeps a breath of colour even as a wire."""
        colour = SELECTED if selected else colour
        self.overlay.color = self.solid.color = colour
        if mode == "wire":
            self.overlay.opacity = 0.12
        else:
            self.overlay.opacity = min(1.0, opacity + 0.12 * selected)
        self.overlay.visible = selected or (mode != "wire" and opacity > 0)
        self.wires.visible = mode != "solid"
        self.wires.colors = _bytes(toward_white(colour, 0.3))
        self.rims.colors = _bytes(WHITE if selected else light(colour))
        self.edges.colors = _bytes(WHITE if selected else dark(colour))
        self.hull.color = WHITE if selected else _colour(dark(colour))
        self.rims.thickness = self.edges.thickness = SELECTED_LINE_PX if selected else LINE_PX

    def set_pose(self, wxyz: Array, position: Array) -> None:
        self.frame.wxyz = wxyz
        self.frame.position = position


class SkinNodes:
    """The observed surface: two nodes by turns.

    A page drops a GLB as soon as it is sent another, and has that one only some moments later;
    hence the one before stands until `settle`.
    """

    NAMES: ClassVar = (f"{ROOT}/surface/0", f"{ROOT}/surface/1")

    def __init__(self, scene: SceneApi) -> None:
        self._scene = scene
        self._newest = 0
        self._nodes: list[GlbHandle | None] = [None, None]

    def put(self, glb: bytes | None) -> None:
        """Show this one; None: nothing."""
        if glb is None:
            self._drop(self._newest)
            self.settle()
            return
        self.settle()
        self._newest = 1 - self._newest
        self._nodes[self._newest] = self._scene.add_glb(
            self.NAMES[self._newest], glb, cast_shadow=False, receive_shadow=False
        )

    def settle(self) -> None:
        """Drop the one before the newest."""
        self._drop(1 - self._newest)

    def _drop(self, number: int) -> None:
        node, self._nodes[number] = self._nodes[number], None
        if node is not None:
            node.remove()


def add_lines(
    scene: SceneApi, name: str, points: Segments, colours: Array | Colour, width_px: float
) -> LineSegmentsHandle:
    """Lines (N, 2, 3) of one colour, or of one colour for each end, as wide at every distance."""
    return scene.add_line_segments(
        name, _some(points), _bytes(colours), thickness=width_px, thickness_units="screen"
    )


def add_lights(scene: SceneApi, name: str) -> None:
    """A soft sky and a sun; their position says where the light comes from."""
    scene.add_light_hemisphere(
        f"{name}/sky", sky_color=(255, 255, 255), ground_color=(92, 96, 106), intensity=2.0
    )
    scene.add_light_directional(f"{name}/sun", intensity=1.6)


def light(colours: Array | Colour) -> Array:
    """The colours of lines over a picture."""
    return toward_white(colours, 0.45)


def dark(colours: Array | Colour) -> Array:
    """The colours of lines around an opaque solid."""
    return np.asarray(colours) * 0.42


def toward_white(colours: Array | Colour, share: float) -> Array:
    return np.asarray(colours) * (1 - share) + np.array(WHITE) * share


def _colour(colour: Array) -> Colour:
    r, g, b = (round(float(value)) for value in colour)
    return r, g, b


def _bytes(colours: Array | Colour) -> Bytes:
    return np.rint(np.asarray(colours, dtype=np.float64)).astype(np.uint8)


def _some(points: Segments) -> Segments:
    """viser wants at least one line; this one is a point, which shows nothing."""
    return points if len(points) else _TOO_FEW
