"""How a real browser comes in, what it shows of that afterwards, and what others can make of it."""

from __future__ import annotations

import ipaddress
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from keypose.app.server.addresses import reachable
from tests.app.server.test_links import started_with, status
from tests.app.serving import Keypose, Visitor
from tests.browser.interaction import section, until
from tests.browser.other_site import other_site
from tests.browser.shared import admit, opened

READY = "html[data-ready]"


def secrets_seen(page: Page) -> list[str]:
    """Every address the page, its parts and its history can name."""
    found = page.evaluate(
        """() => [location.href, document.referrer,
                  ...performance.getEntries().map(({ name }) => name)]"""
    )
    return [address for address in found if "token=" in address]


def test_a_browser_that_is_started_with_the_file_gets_the_page_without_a_token(
    browser: Browser, tmp_path: Path
) -> None:
    reported = tmp_path / "arguments"
    script = tmp_path / "browser"
    script.write_text(
        f'#!/bin/sh\nprintf "%s" "$*" > {reported}.part\nmv {reported}.part {reported}\n'
    )
    script.chmod(0o700)
    with (
        Keypose("--workspace", str(tmp_path / "work"), browser=f"{script} %s &") as keypose,
        admit(browser, drawn=False) as context,
    ):
        address = started_with(reported)
        page = context.new_page()
        page.goto(address)
        page.wait_for_selector(READY, state="attached")
        assert page.url == f"{keypose.origin}/"
        assert secrets_seen(page) == []
        (cookie,) = context.cookies(keypose.origin)
        assert (cookie.get("httpOnly"), cookie.get("sameSite")) == (True, "Strict")
        assert cookie.get("value") not in page.content()
        page.go_back()
        assert "token" not in page.url
        page.goto(keypose.origin)  # in the same browser the address is enough
        page.wait_for_selector(READY, state="attached")
        again = context.new_page()
        again.goto(keypose.origin)
        again.wait_for_selector(READY, state="attached")
        until(lambda: section(again, "tabs") == 2, "both tabs")
        assert not Path(address.removeprefix("file://")).exists()


def test_another_server_on_this_computer_gets_the_cookie_and_can_do_nothing_with_it(
    browser: Browser, tmp_path: Path
) -> None:
    with (
        Keypose("--workspace", str(tmp_path)) as keypose,
        other_site() as other,
        admit(browser, drawn=False) as context,
    ):
        page = context.new_page()
        page.goto(keypose.address)
        page.wait_for_selector(READY, state="attached")
        page.goto(f"http://127.0.0.1:{other.port}/")
        cookie = other.cookies[0]
        assert cookie.startswith(f"keypose_{keypose.port}=")  # this is how cookies are
        assert page.evaluate("() => localStorage.length") == 0
        for path in (
            "/library",
            "/frame/0.jpg",
            "/motion?format=bvh",
            "/picture.png",
            "/report.html",
        ):
            assert status(keypose.origin + path, Cookie=cookie) == 403
        for kinds in (None, ["keypose"], ["keypose", "keypose-key.guess"]):
            with pytest.raises(InvalidStatus):
                connect(
                    f"ws://{keypose.host}/events",
                    origin=keypose.origin,  # type: ignore[arg-type]
                    additional_headers={"Cookie": cookie},
                    subprotocols=kinds,  # type: ignore[arg-type]
                    proxy=None,
                )


def _box(folder: Path) -> list[str]:
    """A session to open, and a workspace."""
    session = "sample_videos/box/session.json"
    return [session, "--out", str(folder / "box"), "--workspace", str(folder / "work")]


def _of_a_network() -> str:
    """An address of this computer that others can reach."""
    found = [a for a in reachable("0.0.0.0")[1:] if a[0].isdigit()]
    return next((a for a in found if not ipaddress.ip_address(a).is_loopback), "")


@pytest.mark.parametrize("where", ["127.0.0.2", "network"])
def test_the_page_works_at_a_second_address_of_this_computer(
    browser: Browser, tmp_path: Path, where: str
) -> None:
    address = _of_a_network() if where == "network" else where
    if not address:
        pytest.skip("This computer is in no network.")
    with (
        Keypose(*_box(tmp_path), "--host", "0.0.0.0", "--let-others-in") as keypose,
        admit(browser, drawn=False) as context,
    ):
        page = context.new_page()
        page.goto(keypose.address.replace(keypose.host, f"{address}:{keypose.port}"))
        page.wait_for_selector(READY, state="attached")
        page.wait_for_selector("#main canvas.vid[data-frame]")
        page.keyboard.press("ArrowRight")
        visitor = Visitor(keypose)
        visitor.until(lambda: visitor.seen["view"]["frame"] == 1)
        visitor.leave()


def test_a_second_browser_comes_in_by_the_next_link(browser: Browser, tmp_path: Path) -> None:
    with (
        Keypose(*_box(tmp_path)) as keypose,
        admit(browser, drawn=False) as one,
        admit(browser, drawn=False) as other,
    ):
        first = keypose.address
        opened(one, keypose)
        page = other.new_page()
        answer = page.goto(first)
        assert answer is not None
        assert answer.status == 403
        assert "This link has been used" in answer.text()
        opened(other, keypose)
