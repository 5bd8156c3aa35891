"""Calibrated cameras as files: what a studio would hand over, of a rendered scene."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.surface.cameras.rig import View
from keypose.tracker.surface.placing import METRES, Placement
from tests.rendering.ring import Shot


def write_studio(
    folder: Path, views: Sequence[View], steps: Sequence[Sequence[Shot]], placed: Placement
) -> Path:
    """Images and silhouettes of every view and step as PNG files, and the cameras' file."""
    for i, view in enumerate(views):
        for what in ("images", "silhouettes"):
            (folder / view.name / what).mkdir(parents=True)
        for step, shots in enumerate(steps):
            name = f"{step:04d}.png"
            cv2.imwrite(str(folder / view.name / "images" / name), shots[i].picture)
            mask = np.where(shots[i].inside, np.uint8(255), np.uint8(0))
            cv2.imwrite(str(folder / view.name / "silhouettes" / name), mask)
    place = folder / "cameras.json"
    place.write_bytes(cameras_json(views, placed, with_pictures=True))
    return place


def cameras_json(views: Sequence[View], placed: Placement, *, with_pictures: bool = False) -> bytes:
    """The cameras in the frame and units of the meshes' files."""
    cameras = [_camera(view, placed, with_pictures) for view in views]
    data = {"units": placed.units, "up": placed.up, "cameras": cameras}
    return json.dumps(data, indent=1).encode() + b"\n"


def _camera(view: View, placed: Placement, with_pictures: bool) -> dict[str, object]:
    R_view_world, t = view.T_view_world[:3, :3], view.T_view_world[:3, 3]
    R = R_view_world @ placed.R_camera_surface
    t = R_view_world @ placed.p_camera_surface + t
    lens = view.camera.model_dump(include={"width", "height", "fx", "fy", "cx", "cy"})
    return {
        "name": view.name,
        **lens,
        "R_camera_world": _rounded(R),
        "t_camera_world": _rounded(t / METRES[placed.units]),
        "images": f"{view.name}/images" if with_pictures else None,
        "silhouettes": f"{view.name}/silhouettes" if with_pictures else None,
    }


def _rounded(values: Array) -> object:
    return np.round(values, 9).tolist()
