"""What aniposelib and Pose2Sim triangulate from the same keypoints by the same cameras."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from bench.films.man import BESIDE, FIRST, FRAMES, Man, about_hips
from bench.films.without_a_hand import Unattended
from bench.keeping import digest, place_for
from bench.table import Report, Table
from keypose.tracker.films.bundle import BONES, LIMBS
from keypose.tracker.films.sightings import Sightings
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.film_clock import FilmClock
from keypose.tracker.geometry.rotations import Array

SCRIPT: Final = Path(__file__).with_name("triangulate.py")
WHOLE: Final = ("aniposelib==0.8.0", "pose2sim==0.10.49")
"""Without what they need for calibrating, detecting and drawing."""
NEEDED: Final = (
    "anytree==2.13.0",
    "c3d==0.6.0",
    "jax==0.10.2",
    "matplotlib==3.11.2",
    "numba==0.68.1",
    "numpy==2.4.6",
    "opencv-python-headless==5.0.0.93",
    "pandas==3.1.1",
    "rtoml==0.14.0",
    "scipy==1.17.1",
    "toml==0.10.2",
    "tqdm==4.70.1",
)


@dataclass(frozen=True, eq=False)
class Rig:
    """Both films' lenses, the second one's clock and its place, T_beside_first (4, 4)."""

    name: str
    cameras: Mapping[int, Camera]
    clock: FilmClock
    T_beside_first: Array


def triangulated_by_others(report: Report, man: Man, alone: Unattended, folder: Path) -> None:
    """Their figures, and ours of the drafts that were tracked without a hand."""
    table = report.table(
        "same keypoints; cameras found by Keypose, or given: published, corrected",
        "about hips mm",
        "in space mm",
        "empty %",
    )
    rigs = _found_here(alone), _published(man)
    python = _environment(report)
    for rig in rigs if python is not None else ():
        films, joints = folder / "films.npz", folder / "joints.npz"
        _write(man, rig, films)
        subprocess.run([str(python), str(SCRIPT), str(films), str(joints)], **_QUIET)
        with np.load(joints) as found:
            for name in found.files:
                _row(table, f"{name} ({rig.name})", found[name], man.truth[:FRAMES])
    whole = slice(alone.first_frame, alone.first_frame + len(alone.joints))
    _row(table, f"Keypose, without a hand ({rigs[0].name})", alone.joints, man.truth[whole])


_QUIET: Final = {"check": True, "capture_output": True}


def _environment(report: Report) -> Path | None:
    """The Python that has both; None where they cannot be installed, which is noted."""
    place = place_for("triangulators", digest(" ".join((*WHOLE, *NEEDED)).encode()), "")
    python, is_made = place / "bin" / "python", place / "made"
    if is_made.is_file():
        return python
    install = [str(python), "-m", "pip", "install", "--quiet"]
    try:
        subprocess.run([sys.executable, "-m", "venv", "--clear", str(place)], **_QUIET)
        subprocess.run([*install, *NEEDED], **_QUIET)
        subprocess.run([*install, "--no-deps", *WHOLE], **_QUIET)
    except (OSError, subprocess.CalledProcessError) as error:
        report.note(
            f"{' and '.join(WHOLE)} cannot be installed, so their rows are left out: {error}"
        )
        return None
    is_made.touch()
    return python


def _found_here(alone: Unattended) -> Rig:
    first, beside = alone.session.views
    cameras = {FIRST: first.camera, BESIDE: beside.camera}
    return Rig("found", cameras, beside.film_clock, beside.T_camera_world)


def _published(man: Man) -> Rig:
    cameras = {number: view.camera for number, view in man.views.items()}
    return Rig("given", cameras, FilmClock(), man.T_beside_first)


def _write(man: Man, rig: Rig, path: Path) -> None:
    """What `triangulate.py` reads: both films at the frames of the first."""
    seen, matrices = [], []
    for number in (FIRST, BESIDE):
        camera = rig.cameras[number].without_distortion()
        film = Sightings.of(man.views[number].keypoints, rig.cameras[number], FRAMES)
        if number == BESIDE:
            film = film.at(rig.clock, np.arange(FRAMES))
        f, c = np.array([camera.fx, camera.fy]), np.array([camera.cx, camera.cy])
        seen.append((film.xy * f + c, film.visibility))
        matrices.append(camera.K)
    xy, likelihood = (np.stack(each) for each in zip(*seen, strict=True))
    np.savez(
        path,
        xy=np.where(likelihood[..., None] > 0, xy, np.nan),
        likelihood=likelihood,
        K=np.stack(matrices),
        T=np.stack([np.eye(4), rig.T_beside_first]),
        bones=[bone.ends for bone in BONES if bone.length < LIMBS],
    )


def _row(table: Table, name: str, joints: Array, truth: Array) -> None:
    """Mean distances over the joints that are there."""
    joints, truth = joints[1:-1], truth[1:-1]
    about = np.linalg.norm(about_hips(joints) - about_hips(truth), axis=-1)
    space = np.linalg.norm(joints - truth, axis=-1)
    empty = float(np.isnan(joints[..., 0]).mean())
    table.row(name, 1000 * float(np.nanmean(about)), 1000 * float(np.nanmean(space)), 100 * empty)
