"""Make the sample of observed surfaces anew:  python -m keypose.sample_videos.make_arms

With --studio DIR, what the cameras take of it instead, for `keypose hull`; --chain, --cameras N.

Three arms of 1 m, seen by 15 calibrated cameras; of every step their visual hull, thinned.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from keypose.tracker.geometry.camera import Camera
from keypose.tracker.session import Keyframe, Session, VideoReference
from keypose.tracker.session.references import Surface
from keypose.tracker.storage.archive import archive_bytes
from keypose.tracker.storage.atomic import write_file
from keypose.tracker.storage.files import session_json
from keypose.tracker.surface.cameras.hulls import ply_bytes
from keypose.tracker.surface.mesh import SurfaceMesh
from keypose.tracker.surface.placing import METRES, Placement
from tests.rendering.arm_bodies import Kind
from tests.rendering.arm_motions import P_CENTRE, arm_poses
from tests.rendering.arms import ArmsScene, arms_scene, make_scene, shots_of
from tests.rendering.ring import ring_of
from tests.rendering.studio import cameras_json, write_studio

FOLDER = Path(__file__).parent / "arms"
MOST_BYTES = 600_000
FPS = 25.0
VOXEL_M = 0.049
PLACED = Placement("cm", "+z", np.array([0.0, 0.5, 3.8]))
"""The files are in centimetres, z up, their origin on the floor below the arms."""

SIZE, FOCAL = (960, 720), 1522.0


def main() -> None:
    options = argparse.ArgumentParser()
    options.add_argument("--studio", type=Path)
    options.add_argument("--chain", action="store_true")
    options.add_argument("--cameras", type=int, default=15)
    asked = options.parse_args()
    if asked.studio is None:
        make_sample()
    else:
        take_pictures("chain" if asked.chain else "tripod", asked.cameras, asked.studio)


def make_sample() -> None:
    """The sample that comes with the product."""
    coarse = make_scene("tripod", cameras=15, voxel_m=VOXEL_M, smoothing_voxels=0.2)
    fine = arms_scene("tripod", cameras=15)
    steps = [lighter(*meshes) for meshes in zip(coarse.steps, fine.steps, strict=True)]
    write(replace(fine, steps=steps), FOLDER)


def take_pictures(kind: Kind, cameras: int, folder: Path) -> None:
    """Images and silhouettes of all steps, and the cameras' file, into a new folder."""
    views = ring_of(cameras, P_CENTRE)
    steps = [shots_of(kind, pose, views, [0, step]) for step, pose in enumerate(arm_poses(kind))]
    write_studio(folder, views, steps, PLACED)


def write(scene: ArmsScene, folder: Path) -> None:
    """Meshes, cameras, session and truth into a folder."""
    (folder / "meshes").mkdir(parents=True, exist_ok=True)
    for step, mesh in enumerate(scene.steps):
        path = folder / "meshes" / f"step_{step:04d}.ply"
        write_file(path, ply_bytes(in_files(mesh)), overwrite=True)
    write_file(folder / "cameras.json", cameras_json(scene.views, PLACED), overwrite=True)
    write_file(folder / "session.json", session_json(session_of(scene)), overwrite=True)
    arrays = {
        "Rs_parent_part": np.stack([pose.Rs_parent_part for pose in scene.poses]),
        "ps_camera_root": np.stack([pose.p_camera_root for pose in scene.poses]),
        "first_frame": np.array(0),
    }
    write_file(folder / "truth.npz", archive_bytes(arrays), overwrite=True)


def lighter(coarse: SurfaceMesh, fine: SurfaceMesh) -> SurfaceMesh:
    """The coarse mesh's triangles on the fine one's surface, with what the cameras say of that."""
    _, nearest = cKDTree(fine.vertices).query(coarse.vertices)
    _, owner = cKDTree(coarse.vertices).query(fine.vertices)
    assert fine.consistency is not None
    total = np.bincount(owner, fine.consistency, len(nearest))
    count = np.bincount(owner, minlength=len(nearest))
    mean = np.where(count, total / np.maximum(count, 1), fine.consistency[nearest])
    return SurfaceMesh(fine.vertices[nearest], coarse.faces, mean)


def in_files(mesh: SurfaceMesh) -> SurfaceMesh:
    """A mesh of the camera frame in the frame and units of the files."""
    p = (mesh.vertices - PLACED.p_camera_surface) @ PLACED.R_camera_surface / METRES[PLACED.units]
    return replace(mesh, vertices=p)


def session_of(scene: ArmsScene) -> Session:
    """The session of the meshes, posed at the first step as the truth is."""
    centre = ((SIZE[0] - 1) / 2, (SIZE[1] - 1) / 2)
    camera = Camera(width=SIZE[0], height=SIZE[1], fx=FOCAL, fy=FOCAL, cx=centre[0], cy=centre[1])
    return Session(
        video=VideoReference(
            path="meshes",
            fingerprint="",
            frame_count=len(scene.steps),
            width=SIZE[0],
            height=SIZE[1],
        ),
        camera=camera,
        body=scene.body,
        keyframes=(Keyframe.of(scene.skeleton, scene.poses[0], 0, 0.0),),
        surface=Surface(
            units=PLACED.units,
            up=PLACED.up,
            p_camera_surface=tuple(PLACED.p_camera_surface.tolist()),
            fps=FPS,
        ),
    )


if __name__ == "__main__":
    main()
