"""Access control: who may speak to this server, and with which requests.

A server on this computer can be reached by every page the browser shows. So each request, sockets
included, must name this server as its host, come from a page of this server, use only the query
names its path knows, and carry the cookie that this browser was given for a one-time token.

Cookies ignore ports: another server on this host is sent them, too. So all that shows the work
or changes it needs the key as well, which the browser keeps for this page's origin alone.

By hand: Starlette checks hosts (TrustedHostMiddleware), but neither origins, cookies nor keys.
"""

from __future__ import annotations

import re
import secrets
from collections.abc import Callable, Iterable
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qsl

from starlette.datastructures import MutableHeaders
from starlette.responses import HTMLResponse, PlainTextResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from keypose.app.orders.drawing import PicturesOrder
from keypose.app.orders.motion import MotionOrder
from keypose.app.orders.order import said_by_page
from keypose.app.server.addresses import parse
from keypose.app.server.admission import LONGEST_S, Browsers, OneTimeTokens
from keypose.app.server.headers import headers_for

TOKEN = "token"
"""The query name that carries a one-time token."""

SESSION = "session"
"""The query name of the session that the page opens. It is no secret."""

KEY_HEADER = "x-keypose-key"
PROTOCOL = "keypose"
KEY_PROTOCOL = "keypose-key."
"""A page cannot give a socket headers of its own: the key comes as one of two subprotocols."""

_QUERIES: tuple[tuple[re.Pattern[str], frozenset[str]], ...] = tuple(
    (re.compile(path), frozenset(names))
    for path, names in (
        (r"/", {TOKEN, SESSION}),
        (r"/view/[a-z]+", {"fixedDpr", "darkMode", "hideViserLogo", "websocket"}),
        (r"/(?:frame|film/[a-z0-9_-]+)/\d+\.jpg", {"v", "shrink"}),
        (r"/picture\.png", said_by_page(PicturesOrder)),
        (r"/motion", {"format"} | said_by_page(MotionOrder)),
        (r"/upload|/imports", {"name"}),
        (r"/folder|/file\.jpg", {"at"}),
    )
)
_MOST_WORDS = max(len(words) for _, words in _QUERIES)
_WITHOUT_KEY = re.compile(r"/|/static/.+|/thumb/.+|/view/[a-z]+")
"""What the browser itself asks for, which adds no key: the page, its files, small pictures, and the
views, which send where the body is and accept nothing."""

_SESSION_ID = re.compile(r"[0-9a-f]{16}")

_SAFE_METHODS = ("GET", "HEAD")
_LONGEST_QUERY = 2000
"""Characters."""


class Refusal(Exception):
    """A request that stays outside; its text says why in plain words."""


class Guard:
    """ASGI middleware in front of everything.

    `port` is set once the socket is bound. `browsers` are those let in,
    `tokens` what lets in more of them. `extra_hosts` are other
    names under which the server may be addressed, with or without a port, such as the one given
    with --host; `public_hosts` those of a proxy in front of it, which may add TLS. `entered` is
    called with each token that has been used.
    """

    def __init__(
        self,
        app: ASGIApp,
        port: int = 0,
        browsers: Browsers | None = None,
        tokens: OneTimeTokens | None = None,
        extra_hosts: Iterable[str] = (),
        public_hosts: Iterable[str] = (),
    ) -> None:
        self._app = app
        self.port = port
        self.tokens = tokens or OneTimeTokens()
        self.entered: Callable[[str], None] = lambda _: None
        self._browsers = browsers or Browsers()
        self._extra_hosts = tuple(host.lower() for host in extra_hosts)
        self._public_hosts = frozenset(host.lower() for host in public_hosts)

    @property
    def cookie(self) -> str:
        """Cookies ignore ports: two servers must not share a name."""
        return f"keypose_{self.port}"

    @property
    def hosts(self) -> frozenset[str]:
        """The names that the Host header may say."""
        names = ("127.0.0.1", "localhost", *self._extra_hosts, *self._public_hosts)
        with_port = (n if re.search(r":\d+$", n) else f"{n}:{self.port}" for n in names)
        without = frozenset(names) if self.port == 80 else self._public_hosts
        return frozenset(with_port) | without

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        try:
            answer = self._examine(scope) or self._app
        except Refusal as refusal:
            await _refuse(str(refusal), scope, receive, send)
            return
        await answer(scope, receive, _guarded(send))

    def _examine(self, scope: Scope) -> Response | None:
        """Raise Refusal, or return what answers one who comes with a token; None for all others."""
        headers = _headers(scope)
        host = self._checked_host(scope, headers)
        query = _query(scope)
        _check_origin(scope, headers, self._origins(host), is_entry=TOKEN in query)
        if "websocket" in query and query["websocket"] not in self._sockets(host, scope["path"]):
            raise Refusal("The address names a server that is not this one.")
        cookie = self._given_cookie(headers)
        knows = self._browsers.has_cookie(cookie)
        if TOKEN in query:
            return self._enter(scope, headers, query[TOKEN], knows)
        if not knows:
            raise Refusal("This browser has not been let in. " + _HOW)
        key = _given_key(headers)
        needs_key = key is not None or not _is_without_key(scope)
        if needs_key and not self._browsers.has_key(cookie, key or ""):
            raise Refusal("This page has not been let in. " + _HOW)
        return None

    def _enter(
        self, scope: Scope, headers: dict[str, list[str]], token: str, is_in: bool
    ) -> Response:
        """Take the token and let its browser in, anew if it was in: its key may be gone. Refusal
        where the token is not valid and the browser not in."""
        if scope["type"] != "http" or scope["method"] != "GET" or _is_speculative(headers):
            raise Refusal("The token belongs in the address of the page.")
        if not self.tokens.spend(token):
            if is_in:
                return _redirect()
            raise Refusal("This link has been used, or is another server's. " + _HOW)
        response = self._welcome()
        self.entered(token)
        return response

    def _checked_host(self, scope: Scope, headers: dict[str, list[str]]) -> str:
        hosts = headers.get("host", [])
        if len(hosts) != 1:
            raise Refusal(_OTHER_HOST)
        host = hosts[0].lower()
        if host not in self.hosts and not self._is_where_it_arrived(host, scope):
            raise Refusal(_OTHER_HOST)
        return host

    def _is_where_it_arrived(self, host: str, scope: Scope) -> bool:
        """Whether the host is the address of ours at which the connection came in. A page of
        another server that has its name lead here still says that name."""
        address, port = _split(host)
        arrived = (scope.get("server") or ("", 0))[0]
        return (
            (port or 80) == self.port
            and parse(address) is not None
            and parse(address) == parse(str(arrived))
        )

    def _origins(self, host: str) -> frozenset[str]:
        return frozenset(f"{scheme}://{host}" for scheme in self._schemes(host, "http"))

    def _sockets(self, host: str, path: str) -> frozenset[str]:
        return frozenset(f"{scheme}://{host}{path}" for scheme in self._schemes(host, "ws"))

    def _schemes(self, host: str, plain: str) -> tuple[str, ...]:
        return (plain, f"{plain}s") if host in self._public_hosts else (plain,)

    def _given_cookie(self, headers: dict[str, list[str]]) -> str:
        cookie = ""
        for line in headers.get("cookie", []):
            try:
                morsel = SimpleCookie(line).get(self.cookie)
            except CookieError:
                continue
            cookie = morsel.value if morsel is not None else cookie
        return cookie

    def _welcome(self) -> Response:
        """A page that keeps the key, then goes on to the page itself without the token.

        It is a page and no redirect: one that comes from a file would go on as from elsewhere, and
        browsers would leave out the cookie.
        """
        admitted, nonce = self._browsers.admit(), secrets.token_urlsafe(16)
        headers = {"Cache-Control": "no-store", **headers_for("data")}
        headers["Content-Security-Policy"] += f"; script-src 'nonce-{nonce}'"
        headers["Referrer-Policy"] = "no-referrer"
        response = HTMLResponse(_ENTRY.format(nonce=nonce, key=admitted.key), 200, headers)
        response.set_cookie(
            self.cookie,
            admitted.cookie,
            max_age=int(LONGEST_S),  # as long as it is known, so that a bookmark leads in
            path="/",
            httponly=True,
            samesite="strict",
        )
        return response


def _redirect() -> Response:
    """One who is in already may come by a link that was used."""
    return RedirectResponse("/", 303, {"Cache-Control": "no-store", **headers_for("data")})


_HOW = "Open the newest link that `keypose open` printed."
_OTHER_PAGE = "The request comes from a page of another server."
_OTHER_HOST = "The request names another host than this server."

_ENTRY = """\
<!doctype html>
<meta charset="utf-8">
<title>Keypose</title>
<p>This browser stores no site data, which Keypose needs. Allow it for this address, then open the
newest link that <code>keypose open</code> printed.</p>
<script nonce="{nonce}">
localStorage.setItem("keypose.key", "{key}");
location.replace("/");
</script>
"""


def _headers(scope: Scope) -> dict[str, list[str]]:
    """All values of every header: a header sent twice must not pass as either."""
    values_of_header: dict[str, list[str]] = {}
    for name, value in scope["headers"]:
        values_of_header.setdefault(name.decode("latin-1").lower(), []).append(
            value.decode("latin-1")
        )
    return values_of_header


def _check_origin(
    scope: Scope, headers: dict[str, list[str]], own: frozenset[str], *, is_entry: bool
) -> None:
    origins, sites = headers.get("origin", []), headers.get("sec-fetch-site", [])
    if len(origins) > 1 or any(origin.lower() not in own for origin in origins):
        raise Refusal(_OTHER_PAGE)
    if _changes(scope) and not origins:
        raise Refusal("The request does not say which page it comes from.")
    # Whoever follows a link with a token comes from elsewhere: a file, a mail.
    is_link = is_entry and _is_opened(headers) and sites in (["same-site"], ["cross-site"])
    if sites not in ([], ["same-origin"], ["none"]) and not is_link:
        raise Refusal(_OTHER_PAGE)


def _is_opened(headers: dict[str, list[str]]) -> bool:
    """Whether a person opened the address as a page, not within one."""
    return (headers.get("sec-fetch-mode"), headers.get("sec-fetch-dest")) == (
        ["navigate"],
        ["document"],
    )


def _is_speculative(headers: dict[str, list[str]]) -> bool:
    """Whether the browser only prepares for a page that may be opened."""
    purposes = (*headers.get("sec-purpose", []), *headers.get("purpose", []))
    return any("prefetch" in purpose for purpose in purposes)


def _changes(scope: Scope) -> bool:
    return scope["type"] == "websocket" or scope["method"] not in _SAFE_METHODS


def _is_without_key(scope: Scope) -> bool:
    is_safe = scope.get("method", "GET") in _SAFE_METHODS  # a socket has no method
    return is_safe and _WITHOUT_KEY.fullmatch(scope["path"]) is not None


def _given_key(headers: dict[str, list[str]]) -> str | None:
    """The key of the page's origin, as a header or among a socket's subprotocols."""
    protocols = ",".join(headers.get("sec-websocket-protocol", [])).split(",")
    named = [p.strip() for p in protocols]
    keys = [p.removeprefix(KEY_PROTOCOL) for p in named if p.startswith(KEY_PROTOCOL)]
    keys += headers.get(KEY_HEADER, [])
    return keys[0] if len(keys) == 1 else None if not keys else ""


def _split(host: str) -> tuple[str, int | None]:
    """Host and port, as a Host header says them."""
    match = re.fullmatch(r"(\[[0-9a-f:.]+\]|[0-9.]+)(?::(\d{1,5}))?", host)
    return (match[1], int(match[2]) if match[2] else None) if match else ("", None)


def _query(scope: Scope) -> dict[str, str]:
    text = scope.get("query_string", b"")
    if not text:
        return {}
    unknown = Refusal("The address asks for something this server does not know.")
    if len(text) > _LONGEST_QUERY:
        raise unknown
    try:
        words = text.decode("ascii")
        pairs = parse_qsl(words, True, True, max_num_fields=_MOST_WORDS, errors="strict")
    except ValueError:  # UnicodeDecodeError is one
        raise unknown from None
    names = [name for name, _ in pairs]
    names_read = next((n for path, n in _QUERIES if path.fullmatch(scope["path"])), frozenset())
    query = dict(pairs)
    if len(query) != len(names) or not names_read.issuperset(names):
        raise unknown
    if SESSION in query and not _SESSION_ID.fullmatch(query[SESSION]):
        raise unknown
    return query


def _guarded(send: Send) -> Send:
    """Whatever is answered has the headers of data, where it does not say others itself."""

    async def answer(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            for name, value in headers_for("data").items():
                headers.setdefault(name, value)
        await send(message)

    return answer


async def _refuse(words: str, scope: Scope, receive: Receive, send: Send) -> None:
    if scope["type"] == "websocket":
        await receive()
        await send({"type": "websocket.close", "code": 4403, "reason": words})
        return
    headers = {"Cache-Control": "no-store", **headers_for("data")}
    await PlainTextResponse(words + "\n", 403, headers)(scope, receive, send)
