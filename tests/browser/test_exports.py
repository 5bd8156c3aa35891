"""The dialog of exports: options, progress, Cancel, and files that are saved."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Locator

from tests.browser.interaction import until
from tests.browser.shared import Desk, desk


@pytest.fixture(scope="module")
def work(browser: Browser, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Desk]:
    with desk(browser, tmp_path_factory.mktemp("exports")) as made:
        yield made


def dialog(at: Desk, item: str) -> Locator:
    at.page.locator("#top").get_by_role("button", name="Export").click()
    at.page.get_by_role("menuitem", name=item).click()
    return at.page.locator("#exporting")


def saved(at: Desk, sheet: Locator) -> tuple[str, bytes]:
    with at.page.expect_download(timeout=0) as download:
        sheet.get_by_role("button", name="Export", exact=True).click()
    return download.value.suggested_filename, Path(download.value.path()).read_bytes()


def test_a_film_is_cancelled_and_made_as_it_is_asked_for(work: Desk) -> None:
    sheet = dialog(work, "Film")
    sheet.get_by_role("button", name="Export", exact=True).click()
    sheet.get_by_role("progressbar").wait_for(state="attached")
    sheet.get_by_role("button", name="Cancel").click()
    sheet.get_by_role("button", name="Export", exact=True).wait_for()
    sheet.get_by_label("Last frame").fill("99")
    sheet.get_by_label("Last frame").blur()
    sheet.get_by_text("The last frame of the video is 72.").wait_for()
    assert sheet.get_by_role("button", name="Export", exact=True).is_disabled()
    sheet.get_by_label("Last frame").fill("4")
    sheet.get_by_label("Last frame").blur()
    name, content = saved(work, sheet)
    assert name == "person.mp4"
    assert content[4:8] == b"ftyp"
    work.page.get_by_text("Saved as person.mp4.").wait_for()
    until(lambda: not sheet.is_visible(), "the end of the dialog")


def test_images_of_all_keyframes_come_as_one_zip(work: Desk) -> None:
    sheet = dialog(work, "Images of all keyframes")
    name, content = saved(work, sheet)
    assert name == "person-pictures.zip"
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        assert archive.namelist() == [f"frame{n:04d}.png" for n in (0, 24, 48, 72)]


def test_motion_with_options_waits_for_a_track_and_says_so(work: Desk) -> None:
    sheet = dialog(work, "With options")
    sheet.get_by_text("there is no motion yet").wait_for()
    assert sheet.get_by_role("button", name="Export", exact=True).is_disabled()
    rig = sheet.get_by_label("Rig:")
    rig.click()
    work.page.get_by_role("option", name="Mixamo").click()
    until(lambda: "Mixamo" in rig.inner_text(), "the rig that was chosen")
    sheet.get_by_label("Format:").click()
    work.page.get_by_role("option", name="CSV").click()
    until(lambda: rig.count() == 0, "a format without bones")
    work.page.keyboard.press("Escape")


def test_what_is_not_installed_is_grey_and_bvh_has_a_unit(work: Desk) -> None:
    remedy = "pip install 'keypose[usd]'"
    work.page.route("**/exports", lambda route: route.fulfill(json={"missing": {"usd": remedy}}))
    sheet = dialog(work, "With options")
    sheet.get_by_text(f"Left out: USD needs usd-core: {remedy}").wait_for()
    sheet.get_by_label("Format:").click()
    usd = work.page.get_by_role("option", name="USD")
    assert usd.get_attribute("title") == f"USD needs usd-core: {remedy}"
    work.page.get_by_role("option", name="BVH").click()
    unit = sheet.get_by_label("Unit:")
    unit.click()
    work.page.get_by_role("option", name="Centimetres").click()
    until(lambda: "Centimetres" in unit.inner_text(), "the unit that was chosen")
    work.page.unroute("**/exports")
    work.page.keyboard.press("Escape")
