"""The person's mask over the picture, and the dialog that exports it."""

from __future__ import annotations

import io
import shutil
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page

from tests.browser.interaction import screens, settled, until
from tests.browser.shared import desk
from tests.tracker.keypoints.keypoint_cases import BALANCE

SHARE = """
async () => {
  const image = document.querySelector('#main .pmask');
  const canvas = new OffscreenCanvas(image.naturalWidth, image.naturalHeight);
  const drawing = canvas.getContext('2d');
  drawing.drawImage(image, 0, 0);
  const { data } = drawing.getImageData(0, 0, canvas.width, canvas.height);
  let covered = 0;
  for (let i = 3; i < data.length; i += 4) covered += data[i] > 70;
  return covered / (data.length / 4);
}
"""


@pytest.fixture(scope="module")
def page(browser: Browser, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    def begin(path: Path) -> None:
        shutil.copytree(BALANCE, path.parent, dirs_exist_ok=True)

    with desk(browser, tmp_path_factory.mktemp("mask"), size=(1440, 900), begin=begin) as made:
        made.page.keyboard.press("Escape")
        yield made.page


def shown_of(page: Page) -> Any:
    return page.locator("#main .pmask").get_attribute("data-frame")


def test_the_mask_lies_over_the_man_while_it_is_on_and_follows_the_playhead(page: Page) -> None:
    assert shown_of(page) is None
    button = page.locator("#mdisp").get_by_role("button", name="Show the mask of the person")
    button.click()
    until(lambda: shown_of(page) == "0", "the mask of the first frame")
    settled(page)
    picture, mask = (page.locator(f"#main .{name}").bounding_box() for name in ("vid", "pmask"))
    assert picture == mask
    assert 0.05 < page.evaluate(SHARE) < 0.2
    screens(page, "person-mask-1")
    page.keyboard.press("ArrowRight")
    until(lambda: shown_of(page) == "1", "that of the second")
    button.click()
    until(lambda: shown_of(page) is None, "no mask")


def test_a_matte_of_some_frames_comes_as_a_zip(page: Page) -> None:
    page.locator("#top").get_by_role("button", name="Export").click()
    screens(page, "person-mask-2-menu")
    page.get_by_role("menuitem", name="Matte of the person").click()
    sheet = page.locator("#exporting")
    sheet.get_by_label("Last frame").fill("1")
    sheet.get_by_label("Last frame").blur()
    screens(page, "person-mask-3-dialog")
    with page.expect_download(timeout=0) as download:
        sheet.get_by_role("button", name="Export", exact=True).click()
    assert download.value.suggested_filename == "person-matte.zip"
    with zipfile.ZipFile(io.BytesIO(Path(download.value.path()).read_bytes())) as archive:
        assert archive.namelist() == ["frame0000.png", "frame0001.png"]
