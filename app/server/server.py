"""The page's server: Starlette on one port, with viser's views inside and the guard in front."""

from __future__ import annotations

import asyncio
import contextlib
import socket
import traceback
from concurrent.futures import Future
from pathlib import Path
from typing import Any

import uvicorn
from pydantic_core import to_json
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import FileResponse, HTMLResponse, PlainTextResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.websockets import WebSocket, WebSocketDisconnect

from keypose import static
from keypose.app.document.library import Library
from keypose.app.editor.state import EditorState
from keypose.app.scene.scene import Stage
from keypose.app.scene.scenery import SceneryMaker
from keypose.app.scene.viser_compat import PAGE, ROLES
from keypose.app.server.admission import BROWSERS_FILE, LINKS_FILE, Browsers, OneTimeTokens
from keypose.app.server.exports import Exports
from keypose.app.server.guard import PROTOCOL, Guard
from keypose.app.server.headers import headers_for
from keypose.app.server.imports import Imports
from keypose.app.server.outputs import Outputs
from keypose.app.server.page_files import PageFiles
from keypose.app.server.routes import LibraryRoutes
from keypose.app.server.surfaces import Surfaces
from keypose.app.store.sections import film_version, image_version
from keypose.app.store.store import Store
from keypose.app.store.tabs import Tab
from keypose.tracker.errors import KeyposeError
from keypose.tracker.scratch import sweep_scratch

STATIC = Path(static.__file__).parent
STATIC_MOUNT = "/static"
SHRINKS = {str(by): by for by in (1, 2, 4)}
"""By how much a frame's picture may be shrunk, as the page asks for it."""
LARGEST_MESSAGE = 1 << 20
FAULT = 1011
"""What a socket is closed with where this program is at fault."""
SECONDS_TO_CLOSE = 2
SECONDS_BETWEEN_BEATS = 1.0
"""A tab that receives nothing for three of them takes the connection for lost."""
SECONDS_BETWEEN_PINGS = 5.0
SECONDS_WITHOUT_PONG = 10.0
"""A tab whose line broke unclosed, as when its computer sleeps, is not counted for longer."""


class Server:
    """Everything behind one port. `serve` runs until `ask_to_stop`."""

    def __init__(
        self, library: Library, hosts: tuple[str, ...] = (), public_hosts: tuple[str, ...] = ()
    ) -> None:
        self.stage = Stage()
        self._maker = SceneryMaker()
        self.store = Store(self.stage.loop, self._show, library)
        self._surfaces = Surfaces(
            self.stage.loop,
            self.stage.show_skin,
            self.stage.settle_skin,
            self.store.surface_seen,
            self.store.surfaces_unusable,
        )
        self._shelf = LibraryRoutes(library)
        self._outputs = Outputs(self.store, self._surfaces)
        self._exports = Exports(self.store)
        self._imports = Imports(self.store)
        self._page_files = PageFiles(STATIC, STATIC_MOUNT)
        self.guard = Guard(
            self._application(),
            browsers=Browsers(library.workspace / BROWSERS_FILE),
            tokens=OneTimeTokens(library.workspace / LINKS_FILE),
            extra_hosts=hosts,
            public_hosts=public_hosts,
        )
        self._uvicorn = _uvicorn(self.guard)
        sweep_scratch()
        self._serving: Future[None] | None = None

    def _application(self) -> Starlette:
        return Starlette(
            routes=[
                Route("/", self._page),
                WebSocketRoute("/events", self._events),
                WebSocketRoute("/view/{role}", self._view_socket),
                Route("/view/{role}", self._view),
                Route("/frame/{index:int}.jpg", self._frame),
                Route("/film/{view}/{index:int}.jpg", self._film_frame),
                *self._outputs.routes(),
                *self._exports.routes(),
                *self._imports.routes(),
                *self._shelf.routes(),
                Mount(STATIC_MOUNT, self._page_files),
            ],
        )

    def _show(self, edit: EditorState, trail: Any) -> None:
        self.stage.show(self._maker.of(edit, trail))
        self._surfaces.follow(self.store.opened, edit)

    # --- running

    def listen(self, listener: socket.socket) -> None:
        """Serve on a bound socket from now on."""
        self.guard.port = listener.getsockname()[1]
        self._serving = asyncio.run_coroutine_threadsafe(self._serve(listener), self.stage.loop)

    def wait(self) -> None:
        """Until the server has ended; short waits, so that signals are handled in between."""
        while self._serving is not None:
            with contextlib.suppress(TimeoutError):
                self._serving.result(timeout=0.2)
                return

    def ask_to_stop(self) -> None:
        """End soon; may be called from a signal handler."""
        self._uvicorn.should_exit = True

    async def _serve(self, listener: socket.socket) -> None:
        try:
            await self._uvicorn.serve(sockets=[listener])
        finally:
            await self._exports.close()
            await self._imports.close()
            await self.store.stop()

    # --- pages

    async def _page(self, request: Request) -> Response:
        return HTMLResponse(self._page_files.page(), headers=_fresh(request, "page"))

    async def _view(self, request: Request) -> Response:
        if request.path_params["role"] not in ROLES:
            return PlainTextResponse("There is no such view.\n", 404)
        return FileResponse(PAGE, headers=_fresh(request, "view"))

    async def _frame(self, request: Request) -> Response:
        store, index = self.store, request.path_params["index"]
        edit, frames = store.app_state.edit, store.frames
        shrink = SHRINKS.get(request.query_params.get("shrink", "1"))
        if edit is None or frames is None or index >= edit.frame_count or shrink is None:
            return PlainTextResponse("There is no such frame.\n", 404, headers_for("data"))
        version = image_version(store.app_state)
        try:
            content = await self._surfaces.jpeg(index, store.app_state)
            if content is None:
                content = await frames.jpeg(index, edit.doc.view.camera, version, shrink)
        except KeyposeError as error:
            return PlainTextResponse(f"{error}\n", 404, headers_for("data"))
        return _picture(request, content, version)

    async def _film_frame(self, request: Request) -> Response:
        """The same of another film."""
        edit, films = self.store.app_state.edit, self.store.films
        index = request.path_params["index"]
        shrink = SHRINKS.get(request.query_params.get("shrink", "1"))
        views = () if edit is None else edit.doc.views[1:]
        view = next((each for each in views if each.id == request.path_params["view"]), None)
        is_there = view is not None and index < view.video.frame_count
        if edit is None or films is None or shrink is None or view is None or not is_there:
            return PlainTextResponse("There is no such frame.\n", 404, headers_for("data"))
        try:
            content = await films.jpeg(edit.doc, view, index, shrink)
        except KeyposeError as error:
            return PlainTextResponse(f"{error}\n", 404, headers_for("data"))
        return _picture(request, content, film_version(view))

    # --- sockets

    async def _view_socket(self, websocket: WebSocket) -> None:
        role = websocket.path_params["role"]
        if role not in ROLES:
            await websocket.close(4404)
            return
        await self.stage.attach(websocket, role)

    async def _events(self, websocket: WebSocket) -> None:
        await websocket.accept(PROTOCOL)
        tab = self.store.join()
        sender = asyncio.ensure_future(_send(websocket, tab))
        try:
            with contextlib.suppress(WebSocketDisconnect):  # this line is over
                while True:
                    self._receive(tab, await _received(websocket))
        finally:
            sender.cancel()
            self.store.leave(tab)

    def _receive(self, tab: Tab, message: Any) -> None:
        if isinstance(message, dict) and "ask" in message:
            try:
                tab.send(self._outputs.answer(message))
            except Exception:  # noqa: BLE001 — a fault of ours; the line must not break with it
                traceback.print_exc()
        else:
            self.store.receive(tab, message)


def _picture(request: Request, content: bytes, version: str) -> Response:
    """A picture that a browser keeps, unless it was asked for before lens or video changed."""
    is_present = request.query_params.get("v") == version
    kept = "private, max-age=31536000, immutable" if is_present else "no-store"
    headers = {**headers_for("data"), "Cache-Control": kept}
    return Response(content, media_type="image/jpeg", headers=headers)


def _uvicorn(guard: Guard) -> uvicorn.Server:
    config = uvicorn.Config(
        guard,
        ws="websockets-sansio",
        ws_per_message_deflate=False,
        ws_max_size=LARGEST_MESSAGE,
        ws_ping_interval=SECONDS_BETWEEN_PINGS,
        ws_ping_timeout=SECONDS_WITHOUT_PONG,
        lifespan="off",
        proxy_headers=False,
        server_header=False,
        access_log=False,
        log_level="warning",
        timeout_graceful_shutdown=SECONDS_TO_CLOSE,
    )
    return uvicorn.Server(config)


async def _received(websocket: WebSocket) -> Any:
    """The next message; WebSocketDisconnect where it is no JSON, or the tab is gone."""
    try:
        return await websocket.receive_json()
    except (ValueError, KeyError, RuntimeError) as error:  # numbers too long, nesting too deep
        raise WebSocketDisconnect(1003) from error


async def _send(websocket: WebSocket, tab: Tab) -> None:
    """Whatever there is for a tab, until it is gone. A line on which nothing can be sent ends."""
    number = 0
    try:
        while True:
            for message in await _news(tab):
                number += 1
                # JSON has no word for what is no number: null, which the page shows as nothing.
                text = to_json({**message, "seq": number}, inf_nan_mode="null").decode()
                await websocket.send_text(text)
    except (WebSocketDisconnect, RuntimeError):  # the tab is gone
        return
    except Exception:  # noqa: BLE001 — a fault of ours: the tab would wait for ever
        traceback.print_exc()
        await websocket.close(FAULT)


async def _news(tab: Tab) -> list[dict[str, Any]]:
    """What is to be sent to a tab, if only that somebody is still here."""
    try:
        return await asyncio.wait_for(tab.next(), SECONDS_BETWEEN_BEATS)
    except TimeoutError:
        return [{"t": "beat"}]


def _fresh(request: Request, kind: Any) -> dict[str, str]:
    return {**headers_for(kind, request.headers["host"]), "Cache-Control": "no-cache"}
