"""The walking human as surfaces: exact joints, and the ways in which it is made harder."""

from __future__ import annotations

import numpy as np
import pytest

from bench.keeping import DATA
from keypose.tracker.body.pose import pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.surface.cameras.hull import surface_of
from tests.rendering.walker import WalkKind, brought_together, walker
from tests.rendering.walker_body import Human, body_and_poses
from tests.rendering.winding import united
from tests.tracker.surface.ball_cases import P_BALL, RADIUS_M, ball_field
from tests.tracker.surface.test_nets import edge_counts, volume

needs_human = pytest.mark.skipif(
    not (DATA / "mesh_walk" / "meta.json").is_file(), reason="the animated human is not here"
)


def area(mesh: object) -> float:
    vertices, faces = mesh.vertices, mesh.faces  # type: ignore[attr-defined]
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


@needs_human
@pytest.mark.parametrize("together", [False, True])
def test_the_bodys_true_poses_have_the_animations_joints(together: bool) -> None:
    human = brought_together(Human.load()) if together else Human.load()
    body, poses = body_and_poses(human, human.Ts_joint)
    skeleton = Skeleton.of(body)
    for frame in (0, 20, 58):
        joints = pose_transforms(skeleton, poses[frame])[:, :3, 3]
        np.testing.assert_allclose(joints, human.Ts_joint[frame, :, :3, 3], atol=1e-5)


@needs_human
def test_halfway_the_limbs_are_nearer_and_their_surface_is_one() -> None:
    human = Human.load()
    close = brought_together(human)
    middle = human.frame_count // 2
    mesh = united(close.vertices[middle], close.faces, 0.012)
    apart = united(human.vertices[middle], human.faces, 0.012)
    assert set(edge_counts(mesh)) <= {2, 4}  # closed; edges may meet at a touch
    assert volume(mesh) < volume(apart)
    assert area(mesh) < 0.97 * area(apart)
    np.testing.assert_allclose(close.vertices[0], human.vertices[0], atol=1e-9)


@needs_human
@pytest.mark.parametrize(("kind", "share"), [("plain", 1.0), ("missing20", 0.8)])
def test_a_fifth_is_missing_where_it_is_said_to_be_but_not_at_first(
    kind: WalkKind, share: float
) -> None:
    walk, plain = walker(kind), walker()
    assert area(walk.steps[0]) == pytest.approx(area(plain.steps[0]))
    for step in (1, 30, 58):
        left = area(walk.steps[step]) / area(plain.steps[step])
        assert share - 0.05 < left <= share + 1e-9
        assert walk.steps[step].faces.max() < len(walk.steps[step].vertices)


def test_two_balls_that_overlap_are_one_surface_of_their_union() -> None:
    one, two = (
        surface_of(ball_field(P_BALL + np.array([x, 0, 0]), RADIUS_M)) for x in (-0.15, 0.15)
    )
    vertices = np.vstack([one.vertices, two.vertices])
    faces = np.vstack([one.faces, two.faces + len(one.vertices)])
    whole = united(vertices, faces, 0.02)
    d, r = 0.3, RADIUS_M
    shared = np.pi * (4 * r + d) * (2 * r - d) ** 2 / 12
    assert volume(whole) == pytest.approx(8 / 3 * np.pi * r**3 - shared, rel=0.02)
    assert edge_counts(whole) == {2}
    for x in (-0.15, 0.15):
        off = np.linalg.norm(whole.vertices - P_BALL - (x, 0, 0), axis=1) - r
        assert off.min() > -0.015
