"""BVH and USD in Blender, and FBX as Blender makes it of the GLB by the script beside it."""

from __future__ import annotations

import json
import subprocess
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from bench.rigs.blender import TO_Y_UP, python_with_bpy
from bench.rigs.material import FRAMES, RIGS, SECONDS, Written
from bench.table import Expected, Report, Table
from keypose.app.export.motion_files import motion_files
from keypose.app.orders.motion import MotionOrder

SCRIPT = Path(__file__).with_name("in_blender_bones.py")
FIRST = {"bvh": 1, "usd": 0, "fbx": 1}
"""The frame at which Blender puts the film's frame 0."""

MOST_BONE_MM = {"bvh": 0.1, "usd": 0.1, "fbx": 0.1}


def blender_bones(report: Report) -> None:
    """Every rig in every format."""
    python = python_with_bpy()
    for kind in FIRST:
        table: Table | None = None
        for name in RIGS:
            made = Written(name)
            found = _found(python, kind, made)
            if table is None:
                columns = ("bones", "off, mm", "height, m", "frames")
                table = report.table(f"{kind.upper()} in Blender {found['version']}", *columns)
            _row(table, kind, made, found)


def _found(python: Path, kind: str, made: Written) -> dict[str, Any]:
    """What Blender says of the file."""
    with tempfile.TemporaryDirectory() as folder:
        for name, content in motion_files(
            kind, made.recording, MotionOrder(rig=made.rig_name)
        ).items():
            (Path(folder) / name).write_bytes(content)
        frames = [str(frame + FIRST[kind]) for frame in FRAMES]
        said = subprocess.run(
            [python, SCRIPT, Path(folder) / f"motion.{kind}", *frames],
            cwd=folder,
            capture_output=True,
            text=True,
            timeout=SECONDS,
        )
        return dict(json.loads(said.stdout.rpartition("RESULT ")[2]))


def _row(table: Table, kind: str, made: Written, found: dict[str, Any]) -> None:
    off_m, heights = [], []
    bones = [i for i, n in enumerate(made.rig.names) if _spelt(kind, n) in found["frames"][0]]
    for frame, heads in zip(FRAMES, found["frames"], strict=True):
        there = np.array([heads[_spelt(kind, made.rig.names[i])] for i in bones]) @ TO_Y_UP.T
        off_m.append(np.linalg.norm(there - made.ps_world_bone[frame, bones], axis=1).max())
        heights.append(float(np.ptp(there[:, 1])))
    first, last = found["range"]
    off, frames = 1000 * float(max(off_m)), last - first + 1
    table.row(
        made.rig_name,
        len(bones),
        off,
        max(heights),
        frames,
        expected=(
            Expected("bones off", off, MOST_BONE_MM[kind], "mm"),
            Expected("parts without a bone", _without(made, bones), 0),
            Expected("frames missing", abs(frames - len(made.recording)), 1e-3),
            Expected("armatures", found["kinds"].count("ARMATURE"), 1),
        ),
    )


def _spelt(kind: str, name: str) -> str:
    """USD has no colons in a path."""
    return name.replace(":", "_") if kind == "usd" else name


def _without(made: Written, bones: list[int]) -> int:
    """Parts of the body that no bone follows."""
    return made.recording.skeleton.part_count - len({int(made.rig.parts[i]) for i in bones} - {-1})
