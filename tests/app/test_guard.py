"""The door, spoken to in plain ASGI."""

from __future__ import annotations

import asyncio
import hmac
from typing import Any

import pytest

from app.serving.guard import Guard, headers_for

TOKEN = "open-sesame"
PORT = 8123
HOST = f"127.0.0.1:{PORT}"
ORIGIN = f"http://{HOST}"
COOKIE = f"keypose_{PORT}={TOKEN}"


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
    **headers: str | list[str] | None,
) -> Answer:
    """One request with a good host, origin and cookie; a header given as None is left out."""
    given: dict[str, str | list[str] | None] = {"host": HOST, "cookie": COOKIE}
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
    }
    if not socket:
        scope["method"] = method
    said: list[Any] = []

    async def receive() -> Any:
        return {"type": "websocket.connect" if socket else "http.request"}

    async def send(message: Any) -> None:
        said.append(message)

    asyncio.run((guard or door())(scope, receive, send))  # type: ignore[arg-type]
    return Answer(said)


def door(**settings: Any) -> Guard:
    return Guard(House(), PORT, TOKEN, **settings)


def refused(answer: Answer) -> bool:
    return answer.status == 403 or (answer.close_code == 4403 and not answer.accepted)


def test_a_browser_that_was_let_in_gets_the_page_its_files_and_its_sockets() -> None:
    assert ask("/").text == "inside"
    assert ask("/static/views/cameras.js").status == 200
    assert ask("/frame/17.jpg", "v=plain").status == 200
    assert ask("/picture.png", "view=all&frame=3&mode=both&opacity=0.5&tint=clay").status == 200
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
        f"keypose_{PORT + 1}={TOKEN}",
        f"other={TOKEN}",
        "a=b; =; ;;;",
        f"keypose_{PORT}=caf\xe9",
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


def test_two_servers_on_one_computer_have_cookies_of_their_own() -> None:
    neighbour = Guard(House(), PORT + 1, "another token")
    assert neighbour.cookie != door().cookie
    host = f"127.0.0.1:{PORT + 1}"
    assert refused(ask("/", guard=neighbour, host=host, cookie=COOKIE))


def test_the_token_in_the_address_is_exchanged_for_a_cookie_once() -> None:
    guard = door()
    answer = ask("/", guard.start_path.partition("?")[2], cookie=None, guard=guard)
    assert answer.status == 303
    assert answer.headers["location"] == "/"
    cookie = answer.headers["set-cookie"].lower()
    assert cookie.startswith(f"keypose_{PORT}={TOKEN};")
    assert "httponly" in cookie
    assert "samesite=strict" in cookie
    assert answer.headers["cache-control"] == "no-store"
    assert isinstance(guard._app, House)
    assert guard._app.guests == []


@pytest.mark.parametrize("query", ["token=guess", "token=", "token=%00", "token=caf%C3%A9"])
def test_a_wrong_token_is_refused_even_with_the_cookie(query: str) -> None:
    assert refused(ask("/", query, cookie=None))
    assert refused(ask("/", query))


def test_the_token_opens_the_page_and_nothing_else() -> None:
    assert refused(ask("/events", f"token={TOKEN}", socket=True, cookie=None))
    assert refused(ask("/", f"token={TOKEN}", method="POST", cookie=None))
    assert refused(ask("/static/page.js", f"token={TOKEN}", cookie=None))
    assert refused(ask("/", f"token={TOKEN}", socket=True, cookie=None))


def test_the_token_is_not_compared_letter_by_letter(monkeypatch: pytest.MonkeyPatch) -> None:
    compared = []

    def compare(a: bytes, b: bytes) -> bool:
        compared.append((a, b))
        return a == b

    monkeypatch.setattr(hmac, "compare_digest", compare)
    ask("/")
    ask("/", "token=guess")
    assert compared == [(TOKEN.encode(), TOKEN.encode()), (b"guess", TOKEN.encode())]


def test_every_server_has_a_token_of_its_own() -> None:
    first, second = Guard(House()), Guard(House())
    assert first.token != second.token
    assert len(first.token) >= 32


@pytest.mark.parametrize(
    ("path", "query"),
    [
        ("/", "next=http://evil.example"),
        ("/view/main", "server=1"),
        ("/view/main", "fixedDpr=1&fixedDpr=2"),
        ("/frame/1.jpg", "v=1&w=2"),
        ("/static/page.js", "v=1"),
        ("/events", "token=1&a=2"),
        ("/", "token"),
        ("/", "&".join(f"a{i}=1" for i in range(20))),
        ("/frame/1.jpg", "v=" + "x" * 5000),
        ("/motion", "format=%ff"),
    ],
)
def test_an_unknown_word_in_the_address_is_refused(path: str, query: str) -> None:
    assert refused(ask(path, query))


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


def test_everything_is_kept_from_being_sniffed_framed_or_read_by_others() -> None:
    for kind in ("page", "view", "data"):
        headers = headers_for(kind, HOST)  # type: ignore[arg-type]
        assert headers["X-Content-Type-Options"] == "nosniff"
        assert headers["X-Frame-Options"] == "SAMEORIGIN"
        assert headers["Cross-Origin-Resource-Policy"] == "same-origin"
        assert "frame-ancestors 'self'" in headers["Content-Security-Policy"]
