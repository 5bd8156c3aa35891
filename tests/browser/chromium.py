"""Which Chromium the tests of the page use; as a program: exit code 0 when there is one."""

from __future__ import annotations

import shutil
import sys

HEADLESS = "chromium-headless-shell"
"""The same engine without windows: opens a page in half the processor time."""
NAMES = (HEADLESS, "chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
ARGUMENTS = (
    "--enable-unsafe-swiftshader",  # 3D by software, as everywhere without a graphics card
    "--no-sandbox",
    "--disable-background-networking",
)


def find() -> str | None:
    """The browser's path."""
    return next((path for name in NAMES if (path := shutil.which(name))), None)


if __name__ == "__main__":
    sys.exit(0 if find() else 1)
