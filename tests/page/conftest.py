"""Node, which runs the page's modules without a browser."""

from __future__ import annotations

import os
import shutil

import pytest


@pytest.fixture(scope="session")
def node() -> str:
    """Node; without it these tests are skipped, but never where all must be tested."""
    path = shutil.which("node")
    if path is None and os.environ.get("CI"):
        pytest.fail("There is no Node, and a build machine must test the page's modules.")
    if path is None:
        pytest.skip("There is no Node on this computer.")
    return path
