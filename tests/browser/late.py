"""A page that hears, sends and draws late, as on a computer that has much else to do. A test that
looks before there is anything to see fails with it every time, not once in a hundred runs."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from playwright.sync_api import Browser, BrowserContext

from tests.app.serving import LONGEST_S

DELAY_MS = int(os.environ.get("KEYPOSE_TEST_DELAY_MS") or 0)
"""How late everything is in all browser tests; usually it is not."""

_SCRIPT = Path(__file__).with_name("late.js").read_text()


def new_context(browser: Browser, *, late: bool = True, **more: Any) -> BrowserContext:
    """A browser of its own, in which everything is late where that is asked for. A test that waits
    for thousands of redraws, and for no answer of the server, does without."""
    context = browser.new_context(**more)
    context.set_default_timeout(1000 * LONGEST_S)
    if late and DELAY_MS:
        delay(context, DELAY_MS)
    return context


def delay(context: BrowserContext, ms: int) -> None:
    """From now on the pages of this browser are late."""
    context.add_init_script(f"({_SCRIPT.rstrip().rstrip(';')})({ms})")
