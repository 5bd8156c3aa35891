"""What the program knows about viser's inside, and that it still is so."""

from __future__ import annotations

import asyncio
import atexit
import socket
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec
import pytest
import viser
import viser._messages
import websockets.asyncio.server
import zstandard
from starlette.websockets import WebSocket

from keypose.app.scene.viser_compat import (
    KNOWN,
    PAGE,
    ROLES,
    SUBPROTOCOL,
    Portless,
    Role,
    hide_from,
)


@pytest.fixture
def portless() -> Iterator[Portless]:
    made = Portless()
    yield made
    made.stop()


class Browser:
    """A browser's end of one websocket, spoken to in plain ASGI."""

    def __init__(self, portless: Portless, role: Role, subprotocol: str = SUBPROTOCOL) -> None:
        self._portless = portless
        self._from_server: asyncio.Queue[dict[str, Any]] = asyncio.Queue()
        self._to_server: asyncio.Queue[dict[str, Any]] = asyncio.Queue()
        self._to_server.put_nowait({"type": "websocket.connect"})
        scope = {"type": "websocket", "path": f"/view/{role}", "headers": []}
        scope["subprotocols"] = [subprotocol]
        websocket = WebSocket(scope, self._to_server.get, self._from_server.put)
        self._serving = asyncio.run_coroutine_threadsafe(
            portless.attach(websocket, role), portless.loop
        )

    def next(self) -> dict[str, Any]:
        waiting = asyncio.run_coroutine_threadsafe(self._from_server.get(), self._portless.loop)
        return waiting.result(timeout=10)

    def messages(self) -> list[dict[str, Any]]:
        """The next window of viser's messages."""
        data = self.next()["bytes"]
        length = int.from_bytes(data[8:16], "little")
        inner = zstandard.ZstdDecompressor().decompress(data[16 : 16 + length])
        return list(msgspec.msgpack.decode(inner)["messages"])

    def until(self, kind: str, **values: Any) -> list[dict[str, Any]]:
        """All messages up to one of this kind with these values."""
        seen: list[dict[str, Any]] = []
        while not any(
            m["type"] == kind and all(m.get(k) == v for k, v in values.items()) for m in seen
        ):
            seen += self.messages()
        return seen

    def say(self, message: dict[str, Any]) -> None:
        self._portless.loop.call_soon_threadsafe(self._to_server.put_nowait, message)

    def leave(self) -> None:
        self.say({"type": "websocket.disconnect", "code": 1000})
        self._serving.result(timeout=10)


def test_viser_is_of_a_version_that_this_program_knows() -> None:
    project = (Path(__file__).parents[3] / "pyproject.toml").read_text("utf-8")
    assert viser.__version__ in KNOWN
    assert f'"viser>={KNOWN[0]},<={KNOWN[-1]}"' in project


def test_the_private_names_are_where_they_were(portless: Portless) -> None:
    server = portless.server
    wire = server._websock_server
    for name in ("_live_connections", "disconnect_all_clients", "unregister_handler", "stop"):
        assert hasattr(wire, name)
    assert viser._messages.ViewerCameraMessage in viser._messages.Message.get_subclasses()
    assert PAGE.is_file()
    page = PAGE.read_text("utf-8")
    assert viser.__version__ in page or len(page) > 100_000


def test_no_port_is_opened(monkeypatch: pytest.MonkeyPatch) -> None:
    bound: list[Any] = []
    bind = socket.socket.bind

    def watched(self: socket.socket, address: Any) -> None:
        bound.append((self.family, address))
        bind(self, address)

    monkeypatch.setattr(socket.socket, "bind", watched)
    serve = websockets.asyncio.server.serve
    made = Portless()
    try:
        assert [one for one in bound if one[0] in (socket.AF_INET, socket.AF_INET6)] == []
        assert websockets.asyncio.server.serve is serve
    finally:
        made.stop()


def test_it_says_nothing_on_the_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    made = Portless()
    made.stop()
    assert capsys.readouterr() == ("", "")


def test_it_leaves_nothing_to_be_done_at_exit(monkeypatch: pytest.MonkeyPatch) -> None:
    kept: list[Any] = []
    register, unregister = atexit.register, atexit.unregister

    def watched_register(function: Any, *args: Any, **kwargs: Any) -> Any:
        kept.append(function)
        return register(function, *args, **kwargs)

    def watched_unregister(function: Any) -> None:
        kept[:] = [one for one in kept if one != function]
        unregister(function)

    monkeypatch.setattr(atexit, "register", watched_register)
    monkeypatch.setattr(atexit, "unregister", watched_unregister)
    made = Portless()
    left = list(kept)
    made.stop()
    assert [one for one in left if getattr(one, "__name__", "") == "stop"] == []


def test_nobody_can_ask_for_a_public_tunnel(portless: Portless) -> None:
    handlers = portless.server._websock_server._incoming_handlers
    assert viser._messages.ShareUrlRequest not in handlers
    assert viser._messages.ShareUrlDisconnect not in handlers


def test_it_stops_and_ends_its_thread() -> None:
    made = Portless()
    thread = made.server._websock_server._server_thread
    assert thread is not None
    made.stop()
    assert not thread.is_alive()


def test_another_version_of_the_page_is_turned_away(portless: Portless) -> None:
    browser = Browser(portless, "main", "viser-v9.9.9")
    assert browser.next() == {
        "type": "websocket.close",
        "code": 1002,
        "reason": "another version of viser",
    }


@pytest.mark.parametrize("role", ROLES)
def test_a_client_is_known_by_the_view_it_came_for(portless: Portless, role: Role) -> None:
    found: list[Role | None] = []

    @portless.server.on_client_connect
    async def _(client: viser.ClientHandle) -> None:
        found.append(portless.role_of(client))

    browser = Browser(portless, role)
    assert browser.next() == {
        "type": "websocket.accept",
        "subprotocol": SUBPROTOCOL,
        "headers": [],
    }
    browser.until("ReplayDoneMessage")
    browser.leave()
    assert found == [role]


def test_what_a_browser_sends_never_reaches_viser(portless: Portless) -> None:
    received: list[Any] = []
    wire = portless.server._websock_server
    wire.register_handler(viser._messages.ScenePointerMessage, lambda *sent: received.append(sent))
    wire.register_handler(viser._messages.ShareUrlRequest, lambda *sent: received.append(sent))
    browser = Browser(portless, "main")
    browser.next()
    browser.say({"type": "websocket.receive", "text": "not even bytes"})
    for data in (b"\x00nonsense", msgspec.msgpack.encode({"type": "ShareUrlRequest"})):
        browser.say({"type": "websocket.receive", "bytes": data})
    portless.server.scene.add_frame("/still-here", show_axes=False)
    browser.until("FrameMessage", name="/still-here")
    browser.leave()
    assert received == []


def test_a_hidden_node_is_replaced_for_that_client_alone(portless: Portless) -> None:
    portless.server.scene.add_icosphere("/ball", 1.0)

    @portless.server.on_client_connect
    async def _(client: viser.ClientHandle) -> None:
        if portless.role_of(client) == "top":
            hide_from(client, "/ball")

    top, side = Browser(portless, "top"), Browser(portless, "side")
    for browser in (top, side):
        browser.next()
    seen = top.until("SetSceneNodeVisibilityMessage", name="/ball", visible=False)
    hiding = next(m for m in seen if m["type"] == "FrameMessage" and m["name"] == "/ball")
    assert hiding["owner"] != ""
    assert not hiding["virtual"]
    others = side.until("ReplayDoneMessage")
    assert not any(m["type"] == "FrameMessage" and m.get("name") == "/ball" for m in others)
    for browser in (top, side):
        browser.leave()


def test_a_client_that_was_dropped_is_forgotten(portless: Portless) -> None:
    browser = Browser(portless, "front")
    browser.next()
    browser.until("ReplayDoneMessage")
    browser.leave()
    assert portless.server.get_clients() == {}
