"""The motion that is written for other programs, and where its bones are by our own kinematics."""

from __future__ import annotations

import subprocess
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from bench.keeping import Absent, kept_folder
from keypose.app.render.palette import SIDE_COLOURS, part_sides
from keypose.tracker.formats.conventions import parts_in_world
from keypose.tracker.formats.glb import glb
from keypose.tracker.formats.recording import Recording
from keypose.tracker.formats.rigs.rig import Rig, rig_of
from keypose.tracker.geometry.rotations import Array, apply_transform
from tests.tracker.formats import recordings

RIGS = ("keypose", "mixamo", "ue5", "vrm")
FRAMES = (0, 17, 40, 72)
FPS = 30
SECONDS = 900


@dataclass(frozen=True, eq=False)
class Written:
    """The rendered person's walk with the bones of one rig, at an even rate; or another motion."""

    rig_name: str
    another: Recording | None = None

    @cached_property
    def recording(self) -> Recording:
        if self.another is not None:
            return self.another
        made = recordings.recording("person")
        times_s = np.arange(len(made)) / FPS
        return replace(made, times_s=times_s, rate=float(FPS))

    @cached_property
    def rig(self) -> Rig:
        return rig_of(self.recording.skeleton, self.rig_name)

    @cached_property
    def T_world_camera(self) -> Array:
        return self.recording.T_world_camera

    @cached_property
    def ps_world_bone(self) -> Array:
        """(N, B, 3) where every bone begins: fixed to its part as at rest."""
        Ts = parts_in_world(self.recording, self.T_world_camera)
        on_part = self.rig.Ts_part_bone[:, :3, 3]
        moving = self.rig.parts >= 0
        ps = np.tile(on_part, (len(Ts), 1, 1))
        T = Ts[:, self.rig.parts[moving]]
        turned = np.einsum("nbij,bj->nbi", T[..., :3, :3], on_part[moving])
        ps[:, moving] = turned + T[..., :3, 3]
        return ps

    @cached_property
    def lowest_m(self) -> Array:
        """(N,) y of the body's lowest point."""
        Ts = self.T_world_camera @ self.recording.trajectory.transforms(self.recording.skeleton)
        parts = self.recording.skeleton.body.parts
        each = [
            apply_transform(Ts[:, i], part.shape.mesh().vertices)[..., 1].min(axis=1)
            for i, part in enumerate(parts)
        ]
        return np.asarray(np.min(each, axis=0))

    @cached_property
    def height_m(self) -> float:
        """Of the body in the rest pose."""
        parts = zip(self.recording.skeleton.body.parts, self.rig.Ts_world_part, strict=True)
        tops = (
            (part.shape.mesh().vertices * [1, -1, -1] @ T[:3, :3].T + T[:3, 3])[:, 1].max()
            for part, T in parts
        )
        return float(max(tops))

    def uv(self, frame: int) -> Array:
        """(B, 2) pixels at which the film's camera sees where the bones begin."""
        T_camera_world = np.linalg.inv(self.recording.Ts_world_camera[frame])
        return self.recording.camera_at(frame).project(
            apply_transform(T_camera_world, self.ps_world_bone[frame])
        )

    def glb(self, folder: Path) -> Path:
        """The file, written."""
        body = self.recording.skeleton.body
        colours = {str(side): colour for side, colour in SIDE_COLOURS.items()}
        file = folder / f"{self.rig_name}.glb"
        file.write_bytes(glb(self.recording, part_sides(body), colours, self.rig_name))
        return file


def installed(name: str, folder: str, *commands: Sequence[str | Path]) -> Path:
    """A folder of this user's with what these commands, run in it, install; kept for the next time.

    Absent with the name where one of them fails.
    """
    place = kept_folder() / folder
    done = place / "installed"
    if done.exists():
        return place
    place.mkdir(exist_ok=True)
    for command in commands:
        try:
            subprocess.run(command, cwd=place, check=True, capture_output=True, timeout=SECONDS)
        except (OSError, subprocess.SubprocessError):
            raise Absent(name) from None
    done.touch()
    return place
