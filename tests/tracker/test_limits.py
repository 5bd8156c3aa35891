"""What a process holds and gives back."""

from __future__ import annotations

import platform
import subprocess
import sys

import pytest

_HOLES = """
from pathlib import Path
import numpy as np
from keypose.tracker.limits import give_back

def resident_mb():
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096 / 2**20

pieces = [np.ones(12_000) for _ in range(1000)]
last = pieces[-1]
del pieces
full = resident_mb()
give_back()
print(full - resident_mb())
"""


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="holes are given back by glibc alone")
def test_memory_between_arrays_goes_back_to_the_system() -> None:
    done = subprocess.run(
        [sys.executable, "-c", _HOLES], capture_output=True, text=True, check=True
    )
    assert float(done.stdout) > 60
