"""Every format opened by libraries that its users have: as many frames, from the same second."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Final

from bench.rigs.material import SECONDS, Written, installed
from bench.table import Expected, Report
from keypose.app.export.motion_files import motion_files
from keypose.app.export.motion_formats import FORMATS, MotionFormat
from keypose.app.orders.motion import MotionOrder

SCRIPT: Final = Path(__file__).with_name("in_readers.py")
READERS: Final[tuple[tuple[str, str, MotionFormat], ...]] = (
    ("bvh", "bvh==0.3", "bvh"),
    ("bvhio", "bvhio==1.5.4", "bvh"),
    ("c3d", "c3d==0.6.0", "c3d"),
    ("ezc3d", "ezc3d==1.7.2", "c3d"),
    ("kineticstoolkit", "kineticstoolkit==0.17.0 ezc3d==1.7.2", "c3d"),
    ("opensim", "opensim==4.6", "trc"),
    ("opensim", "opensim==4.6", "mot"),
    ("pandas", "pandas==2.3.3", "trc"),
    ("pygltflib", "pygltflib==1.16.5", "glb"),
    ("pxr", "usd-core==26.11", "usd"),
    ("numpy", "numpy==2.4.6", "npz"),
    ("numpy", "numpy==2.4.6", "amass"),
)
"""The module, what installs it, and the format."""
FIRST: Final = 12
"""Frame at which the exported motion begins."""


def readers(report: Report) -> None:
    """One motion, from a frame in the middle of its film."""
    table = report.table("Exports in other libraries", "format", "frames", "first second")
    made = Written("keypose").recording
    recording = made.between(FIRST, made.frames[-1])
    with tempfile.TemporaryDirectory() as folder:
        for module, packages, name in READERS:
            path = Path(folder) / FORMATS[name].names[0]
            path.write_bytes(motion_files(name, recording, MotionOrder())[path.name])
            frames, first_s = _opened(module, packages, path)
            off_s = first_s - (recording.times_s[0] if FORMATS[name].timed else 0.0)
            table.row(
                packages.split()[0],
                name,
                frames,
                first_s,
                expected=(
                    Expected("frames missing", abs(frames - len(recording)), 0),
                    Expected("seconds off", abs(off_s), 1e-4, "s"),
                ),
            )


def _opened(module: str, packages: str, path: Path) -> tuple[int, float]:
    """Frames and first second as the library has them."""
    pip = ["bin/python", "-m", "pip", "install", "--quiet", *packages.split()]
    place = installed(module, f"reads-{module}", [sys.executable, "-m", "venv", "."], pip)
    python = place / "bin" / "python"
    command = [python, "-P", SCRIPT, module, path]  # no module beside the script
    said = subprocess.run(command, check=True, capture_output=True, text=True, timeout=SECONDS)
    frames, first_s = json.loads(said.stdout.splitlines()[-1])
    return int(frames), float(first_s)
