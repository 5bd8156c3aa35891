"""The door: who may speak to this server, and with what words.

A server on this computer can be reached by every page the browser shows. So each request, sockets
included, must name this server as its host, come from a page of this server, use only the query
names its path knows, and carry the cookie that the start address hands out once.
"""

from __future__ import annotations

import hmac
import re
import secrets
from collections.abc import Iterable
from http.cookies import CookieError, SimpleCookie
from typing import Literal, TypeAlias
from urllib.parse import parse_qsl

from starlette.responses import PlainTextResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Receive, Scope, Send

Kind: TypeAlias = Literal["page", "view", "data"]

TOKEN = "token"
"""The query name that carries the token, once."""

_QUERIES: tuple[tuple[re.Pattern[str], frozenset[str]], ...] = tuple(
    (re.compile(path), frozenset(names))
    for path, names in (
        (r"/", {TOKEN}),
        (r"/view/[a-z]+", {"fixedDpr", "darkMode", "hideViserLogo", "websocket"}),
        (r"/frame/\d+\.jpg", {"v"}),
        (r"/picture\.png", {"view", "frame", "mode", "opacity", "tint"}),
        (r"/motion", {"format"}),
        (r"/upload", {"name"}),
    )
)
_SAFE_METHODS = ("GET", "HEAD")
_LONGEST_QUERY = 2000


class Refusal(Exception):
    """A request that stays outside; its text says why in plain words."""


class Guard:
    """ASGI middleware in front of everything.

    `port` is set once the socket is bound. `extra_hosts` are other names under which the server may
    be addressed, with or without a port, such as the one given with --host.
    """

    def __init__(
        self, app: ASGIApp, port: int = 0, token: str | None = None, extra_hosts: Iterable[str] = ()
    ) -> None:
        self._app = app
        self.port = port
        self.token = token or secrets.token_urlsafe(24)
        self._extra_hosts = tuple(host.lower() for host in extra_hosts)

    @property
    def cookie(self) -> str:
        """Cookies do not tell ports apart: two servers must not share a name."""
        return f"keypose_{self.port}"

    @property
    def start_path(self) -> str:
        """The address, without its host, that lets a browser in."""
        return f"/?{TOKEN}={self.token}"

    @property
    def hosts(self) -> frozenset[str]:
        """What the Host header may say."""
        names = ("127.0.0.1", "localhost", *self._extra_hosts)
        with_port = (n if re.search(r":\d+$", n) else f"{n}:{self.port}" for n in names)
        return frozenset(with_port) | (frozenset(names) if self.port == 80 else frozenset())

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        try:
            enters = self._examine(scope)
        except Refusal as refusal:
            await _refuse(str(refusal), scope, receive, send)
            return
        if enters:
            await self._welcome()(scope, receive, send)
        else:
            await self._app(scope, receive, send)

    def _examine(self, scope: Scope) -> bool:
        """Raise Refusal, or tell whether this is the first visit, the token in its address."""
        headers = _headers(scope)
        host = self._checked_host(headers)
        _check_origin(scope, headers, host)
        query = _query(scope)
        if query.get("websocket", own := f"ws://{host}{scope['path']}") != own:
            raise Refusal("The address names a server that is not this one.")
        if TOKEN in query:
            if scope["type"] != "http" or scope["method"] not in _SAFE_METHODS:
                raise Refusal("The token belongs in the address of the page.")
            if not self._is_token(query[TOKEN]):
                raise Refusal("The token in the address is not this server's. " + _HOW)
            return True
        if not self._is_token(self._given_cookie(headers)):
            raise Refusal("This browser has not been let in. " + _HOW)
        return False

    def _checked_host(self, headers: dict[str, list[str]]) -> str:
        given = headers.get("host", [])
        if len(given) != 1 or given[0].lower() not in self.hosts:
            raise Refusal("The request names another host than this server.")
        return given[0].lower()

    def _given_cookie(self, headers: dict[str, list[str]]) -> str:
        given = ""
        for line in headers.get("cookie", []):
            try:
                morsel = SimpleCookie(line).get(self.cookie)
            except CookieError:
                continue
            given = morsel.value if morsel is not None else given
        return given

    def _is_token(self, given: str) -> bool:
        return hmac.compare_digest(given.encode("utf-8", "replace"), self.token.encode())

    def _welcome(self) -> Response:
        """Exchange the token in the address for a cookie, and forget the address."""
        response = RedirectResponse("/", 303, {"Cache-Control": "no-store", **headers_for("data")})
        response.set_cookie(self.cookie, self.token, path="/", httponly=True, samesite="strict")
        return response


def headers_for(kind: Kind, host: str = "") -> dict[str, str]:
    """Security headers for our page, for viser's page inside it, or for anything else.

    `host` is the request's Host, already examined: some browsers want the socket's scheme named.
    """
    common = {
        "X-Content-Type-Options": "nosniff",
        "Referrer-Policy": "same-origin",
        "Cross-Origin-Resource-Policy": "same-origin",
        "Cross-Origin-Opener-Policy": "same-origin",
        "X-Frame-Options": "SAMEORIGIN",
    }
    socket = f" ws://{host}" if host else ""
    policy = {"page": _PAGE_POLICY, "view": _VIEW_POLICY, "data": _DATA_POLICY}[kind]
    return {**common, "Content-Security-Policy": policy.format(socket=socket)}


_HOW = "Open the address that `keypose open` printed."

_PAGE_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; font-src 'self'; "
    "img-src 'self' data: blob:; connect-src 'self'{socket}; frame-src 'self'; "
    "frame-ancestors 'self'; base-uri 'none'; form-action 'none'"
)
_VIEW_POLICY = (  # viser's page is one file that unpacks and starts itself
    "default-src 'none'; script-src 'self' 'unsafe-inline' 'unsafe-eval' blob: data:; "
    "worker-src 'self' blob: data:; style-src 'self' 'unsafe-inline'; "
    "font-src 'self' data: blob:; img-src 'self' data: blob:; "
    "connect-src 'self'{socket} data: blob:; "
    "frame-ancestors 'self'; base-uri 'none'; form-action 'none'"
)
_DATA_POLICY = "default-src 'none'; frame-ancestors 'self'"


def _headers(scope: Scope) -> dict[str, list[str]]:
    """All values of every header: a header sent twice must not pass as either."""
    found: dict[str, list[str]] = {}
    for name, value in scope["headers"]:
        found.setdefault(name.decode("latin-1").lower(), []).append(value.decode("latin-1"))
    return found


def _check_origin(scope: Scope, headers: dict[str, list[str]], host: str) -> None:
    origins, sites = headers.get("origin", []), headers.get("sec-fetch-site", [])
    changes = scope["type"] == "websocket" or scope["method"] not in _SAFE_METHODS
    if len(origins) > 1 or any(origin.lower() != f"http://{host}" for origin in origins):
        raise Refusal("The request comes from a page of another server.")
    if changes and not origins:
        raise Refusal("The request does not say which page it comes from.")
    if len(sites) > 1 or any(site not in ("same-origin", "none") for site in sites):
        raise Refusal("The request comes from a page of another server.")


def _query(scope: Scope) -> dict[str, str]:
    text = scope.get("query_string", b"")
    if not text:
        return {}
    unknown = Refusal("The address asks for something this server does not know.")
    if len(text) > _LONGEST_QUERY:
        raise unknown
    try:
        pairs = parse_qsl(text.decode("ascii"), True, True, max_num_fields=8, errors="strict")
    except ValueError:  # UnicodeDecodeError is one
        raise unknown from None
    names = [name for name, _ in pairs]
    known = next((n for path, n in _QUERIES if path.fullmatch(scope["path"])), frozenset())
    if len(set(names)) != len(names) or not known.issuperset(names):
        raise unknown
    return dict(pairs)


async def _refuse(words: str, scope: Scope, receive: Receive, send: Send) -> None:
    if scope["type"] == "websocket":
        await receive()
        await send({"type": "websocket.close", "code": 4403, "reason": words})
        return
    headers = {"Cache-Control": "no-store", **headers_for("data")}
    await PlainTextResponse(words + "\n", 403, headers)(scope, receive, send)
