"""How tests are run: properties with the same examples every time on a build machine, and all that
use a browser on one worker."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from hypothesis import settings

if TYPE_CHECKING:
    from xdist.remote import Producer
    from xdist.scheduler import LoadGroupScheduling

# No deadlines: the first example of a test may compile a loop.
settings.register_profile("here", deadline=None)
settings.register_profile("ci", deadline=None, derandomize=True, print_blob=True)
settings.load_profile("ci" if os.environ.get("CI") else "here")

BROWSER = "tests/browser/"

# Whatever a person has chosen for themselves, tests begin with what is built in.
os.environ["KEYPOSE_CONFIG"] = str(Path(__file__).with_name("there_is_no_config.toml"))

# Whatever the environment says: a program that compiles itself at every start is not what people
# have, and every server and worker of a test would spend half a second on it.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Producer) -> LoadGroupScheduling | None:
    """With `--dist loadgroup` all that use a browser are one group: two browsers that draw 3D by
    software at once starve each other. xdist's own marks of groups do nothing with this pytest."""
    if config.getvalue("dist") != "loadgroup":
        return None
    from xdist.scheduler import LoadGroupScheduling

    class OneBrowser(LoadGroupScheduling):
        def _split_scope(self, nodeid: str) -> str:
            return BROWSER if nodeid.startswith(BROWSER) else nodeid

    return OneBrowser(config, log)
