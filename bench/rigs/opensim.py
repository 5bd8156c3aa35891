"""Inverse kinematics by OpenSim: our markers followed by Pose2Sim's full-body model at our size.

Wanted are the modules opensim and Pose2Sim, of which the model alone is read:
`pip install opensim`, `pip install --no-deps pose2sim`.
"""

from __future__ import annotations

import io
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pandas as pd

from bench.keeping import Absent
from bench.table import Expected, Report, Table
from keypose.app.export.opensim_files import files_for_model
from keypose.app.orders.motion import MotionOrder
from keypose.tracker.body.body import preset
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.formats.opensim.setups import IK_FILE
from keypose.tracker.formats.recording import MARKER_SETS, MarkerSetName
from tests.rendering import mocap
from tests.tracker.formats import recordings

MOST_RMS_MM = 10.0
MOST_HIP_DEG = 10.0
MOST_KNEE_DEG = 5.0
ERRORS = "keypose_ik_marker_errors.sto"
_FOLLOW = "import sys, opensim; opensim.InverseKinematicsTool(sys.argv[1]).run()"
SECONDS = 300

_MOTIONS: dict[str, tuple[Callable[..., Trajectory], float, str]] = {
    "walk": (mocap.walk, 30, "adult_female"),
    "jump": (mocap.jump, 60, "adult_male"),
    "wash": (mocap.wash, 30, "elderly_male"),
    "pirouette": (mocap.pirouette, 60, "adult_female"),
    "jumping jacks": (mocap.jumping_jacks, 30, "adult_male"),
}


@dataclass(frozen=True)
class Followed:
    """rms_mm: (N,) of all markers, each frame.  off_deg: of motion.mot from what was followed, by
    coordinate, root mean square."""

    rms_mm: np.ndarray  # type: ignore[type-arg]
    off_deg: dict[str, float]


def opensim(report: Report) -> None:
    """Recorded motions of the presets, exactly known, with both sets of markers."""
    model = _model()
    columns = ("RMS, mm", "worst, mm", "hip, °", "knee, °", "pelvis, °", "elbow, °")
    for marker_set in MARKER_SETS:
        table = report.table(f"{model.name} follows the markers of {marker_set}", *columns)
        for name, (made, fps, body) in _MOTIONS.items():
            skeleton = Skeleton.of(preset(body))
            try:
                motion = made(skeleton)
            except FileNotFoundError:
                raise Absent("the recorded motions beside the checkout") from None
            _row(table, name, followed(skeleton, motion, fps, marker_set, model))
    report.note(
        "halpe26 has its three markers of the pelvis in one line: how the trunk is bent against it "
        "comes from motion.mot, softly"
    )


def followed(
    skeleton: Skeleton, motion: Trajectory, fps: float, marker_set: MarkerSetName, model: Path
) -> Followed:
    """What OpenSim's own tools make of the files that are written for a model."""
    recording = recordings.recorded(skeleton, motion, fps)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        made = files_for_model(recording, MotionOrder(markers=marker_set), model, folder)
        for file, content in made.files.items():
            (folder / file).write_bytes(content)
        command = [sys.executable, "-c", _FOLLOW, IK_FILE]
        subprocess.run(command, cwd=folder, capture_output=True, timeout=SECONDS, check=True)
        errors = _table(folder / ERRORS)
        ours, theirs = _table(folder / "motion.mot"), _table(folder / "ik.mot")
    off = {
        name: float(np.sqrt(np.square(_turn(ours[name] - theirs[name])).mean()))
        for name in ours.columns
        if name in theirs.columns
    }
    return Followed(1e3 * errors["marker_error_RMS"].to_numpy(), off)


def _turn(degrees: np.ndarray) -> np.ndarray:  # type: ignore[type-arg]
    return degrees - 360 * np.round(degrees / 360)


def _row(table: Table, name: str, found: Followed) -> None:
    def of(coordinate: str) -> float:
        return max(found.off_deg[f"{coordinate}_{side}"] for side in "lr")

    rms = float(found.rms_mm.mean())
    table.row(
        name,
        rms,
        float(found.rms_mm.max()),
        of("hip_flexion"),
        of("knee_angle"),
        found.off_deg["pelvis_tilt"],
        of("elbow_flex"),
        expected=[
            Expected("marker RMS", rms, MOST_RMS_MM, "mm"),
            Expected("hip flexion", of("hip_flexion"), MOST_HIP_DEG, "°"),
            Expected("knee flexion", of("knee_angle"), MOST_KNEE_DEG, "°"),
        ],
    )


def _model() -> Path:
    """Pose2Sim's model; Absent where a module is not here."""
    if find_spec("opensim") is None:
        raise Absent("the module opensim")
    spec = find_spec("Pose2Sim")
    folders = list(spec.submodule_search_locations or ()) if spec is not None else []
    models = [Path(f) / "OpenSim_Setup" / "Model_Pose2Sim_simple.osim" for f in folders]
    found = [model for model in models if model.is_file()]
    if not found:
        raise Absent("the model of the module Pose2Sim")
    return found[0]


def _table(path: Path) -> pd.DataFrame:
    rows = path.read_text(encoding="utf-8").partition("endheader\n")[2]
    return pd.read_csv(io.StringIO(rows), sep=r"\s+")
