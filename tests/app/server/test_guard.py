"""The door, spoken to in plain ASGI."""

from __future__ import annotations

import asyncio
import hashlib
import hmac
import re
from typing import Any

import pytest

from keypose.app.orders.drawing import PicturesOrder
from keypose.app.orders.motion import MotionOrder
from keypose.app.orders.order import said_by_page
from keypose.app.server.admission import Browsers
from keypose.app.server.guard import Guard
from keypose.app.server.headers import headers_for

PORT = 8123
HOST = f"127.0.0.1:{PORT}"
ORIGIN = f"http://{HOST}"
BROWSERS = Browsers()
GIVEN = BROWSERS.admit()
COOKIE = f"keypose_{PORT}={GIVEN.cookie}"
PROTOCOLS = f"keypose, keypose-key.{GIVEN.key}"
OPENED = {"sec_fetch_mode": "navigate", "sec_fetch_dest": "document"}
"""What a browser says of an address that a person opens."""


class House:
    """What lies behind the door: it remembers who came in."""

    def __init__(self) -> None:
        self.guests: list[str] = []

    async def __call__(self, scope: Any, receive: Any, send: Any) -> None:
        self.guests.append(scope["path"])
        if scope["type"] == "http":
            await send({"type": "http.response.start", "status": 200, "headers": []})
            await send({"type": "http.response.body", "body": b"inside"})
        else:
            await send({"type": "websocket.accept"})


class Answer:
    def __init__(self, messages: list[Any]) -> None:
        first = messages[0]
        self.accepted = first["type"] == "websocket.accept"
        self.close_code = first.get("code")
        self.reason = first.get("reason", "")
        self.status = first.get("status")
        headers = [(k.decode(), v.decode()) for k, v in first.get("headers", [])]
        self.headers = dict(headers)
        self.text = b"".join(m.get("body", b"") for m in messages[1:]).decode()


def ask(
    path: str = "/",
    query: str = "",
    method: str = "GET",
    socket: bool = False,
    guard: Guard | None = None,
    arrived_at: str = "127.0.0.1",
    **headers: str | list[str] | None,
) -> Answer:
    """One request with a good host, origin, cookie and key; a header given as None is left out."""
    given: dict[str, str | list[str] | None] = {"host": HOST, "cookie": COOKIE}
    given["sec-websocket-protocol" if socket else "x-keypose-key"] = (
        PROTOCOLS if socket else GIVEN.key
    )
    if socket or method != "GET":
        given["origin"] = ORIGIN
    given |= {name.replace("_", "-"): value for name, value in headers.items()}
    lines = []
    for name, value in given.items():
        for one in [value] if isinstance(value, str) else value or []:
            lines.append((name.encode(), one.encode("latin-1")))
    scope: dict[str, Any] = {
        "type": "websocket" if socket else "http",
        "path": path,
        "query_string": query.encode(),
        "headers": lines,
        "server": (arrived_at, PORT),
    }
    if not socket:
        scope["method"] = method
    refusal: list[Any] = []

    async def receive() -> Any:
        return {"type": "websocket.connect" if socket else "http.request"}

    async def send(message: Any) -> None:
        refusal.append(message)

    asyncio.run((guard or door())(scope, receive, send))  # type: ignore[arg-type]
    return Answer(refusal)


def door(**settings: Any) -> Guard:
    return Guard(House(), PORT, BROWSERS, **settings)


def link(guard: Guard) -> str:
    """The query of a link that lets one browser in."""
    return f"token={guard.tokens.issue()}"


def comes(guard: Guard, query: str, **headers: str | list[str] | None) -> Answer:
    """A browser that was never here opens a link."""
    return ask("/", query, guard=guard, **{"cookie": None, "x_keypose_key": None, **headers})


def refused(answer: Answer) -> bool:
    return answer.status == 403 or (answer.close_code == 4403 and not answer.accepted)


def test_a_browser_that_was_let_in_gets_the_page_its_files_and_its_sockets() -> None:
    assert ask("/").text == "inside"
    assert ask("/static/views/cameras.js").status == 200
    assert ask("/frame/17.jpg", "v=plain&shrink=2").status == 200
    assert ask("/film/film-2/17.jpg", "v=plain&shrink=2").status == 200
    assert ask("/picture.png", "view=all&frames=3&style=both&opacity=50&tint=clay").status == 200
    assert ask("/picture.png", "view=orbit:52.5,20").status == 200
    assert ask("/motion", "format=bvh").status == 200
    assert ask("/upload", "name=jump.mp4", method="POST").status == 200
    assert ask("/events", socket=True).accepted
    assert ask("/view/top", socket=True).accepted


def test_the_name_localhost_is_as_good() -> None:
    host = f"localhost:{PORT}"
    assert ask("/events", socket=True, host=host, origin=f"http://{host}").accepted


@pytest.mark.parametrize("socket", [False, True])
@pytest.mark.parametrize(
    "host",
    [
        "evil.example",
        f"evil.example:{PORT}",  # DNS rebinding: its own name, our address
        f"127.0.0.1.evil.example:{PORT}",
        "127.0.0.1",
        "127.0.0.1:1",
        f"localhost:{PORT}@evil.example",
        "",
    ],
)
def test_another_host_is_refused(host: str, socket: bool) -> None:
    assert refused(ask("/events" if socket else "/", socket=socket, host=host))


@pytest.mark.parametrize("socket", [False, True])
def test_a_host_named_twice_or_not_at_all_is_refused(socket: bool) -> None:
    assert refused(ask("/", socket=socket, host=[HOST, HOST]))
    assert refused(ask("/", socket=socket, host=None))


@pytest.mark.parametrize(
    "origin",
    [
        "http://evil.example",
        f"https://{HOST}",
        f"http://localhost:{PORT}",  # the same machine under another name is another origin
        "http://127.0.0.1:1",
        "null",
        "",
    ],
)
def test_a_page_of_another_server_is_refused(origin: str) -> None:
    assert refused(ask("/events", socket=True, origin=origin))
    assert refused(ask("/view/main", socket=True, origin=origin))
    assert refused(ask("/upload", "name=a.mp4", method="POST", origin=origin))
    assert refused(ask("/", origin=origin))


def test_sockets_and_changes_must_say_where_they_come_from() -> None:
    assert refused(ask("/events", socket=True, origin=None))
    assert refused(ask("/upload", "name=a.mp4", method="POST", origin=None))
    assert refused(ask("/", method="DELETE", origin=None))
    assert refused(ask("/events", socket=True, origin=[ORIGIN, ORIGIN]))


@pytest.mark.parametrize("site", ["cross-site", "same-site", "nonsense"])
def test_what_the_browser_calls_foreign_is_refused(site: str) -> None:
    assert refused(ask("/", sec_fetch_site=site))
    assert refused(ask("/events", socket=True, sec_fetch_site=site))


def test_what_the_browser_calls_ours_or_typed_passes() -> None:
    assert ask("/", sec_fetch_site="none").status == 200
    assert ask("/", sec_fetch_site="same-origin").status == 200
    assert refused(ask("/", sec_fetch_site=["same-origin", "cross-site"]))


@pytest.mark.parametrize(
    "cookie",
    [
        None,
        "",
        f"keypose_{PORT}=guess",
        f"keypose_{PORT}=",
        f"keypose_{PORT + 1}={GIVEN.cookie}",
        f"other={GIVEN.cookie}",
        f"keypose_{PORT}={GIVEN.key}",
        "a=b; =; ;;;",
        f"keypose_{PORT}=caf\xe9",
    ],
    ids=[
        "none",
        "blank",
        "guess",
        "no value",
        "other port",
        "other name",
        "the key",
        "odd",
        "accent",
    ],
)
def test_without_the_cookie_nothing_is_served(cookie: str | None) -> None:
    answer = ask("/", cookie=cookie)
    assert answer.status == 403
    assert "keypose open" in answer.text
    assert refused(ask("/events", socket=True, cookie=cookie))
    assert refused(ask("/static/page.js", cookie=cookie))


def test_the_cookie_may_stand_among_others() -> None:
    assert ask("/", cookie=f"theme=dark; {COOKIE}; last=1").status == 200


def test_the_cookie_alone_gets_what_browsers_ask_for_themselves_and_no_more() -> None:
    for path in ("/", "/static/views/cameras.js", "/thumb/ab12.jpg", "/view/main"):
        assert ask(path, x_keypose_key=None).status == 200
    assert ask("/view/top", socket=True, sec_websocket_protocol="viser-v1.1.1").accepted
    for path in (
        "/frame/17.jpg",
        "/film/film-2/17.jpg",
        "/library",
        "/motion",
        "/picture.png",
        "/report.html",
        "/other",
    ):
        assert refused(ask(path, x_keypose_key=None))
        assert refused(ask(path, x_keypose_key="guess"))
    assert refused(ask("/upload", "name=a.mp4", method="POST", x_keypose_key=None))
    assert refused(ask("/", method="POST", x_keypose_key=None))
    for protocols in (None, "keypose", "keypose, keypose-key.guess", "keypose-key."):
        assert refused(ask("/events", socket=True, sec_websocket_protocol=protocols))


def test_a_wrong_key_is_refused_even_where_none_is_needed() -> None:
    assert refused(ask("/static/logo.svg", x_keypose_key="guess"))
    assert refused(ask("/static/logo.svg", x_keypose_key=[GIVEN.key, GIVEN.key]))


def test_the_key_of_another_browser_does_not_fit() -> None:
    other = BROWSERS.admit()
    assert ask("/library", cookie=f"keypose_{PORT}={other.cookie}", x_keypose_key=other.key).text
    assert refused(ask("/library", x_keypose_key=other.key))


def test_two_servers_on_one_computer_have_cookies_of_their_own() -> None:
    neighbour = Guard(House(), PORT + 1)
    assert neighbour.cookie != door().cookie
    host = f"127.0.0.1:{PORT + 1}"
    assert refused(ask("/", guard=neighbour, host=host, cookie=COOKIE))


def test_a_link_lets_one_browser_in_once_and_gives_it_secrets_of_its_own() -> None:
    guard = door()
    query = link(guard)
    answer = comes(guard, query)
    assert answer.status == 200
    name, _, cookie = answer.headers["set-cookie"].partition(";")[0].partition("=")
    assert name == f"keypose_{PORT}"
    settings = answer.headers["set-cookie"].lower()
    assert "httponly" in settings
    assert "samesite=strict" in settings
    assert f"max-age={30 * 24 * 3600}" in settings
    assert answer.headers["cache-control"] == "no-store"
    key = re.search(r'"keypose.key", "([^"]+)"', answer.text)
    assert key is not None
    token = query.removeprefix("token=")
    assert len({token, cookie, key[1]}) == 3
    assert min(len(token), len(cookie), len(key[1])) >= 32
    assert token not in answer.text
    assert ask("/library", cookie=f"{name}={cookie}", x_keypose_key=key[1]).text == "inside"
    again = comes(guard, query)
    assert refused(again)
    assert "has been used" in again.text


def test_one_who_is_in_already_may_come_by_a_link_again_and_gets_a_new_key_by_a_new_one() -> None:
    guard = door()
    query = link(guard)
    first = ask("/", query, guard=guard, x_keypose_key=None)
    assert first.status == 200
    assert "keypose.key" in first.text
    again = ask("/", query, guard=guard, x_keypose_key=None)
    assert (again.status, again.headers["location"]) == (303, "/")
    assert "set-cookie" not in again.headers


def test_whoever_starts_a_browser_learns_that_a_link_was_used() -> None:
    guard, used = door(), []
    guard.entered = used.append
    query = link(guard)
    comes(guard, query)
    comes(guard, query)
    ask("/", query, guard=guard)
    assert used == [query.removeprefix("token=")]


@pytest.mark.parametrize("query", ["token=guess", "token=", "token=%00", "token=caf%C3%A9"])
def test_a_wrong_token_is_refused(query: str) -> None:
    assert refused(comes(door(), query))


def test_a_link_opens_the_page_and_nothing_else() -> None:
    guard = door()
    query = link(guard)
    outside = {"guard": guard, "cookie": None}
    assert refused(ask("/events", query, socket=True, **outside))  # type: ignore[arg-type]
    assert refused(ask("/", query, method="POST", **outside))  # type: ignore[arg-type]
    assert refused(ask("/", query, method="HEAD", **outside))  # type: ignore[arg-type]
    assert refused(ask("/static/page.js", query, **outside))  # type: ignore[arg-type]
    assert refused(ask("/", query, socket=True, **outside))  # type: ignore[arg-type]
    assert comes(guard, query).status == 200


@pytest.mark.parametrize("site", ["cross-site", "same-site", "none"])
def test_a_link_may_be_followed_from_a_file_or_a_mail(site: str) -> None:
    guard = door()
    assert comes(guard, link(guard), sec_fetch_site=site, **OPENED).status == 200
    if site != "none":
        assert refused(comes(guard, "token=guess", sec_fetch_site=site, **OPENED))
        assert refused(ask("/", sec_fetch_site=site, **OPENED))


@pytest.mark.parametrize(
    "how",
    [
        {"sec_fetch_mode": "no-cors", "sec_fetch_dest": "image"},
        {"sec_fetch_mode": "navigate", "sec_fetch_dest": "iframe"},
        {"sec_fetch_mode": "cors", "sec_fetch_dest": "empty"},
        {},
    ],
)
def test_a_link_within_another_page_is_refused_and_stays_valid(how: dict[str, str]) -> None:
    guard = door()
    query = link(guard)
    assert refused(comes(guard, query, sec_fetch_site="cross-site", **how))
    assert comes(guard, query).status == 200


def test_a_browser_that_only_looks_ahead_does_not_use_a_link_up() -> None:
    guard = door()
    query = link(guard)
    assert refused(comes(guard, query, sec_purpose="prefetch;prerender"))
    assert refused(comes(guard, query, purpose="prefetch"))
    assert comes(guard, query).status == 200


def test_secrets_are_not_compared_letter_by_letter(monkeypatch: pytest.MonkeyPatch) -> None:
    compared = []

    def compare(a: bytes, b: bytes) -> bool:
        compared.append((a, b))
        return a == b

    monkeypatch.setattr(hmac, "compare_digest", compare)
    ask("/library")
    secrets = (GIVEN.cookie.encode(), GIVEN.key.encode())
    assert len(compared) >= 2
    assert not any(secret in pair for secret in secrets for pair in compared)  # only digests are
    guard = door()
    query = link(guard)
    comes(guard, "token=guess")
    token = query.removeprefix("token=").encode()
    assert (_sha256(b"guess"), _sha256(token)) in compared  # digests as well


def _sha256(secret: bytes) -> bytes:
    return hashlib.sha256(secret).hexdigest().encode()


@pytest.mark.parametrize(
    ("path", "query"),
    [
        ("/", "next=http://evil.example"),
        ("/view/main", "server=1"),
        ("/view/main", "fixedDpr=1&fixedDpr=2"),
        ("/frame/1.jpg", "v=1&w=2"),
        ("/film/film-2/1.jpg", "v=1&w=2"),
        ("/film/../1.jpg", "v=1"),
        ("/static/page.js", "v=1"),
        ("/events", "token=1&a=2"),
        ("/", "token"),
        ("/", "session=../../etc/passwd"),
        ("/", "session=0123456789abcdef&session=0123456789abcdef"),
        ("/library", "session=0123456789abcdef"),
        ("/", "&".join(f"a{i}=1" for i in range(20))),
        ("/frame/1.jpg", "v=" + "x" * 5000),
        ("/motion", "format=%ff"),
    ],
)
def test_an_unknown_word_in_the_address_is_refused(path: str, query: str) -> None:
    assert refused(ask(path, query))


@pytest.mark.parametrize(
    ("path", "query"),
    [
        (
            "/motion",
            "format=1&" + "&".join(f"{name}=1" for name in sorted(said_by_page(MotionOrder))),
        ),
        ("/picture.png", "&".join(f"{name}=1" for name in sorted(said_by_page(PicturesOrder)))),
        ("/folder", "at=0/films"),
        ("/file.jpg", "at=0/films/jump.mp4"),
        ("/upload", "name=jump.mp4"),
        ("/imports", "name=walk.bvh"),
    ],
)
def test_every_word_that_the_page_asks_with_is_known_and_needs_the_key(
    path: str, query: str
) -> None:
    assert ask(path, query).text == "inside"
    assert refused(ask(path, query, x_keypose_key=None))


def test_the_page_s_address_may_name_a_session_but_lets_nobody_in_by_it() -> None:
    query = "session=0123456789abcdef"
    assert ask("/", query).text == "inside"
    assert refused(ask("/", query, cookie=None))
    assert refused(ask("/", query, sec_fetch_site="cross-site", **OPENED))


def test_a_view_takes_the_settings_the_page_gives_it() -> None:
    settings = "fixedDpr=1.5&darkMode=1&hideViserLogo=1"
    assert ask("/view/main", settings).status == 200
    own = f"websocket=ws://{HOST}/view/main"
    assert ask("/view/main", f"{settings}&{own}").status == 200


@pytest.mark.parametrize(
    "server",
    [
        "ws://evil.example/view/main",
        f"ws://{HOST}/view/top",
        f"wss://{HOST}/view/main",
        f"ws://{HOST}/view/main/",
        f"ws://localhost:{PORT}/view/main",
        "",
    ],
)
def test_a_view_is_never_sent_to_another_server(server: str) -> None:
    assert refused(ask("/view/main", f"websocket={server}"))


def test_a_host_that_was_allowed_passes_with_its_port() -> None:
    guard = door(extra_hosts=("Workshop.local", "10.0.0.7:9000"))
    for host in (f"workshop.local:{PORT}", "10.0.0.7:9000"):
        answer = ask("/events", socket=True, guard=guard, host=host, origin=f"http://{host}")
        assert answer.accepted
    assert refused(ask("/", guard=guard, host="workshop.local:1"))
    assert refused(ask("/", guard=guard, host="workshop.local"))


def test_the_address_at_which_a_request_arrives_is_always_ours() -> None:
    for host, address in (
        (f"192.0.2.2:{PORT}", "192.0.2.2"),
        (f"192.0.2.2:{PORT}", "::ffff:192.0.2.2"),
        (f"[fd00::2]:{PORT}", "fd00::2"),
        (f"[fd00:0:0::2]:{PORT}", "fd00::2"),
    ):
        origin = f"http://{host}"
        assert ask("/events", socket=True, host=host, origin=origin, arrived_at=address).accepted
        assert refused(ask("/", host=host, arrived_at="192.0.2.3"))
    assert refused(ask("/", host="192.0.2.2:1", arrived_at="192.0.2.2"))
    assert refused(ask("/", host="192.0.2.2", arrived_at="192.0.2.2"))


def test_a_name_that_leads_to_an_address_of_ours_is_still_another_host() -> None:
    for name in ("evil.example", "192.0.2.2.evil.example", "0xc0000202", "3221225986"):
        assert refused(ask("/", host=f"{name}:{PORT}", arrived_at="192.0.2.2"))


def test_a_public_name_passes_as_it_is_written_also_with_tls_in_front() -> None:
    guard = door(public_hosts=("Keypose.example.org", f"workshop.lan:{PORT}"))
    for scheme in ("http", "https"):
        origin = f"{scheme}://keypose.example.org"
        host = "keypose.example.org"
        assert ask("/events", socket=True, guard=guard, host=host, origin=origin).accepted
    own = "websocket=wss://keypose.example.org/view/main"
    assert ask("/view/main", own, guard=guard, host="keypose.example.org").status == 200
    assert ask("/", guard=guard, host=f"workshop.lan:{PORT}").status == 200
    assert refused(ask("/", guard=guard, host="workshop.lan"))
    assert refused(ask("/", guard=guard, host="example.org"))
    assert refused(ask("/events", socket=True, guard=guard, origin=f"https://{HOST}"))


def test_a_refusal_says_why_and_is_not_kept() -> None:
    answer = ask("/", host="evil.example")
    assert answer.text == "The request names another host than this server.\n"
    assert answer.headers["cache-control"] == "no-store"
    assert "another server" in ask("/events", socket=True, origin="http://evil.example").reason


def test_our_page_runs_its_own_files_only() -> None:
    policy = headers_for("page", HOST)["Content-Security-Policy"]
    scripts = next(p for p in policy.split("; ") if p.startswith("script-src"))
    assert scripts == "script-src 'self'"
    assert f"connect-src 'self' ws://{HOST};" in policy
    assert "frame-ancestors 'self'" in policy
    assert "default-src 'none'" in policy


def test_a_view_may_start_itself_but_speaks_to_us_only() -> None:
    policy = headers_for("view", HOST)["Content-Security-Policy"]
    assert "'unsafe-inline'" in policy
    assert f"connect-src 'self' ws://{HOST} data: blob:;" in policy
    assert "frame-ancestors 'self'" in policy


@pytest.mark.parametrize("path", ["/static/page.js", "/nowhere"])
def test_what_says_nothing_of_itself_is_not_sniffed_and_runs_nothing(path: str) -> None:
    headers = ask(path).headers
    assert headers["x-content-type-options"] == "nosniff"
    assert headers["content-security-policy"] == "default-src 'none'; frame-ancestors 'self'"


def test_everything_is_kept_from_being_sniffed_framed_or_read_by_others() -> None:
    for kind in ("page", "view", "data"):
        headers = headers_for(kind, HOST)  # type: ignore[arg-type]
        assert headers["X-Content-Type-Options"] == "nosniff"
        assert headers["X-Frame-Options"] == "SAMEORIGIN"
        assert headers["Cross-Origin-Resource-Policy"] == "same-origin"
        assert "frame-ancestors 'self'" in headers["Content-Security-Policy"]
