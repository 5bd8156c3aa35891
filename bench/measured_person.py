"""The man on the balance beam, whose joints were measured beside the film."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array


def person_reference(folder: Path) -> tuple[str, Camera, list[str], Array]:
    """Of the man on the balance beam: his video's name, its camera, the joints that were measured
    beside it, and where they were: (frames, joints, 3), metres, camera frame."""
    meta = json.loads((folder / "meta.json").read_text("utf-8"))
    lens, K = meta["camera"], meta["camera"]["K"]
    camera = Camera(
        width=lens["width"], height=lens["height"], fx=K[0][0], fy=K[1][1], cx=K[0][2], cy=K[1][2],
        distortion=(*lens["dist_k1k2p1p2"], 0.0),
    )  # fmt: skip
    with np.load(folder / "reference.npz") as reference:
        names, world = [str(n) for n in reference["names"]], reference["xyz_world"]
    joints = world @ np.array(lens["R_world_to_cam"]).T + np.array(lens["t_world_to_cam_m"])
    return meta["video"], camera, names, joints
