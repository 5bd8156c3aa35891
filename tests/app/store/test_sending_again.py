"""What a tab sends again, to this server or the next, is done once, wherever one was killed."""

from __future__ import annotations

import asyncio
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from keypose.app.document import edit_log
from keypose.app.document.library import Library
from keypose.app.store.store import Store
from keypose.app.store.tabs import MOST, Clients, Tab
from keypose.app.working import queue
from keypose.tracker.session import Session
from keypose.tracker.storage.edit_history import mark_of, without_results
from keypose.tracker.storage.files import load_session
from keypose.tracker.storage.journal import Journal
from tests.app.serving import Keypose, Visitor
from tests.scenes import SAMPLES, IdleWorker, sample

TAB = "tab-of-a-test"


def mask(number: int) -> dict[str, Any]:
    corners = [[number, 0], [number + 1, 0], [number, 1]]
    return {"do": "add_mask", "polygon": corners, "first": 0, "last": 1}


def turn(degrees: float, stroke: str | None = None) -> dict[str, Any]:
    return {"do": "angles", "part": "left_forearm", "x": degrees, "stroke": stroke}


WORK = [
    mask(1),
    {"do": "go", "frame": 24},
    turn(-10, "first"),
    turn(-20, "first"),
    {"do": "select", "part": "head"},
    turn(-30, "first"),
    {"do": "end_stroke", "stroke": "first"},
    mask(2),
    {"do": "undo"},
    {"do": "undo"},
    {"do": "redo"},
    turn(-40, "second"),
    turn(-50, "third"),  # ends the second
    {"do": "go", "frame": 0},  # ends the third
    {"do": "move_key", "frame": 24, "to": 25},
    {"do": "delete_mask", "index": 0},
    mask(3),
    mask(3),
]
"""Most of these would show if they were made twice."""


@pytest.fixture(autouse=True)
def _without_worker(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(queue, "JobRunner", IdleWorker)


@pytest.fixture(params=["session.json", "person.mp4"])
def path(tmp_path: Path, request: pytest.FixtureRequest) -> Path:
    """A session, or a video that has none yet."""
    folder = tmp_path / "alive" / "person"
    folder.mkdir(parents=True)
    for name in {"person.mp4", request.param}:
        shutil.copy(SAMPLES / "person" / name, folder)
    return folder / str(request.param)


class Page:
    """What the page does: it numbers its messages and keeps those that are not acknowledged."""

    def __init__(self, work: list[dict[str, Any]]) -> None:
        self.messages = [{**m, "n": n, "client": TAB} for n, m in enumerate(work, start=1)]
        self.acked = 0

    def kept(self, acked: int) -> list[dict[str, Any]]:
        """Those to send again: a gesture from its beginning, as long as its end is not safe."""
        return [m for m in self.messages if m["n"] > acked or self._end(m) > acked]

    def frame_at(self, number: int) -> int:
        """Where one stood before a message."""
        went = [m["frame"] for m in self.messages if m["n"] < number and m["do"] == "go"]
        return went[-1] if went else 0

    def _end(self, move: dict[str, Any]) -> int:
        if move["do"] == "end_stroke" or not move.get("stroke"):
            return 0
        own = move["stroke"]
        over = (m["n"] for m in self.messages if m["n"] > move["n"] and _ends(m, own))
        return next(over, len(self.messages) + 1)


def _ends(message: dict[str, Any], stroke: str) -> bool:
    return message["do"] not in ("select",) and (
        message.get("stroke") != stroke or message["do"] == "end_stroke"
    )


async def listened(tab: Tab, note: Callable[[int], None]) -> None:
    while True:
        for message in await tab.next():
            note(message.get("acks", {}).get(TAB, 0))


async def worked(path: Path, work: list[dict[str, Any]], page: Page) -> Session:
    """The document after a server has had these messages, and all that follows is on the disk."""
    library = Library(path.parents[2] / "workspace", [path.parent])
    store = Store(asyncio.get_running_loop(), lambda *_: None, library)
    await store.open(path)
    assert store.opened is not None
    session_path = store.opened.session_path
    tab = store.join()

    def note(number: int) -> None:
        page.acked = max(page.acked, number)

    listening = asyncio.ensure_future(listened(tab, note))
    for place, message in enumerate(work):
        store.receive(tab, message)
        # Two are under way at a time, however quick the disk is.
        while place % 2 and page.acked < message["n"]:
            await asyncio.sleep(0.001)
    while page.acked < len(page.messages):
        await asyncio.sleep(0.003)
    await store.stop()
    listening.cancel()
    return without_results(load_session(session_path))


def test_wherever_it_is_killed_the_next_server_ends_with_the_same_document(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """After each step of writing, the files are kept as a kill would leave them."""
    deaths: list[tuple[Path, int]] = []
    page = Page(WORK)

    def and_died(usual: Callable[..., Any]) -> Callable[..., Any]:
        def write(*arguments: Any, **options: Any) -> Any:
            found = usual(*arguments, **options)
            place = tmp_path / f"death-{len(deaths)}" / "person"
            shutil.copytree(path.parent, place)
            deaths.append((place / path.name, page.acked))
            return found

        return write

    with monkeypatch.context() as patched:
        patched.setattr(Journal, "append", and_died(Journal.append))
        patched.setattr(Journal, "begin_anew", and_died(Journal.begin_anew))
        patched.setattr(edit_log, "save_session", and_died(edit_log.save_session))
        wanted = asyncio.run(worked(path, page.messages, page))
    assert len(deaths) > 10
    for place, acked in deaths:
        again = Page(WORK)
        kept = again.kept(acked)
        at = [{"do": "go", "frame": again.frame_at(kept[0]["n"])}] if kept else []
        again.acked = acked
        found = asyncio.run(worked(place, [*at, *kept], again))
        assert mark_of(found) == mark_of(wanted), (place, acked)


def test_a_message_that_comes_twice_is_done_once_and_acknowledged_twice(path: Path) -> None:
    page = Page([mask(1), mask(2)])
    twice = [*page.messages, *page.messages]
    doc = asyncio.run(worked(path, twice, page))
    assert [m.polygon[0][0] for m in doc.view.ignore_masks] == [1, 2]


def test_two_tabs_have_numbers_of_their_own(path: Path) -> None:
    page = Page([mask(1)])
    other = {**mask(2), "n": 1, "client": "another-tab"}
    doc = asyncio.run(worked(path, [other, *page.messages], page))
    assert [m.polygon[0][0] for m in doc.view.ignore_masks] == [2, 1]


def test_a_gesture_under_way_is_in_no_document_yet() -> None:
    clients = Clients({"one": 4})
    clients.begin("one", 5)
    clients.received("drag")
    clients.begin("one", 6)
    assert clients.received("drag").clients == {"one": 4}
    clients.begin("two", 1)
    assert clients.received("drag").clients == {"one": 4, "two": 1}
    clients.begin("one", 7)
    assert clients.received(None).clients == {"two": 1, "one": 7}


def test_a_revision_says_whose_edit_was_the_newest_and_what_comes_of_itself_is_nobodys() -> None:
    clients = Clients()
    clients.begin("one", 5)
    assert clients.received(None).revision == "one:5"
    clients.end()
    first, second = clients.received(None).revision, clients.received(None).revision
    assert first != second
    assert not first.startswith("one:")


def test_tabs_that_were_not_received_for_long_are_forgotten() -> None:
    clients = Clients()
    for number in range(MOST + 1):
        clients.begin(f"tab-{number}", 1)
    assert clients.begin("tab-0", 1)
    assert not clients.begin(f"tab-{MOST}", 1)
    assert len(clients.received(None).clients) == MOST


@pytest.fixture(scope="module")
def tab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Visitor]:
    """A tab of a running server."""
    folder = tmp_path_factory.mktemp("nameless")
    with Keypose(str(sample(folder, "box")), "--workspace", str(folder / "w")) as keypose:
        visitor = Visitor(keypose)
        yield visitor
        visitor.leave()


@pytest.mark.parametrize("client", ["", "short", "x" * 65, "a b c d e f", 7, None])
def test_a_client_without_a_proper_name_is_not_remembered(client: Any, tab: Visitor) -> None:
    before = len(tab.seen["masks"])
    for _ in range(2):
        tab.do(**mask(1), client=client)
    assert len(tab.seen["masks"]) == before + 2
