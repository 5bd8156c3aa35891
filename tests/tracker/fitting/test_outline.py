"""The outline: rows against finite differences, and where colour says that a body ends."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.body.joint_limits import Limits
from keypose.tracker.body.pose import Pose, moved
from keypose.tracker.fitting.pose.outline import Edges, Outline, gain, separation
from keypose.tracker.fitting.pose.refinement import (
    EdgeDistances,
    PosedKeyframe,
    decided_share,
    refine,
)
from keypose.tracker.solver.posed import Posed
from keypose.tracker.solver.terms import Equations
from keypose.tracker.tracking.scene import Scene
from tests.tracker.tracking_cases import Case, case, random_body, random_pose


@pytest.fixture(scope="module")
def box() -> Case:
    return case("tumbling_box", 20, 20)


@pytest.fixture(scope="module")
def person() -> Case:
    return case("speech", 40, 40)


def outline_of(
    shown: Case, usable: np.ndarray | None = None, rgb: np.ndarray | None = None
) -> Outline:
    picture = shown.pictures[0] if rgb is None else rgb
    allowed = np.ones(picture.shape[:2], bool) if usable is None else usable
    found = Outline.of(shown.skeleton, shown.camera, picture, allowed, shown.truth.pose(0))
    assert found is not None
    return found


def aside(shown: Case, shift_m: float) -> Pose:
    """The true pose, shifted to the picture's right."""
    true = shown.truth.pose(0)
    return Pose(true.Rs_parent_part, true.p_camera_root + np.array([shift_m, 0.0, 0.0]))


def equations(outline: Outline, pose: Pose, edges: Edges) -> Equations:
    posed = Posed.of(outline.skeleton, pose)
    return EdgeDistances.of(outline, posed, edges).equations(posed)


@pytest.mark.parametrize("seed", range(3))
def test_limits_agree_with_finite_differences(seed: int) -> None:
    shown = case("speech", 40, 40)
    keyframe = PosedKeyframe(
        Scene.of(shown.skeleton, shown.camera, [shown.truth.pose(0)]),
        shown.truth.pose(0),
        Limits.of(shown.skeleton.body),
    )
    rng = np.random.default_rng(seed)
    pose = moved(shown.skeleton, keyframe.pose, rng.normal(0, 0.6, shown.skeleton.dof_count))
    b = keyframe.joint_limits.equations(Posed.of(shown.skeleton, pose)).b
    assert np.abs(b).max() > 0

    def cost(motion: np.ndarray) -> float:
        there = moved(shown.skeleton, pose, motion)
        outside, _ = keyframe.limits.excess(there.Rs_parent_part)
        set_so, _ = keyframe.limits.excess(keyframe.pose.Rs_parent_part)
        outside -= np.clip(outside, np.minimum(set_so, 0), np.maximum(set_so, 0))
        return 0.5 * float(((outside / np.radians(2.0)) ** 2).sum())

    for d in range(shown.skeleton.dof_count):
        step = np.zeros(shown.skeleton.dof_count)
        step[d] = 1e-6
        slope = (cost(step) - cost(-step)) / 2e-6
        assert b[d] == pytest.approx(slope, rel=1e-3, abs=1e-2)


def test_a_motion_between_two_poses_leads_from_one_to_the_other() -> None:
    skeleton = random_body(4)
    pose = random_pose(skeleton, 4)
    motion = 0.05 * np.random.default_rng(0).normal(size=skeleton.dof_count)
    there = Posed.of(skeleton, moved(skeleton, pose, motion))
    found = there.motion_from(pose.Rs_parent_part, pose.p_camera_root, backward=False)
    np.testing.assert_allclose(found, motion, atol=1e-12)


@pytest.mark.parametrize("shift_px", [-4, 4])
def test_edges_lie_where_the_picture_has_them(box: Case, shift_px: int) -> None:
    outline = outline_of(box)
    true = outline.draw(box.truth.pose(0))
    shown = outline.draw(aside(box, shift_px * outline.pixel_m))
    edges = outline.edges(shown, outline.colours(true), 0.1)
    sideways = edges.located & (np.abs(edges.normal[:, 0]) > 0.9)
    away = (edges.away_px * np.sign(edges.normal[:, 0]))[sideways]
    assert np.median(away) == pytest.approx(-shift_px, abs=1.0)


def test_a_box_beside_its_outline_is_laid_into_it(box: Case) -> None:
    outline, pose = outline_of(box), aside(box, 0.03)
    keyframe = PosedKeyframe(
        Scene.of(box.skeleton, box.camera, [pose]), pose, Limits.of(box.skeleton.body)
    )
    found = refine(keyframe, pose, None, outline, lambda: False)
    off = found.pose.p_camera_root - box.truth.pose(0).p_camera_root
    assert abs(off[0]) < 0.01
    share = decided_share(keyframe, found)
    assert share.shape == (1,)
    assert 0.2 < share[0] <= 1.0


def test_depth_is_not_taken_from_the_thickness_of_the_outline(person: Case) -> None:
    """A body wider than it is modelled: the hips stay about as far away as they were posed."""
    outline, pose = outline_of(person), person.truth.pose(0)
    shown = outline.draw(pose)
    edges = outline.edges(shown, outline.colours(shown), 0.05)
    wider = Edges(
        edges.p_camera, edges.part, edges.normal, np.full(len(edges.part), 2.0),
        np.ones(len(edges.part)), np.ones(len(edges.part), bool),
    )  # fmt: skip
    found = equations(outline, pose, wider)
    keyframe = PosedKeyframe(
        Scene.of(person.skeleton, person.camera, [pose]), pose, Limits.of(person.skeleton.body)
    )
    step = -np.linalg.solve(found.A + np.diag(keyframe.precision), found.b)
    there = moved(person.skeleton, pose, step)
    nearer = pose.p_camera_root[2] - there.p_camera_root[2]
    assert abs(nearer) < 0.01


def test_hands_and_feet_do_not_pull_at_what_carries_them(person: Case) -> None:
    outline, pose = outline_of(person), person.truth.pose(0)
    shown = outline.draw(pose)
    edges = outline.edges(shown, outline.colours(shown), 0.05)
    own = np.isin(edges.part, person.skeleton.dof_part)
    assert not own.all()
    away = np.where(own, 0.0, 5.0)
    pulled = Edges(edges.p_camera, edges.part, edges.normal, away, edges.variance, edges.located)
    np.testing.assert_allclose(equations(outline, pose, pulled).b, 0.0, atol=1e-9)


def test_colour_parts_a_rendered_body_from_its_background_and_noise_does_not(person: Case) -> None:
    clear = separation(outline_of(person), person.truth.pose(0))
    noise = np.random.default_rng(0).integers(0, 255, person.pictures[0].shape, dtype=np.uint8)
    unclear = separation(outline_of(person, rgb=noise), person.truth.pose(0))
    assert clear > 0.4
    assert unclear < 0.1


def test_the_true_pose_is_likelier_than_one_beside_it(person: Case) -> None:
    outline, true, beside = outline_of(person), person.truth.pose(0), aside(person, 0.05)
    assert gain(outline, beside, true) > 0.05
    assert gain(outline, true, beside) == pytest.approx(-gain(outline, beside, true))
    assert gain(outline, true, true) == 0.0


def test_what_may_not_be_used_has_no_say(person: Case) -> None:
    usable = np.ones(person.pictures[0].shape[:2], bool)
    usable[:, 150:175] = False
    found = []
    for value in (0, 255):
        rgb = person.pictures[0].copy()
        rgb[:, 150:175] = value
        outline = outline_of(person, usable, rgb)
        shown = outline.draw(aside(person, 0.03))
        edges = outline.edges(shown, outline.colours(shown), 0.05)
        found.append(equations(outline, aside(person, 0.03), edges))
    np.testing.assert_array_equal(found[0].A, found[1].A)
    np.testing.assert_array_equal(found[0].b, found[1].b)


def test_a_body_out_of_the_picture_has_no_outline(person: Case) -> None:
    usable = np.ones(person.pictures[0].shape[:2], bool)
    away = aside(person, 30.0)
    behind = Pose(away.Rs_parent_part, -away.p_camera_root)
    for pose in (away, behind):
        assert Outline.of(person.skeleton, person.camera, person.pictures[0], usable, pose) is None
