"""GLB in three.js, as programs on the web load it, and in the validator of glTF's makers."""

from __future__ import annotations

import json
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from bench.rigs.material import FPS, FRAMES, RIGS, SECONDS, Written, installed
from bench.table import Expected, Report

SCRIPT = Path(__file__).with_name("in_three.mjs")
MOST_M = 1e-4


def three_js(report: Report) -> None:
    """Every rig loaded and played."""
    quietly = ("--no-audit", "--no-fund", "--ignore-scripts")
    packages = ("three", "gltf-validator")
    place = installed("three", "three-js", ["npm", "install", *quietly, *packages])
    script = place / SCRIPT.name  # beside what it imports
    script.write_text(SCRIPT.read_text("utf-8"), encoding="utf-8")
    columns = ("bones", "off, m", "skin off, m", "errors", "warnings")
    with tempfile.TemporaryDirectory() as folder:
        for name in RIGS:
            made = Written(name)
            command = ["node", script, made.glb(Path(folder)), str(FPS), *map(str, FRAMES)]
            said = subprocess.run(
                command, capture_output=True, text=True, timeout=SECONDS, check=True
            )
            found = json.loads(said.stdout)
            if name == RIGS[0]:
                table = report.table(f"GLB in three.js {found['revision']}", *columns)
            bones = max(
                np.abs(np.array([at["bones"][b] for b in made.rig.names]) - ps).max()
                for at, ps in zip(found["frames"], made.ps_world_bone[list(FRAMES)], strict=True)
            )
            soles = max(
                abs(at["lowest"] - lowest)
                for at, lowest in zip(found["frames"], made.lowest_m[list(FRAMES)], strict=True)
            )
            errors, warnings = found["errors"], found["warnings"]
            table.row(
                name,
                len(made.rig),
                float(bones),
                float(soles),
                errors,
                warnings,
                expected=(
                    Expected("bones off", float(bones), MOST_M, "m"),
                    Expected("skin off", float(soles), MOST_M, "m"),
                    Expected("errors and warnings", errors + warnings, 0),
                ),
            )
