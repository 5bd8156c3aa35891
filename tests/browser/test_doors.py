"""Who may speak to the server: shown from hostile pages in a real browser, and from the inside."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, BrowserContext, Page

from keypose.app.scene.viser_compat import SUBPROTOCOL
from tests.app.serving import Keypose, Visitor, family
from tests.browser.interaction import section
from tests.browser.other_site import OtherSite, other_site
from tests.browser.proxy import Proxy, proxy
from tests.browser.shared import admit, opened, served

ATTEMPTS = """
async ([origin, key]) => {
  const headers = key ? { 'X-Keypose-Key': key } : {};
  const line = (path, kinds) => new Promise((done) => {
    const socket = new WebSocket(origin.replace('http', 'ws') + path, kinds);
    socket.onopen = () => { socket.close(); done('let in'); };
    socket.onerror = () => done('refused');
  });
  const own = { credentials: 'include', headers };
  const asked = (path, how) => fetch(origin + path, { ...own, ...how }).then(
    async (answer) => (answer.ok ? 'let in' : `refused: ${await answer.text()}`),
    () => 'refused',
  );
  const element = (kind, settings) => new Promise((done) => {
    const made = Object.assign(document.createElement(kind), settings);
    made.onload = () => done('let in');
    made.onerror = () => done('refused');
    document.head.append(made);
  });
  const film = { method: 'POST', body: 'x'.repeat(100) };
  return {
    events: await line('/events', ['keypose', `keypose-key.${key || 'guess'}`]),
    view: await line('/view/main', 'VISER'),
    frame: await asked('/frame/0.jpg'),
    blind: await asked('/frame/0.jpg', { mode: 'no-cors', headers: {} }),
    picture: await asked('/picture.png'),
    library: await asked('/library'),
    upload: await asked('/upload?name=evil.mp4', film),
    'blind upload': await asked('/upload?name=evil.mp4', { ...film, mode: 'no-cors', headers: {} }),
    image: await element('img', { src: `${origin}/static/logo.svg` }),
    style: await element('link', { rel: 'stylesheet', href: `${origin}/static/style/base.css` }),
  };
}
""".replace("VISER", SUBPROTOCOL)
"""What a hostile page can try, by name: "let in" or "refused", with the words it can read."""

FRAMED = """
(address) => new Promise((done) => {
  const frame = Object.assign(document.createElement('iframe'), { src: address });
  frame.onload = done;
  document.body.append(frame);
})
"""

SPEAK = """
([address, messages]) => new Promise((done) => {
  const kinds = ['keypose', `keypose-key.${localStorage.getItem('keypose.key')}`];
  const socket = new WebSocket(address, kinds);
  const told = [];
  socket.onopen = () => messages.forEach((message) => socket.send(message));
  socket.onmessage = ({ data }) => {
    const message = JSON.parse(data);
    if (message.t === 'refused') told.push(message.words);
    if (message.ack >= messages.length) socket.close();
  };
  socket.onclose = ({ code }) => done([code, told]);
})
"""
"""Messages on a line of their own; how it closed, and all refusals, once the last is dealt with."""


@dataclass
class Doors:
    """A server; a browser that was let in by both its names, with the page open; a hostile site."""

    keypose: Keypose
    session: Path
    context: BrowserContext
    page: Page
    other_site: OtherSite
    visitor: Visitor

    def known(self) -> dict[str, Any]:
        """Everything the server holds: its sections as a new tab is told them, and its files."""
        visitor = Visitor(self.keypose)
        sections = {name: value for name, value in visitor.seen.items() if name != "tabs"}
        visitor.leave()
        folder = self.session.parent.parent
        own = ("browsers.json", "links.json")  # who was let in, and who may be
        kept = (p for p in folder.rglob("*") if p.is_file() and p.name not in own)
        files = {str(p): p.stat().st_size for p in kept}
        return {**json.loads(json.dumps(sections)), "files": files}


@pytest.fixture(scope="module")
def doors(browser: Browser, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Doors]:
    folder = tmp_path_factory.mktemp("doors")
    with (
        other_site() as other,
        served(folder) as (keypose, session),
        admit(browser, drawn=False) as context,
    ):
        page = opened(context, keypose)
        by_name = context.new_page()
        by_name.goto(keypose.address.replace("127.0.0.1", "localhost"))
        by_name.close()
        visitor = Visitor(keypose)
        yield Doors(keypose, session, context, page, other, visitor)
        visitor.leave()


@pytest.fixture
def untouched(doors: Doors) -> Iterator[None]:
    """Nothing that happens in the test changes anything, and the open page does not notice."""
    before = doors.known()
    yield
    assert doors.known() == before
    assert section(doors.page, "view") == before["view"]
    assert doors.page.evaluate("() => window.keypose.ui.connected")
    frame = before["view"]["frame"] + 1
    doors.visitor.do(do="go", frame=frame)
    doors.page.wait_for_selector(f"#main canvas.vid[data-frame='{frame}']")


def visiting(context: BrowserContext, address: str) -> Page:
    page = context.new_page()
    page.goto(address)
    return page


def cannot_frame(page: Page, origin: str) -> bool:
    """Whether the browser shows an error where a frame should show the server's page."""
    page.evaluate(FRAMED, origin + "/")
    (frame,) = page.frames[1:]
    return bool(frame.evaluate("() => location.protocol") == "chrome-error:")


def all_refused(found: dict[str, str], words: str = "") -> bool:
    return all(outcome in ("refused", f"refused: {words}") for outcome in found.values())


def test_the_page_itself_is_let_in(doors: Doors) -> None:
    key = doors.page.evaluate("() => localStorage.getItem('keypose.key')")
    found = doors.page.evaluate(ATTEMPTS, [doors.keypose.origin, key])
    needs_key = {name: found.pop(name) for name in ("blind", "blind upload")}
    assert set(found.values()) == {"let in"}
    assert all(outcome.startswith("refused") for outcome in needs_key.values())


@pytest.mark.usefixtures("untouched")
@pytest.mark.parametrize("target", ["127.0.0.1", "localhost"])
@pytest.mark.parametrize("home", ["127.0.0.1", "localhost"])
def test_a_page_of_another_server_on_this_computer_is_refused(
    doors: Doors, home: str, target: str
) -> None:
    hostile = visiting(doors.context, f"http://{home}:{doors.other_site.port}/")
    origin = doors.keypose.origin.replace("127.0.0.1", target)
    assert all_refused(hostile.evaluate(ATTEMPTS, [origin, None]))
    assert cannot_frame(hostile, origin)
    hostile.close()


@pytest.fixture(scope="module")
def far(browser: Browser, doors: Doors) -> Iterator[tuple[BrowserContext, Proxy]]:
    """A browser that was let in, too, whose names lead where they are told."""
    with proxy() as relay, admit(browser, drawn=False, proxy={"server": relay.address}) as context:
        opened(context, doors.keypose).close()
        yield context, relay


@pytest.mark.usefixtures("untouched")
def test_a_page_from_far_away_is_refused(doors: Doors, far: tuple[BrowserContext, Proxy]) -> None:
    context, relay = far
    relay.lead("attacker.test", f"127.0.0.1:{doors.other_site.port}")
    hostile = visiting(context, "http://attacker.test/")
    assert all_refused(hostile.evaluate(ATTEMPTS, [doors.keypose.origin, None]))
    assert cannot_frame(hostile, doors.keypose.origin)
    hostile.close()


@pytest.mark.usefixtures("untouched")
def test_a_name_that_suddenly_leads_here_is_refused(
    doors: Doors, far: tuple[BrowserContext, Proxy]
) -> None:
    context, relay = far
    host = f"attacker.test:{doors.keypose.port}"
    relay.lead(host, f"127.0.0.1:{doors.other_site.port}")
    hostile = visiting(context, f"http://{host}/")
    relay.lead(host, doors.keypose.host)
    words = "The request names another host than this server.\n"
    assert all_refused(hostile.evaluate(ATTEMPTS, [f"http://{host}", None]), words)
    answer = hostile.goto(f"http://{host}/?token={doors.keypose.token}")
    assert answer is not None
    assert (answer.status, answer.text()) == (403, words)
    assert context.cookies(f"http://{host}") == []
    hostile.close()


@pytest.mark.usefixtures("untouched")
def test_without_the_token_nothing_is_to_be_had(browser: Browser, doors: Doors) -> None:
    words = (
        "This browser has not been let in. Open the newest link that `keypose open` printed.\n",
        "This link has been used, or is another server's. "
        "Open the newest link that `keypose open` printed.\n",
    )
    origin = doors.keypose.origin
    with admit(browser, drawn=False) as stranger:
        page = stranger.new_page()
        for path, reported in (
            ("/", words[0]),
            ("/view/main", words[0]),
            ("/?token=guess", words[1]),
        ):
            answer = page.goto(origin + path)
            assert answer is not None
            assert (answer.status, answer.text()) == (403, reported)
        assert stranger.cookies() == []
        stranger.route(origin + "/", lambda route: route.fulfill(body="<!doctype html>"))
        page.goto(origin + "/")
        assert all_refused(page.evaluate(ATTEMPTS, [origin, None]), words[0])


@pytest.mark.usefixtures("untouched")
@pytest.mark.parametrize("path", ["/", "/view/main"])
def test_an_address_that_names_another_socket_is_refused(
    browser: Browser, doors: Doors, path: str
) -> None:
    doors.other_site.visits.clear()
    evil = f"ws://127.0.0.1:{doors.other_site.port}{path}"
    with admit(browser, drawn=False) as context:
        page = visiting(context, doors.keypose.address)
        answer = page.goto(f"{doors.keypose.origin}{path}?websocket={evil}")
        assert answer is not None
        assert answer.status == 403
        assert page.locator("script").count() == 0
    assert doors.other_site.visits == []


FORGED: tuple[tuple[Any, str], ...] = (
    ({"do": "go", "frame": -1}, "frame"),
    ({"do": "go", "frame": 1.5}, "frame"),
    ({"do": "select", "part": "tail"}, "tail"),
    ({"do": "display", "opacity": 9}, "opacity"),
    ({"do": "display", "mode": "naked"}, "mode"),
    ({"do": "root", "x": float("nan")}, "x"),
    ({"do": "root", "z": float("inf")}, "z"),
    ({"do": "angles", "part": "head", "x": 1e9}, "x"),
    ({"do": "angles", "part": "head", "x": "1e9; rm -rf"}, "x"),
    ({"do": "height", "cm": -5}, "height"),
    ({"do": "size", "part": "head", "key": "__class__", "cm": 5}, "__class__"),
    ({"do": "add_mask", "polygon": [[0, 0]] * 100_000, "first": 0, "last": 1}, "polygon"),
    ({"do": "delete_mask", "index": 3}, "mask"),
    ({"do": "delete_key", "frame": 5}, "5"),
    ({"do": "open", "kind": "file", "id": "/etc/passwd"}, ""),
    ({"do": "open", "kind": "upload", "id": "../../etc/passwd"}, ""),
    ({"do": "format", "disk": "C"}, "do"),
    ({"do": "drag", "view": "main", "handle": {"kind": "end", "name": "tail"},
      "from": [0, 0], "at": [1, 1], "stroke": "s"}, "tail"),
    ([1, 2, 3], ""),
    ("go", ""),
)  # fmt: skip


@pytest.mark.usefixtures("untouched")
def test_forged_values_are_refused_in_words(doors: Doors) -> None:
    messages = []
    for number, (message, _) in enumerate(FORGED, start=1):
        numbered = {**message, "n": number} if isinstance(message, dict) else message
        messages.append(json.dumps(numbered))
    messages.append(json.dumps({"do": "end_stroke", "stroke": "-", "n": len(messages) + 1}))
    address = f"ws://{doors.keypose.host}/events"
    code, reported = doors.page.evaluate(SPEAK, [address, messages])
    assert code == 1005  # closed by us, when all was dealt with
    expected = [words for message, words in FORGED if message not in _BY_NOTE]
    assert len(reported) == len(expected)
    for sentence, words in zip(reported, expected, strict=True):
        assert words in sentence
        assert sentence.endswith(".")


_BY_NOTE = [
    message for message, _ in FORGED if isinstance(message, dict) and message["do"] == "open"
]
"""These are answered with a note once the file has been looked for."""

BROKEN = {
    "2 MB": "'x'.repeat(2e6)",
    "a million corners": "JSON.stringify({do: 'add_mask', polygon: Array(1e6).fill([0, 0])})",
    "no JSON": "'{'",
    "binary": "new Uint8Array(1000)",
    "binary JSON": 'new TextEncoder().encode(\'{"do": "go", "frame": 3}\')',
    "depth": "'['.repeat(1e5)",
    "digits": "'9'.repeat(1e4)",
    "half a letter": '\'{"do": "select", "part": "\\\\ud800"}\'',
    "a lost question": '\'{"ask": "pick", "id": NaN}\'',
}


@pytest.mark.usefixtures("untouched")
@pytest.mark.parametrize("what", BROKEN)
def test_what_is_no_message_ends_its_own_line_at_most(doors: Doors, what: str) -> None:
    outcome = doors.page.evaluate(
        f"""
        (address) => new Promise((done) => {{
          const kinds = ['keypose', `keypose-key.${{localStorage.getItem('keypose.key')}}`];
          const socket = new WebSocket(address, kinds);
          socket.onopen = () => {{
            socket.send({BROKEN[what]});
            socket.send('{{"do": "end_stroke", "stroke": "-", "n": 7}}');
          }};
          socket.onmessage = ({{ data }}) => data.includes('"ack":7') && done('lives on');
          socket.onclose = () => done('ended');
        }})
        """,
        f"ws://{doors.keypose.host}/events",
    )
    assert outcome in ("lives on", "ended")


@pytest.mark.usefixtures("untouched")
def test_nothing_that_is_said_to_a_view_reaches_viser(doors: Doors) -> None:
    received = doors.page.evaluate(
        """
        ([address, viser]) => new Promise((done) => {
          const socket = new WebSocket(address, viser);
          let heard = 0;
          socket.onopen = () => {
            for (const size of [0, 1, 1000, 900000]) socket.send(new Uint8Array(size).fill(0x93));
            socket.send('{"type": "ShareUrlRequest"}');
          };
          socket.onmessage = () => {
            heard += 1;
            // What was said is not answered, and does not end the line.
            if (heard === 1) setTimeout(() => { socket.close(); done(heard); }, 300);
          };
          socket.onclose = ({ code }) => done(`closed ${code}`);
        })
        """,
        [f"ws://{doors.keypose.host}/view/main", SUBPROTOCOL],
    )
    assert isinstance(received, int)
    assert received > 0
    for path, kinds in (("/view/tail", [SUBPROTOCOL]), ("/view/main", ["viser-v0.2"])):
        refused = doors.page.evaluate(
            """
            ([address, kinds]) => new Promise((done) => {
              const socket = new WebSocket(address, kinds);
              socket.onopen = () => done('let in');
              socket.onclose = () => done('refused');
            })
            """,
            [f"ws://{doors.keypose.host}{path}", kinds],
        )
        assert refused == "refused"


def test_there_is_one_port_and_viser_has_none(doors: Doors) -> None:
    processes = family(doors.keypose.process.pid)
    inodes = {inode for pid in processes for inode in _sockets(pid)}
    assert _listening(inodes) == {("127.0.0.1", doors.keypose.port)}


def _sockets(pid: int) -> set[str]:
    """The inodes of a process's sockets."""
    targets = (str(file.readlink()) for file in Path(f"/proc/{pid}/fd").iterdir())
    return {target[8:-1] for target in targets if target.startswith("socket:[")}


def _listening(inodes: set[str]) -> set[tuple[str, int]]:
    """Addresses and ports at which these sockets listen."""
    found = set()
    for table in ("tcp", "tcp6"):
        for row in Path("/proc/net", table).read_text().splitlines()[1:]:
            fields = row.split()
            address, port = fields[1].split(":")
            if fields[3] == "0A" and fields[9] in inodes:
                found.add((".".join(str(b) for b in bytes.fromhex(address)[::-1]), int(port, 16)))
    return found
