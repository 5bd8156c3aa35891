"""A browser without WebGL is told so in a sentence; the camera view and all else work."""

from __future__ import annotations

from playwright.sync_api import Browser

from tests.app.serving import Keypose
from tests.browser.interaction import answered, drag, screen, section, spot, until
from tests.browser.shared import admit, opened

WITHOUT = """
const usual = HTMLCanvasElement.prototype.getContext;
HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
  return kind.startsWith('webgl') ? null : usual.call(this, kind, ...more);
};
"""


def test_a_browser_without_3d_says_so_and_still_poses(browser: Browser, keypose: Keypose) -> None:
    with admit(browser, drawn=True) as context:
        context.add_init_script(WITHOUT)
        page = opened(context, keypose)
        banner = page.locator("#banner .banner")
        until(lambda: banner.count() and "WebGL is off" in banner.inner_text(), "the sentence")
        page.wait_for_selector("#main canvas.vid[data-frame]")
        page.wait_for_selector("#main.painted canvas.figure[data-frame]")
        screen(page, "without-3d")
        banner.get_by_role("button", name="Dismiss").click()
        until(lambda: banner.count() == 0, "the banner gone")
        before = section(page, "pose.points")["left_hand"]
        x, y = spot(page, "left_hand")
        drag(page, (x, y), (x + 20, y))
        answered(page)
        assert section(page, "pose.points")["left_hand"] != before
