"""Every private touch with viser, and nothing else. Known to hold for viser 1.1.0 and 1.1.1.

viser wants a port of its own. Here it has none: while its server is constructed, the function that
would bind a socket is replaced by one that keeps viser's connection handler. Our server accepts the
websockets and hands them to that handler. Nothing a browser sends ever reaches viser: it is sent
once that a camera is there, which is what it calls a connected client, and then receives nothing.
"""

from __future__ import annotations

import asyncio
import atexit
import contextlib
import functools
from collections.abc import AsyncIterator, Awaitable, Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Literal, TypeAlias, get_args

import msgspec
import rich
import viser
import viser._assignable_props_api
import viser._messages
import websockets.asyncio.server as websocket_server
from starlette.websockets import WebSocket, WebSocketDisconnect
from viser import ClientHandle, ViserServer
from websockets.exceptions import ConnectionClosedOK

KNOWN = ("1.1.0", "1.1.1")
"""The versions that the tests passed with; pyproject.toml allows these."""

SUBPROTOCOL = f"viser-v{viser.__version__}"
"""What viser's page calls its protocol: page and server are of one version."""

PAGE = Path(viser.__file__).parent / "client" / "build" / "index.html"
"""viser's page, one file with everything in it."""

Role: TypeAlias = Literal["main", "top", "side", "front", "free"]
ROLES: tuple[Role, ...] = get_args(Role)


# Asked for every node anew, although a kind of node has always the same: a tenth of a second, until
# a body is drawn.
viser._assignable_props_api.get_type_hints = functools.cache(  # type: ignore[assignment,attr-defined]
    viser._assignable_props_api.get_type_hints  # type: ignore[attr-defined]
)


class Portless:
    """A viser server without a socket, its event loop running in a thread of its own."""

    def __init__(self) -> None:
        caught: list[Callable[[Any], Awaitable[None]]] = []
        with _without_banner(), _caught_handler(caught):
            self.server = ViserServer(host="127.0.0.1", port=0, verbose=False)
        self._handle = caught[0]
        self._wire = self.server._websock_server
        for exit_of in (self.server.stop, self._wire.stop):
            atexit.unregister(exit_of)  # whoever made it stops it
        for request in (viser._messages.ShareUrlRequest, viser._messages.ShareUrlDisconnect):
            self._wire.unregister_handler(request)  # would open a public tunnel

    @property
    def loop(self) -> asyncio.AbstractEventLoop:
        """The loop on which `attach` must run, and on which all callbacks do."""
        return self.server.get_event_loop()

    async def attach(self, websocket: WebSocket, role: Role) -> None:
        """Serve one websocket of viser's page until it closes. Accepts it, or refuses it."""
        if SUBPROTOCOL not in websocket.scope["subprotocols"]:
            await websocket.close(1002, "another version of viser")
            return
        await websocket.accept(SUBPROTOCOL)
        await self._handle(_Wire(websocket, role))

    def role_of(self, client: ClientHandle) -> Role | None:
        """Which view a client is; None once it has gone."""
        wire: Any = self._wire._live_connections.get(client.client_id)
        return None if wire is None else wire.role

    def stop(self) -> None:
        """End the loop, its thread and all connections."""
        with _without_banner():
            self.server.stop()


def hide_from(client: ClientHandle, name: str) -> None:
    """Take a shared node out of one client's picture, now and after it is drawn anew.

    A node of a client's own stands before the shared one of the same name, in whatever order the
    two arrive; this one shows nothing.
    """
    client.scene.add_frame(name, show_axes=False, visible=False)


class _Wire:
    """The part of a websocket that viser's handler uses, over ours."""

    subprotocol = SUBPROTOCOL

    def __init__(self, websocket: WebSocket, role: Role) -> None:
        self._websocket = websocket
        self.role = role
        self.request = SimpleNamespace(path=f"/view/{role}")
        self._greeted = False

    async def send(self, data: bytes) -> None:
        try:
            await self._websocket.send_bytes(data)
        except (WebSocketDisconnect, RuntimeError, OSError) as error:
            raise ConnectionClosedOK(None, None) from error

    async def recv(self) -> bytes:
        if not self._greeted:
            self._greeted = True
            return _CAMERA
        while (await self._websocket.receive())["type"] != "websocket.disconnect":
            pass
        raise ConnectionClosedOK(None, None)

    async def close(self, code: int = 1000, reason: str = "") -> None:
        with contextlib.suppress(RuntimeError, OSError):
            await self._websocket.close(code, reason)


_CAMERA = msgspec.msgpack.encode(
    {
        "type": "ViewerCameraMessage",
        "wxyz": [1.0, 0.0, 0.0, 0.0],
        "position": [0.0, 0.0, 0.0],
        "fov": 1.0,
        "near": 0.1,
        "far": 10.0,
        "image_height": 1,
        "image_width": 1,
        "look_at": [0.0, 0.0, 1.0],
        "up_direction": [0.0, 1.0, 0.0],
    }
)


@contextlib.contextmanager
def _caught_handler(caught: list[Callable[[Any], Awaitable[None]]]) -> Iterator[None]:
    """Keep the handler that viser would serve, and bind nothing."""
    serve = websocket_server.serve

    @contextlib.asynccontextmanager
    async def keep(
        handler: Callable[[Any], Awaitable[None]], *_: object, **__: object
    ) -> AsyncIterator[SimpleNamespace]:
        caught.append(handler)
        yield SimpleNamespace(server=SimpleNamespace(sockets=[]))

    websocket_server.serve = keep  # type: ignore[misc,assignment]
    try:
        yield
    finally:
        websocket_server.serve = serve  # type: ignore[misc]


@contextlib.contextmanager
def _without_banner() -> Iterator[None]:
    """Without viser's banner and its farewell, which it prints whatever `verbose` says."""
    speak = rich.print
    rich.print = lambda *_, **__: None
    try:
        yield
    finally:
        rich.print = speak
