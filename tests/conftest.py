"""How tests are run: properties with the same examples every time on a build machine, and what uses
a browser apart from the rest."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from hypothesis import settings

from keypose.app.cli.main import THREADS

if TYPE_CHECKING:
    from xdist.remote import Producer
    from xdist.scheduler import LoadFileScheduling
    from xdist.workermanage import WorkerController

EXAMPLES = 40
"""Of a property, unless a test says otherwise."""

# No deadlines: the first example of a test may compile a loop. Fewer examples than usual: they are
# others in every run, and many of them are drags, or bodies that are drawn.
settings.register_profile("here", deadline=None, max_examples=EXAMPLES)
settings.register_profile(
    "ci", deadline=None, max_examples=EXAMPLES, derandomize=True, print_blob=True
)
settings.load_profile("ci" if os.environ.get("CI") else "here")

BROWSER = "tests/browser/"
LONGEST = (
    "tests/test_commands.py",
    *(
        f"{BROWSER}test_{name}.py"
        for name in ("everyone", "restart", "surface", "steady", "tabs_and_reload", "guide")
    ),
)
"""The files that take longest begin first, or one worker would end alone."""
MOST_WORKERS = 8

# Whatever a person has chosen for themselves, tests begin with what is built in.
os.environ["KEYPOSE_CONFIG"] = str(Path(__file__).with_name("there_is_no_config.toml"))

# Whatever the environment says: a program that compiles itself at every start is not what people
# have, and every server and worker of a test would spend half a second on it.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

# As the program itself has them, before NumPy and OpenCV are loaded.
for name, count in THREADS.items():
    os.environ.setdefault(name, count)


@pytest.fixture(scope="session")
def anyio_backend() -> str:
    """What runs tests that are coroutines."""
    return "asyncio"


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers(config: pytest.Config) -> int:
    """Two more than there are processors: who waits for a page, a server or a disk leaves one."""
    return min((os.cpu_count() or 1) + 2, MOST_WORKERS)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Producer) -> LoadFileScheduling | None:
    """With `--dist loadfile` half of the workers begin with all that uses a browser and the others
    with the rest, file by file; who has done theirs helps with what is left. One worker alone would
    end last, as a test, its page and its server wait for each other; not all begin with the page,
    as each has to start a browser and a server of its own."""
    if config.getvalue("dist") != "loadfile":
        return None
    from xdist.scheduler import LoadFileScheduling

    class BrowserApart(LoadFileScheduling):
        def _assign_work_unit(self, node: WorkerController) -> None:
            mine = node in self.nodes[: (len(self.nodes) + 1) // 2]
            files = [*(file for file in LONGEST if file in self.workqueue), *self.workqueue]
            wanted = [file for file in files if file.startswith(BROWSER) == mine] or files
            if wanted:
                self.workqueue.move_to_end(wanted[0], last=False)
            super()._assign_work_unit(node)

    return BrowserApart(config, log)
