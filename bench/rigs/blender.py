"""GLB in Blender, which comes as the Python module bpy: its armature, its action, its picture.

bpy is for one version of Python and NumPy each, so that it has an environment of its own.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from bench.keeping import ROOT
from bench.rigs.material import FPS, FRAMES, RIGS, SECONDS, Written, installed
from bench.table import Expected, Report, Table

SCRIPT = Path(__file__).with_name("in_blender.py")
PICTURES = ROOT / "out" / "bench" / "rigs"
TO_Y_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
"""Blender's z is up; its importer of glTF turns the scene accordingly."""

MOST_BONE_MM = 0.1
MOST_HEIGHT_MM = 1.0
MOST_PX = 0.05


def blender(report: Report) -> None:
    """Every rig opened; one of them rendered, with the film's camera."""
    python = python_with_bpy()
    PICTURES.mkdir(parents=True, exist_ok=True)
    columns = ("bones", "off, mm", "height, mm", "floor, mm", "camera, px", "frames/s")
    with tempfile.TemporaryDirectory() as folder:
        for name in RIGS:
            made = Written(name)
            picture = PICTURES / f"blender-{name}.png" if name == "mixamo" else ""
            command = [python, SCRIPT, made.glb(Path(folder)), str(FPS), str(picture)]
            said = subprocess.run(
                [*command, *map(str, FRAMES)], capture_output=True, text=True, timeout=SECONDS
            )
            found = json.loads(said.stdout.rpartition("RESULT ")[2])
            if name == RIGS[0]:
                table = report.table(f"GLB in Blender {found['version']}", *columns)
            _row(table, made, found)
    report.note(f"the picture: {PICTURES.relative_to(ROOT) / 'blender-mixamo.png'}")


def python_with_bpy() -> Path:
    """The interpreter of the environment; Absent where bpy does not install."""
    python = Path("bin/python") if sys.platform != "win32" else Path("Scripts/python.exe")
    place = installed(
        "bpy",
        f"bpy-{sys.version_info.major}.{sys.version_info.minor}",
        [sys.executable, "-m", "venv", "."],
        [python, "-m", "pip", "install", "--quiet", "bpy"],
    )
    return place / python


def _row(table: Table, made: Written, found: dict[str, Any]) -> None:
    """One rig, with what is expected of it."""
    camera = made.recording.camera
    off_m, off_px, floor_m = [], [], []
    for at in found["frames"]:
        heads = np.array([at["heads"][bone] for bone in made.rig.names]) @ TO_Y_UP.T
        off_m.append(np.linalg.norm(heads - made.ps_world_bone[at["frame"]], axis=1).max())
        seen = np.array([at["seen"][bone] for bone in made.rig.names])
        uv = np.stack([seen[:, 0] * camera.width, (1 - seen[:, 1]) * camera.height], axis=1) - 0.5
        in_sight = made.rig.parts >= 0  # a root that stands still is below the camera
        off_px.append(np.linalg.norm(uv - made.uv(at["frame"]), axis=1)[in_sight].max())
        floor_m.append(abs(at["lowest_m"] - made.lowest_m[at["frame"]]))
    height_m = abs(found["height_m"] - made.height_m) + abs(found["lowest_at_rest_m"])
    steps = np.diff(found["keys"])
    rate = FPS / float(steps.mean())
    bone, height, floor = (1000 * float(m) for m in (max(off_m), height_m, max(floor_m)))
    table.row(
        made.rig_name,
        len(made.rig),
        bone,
        height,
        floor,
        float(max(off_px)),
        rate,
        expected=(
            Expected("bones off", bone, MOST_BONE_MM, "mm"),
            Expected("height off", height, MOST_HEIGHT_MM, "mm"),
            Expected("soles off the floor", floor, MOST_HEIGHT_MM, "mm"),
            Expected("off in the camera", float(max(off_px)), MOST_PX, "px"),
            Expected("actions", found["actions"], 1),
            Expected("keys between frames", float(np.ptp(steps)), 1e-3),
            Expected("keys missing", abs(len(found["keys"]) - len(made.recording)), 0),
        ),
    )
