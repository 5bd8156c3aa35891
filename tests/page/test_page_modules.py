"""The page's pure modules, tested by Node's own runner."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

HERE = Path(__file__).parent
SECONDS = 60


@pytest.mark.parametrize("name", sorted(path.name for path in HERE.glob("*.test.js")))
def test_a_module_of_the_page_keeps_its_promises(name: str, node: str) -> None:
    run = subprocess.run(
        [node, "--test", name], cwd=HERE, capture_output=True, text=True, timeout=SECONDS
    )
    assert run.returncode == 0, run.stdout + run.stderr
    assert "# fail 0" in run.stdout.replace("ℹ", "#")
