"""What OpenSim needs to follow the motion with a model that a person has."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

from keypose.app.export.motion_files import sampled
from keypose.app.orders.motion import MotionOrder
from keypose.tracker.apart import read_apart
from keypose.tracker.formats.marker_files import trc
from keypose.tracker.formats.marker_sets import markers_of
from keypose.tracker.formats.opensim.model import read_model, scaled
from keypose.tracker.formats.opensim.mot import mot_files, trunk_flexion
from keypose.tracker.formats.opensim.setups import (
    ERRORS_FILE,
    IK_FILE,
    MARKERS_FILE,
    MOTION_FILE,
    SCALE_FILE,
    ik_xml,
    markers_xml,
    scale_xml,
)
from keypose.tracker.formats.recording import Recording

SCALING_S = 120.0
"""After which the Scale Tool is given up; a model without muscles takes a second."""

_SCALING = "import sys, opensim; opensim.ScaleTool(sys.argv[1]).run()"
"""In a process of its own: the library logs into the present folder, and a fault ends Python.
Whether there is a model then shows whether it worked."""


@dataclass(frozen=True)
class ForModel:
    """files: by name, for one folder.  words: what a person should know of them."""

    files: dict[str, bytes]
    words: str


def files_for_model(
    recording: Recording, order: MotionOrder, model_path: Path, out: Path
) -> ForModel:
    """The motion as markers and coordinates, the model's scaling and inverse kinematics.

    out: the folder that the files will be in. FormatError where the model or the body is not a
    person's, or where the motion has gaps.
    """
    model = read_apart(read_model, model_path)
    made = sampled(recording, order, own_times=False).whole("MOT")
    body = made.skeleton.body
    markers = markers_of(body, made.marker_set)
    sizes = scaled(model, body, markers)
    larger = f"{model_path.stem}-scaled.osim"
    times_s = (float(made.times_s[0]), float(made.times_s[-1]))
    bend = None if sizes.shows_tilt else trunk_flexion(model)
    motion, *errors = mot_files(made, model)
    texts = {
        "motion.trc": trc(made),
        MOTION_FILE: motion,
        **dict(zip((ERRORS_FILE,), errors, strict=False)),
        MARKERS_FILE: markers_xml(sizes),
        SCALE_FILE: scale_xml(sizes, _from(out, model_path), larger),
        IK_FILE: ik_xml(sizes.placed, larger, times_s, beside=[] if bend is None else [bend]),
    }
    files = {name: text.encode() for name, text in texts.items()}
    done = _scaled_model(texts[MARKERS_FILE], scale_xml(sizes, str(model_path.absolute()), larger))
    if done is not None:
        return ForModel(files | {larger: done}, _words(larger, "is the model at the body's size"))
    return ForModel(files, _words(larger, f"is made by OpenSim's Scale Tool from {SCALE_FILE}"))


def _words(larger: str, how: str) -> str:
    return (
        f"{larger} {how}; {IK_FILE} lets it follow motion.trc, and motion.mot moves it as Keypose "
        "found. Mass stays the model's own: set it where forces count."
    )


def _from(folder: Path, path: Path) -> str:
    """The path from a folder on; absolute on another drive."""
    try:
        return Path(os.path.relpath(path.absolute(), folder.absolute())).as_posix()
    except ValueError:
        return path.absolute().as_posix()


def _scaled_model(markers: str, setup: str) -> bytes | None:
    """The scaled model by OpenSim itself; None where it is not installed, or cannot do it."""
    if find_spec("opensim") is None:
        return None
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        (place / MARKERS_FILE).write_text(markers, encoding="utf-8")
        (place / SCALE_FILE).write_text(setup, encoding="utf-8")
        command = [sys.executable, "-c", _SCALING, SCALE_FILE]
        try:
            subprocess.run(command, cwd=place, capture_output=True, timeout=SCALING_S, check=False)
        except (OSError, subprocess.SubprocessError):
            return None
        models = list(place.glob("*.osim"))
        return models[0].read_bytes() if models else None
