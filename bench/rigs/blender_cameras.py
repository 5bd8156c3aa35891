"""The film's camera in Blender, of GLB and FBX: rates, shapes of the picture, a pan with a zoom."""

from __future__ import annotations

import json
import subprocess
import tempfile
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from bench.rigs.blender import python_with_bpy
from bench.rigs.material import FRAMES, SECONDS, Written
from bench.table import Expected, Report, Table
from keypose.app.export.motion_files import motion_files
from keypose.app.orders.motion import MotionOrder
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import exp_rotation

SCRIPT = Path(__file__).with_name("in_blender_cameras.py")
FIRST = {"glb": 0, "fbx": 1}
"""The frame at which Blender puts the film's frame 0."""
MOST_PX = 0.05
MOST_FRAMES = 1e-3
MOST_RATE = 1e-4
PAN_RAD = 0.15
ZOOM = 1.3

CASES: tuple[tuple[str, Fraction, tuple[int, int], bool], ...] = (
    ("glb", Fraction(30), (640, 360), False),
    ("glb", Fraction(30), (640, 360), True),
    ("fbx", Fraction(30), (640, 360), False),
    ("fbx", Fraction(25), (640, 480), True),
    ("fbx", Fraction(24000, 1001), (640, 268), False),
    ("fbx", Fraction(30000, 1001), (640, 360), True),
    ("fbx", Fraction(60000, 1001), (640, 427), False),
    ("fbx", Fraction(30000, 1001), (360, 640), True),
)
"""The format, the rate, the size of the picture, and whether the camera pans and zooms."""


def blender_cameras(report: Report) -> None:
    """Every case, where the film's camera sees the bones begin."""
    python = python_with_bpy()
    table: Table | None = None
    for kind, rate, size, moves in CASES:
        made = _written(rate, size, moves)
        found = _found(python, kind, made, size)
        if table is None:
            columns = ("frames/s", "camera", "off, px", "first", "last")
            wide = ("camera",)
            table = report.table(f"The camera in Blender {found['version']}", *columns, wide=wide)
        _row(table, kind, made, found)


def _written(rate: Fraction, size: tuple[int, int], moves: bool) -> Written:
    """The walk at a rate, in pictures of a size, its camera at rest or panning and zooming."""
    made = Written("keypose").recording
    count = len(made)
    t = np.linspace(0, 1, count)
    turn = np.outer(t, (0.0, PAN_RAD, 0.0))
    path = CameraPath.of(exp_rotation(turn), np.zeros((count, 3)), ZOOM**t) if moves else None
    width, height = size
    changes = {"width": width, "height": height, "cx": (width - 1) / 2, "cy": (height - 1) / 2}
    camera = made.camera.model_copy(update=changes)
    times_s = np.arange(count) / float(rate)
    moving = replace(made, camera=camera, path=path, times_s=times_s, rate=float(rate))
    return Written("keypose", moving)


def _found(python: Path, kind: str, made: Written, size: tuple[int, int]) -> dict[str, Any]:
    """What Blender says of the file."""
    rate = made.recording.frames_per_second
    with tempfile.TemporaryDirectory() as folder:
        for name, content in motion_files(
            "fbx" if kind == "fbx" else "glb", made.recording, MotionOrder(rig=made.rig_name)
        ).items():
            (Path(folder) / name).write_bytes(content)
        frames = [str(_there(kind, rate, frame)) for frame in FRAMES]
        said = subprocess.run(
            [
                python,
                SCRIPT,
                Path(folder) / f"motion.{kind}",
                str(round(rate)),
                *map(str, size),
                *frames,
            ],
            cwd=folder,
            capture_output=True,
            text=True,
            timeout=SECONDS,
        )
        return dict(json.loads(said.stdout.rpartition("RESULT ")[2]))


def _there(kind: str, rate: float, frame: float) -> float:
    """Blender's frame of a frame of the film. Its importer of FBX takes 29.97 frames for 30."""
    return frame * round(rate) / rate + FIRST[kind]


def _row(table: Table, kind: str, made: Written, found: dict[str, Any]) -> None:
    recording, off_px = made.recording, []
    camera = recording.camera
    for frame, shares in zip(FRAMES, found["frames"], strict=True):
        seen = np.array([shares[bone] for bone in made.rig.names])
        uv = np.stack([seen[:, 0] * camera.width, (1 - seen[:, 1]) * camera.height], axis=1) - 0.5
        in_sight = made.rig.parts >= 0  # a root that stands still is below the camera
        off_px.append(np.linalg.norm(uv - made.uv(frame), axis=1)[in_sight].max())
    off, rate = float(max(off_px)), recording.frames_per_second
    end = _there(kind, rate, len(recording) - 1)
    first, last = found["range"]
    moves = "pans, zooms" if recording.seen_from is not None else "stands still"
    expected = [
        Expected("off in the camera", off, MOST_PX, "px"),
        Expected("first frame off", abs(first - FIRST[kind]), MOST_FRAMES),
        Expected("last frame off", abs(last - end), MOST_FRAMES),
    ]
    if kind == "fbx":
        expected.append(Expected("rate off", abs(found["rate"] / rate - 1), MOST_RATE))
    size = f"{camera.width} × {camera.height}, {moves}"
    table.row(kind, f"{rate:.2f}", size, off, first, last, expected=tuple(expected))
