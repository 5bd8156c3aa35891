"""What the page's views show of the body, drawn by viser.

The scene holds one frame per part; a new pose is their transforms and the outlines. Everything
hangs below one node whose frame is the camera's, turned so that on the page three.js has the
camera's x to the right, y up and z toward the viewer: the page drives its cameras itself.
"""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from starlette.websockets import WebSocket
from viser import ClientHandle, LineSegmentsHandle

from keypose.app.render.palette import SIDE_COLOURS, WHITE, Colour, part_sides
from keypose.app.scene.figure import Outline, Segments, rim_lines, trail_lines
from keypose.app.scene.nodes import (
    FREE_ONLY,
    GHOST_PX,
    LINE_PX,
    OVERLAY_ONLY,
    ROOT,
    SELECTED_LINE_PX,
    SOLID_ONLY,
    Mode,
    PartNodes,
    SkinNodes,
    add_lights,
    add_lines,
    dark,
    light,
)
from keypose.app.scene.viser_compat import ROLES, Portless, Role, hide_from
from keypose.tracker.body.body import Body, Part
from keypose.tracker.geometry.rotations import Array, apply_transform, quaternion_wxyz

__all__ = ["Mode", "Role", "Scenery", "Stage", "Trail"]

GHOST_COLOURS: tuple[Colour, ...] = ((134, 217, 147), (217, 213, 199), (240, 186, 96))
"""Of the keyframe before, of the one after, and of a soft one's own pose."""
BEFORE_COLOUR: Colour = (226, 226, 230)
"""Of the body that new sizes are compared with."""

_SMALL: tuple[Role, ...] = ("top", "side", "front")
_OPAQUE: tuple[Role, ...] = (*_SMALL, "free")
"""Views that show the body as opaque solids."""
_OUTLINED: tuple[Role, ...] = ("main", *_SMALL)
"""Views whose direction is known here, so that lines can be drawn where round sides turn away; the
free one is turned by the page, which draws ghosts and trails in it by itself."""

_CAMERA_WXYZ = (0.0, 0.0, 0.0, 1.0)
"""viser's +y-up world stands half a turn about y from three.js's; with half a turn about z the
camera's y down becomes y up and its z away becomes z toward the viewer."""

_TO_LIGHT = np.array([-0.50, -0.70, -0.75])
"""From the upper left, behind the viewer, in the view's frame."""
_TO_LIGHT_OF: dict[Role, Array] = {"free": np.array([0.15, -0.8, -0.6])}
"""The free view goes round a body in one light: from above, in the front view's frame."""

_R_EYE_CAMERA: dict[Role, Array] = {
    "main": np.eye(3),
    "top": np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]]),
    "side": np.array([[0, 0, 1.0], [0, 1.0, 0], [-1.0, 0, 0]]),
    "front": np.eye(3),
    "free": np.eye(3),
}


@dataclass(frozen=True, eq=False)
class Trail:
    """The way of one point.

    p_camera: (N, 3) metres, frame after frame.
    present:  the index of the frame shown; what comes after it is dashed.
    """

    p_camera: Array
    present: int


@dataclass(frozen=True, eq=False)
class BodyBeside:
    """A body that is not posed, where its parts are, (P, 4, 4), and its colour."""

    body: Body
    Ts_camera_part: Array
    colour: Colour


@dataclass(frozen=True, eq=False)
class Scenery:
    """All there is to see at one moment.

    Ts_camera_part: (P, 4, 4) of the body's parts.
    selected:  names of parts.
    opacity:   of the body over the picture, 0 to 1.
    ghosts:    up to three other poses (frame, Ts_camera_part), as `editor.shown.ghosts` has them.
    beside:    the other bodies of the scene.
    before:    another body and its Ts_camera_part, drawn as an outline to compare with.
    Rs_view_camera: (3, 3) of the small views; of those not named the usual ones.
    telephoto: rays to the camera are parallel.
    """

    body: Body
    Ts_camera_part: Array
    selected: frozenset[str] = frozenset()
    mode: Mode = "both"
    opacity: float = 0.5
    ghosts: tuple[tuple[int, Array], ...] = ()
    beside: tuple[BodyBeside, ...] = ()
    before: tuple[Body, Array] | None = None
    trail: Trail | None = None
    Rs_view_camera: dict[Role, Array] = field(default_factory=dict)
    telephoto: bool = False

    def R_view_camera(self, role: Role) -> Array:
        return self.Rs_view_camera.get(role, _R_EYE_CAMERA[role])

    def rays(self, role: Role) -> Array | None:
        """The direction (3,) of parallel rays in the camera frame; None: from the camera."""
        if role == "main" and not self.telephoto:
            return None
        return np.asarray(self.R_view_camera(role)[2])

    def looks_like(self, scenery: Scenery) -> bool:
        """The same body in the same colours, wherever it is."""
        return (
            self.body is scenery.body
            and self.selected == scenery.selected
            and self.mode == scenery.mode
            and self.opacity == scenery.opacity
        )

    def is_seen_as(self, scenery: Scenery) -> bool:
        """Tell whether both are seen from the same sides."""
        same = (np.array_equal(self.R_view_camera(r), scenery.R_view_camera(r)) for r in ROLES)
        return self.telephoto == scenery.telephoto and all(same)

    def is_posed_as(self, scenery: Scenery) -> bool:
        return self.Ts_camera_part is scenery.Ts_camera_part or np.array_equal(
            self.Ts_camera_part, scenery.Ts_camera_part
        )


class Stage:
    """Owns viser's scene. `show` and `attach` belong to its loop's thread, the rest to any."""

    def __init__(self) -> None:
        self._viser = Portless()
        self._scene = self._viser.server.scene
        self._drawn: Scenery | None = None
        self._outline: Outline | None = None
        self._parts: list[PartNodes] = []
        self._beside: list[_NodesBeside] = []
        self._lines: dict[str, LineSegmentsHandle] = {}
        self._skins = SkinNodes(self._scene)
        self._only_for: dict[str, tuple[Role, ...]] = {}
        """Nodes that some views must not show, with the views that do."""
        self._prepare()
        self._viser.server.on_client_connect(self._welcome)

    @property
    def loop(self) -> asyncio.AbstractEventLoop:
        """The loop the program's server must run on."""
        return self._viser.loop

    async def attach(self, websocket: WebSocket, role: Role) -> None:
        """Serve the websocket of one view until it closes."""
        await self._viser.attach(websocket, role)

    def stop(self) -> None:
        """End viser's loop, and with it every view's connection."""
        self._viser.stop()

    def show(self, scenery: Scenery) -> None:
        """Draw what differs from what is drawn."""
        was, self._drawn = self._drawn, scenery
        new_body = was is None or was.body is not scenery.body
        new_looks = was is None or not was.looks_like(scenery)
        new_sides = was is None or not was.is_seen_as(scenery)
        new_pose = was is None or not was.is_posed_as(scenery)
        with self._viser.server.atomic():
            if new_body:
                self._draw_shapes(scenery.body)
            if new_looks:
                self._draw_looks(scenery)
            if new_sides:
                self._draw_lights(scenery)
            if new_pose:
                self._draw_pose(scenery.Ts_camera_part)
            if new_pose or new_looks or new_sides:
                self._draw_outlines(scenery)
            if was is None or new_body or new_sides or was.ghosts is not scenery.ghosts:
                self._draw_ghosts(scenery)
            if was is None or new_sides or new_looks or was.beside is not scenery.beside:
                self._draw_beside(scenery)
            if was is None or new_sides or was.before is not scenery.before:
                self._draw_before(scenery)
            if was is None or was.trail is not scenery.trail:
                self._draw_trail(scenery.trail)
        self._viser.server.flush()

    def show_skin(self, glb: bytes | None) -> None:
        """Draw this observed surface in the small views; `settle_skin` some pictures later."""
        with self._viser.server.atomic():
            self._skins.put(glb)
        self._viser.server.flush()

    def settle_skin(self) -> None:
        """The page has drawn the newest surface: take the one before away."""
        self._skins.settle()
        self._viser.server.flush()

    def _prepare(self) -> None:
        self._scene.set_up_direction("+y")
        self._scene.configure_default_lights(enabled=False)
        self._scene.configure_environment_map(None)
        self._scene.add_frame(ROOT, show_axes=False, wxyz=_CAMERA_WXYZ)
        for name in SkinNodes.NAMES:
            self._reserve(name, _OPAQUE)
        self._reserve(f"{ROOT}/trail", _OUTLINED)
        for role in ROLES:
            add_lights(self._scene, f"{ROOT}/light/{role}")
            for kind in ("sky", "sun"):
                self._reserve(f"{ROOT}/light/{role}/{kind}", (role,))
        for role in _OUTLINED:
            for lines in ("outline", "held"):
                self._reserve(f"{ROOT}/{lines}/{role}", (role,))
            self._reserve(f"{ROOT}/before/{role}", (role,))
            self._reserve(f"{ROOT}/around/{role}", (role,))
            for number in range(len(GHOST_COLOURS)):
                self._reserve(f"{ROOT}/ghost/{number}/{role}", (role,))

    async def _welcome(self, client: ClientHandle) -> None:
        role = self._viser.role_of(client)
        for name, roles in self._only_for.items():
            if role not in roles:
                hide_from(client, name)

    def _reserve(self, name: str, roles: tuple[Role, ...]) -> None:
        """Keep a node, whenever it is there, out of all views but these."""
        if name in self._only_for:
            return
        self._only_for[name] = roles
        for client in self._viser.server.get_clients().values():
            if self._viser.role_of(client) not in roles:
                hide_from(client, name)

    def _draw_shapes(self, body: Body) -> None:
        """New shapes in the nodes there are; new nodes where there is another number of parts."""
        self._outline = Outline.of(body)
        if len(self._parts) == len(body.parts):
            for nodes, part in zip(self._parts, body.parts, strict=True):
                nodes.set_shape(part.shape)
            return
        for nodes in self._parts:
            nodes.frame.remove()
        self._parts = self._add_parts(f"{ROOT}/body", body)
        if self._drawn is not None:
            self._draw_pose(self._drawn.Ts_camera_part)

    def _add_parts(self, below: str, body: Body) -> list[PartNodes]:
        """The nodes of a body's parts, each kept out of the views that must not show it."""
        parts = []
        for number, part in enumerate(body.parts):
            name = f"{below}/{number}"
            for child in OVERLAY_ONLY:
                self._reserve(f"{name}/{child}", ("main",))
            for child in SOLID_ONLY:
                self._reserve(f"{name}/{child}", _OPAQUE)
            for child in FREE_ONLY:
                self._reserve(f"{name}/{child}", ("free",))
            parts.append(PartNodes.add(self._scene, name, part.shape))
        return parts

    def _draw_beside(self, scenery: Scenery) -> None:
        """The bodies that are not posed: new nodes where one of them is another body."""
        if [nodes.body for nodes in self._beside] != [each.body for each in scenery.beside]:
            for nodes in self._beside:
                nodes.remove()
            self._beside = [
                _NodesBeside(each.body, self._add_parts(f"{ROOT}/beside/{number}", each.body))
                for number, each in enumerate(scenery.beside)
            ]
        for each, nodes in zip(scenery.beside, self._beside, strict=True):
            nodes.set_look(each.colour, scenery.mode, scenery.opacity)
            nodes.set_pose(each.Ts_camera_part)
        for role in _OUTLINED:
            lines, colours = self._lines_beside(scenery, role)
            self._put(f"{ROOT}/around/{role}", lines, colours, LINE_PX)

    def _lines_beside(self, scenery: Scenery, role: Role) -> tuple[Segments, Array]:
        """The lines (N, 2, 3) where round sides of the bodies that are not posed turn away from a
        view, camera frame, and the colours (N, 2, 3) of their ends."""
        tint = light if role == "main" else dark
        lines = [np.zeros((0, 2, 3), dtype=np.float32)]
        colours = [np.zeros((0, 2, 3))]
        for each, nodes in zip(scenery.beside, self._beside, strict=True):
            own = nodes.outline.lines(each.Ts_camera_part, scenery.rays(role))
            lines.append(own)
            colours.append(np.broadcast_to(tint(each.colour), own.shape))
        return np.concatenate(lines), np.concatenate(colours)

    def _draw_looks(self, scenery: Scenery) -> None:
        sides = part_sides(scenery.body)
        for nodes, name, side in zip(self._parts, scenery.body.names, sides, strict=True):
            is_selected = name in scenery.selected
            nodes.set_look(SIDE_COLOURS[side], is_selected, scenery.mode, scenery.opacity)

    def _draw_lights(self, scenery: Scenery) -> None:
        for role in ROLES:
            for kind in ("sky", "sun"):
                node = self._scene.get_handle_by_name(f"{ROOT}/light/{role}/{kind}")
                assert node is not None
                node.position = scenery.R_view_camera(role).T @ _TO_LIGHT_OF.get(role, _TO_LIGHT)

    def _draw_pose(self, Ts_camera_part: Array) -> None:
        _set_poses(self._parts, Ts_camera_part)

    def _draw_outlines(self, scenery: Scenery) -> None:
        assert self._outline is not None
        parts = [scenery.body.names[i] for i in self._outline.part]
        is_selected = np.array([name in scenery.selected for name in parts], dtype=bool)
        sides = np.array(part_sides(scenery.body))[self._outline.part]
        colours = np.array([SIDE_COLOURS[side] for side in sides]).reshape(-1, 3)
        for role in _OUTLINED:
            lines = self._outline.lines(scenery.Ts_camera_part, scenery.rays(role))
            tints = light(colours) if role == "main" else dark(colours)
            ends = np.broadcast_to(tints[:, None], lines.shape)
            self._put(f"{ROOT}/outline/{role}", lines[~is_selected], ends[~is_selected], LINE_PX)
            self._put(f"{ROOT}/held/{role}", lines[is_selected], WHITE, SELECTED_LINE_PX)

    def _draw_ghosts(self, scenery: Scenery) -> None:
        for number, colour in enumerate(GHOST_COLOURS):
            for role in _OUTLINED:
                lines = np.zeros((0, 2, 3), dtype=np.float32)
                if number < len(scenery.ghosts):
                    assert self._outline is not None
                    Ts = scenery.ghosts[number][1]
                    lines = _body_lines(scenery.body, self._outline, Ts, scenery.rays(role))
                self._put(f"{ROOT}/ghost/{number}/{role}", lines, colour, GHOST_PX)

    def _draw_before(self, scenery: Scenery) -> None:
        for role in ROLES:
            lines = np.zeros((0, 2, 3), dtype=np.float32)
            if scenery.before is not None:
                body, Ts = scenery.before
                lines = _body_lines(body, Outline.of(body), Ts, scenery.rays(role))
            self._put(f"{ROOT}/before/{role}", lines, BEFORE_COLOUR, LINE_PX)

    def _draw_trail(self, trail: Trail | None) -> None:
        if trail is None:
            lines = np.zeros((0, 2, 3), dtype=np.float32)
        else:
            lines = trail_lines(trail.p_camera, trail.present)
        self._put(f"{ROOT}/trail", lines, WHITE, LINE_PX)

    def _put(self, name: str, lines: Segments, colours: Array | Colour, width_px: float) -> None:
        """Lines (..., 2, 3) in the camera frame; where there are none, no node."""
        points = lines.reshape(-1, 2, 3)
        ends = np.asarray(colours).reshape(-1, 2, 3) if np.ndim(colours) > 1 else colours
        node = self._lines.get(name)
        if node is not None and len(points) == len(node.points):
            node.points = points
            node.colors = np.rint(np.asarray(ends)).astype(np.uint8)
            return
        if node is not None:
            self._lines.pop(name).remove()
        if len(points):
            self._lines[name] = add_lines(self._scene, name, points, ends, width_px)


class _NodesBeside:
    """The nodes of a body that is not posed."""

    def __init__(self, body: Body, parts: list[PartNodes]) -> None:
        self.body = body
        self.outline = Outline.of(body)
        self._parts = parts
        self._look: tuple[Colour, Mode, float] | None = None

    def set_look(self, colour: Colour, mode: Mode, opacity: float) -> None:
        """Nothing where it looks so already: every setting goes to every view."""
        if self._look == (colour, mode, opacity):
            return
        self._look = colour, mode, opacity
        for nodes in self._parts:
            nodes.set_look(colour, False, mode, opacity)

    def set_pose(self, Ts_camera_part: Array) -> None:
        _set_poses(self._parts, Ts_camera_part)

    def remove(self) -> None:
        for nodes in self._parts:
            nodes.frame.remove()


def _set_poses(parts: Sequence[PartNodes], Ts_camera_part: Array) -> None:
    turns = quaternion_wxyz(Ts_camera_part[:, :3, :3])
    for nodes, wxyz, T in zip(parts, turns, Ts_camera_part, strict=True):
        nodes.set_pose(wxyz, T[:3, 3])


def _body_lines(
    body: Body, outline: Outline, Ts_camera_part: Array, rays: Array | None
) -> Segments:
    """All lines (N, 2, 3) of a body in a pose as one view sees it, camera frame."""
    rims = [
        apply_transform(T, lines.astype(np.float64).reshape(-1, 3)).reshape(-1, 2, 3)
        for T, lines in zip(Ts_camera_part, map(_rims, body.parts), strict=True)
    ]
    return np.concatenate([outline.lines(Ts_camera_part, rays), *rims]).astype(np.float32)


def _rims(part: Part) -> Segments:
    return rim_lines(part.shape)
