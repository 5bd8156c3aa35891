"""Textures of known poses projected into another frame."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.body.pose import Pose, moved
from keypose.tracker.fitting.pose.texture import TextureMatch, texture_of, without_parts
from keypose.tracker.solver.posed import Posed
from keypose.tracker.tracking.scene import Scene
from tests.tracker.tracking_cases import CAMERAS, random_body, random_pose, scene_of, smooth_picture


def textured_case(seed: int, name: str = "perspective") -> tuple[Scene, Pose, TextureMatch]:
    """A random body before a smooth picture, and its own texture from the same picture."""
    skeleton = random_body(seed)
    pose = random_pose(skeleton, seed)
    scene, pictures = scene_of(skeleton, CAMERAS[name], [pose]), [smooth_picture(seed)]
    match = TextureMatch(scene, pictures, [texture_of(scene, pictures, pose, 1.0)])
    match.update_visibility(pose)
    return scene, pose, match


@pytest.mark.parametrize("seed", range(3))
def test_a_frame_is_like_itself(seed: int) -> None:
    scene, pose, match = textured_case(seed)
    assert match.score(pose) < 0.1
    aside = moved(scene.skeleton, pose, np.full(scene.skeleton.dof_count, 0.03))
    assert match.score(aside) > 10 * match.score(pose)


@pytest.mark.parametrize("name", list(CAMERAS))
@pytest.mark.parametrize("fine", [False, True])
@pytest.mark.parametrize("seed", range(3))
def test_the_equations_lead_back_to_the_pose(seed: int, fine: bool, name: str) -> None:
    scene, pose, match = textured_case(seed, name)
    motion = 0.02 * np.random.default_rng(seed).normal(size=scene.skeleton.dof_count)
    there = moved(scene.skeleton, pose, motion)
    match.reset_noise(0)
    posed = Posed.of(scene.skeleton, there)
    found = match.term(posed, 0, fine).equations(posed)
    few = 1e-6 * np.trace(found.A) * np.eye(len(found.b))
    step = -np.linalg.solve(found.A + few, found.b)
    assert match.score(moved(scene.skeleton, there, step)) < 0.5 * match.score(there)


def test_parts_that_are_left_out_give_nothing() -> None:
    scene, pose, match = textured_case(1)
    left_out = np.zeros(scene.skeleton.part_count, bool)
    left_out[scene.skeleton.below[:, 1]] = True
    rest = TextureMatch(scene, match.pictures, [without_parts(t, left_out) for t in match.textures])
    rest.update_visibility(pose)
    posed = Posed.of(scene.skeleton, pose)
    A = rest.term(posed, 0, fine=False).equations(posed).A
    without = np.isin(scene.skeleton.dof_part, np.flatnonzero(left_out))
    assert without.any()
    np.testing.assert_array_equal(A[without], 0.0)
    assert np.abs(A[~without][:, ~without]).max() > 0
