"""The scene of three arms brings what surface fitting is to withstand; its sample is small."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree

from keypose.sample_videos.make_arms import FOLDER, MOST_BYTES
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.storage.archive import archive_arrays
from keypose.tracker.storage.files import load_session
from keypose.tracker.surface.cameras.rig import Rig
from keypose.tracker.surface.files.sequence import MeshSequence
from keypose.tracker.surface.mesh import SurfaceMesh
from keypose.tracker.surface.source import placement_of
from tests.rendering import arms, walker
from tests.rendering.arm_bodies import Kind, arm_mesh, arms_body
from tests.rendering.arm_motions import P_CENTRE, STEPS, arm_poses
from tests.rendering.arms import made_by, observed, shots_of
from tests.rendering.ring import ring_of

VOXEL_M = 0.02


def clouds(kind: Kind, pose: Pose, count: int = 20_000) -> list[Array]:
    """Points (N, 3) all over the true surface of each arm."""
    mesh, rng = arm_mesh(kind), np.random.default_rng(0)
    corners = mesh.vertices[mesh.faces]
    edges = corners[:, 1:] - corners[:, :1]
    areas = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
    chosen = corners[rng.choice(len(corners), count, p=areas / areas.sum())]
    points = np.einsum("nk,nki->ni", rng.dirichlet((1, 1, 1), len(chosen)), chosen)
    Ts = pose_transforms(Skeleton.of(arms_body(kind)), pose)
    return [points @ T[:3, :3].T + T[:3, 3] for T in Ts]


def seen(kind: Kind, step: int) -> tuple[SurfaceMesh, Array]:
    """The hull of a step from 8 views, and how far (V,) its vertices are from the true surface."""
    pose, views = arm_poses(kind)[step], ring_of(8, P_CENTRE)
    mesh = observed(views, shots_of(kind, pose, views, [0, step]), VOXEL_M)
    return mesh, cKDTree(np.concatenate(clouds(kind, pose))).query(mesh.vertices)[0]


@pytest.mark.parametrize("kind", ["tripod", "chain"])
def test_at_first_the_hull_is_whole_and_near_the_arms(kind: Kind) -> None:
    _, off_m = seen(kind, 0)
    assert np.median(off_m) < 0.01
    assert (off_m > 0.04).mean() < 0.03


def test_before_the_arms_touch_there_is_phantom_volume_that_the_cameras_do_not_believe() -> None:
    mesh, off_m = seen("tripod", 7)
    assert mesh.consistency is not None
    phantom, true = off_m > 0.04, off_m < 0.01
    assert phantom.mean() > 0.05
    assert (mesh.consistency[phantom] < 0.4).mean() > 0.9
    assert (mesh.consistency[true] < 0.4).mean() < 0.65


@pytest.mark.parametrize("kind", ["tripod", "chain"])
def test_the_arms_touch_at_steps_8_to_10_and_then_only(kind: Kind) -> None:
    near = []
    for pose in arm_poses(kind):
        first, second, third = clouds(kind, pose, 4000)
        pairs = ((first, second), (second, third))
        near.append(min((cKDTree(a).query(b)[0] < 0.03).mean() for a, b in pairs))
    assert len(near) == STEPS
    assert min(near[8:11]) > 0.04
    assert max(near[:6] + near[13:]) < 0.5 * min(near[8:11])


def test_the_sample_is_small_and_its_keyframe_is_the_truth() -> None:
    assert sum(path.stat().st_size for path in FOLDER.rglob("*") if path.is_file()) < MOST_BYTES
    session = load_session(Path(FOLDER) / "session.json")
    truth = archive_arrays((Path(FOLDER) / "truth.npz").read_bytes())
    skeleton = Skeleton.of(session.subject.body)
    (keyframe,) = session.subject.keyframes
    pose = keyframe.pose(skeleton)
    np.testing.assert_allclose(pose.Rs_parent_part, truth["Rs_parent_part"][0], atol=1e-12)
    np.testing.assert_allclose(pose.p_camera_root, truth["ps_camera_root"][0])
    assert len(truth["ps_camera_root"]) == session.view.video.frame_count == STEPS


def test_the_samples_meshes_lie_about_the_true_arms() -> None:
    session = load_session(Path(FOLDER) / "session.json")
    truth = archive_arrays((Path(FOLDER) / "truth.npz").read_bytes())
    assert session.view.surface is not None
    with MeshSequence.open(FOLDER / session.view.video.path) as sequence:
        assert sequence.frame_count == STEPS
        for step in (0, 9, 18):
            pose = Pose(truth["Rs_parent_part"][step], truth["ps_camera_root"][step])
            mesh = placement_of(session.view.surface).place(sequence.mesh(step))
            tree = cKDTree(np.concatenate(clouds("tripod", pose)))
            assert np.median(tree.query(mesh.vertices)[0]) < 0.012
            assert mesh.consistency is not None


def test_the_samples_cameras_look_at_its_arms() -> None:
    session = load_session(Path(FOLDER) / "session.json")
    assert session.view.surface is not None
    p_arms = np.array(session.subject.keyframes[0].root_m)
    views = Rig.open(FOLDER / "cameras.json").views(np.array(session.view.surface.p_camera_surface))
    assert len(views) == 15
    for view in views:
        assert np.abs(view.project(p_arms) - (320, 240)).max() < 140


def test_all_files_that_decide_what_kept_scenes_look_like_are_there() -> None:
    for names in (arms.MADE_BY, walker.MADE_BY):
        assert [file for file in made_by(*names) if not file.is_file()] == []
