"""The motions: whole in the picture, smooth, and within what the tracker can follow."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.body.pose import part_transforms
from keypose.tracker.geometry.rotations import log_rotation, transpose
from tests.rendering.mocap import _recorded, fitted, needs_mocap
from tests.rendering.scenes import NAMES, RECORDED, scene

FRAMES = {
    "speech": 181,
    "throw": 120,
    "stride": 121,
    "shelf": 39,
    "crossing": 153,
    "walk": 76,
    "jump": 121,
    "wash": 121,
    "pirouette": 121,
    "jumping_jacks": 113,
    "tumbling_box": 61,
}
HINGES = ("left_forearm", "right_forearm", "left_shin", "right_shin")

every_scene = pytest.mark.parametrize(
    "name", [pytest.param(n, marks=[needs_mocap] if n in RECORDED else []) for n in NAMES]
)


@every_scene
def test_every_joint_stays_in_the_picture(name: str) -> None:
    made = scene(name)
    uv = made.camera.project(made.truth.joints(made.skeleton))
    assert len(made.truth) == FRAMES[name]
    assert (uv > 0).all()
    assert (uv < (640, 360)).all()


@every_scene
def test_no_part_jumps_from_frame_to_frame(name: str) -> None:
    Rs = scene(name).truth.Rs_parent_part
    turns = np.linalg.norm(log_rotation(transpose(Rs[:-1]) @ Rs[1:]), axis=-1)
    turned = np.linalg.norm(log_rotation(Rs), axis=-1)
    spins = name == "pirouette"  # its root turns twice about, and an upper arm about itself
    assert np.rad2deg(turns.max()) < (25.0 if spins else 20.0)
    assert np.rad2deg(turned[:, 1 if spins else 0 :].max()) < 170.0


@needs_mocap
def test_the_pirouette_turns_twice_about() -> None:
    R_camera_root = scene("pirouette").truth.Rs_parent_part[:, 0]
    yaw = np.unwrap(np.arctan2(R_camera_root[:, 0, 2], R_camera_root[:, 2, 2]))
    assert abs(yaw[-1] - yaw[0]) > 0.9 * 4 * np.pi


@every_scene
def test_elbows_and_knees_are_hinges_and_untracked_parts_rest(name: str) -> None:
    made = scene(name)
    turns = log_rotation(made.truth.Rs_parent_part)
    for i, part in enumerate(made.skeleton.body.parts):
        if part.name in HINGES:
            assert np.abs(turns[:, i, 1:]).max() < 1e-9
        if not part.tracked:
            assert np.abs(turns[:, i]).max() < 1e-12


@needs_mocap
def test_free_of_constraints_the_limbs_point_as_recorded() -> None:
    skeleton = scene("walk").skeleton
    joints = _recorded("cmu_02_01", every=2, frames=76, yaw=1.15)
    Rs = fitted(skeleton, joints, constrained=False)
    T = part_transforms(skeleton, Rs, np.zeros((len(Rs), 3)))
    for part, start, end in (
        ("left_shin", "lfemur", "ltibia"),
        ("right_forearm", "rhumerus", "rradius"),
    ):
        bone = joints[end] - joints[start]
        bone /= np.linalg.norm(bone, axis=1, keepdims=True)
        along = T[:, skeleton.body.index(part), :3, 1]
        np.testing.assert_allclose(along, bone, atol=1e-9)


@needs_mocap
def test_hinges_cost_the_recorded_motion_only_a_few_degrees() -> None:
    skeleton = scene("walk").skeleton
    for name, every in (("cmu_02_01", 2), ("cmu_02_04", 1)):
        joints = _recorded(name, every=every, frames=76, yaw=0.0)
        free, hinged = (fitted(skeleton, joints, constrained) for constrained in (False, True))
        for part in HINGES:
            i = skeleton.body.index(part)
            miss = np.sum(free[:, i, :, 1] * hinged[:, i, :, 1], axis=1)
            assert np.rad2deg(np.arccos(np.clip(miss, -1, 1))).mean() < 6.0
