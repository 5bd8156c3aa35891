"""The motion between two frames: found where it shows, predicted where it does not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.body.body import ALL_DOFS, Body, Part
from keypose.tracker.body.pose import Pose, moved
from keypose.tracker.body.shapes import Box
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import exp_rotation, log_rotation, transpose
from keypose.tracker.kernels.pairs import observe_pairs
from keypose.tracker.tracking.diagnostics.observability import observe
from keypose.tracker.tracking.drift import Doubt
from keypose.tracker.tracking.frame_pair import (
    SINGULAR_CUT,
    MotionStep,
    least_squares_pass,
    least_squares_step,
    printed_score,
    robust_pass,
    solve_with_cut,
)
from keypose.tracker.tracking.initial.chains import Chain, blend_chains, follow
from keypose.tracker.tracking.scene import Scene
from keypose.tracker.video.pyramid import IGNORED, Clip, Picture
from tests.rendering.settings import RenderSettings
from tests.tracker import reference_loops as plain
from tests.tracker.tracking_cases import Case, case, clip_of, random_body, scene_of

Floats = NDArray[np.float64]

CLEAN = RenderSettings(noise=0.5)


@pytest.fixture(scope="module")
def box() -> Case:
    return case("tumbling_box", 20, 24, CLEAN)


@pytest.fixture(scope="module")
def person() -> Case:
    return case("stride", 40, 44, CLEAN)


@pytest.fixture(scope="module")
def telephoto() -> Case:
    return case("stride", 40, 44, CLEAN, telephoto=True)


def standing(shown: Case, j: int) -> Trajectory:
    """Pose j of the truth twice: the prediction that nothing moves."""
    R, t = shown.truth.Rs_parent_part[j], shown.truth.ps_camera_root[j]
    return Trajectory(0, np.stack([R, R]), np.stack([t, t]))


def miss(shown: Case, R: Floats, t: Floats, j: int) -> tuple[float, float]:
    """Largest turn (degrees) and distance (mm) between a pose and the truth at frame j."""
    turns = log_rotation(transpose(shown.truth.Rs_parent_part[j]) @ R)
    shift = np.linalg.norm(t - shown.truth.ps_camera_root[j])
    return float(np.rad2deg(np.linalg.norm(turns, axis=-1).max())), float(1e3 * shift)


def stepped(shown: Case, j: int, before: Trajectory, inner: int = 8) -> MotionStep:
    pictures = shown.clip().levels[0]
    return least_squares_step(shown.scene(), pictures[j], pictures[j + 1], before, 0, inner)


def test_least_squares_finds_the_motion_of_a_box(box: Case) -> None:
    before = standing(box, 1)
    far = miss(box, before.Rs_parent_part[1], before.ps_camera_root[1], 2)
    step = stepped(box, 1, before)
    near = miss(box, step.Rs_parent_part, step.p_camera_root, 2)
    assert far[0] > 0.5
    assert near[0] < 0.15 * far[0]
    assert near[1] < 0.25 * far[1]
    assert step.rank == 6
    assert step.followed > 300


def robust(shown: Case, clip: Clip, before: Trajectory) -> tuple[Pose, float]:
    motions, score = robust_pass(shown.scene(), clip, before, 2, 8, 1e-4)
    return Pose(motions.Rs_parent_part[0], motions.ps_camera_root[0]), score


def test_the_robust_pass_finds_the_motion_of_a_box(box: Case) -> None:
    clip = Clip(0, tuple(level[1:3] for level in box.clip().levels))
    before = standing(box, 1)
    found, score = robust(box, clip, before)
    far = miss(box, before.Rs_parent_part[1], before.ps_camera_root[1], 2)
    near = miss(box, found.Rs_parent_part, found.p_camera_root, 2)
    assert near[0] < 0.5 * far[0]
    again, better = robust(
        box, clip,
        Trajectory(0, np.stack([before.Rs_parent_part[0], found.Rs_parent_part]),
                   np.stack([before.ps_camera_root[0], found.p_camera_root])),
    )  # fmt: skip
    nearer = miss(box, again.Rs_parent_part, again.p_camera_root, 2)
    assert nearer[0] < 0.25 * far[0]
    assert better < 0.6 * score


def test_a_persons_motion_is_found_from_the_one_before(person: Case) -> None:
    clip = person.clip()
    R, t = person.truth.Rs_parent_part, person.truth.ps_camera_root
    ahead = R[1] @ transpose(R[0]) @ R[1], 2 * t[1] - t[0]
    before = Trajectory(0, np.stack([R[1], ahead[0]]), np.stack([t[1], ahead[1]]))
    found, _ = robust(person, Clip(0, tuple(level[1:3] for level in clip.levels)), before)
    still = miss(person, R[1], t[1], 2)
    near = miss(person, found.Rs_parent_part, found.p_camera_root, 2)
    assert near[0] < 0.5 * still[0]


def test_the_singular_values_are_those_of_the_dense_matrix(person: Case) -> None:
    scene, pictures = person.scene(), person.clip().levels[0]
    before = standing(person, 1)
    step = least_squares_step(scene, pictures[1], pictures[2], before, 0, inner=1)
    body, R, t = scene.arrays, before.Rs_parent_part[0], before.ps_camera_root[0]
    HR, Ho = plain.place_parts(body, R, t)
    height, width = pictures.shape[1:3]
    uvz, seen = plain.see(body, HR, Ho, scene.lens, scene.visibility, width, height)
    picked, _ = plain.pick(body, uvz.astype(np.float32), seen, pictures[1], 1.0, 1, 1)
    chosen = np.array(picked)
    grey = plain.bilinear(pictures[1], uvz[chosen, :2])[:, 0]
    rows = plain.rows_of(body, chosen, grey, HR, Ho, np.zeros(3), pictures[2], scene.lens)
    S = plain.camera_twists(body, HR, Ho)
    J = plain.dense_jacobian(body, person.skeleton.below, rows, S) * person.skeleton.column_scale
    singular = np.linalg.svd(J, compute_uv=False)
    np.testing.assert_allclose(step.singular_values, singular, rtol=0.03, atol=0.003 * singular[0])
    assert step.followed == pytest.approx(len(chosen), abs=10)
    assert step.squares == pytest.approx(np.sum(rows.r**2), rel=0.03)


def test_directions_below_the_cut_stay_at_the_prediction_and_the_others_are_solved() -> None:
    rng = np.random.default_rng(0)
    V, _ = np.linalg.qr(rng.normal(size=(4, 4)))
    values = np.array([1.0, 0.3, (0.5 * SINGULAR_CUT) ** 2, 0.0])
    A, b = V @ np.diag(values) @ V.T, rng.normal(size=4)
    x, singular = solve_with_cut(A, b, np.ones(4))
    np.testing.assert_allclose(singular, np.sqrt(values), atol=1e-8)
    np.testing.assert_allclose(V.T @ x, [*(-(V.T @ b)[:2] / values[:2]), 0, 0], atol=1e-9)
    scale = np.array([1.0, 0.3, 2.0, 5.0])
    full = V @ np.diag([1.0, 0.7, 0.4, 0.2]) @ V.T
    x, _ = solve_with_cut(full, b, scale)
    np.testing.assert_allclose(full @ x, -b, atol=1e-9)


def test_a_telephoto_camera_leaves_one_motion_unseen_and_depth_at_its_prediction(
    telephoto: Case, person: Case
) -> None:
    R, t = telephoto.truth.Rs_parent_part, telephoto.truth.ps_camera_root
    ahead = t[1] + np.array([0.0, 0.0, 0.123])
    before = Trajectory(0, np.stack([R[1], R[1]]), np.stack([t[1], ahead]))
    dofs = telephoto.skeleton.dof_count
    step = stepped(telephoto, 1, before)
    assert step.singular_values[-1] < 1e-3 * step.singular_values[0]
    assert step.rank <= dofs - 1
    assert step.p_camera_root[2] == pytest.approx(ahead[2], abs=2e-3)
    clip = Clip(0, tuple(level[1:3] for level in telephoto.clip().levels))
    found, _ = robust(telephoto, clip, before)
    assert found.p_camera_root[2] == pytest.approx(ahead[2], abs=2e-3)
    seen = observe(telephoto.scene(), clip, before)
    assert seen.diagnostics.rank[0] <= dofs - 1
    near = stepped(person, 1, standing(person, 1))
    assert near.singular_values[-1] > 10 * step.singular_values[-1]


def test_observability_is_the_pictures_share_beside_the_prior(person: Case) -> None:
    scene, clip = person.scene(), Clip(0, tuple(x[:2] for x in person.clip().levels))
    path = Trajectory(0, person.truth.Rs_parent_part[:2], person.truth.ps_camera_root[:2])
    dofs, parts = person.skeleton.dof_count, person.skeleton.part_count
    A, sigma = np.empty((1, dofs, dofs)), np.empty(1)
    residual, shown = np.empty((1, parts)), np.empty((1, parts), np.int64)
    observe_pairs(
        scene.arrays, scene.lens, scene.visibility, clip.levels[0], np.arange(2),
        path.Rs_parent_part, path.ps_camera_root, A, residual, shown, sigma,
    )  # fmt: skip
    precision = scene.prior(1).precision
    data = A[0] * scene.information(1) / sigma[0] ** 2
    share = 1 - precision * np.diag(np.linalg.inv(data + np.diag(precision)))
    seen = observe(scene, clip, path).diagnostics.observability
    for i in range(parts):
        mine = person.skeleton.dof_part == i
        if mine.any():
            assert seen[0, i] == pytest.approx(share[mine].mean(), abs=1e-6)
        else:
            assert np.isnan(seen[0, i])
    assert 0.01 < np.nanmin(seen) < np.nanmax(seen) < 0.999


def hidden_arm() -> tuple[Skeleton, Camera]:
    """A broad wall before a small block that turns about its joint."""
    wall = Part(name="wall", shape=Box(low_m=(-0.5, -0.4, -0.02), high_m=(0.5, 0.4, 0.02)),
                tracked=ALL_DOFS)  # fmt: skip
    arm = Part(name="arm", parent="wall", joint_m=(0.0, 0.0, 0.3),
               shape=Box(low_m=(-0.1, -0.1, -0.1), high_m=(0.1, 0.1, 0.1)),
               tracked=("rx", "ry", "rz"))  # fmt: skip
    body = Body(name="hidden", parts=(wall, arm))
    return Skeleton.of(body), Camera.from_field_of_view(320, 180, 0.8)


def test_what_is_hidden_follows_the_prediction() -> None:
    from tests.rendering.render import render

    skeleton, camera = hidden_arm()
    start = Pose.rest(skeleton, (0.0, 0.0, 2.5))
    true = moved(skeleton, start, np.array([0.01, 0, 0, 0, 0, 0.01, 0, 0, 0]))
    predicted = moved(skeleton, start, np.array([0, 0, 0, 0, 0, 0, 0.2, -0.1, 0.3]))
    truth = Trajectory(0, np.stack([start.Rs_parent_part, true.Rs_parent_part]),
                       np.stack([start.p_camera_root, true.p_camera_root]))  # fmt: skip
    shown = Case(skeleton, camera, truth, render(skeleton, truth, camera, CLEAN))
    before = Trajectory(0, np.stack([start.Rs_parent_part, predicted.Rs_parent_part]),
                        np.stack([start.p_camera_root, predicted.p_camera_root]))  # fmt: skip
    step = stepped(shown, 0, before)
    found, _ = robust(shown, shown.clip(), before)
    for R, t in ((step.Rs_parent_part, step.p_camera_root),
                 (found.Rs_parent_part, found.p_camera_root)):  # fmt: skip
        np.testing.assert_allclose(R[1], predicted.Rs_parent_part[1], atol=1e-9)
        assert np.abs(t - true.p_camera_root)[0] < 0.003
    assert step.rank == 6
    seen = observe(shown.scene(), shown.clip(), truth)
    assert seen.diagnostics.observability[0, 1] == pytest.approx(0.0, abs=1e-6)
    assert seen.diagnostics.observability[0, 0] > 0.3
    assert seen.shown[0, 1] == 0
    assert np.isnan(seen.diagnostics.residual[0, 1])


@pytest.mark.parametrize("pictured", ["all ignored", "one grey", "target ignored"])
def test_where_nothing_shows_everything_follows_the_prediction(box: Case, pictured: str) -> None:
    pictures = box.pictures[:2]
    usable: Picture | None = None
    if pictured == "one grey":
        pictures = np.full_like(pictures, 128)
    if pictured == "all ignored":
        usable = np.full(pictures.shape[1:3], IGNORED, np.uint8)
    clip = clip_of(pictures, usable)
    if pictured == "target ignored":
        clip.levels[0][1, ..., 3] = IGNORED
    before = Trajectory(0, box.truth.Rs_parent_part[[0, 3]], box.truth.ps_camera_root[[0, 3]])
    scene = box.scene()
    step = least_squares_step(scene, clip.levels[0][0], clip.levels[0][1], before, 0, 5)
    found, score = robust(box, clip, before)
    for R, t in ((step.Rs_parent_part, step.p_camera_root),
                 (found.Rs_parent_part, found.p_camera_root)):  # fmt: skip
        np.testing.assert_allclose(R, before.Rs_parent_part[1], atol=1e-9)
        np.testing.assert_allclose(t, before.ps_camera_root[1], atol=1e-9)
    assert step.rank == 0
    assert score == pytest.approx(0.0, abs=0.02)  # the middle of the first bin
    seen = observe(scene, clip, before)
    assert seen.diagnostics.rank[0] == 0
    np.testing.assert_allclose(seen.diagnostics.observability, 0.0, atol=1e-9)


def test_a_residual_without_a_target_is_none(box: Case) -> None:
    clip = clip_of(box.pictures[:2])
    clip.levels[0][1, ..., 3] = IGNORED
    pair = Trajectory(0, box.truth.Rs_parent_part[:2], box.truth.ps_camera_root[:2])
    assert np.isnan(observe(box.scene(), clip, pair).diagnostics.residual[0, 0])
    with pytest.raises(IndexError, match="frames 0 to 4 are not all in the clip"):
        observe(box.scene(), clip, box.truth)


def test_a_part_beside_the_picture_is_no_trouble() -> None:
    skeleton = random_body(5, parts=5)
    camera = Camera.from_field_of_view(64, 48, 0.3)
    scene = scene_of(skeleton, camera)
    rng = np.random.default_rng(1)
    pictures = rng.integers(0, 255, (2, 48, 64, 3)).astype(np.uint8)
    for place in ((0.2, 0.0, 2.0), (5.0, 0.0, 2.0), (0.0, 0.0, -1.0)):
        pose = Pose.rest(skeleton, place)
        both = Trajectory(
            0, np.stack([pose.Rs_parent_part] * 2), np.stack([pose.p_camera_root] * 2)
        )
        clip = clip_of(pictures)
        motions, score = robust_pass(scene, clip, both, 2, 5, 1e-3)
        assert np.isfinite(motions.Rs_parent_part).all()
        assert np.isfinite(motions.ps_camera_root).all()
        assert np.isfinite(score)
        step = least_squares_step(scene, clip.levels[0][0], clip.levels[0][1], both, 0, 5)
        assert np.isfinite(step.p_camera_root).all()


def test_the_printed_score_is_the_passes_own_and_least_at_the_truth(box: Case) -> None:
    scene, clip = box.scene(), box.clip()
    motions, score = least_squares_pass(scene, clip, box.truth, inner=3)
    assert len(motions.ps_camera_root) == len(box.truth) - 1
    assert printed_score(scene, clip, box.truth) == pytest.approx(score)
    still = Trajectory(0, box.truth.Rs_parent_part[[0] * 5], box.truth.ps_camera_root[[0] * 5])
    assert printed_score(scene, clip, still) > 3 * score


@pytest.mark.parametrize("score", ["capped", "printed"])
def test_a_path_out_of_the_picture_scores_worse_than_the_truth(box: Case, score: str) -> None:
    ps = box.truth.ps_camera_root.copy()
    ps[1:-1, 0] += 40.0
    gone = Trajectory(0, box.truth.Rs_parent_part, ps)
    scores = [
        robust_pass(box.scene(), box.clip(), path, 4, 1, 1e-3)[1]
        if score == "capped"
        else printed_score(box.scene(), box.clip(), path)
        for path in (gone, box.truth)
    ]
    assert scores[0] > scores[1]


def test_following_runs_both_ways_and_the_blend_starts_at_each_keyframe(box: Case) -> None:
    scene, clip = box.scene(), box.clip()
    how = {"stride": 4, "inner": 4, "stop": 1e-3}
    there = follow(scene, clip, box.truth.pose(0), 0, 4, **how)
    back = follow(scene, clip, box.truth.pose(4), 4, 0, **how)
    for chain, start in ((there, 0), (back, 4)):
        assert (chain.first_frame, len(chain)) == (0, 5)
        np.testing.assert_array_equal(chain.ps_camera_root[start], box.truth.ps_camera_root[start])
        still = Trajectory(
            0, box.truth.Rs_parent_part[[start] * 5], box.truth.ps_camera_root[[start] * 5]
        )
        assert box.error_cm(chain) < 0.3 * box.error_cm(still)
    middle = blend_chains(scene, there, back)
    for k in (0, 4):
        np.testing.assert_allclose(
            middle.Rs_parent_part[k], box.truth.Rs_parent_part[k], atol=1e-12
        )
        np.testing.assert_allclose(
            middle.ps_camera_root[k], box.truth.ps_camera_root[k], atol=1e-12
        )


def test_a_limb_that_one_chain_has_lost_is_taken_from_the_other(person: Case) -> None:
    scene, truth = person.scene(), person.truth
    arm = scene.skeleton.body.index("right_upper_arm")
    away = np.linspace(0.0, 1.2, len(truth))[:, None] * np.array([1.0, 0.0, 0.0])

    def strayed(turns: Floats) -> Chain:
        R, t = truth.writable()
        R[:, arm] = R[:, arm] @ exp_rotation(turns)
        return Chain.even(Trajectory(truth.first_frame, R, t))

    right = Chain.even(truth)
    for chains in ((strayed(away), right), (right, strayed(away[::-1]))):
        whole = blend_chains(scene, *chains)
        assert person.error_cm(whole) < 0.1 * person.error_cm(strayed(away))
        for k in (0, -1):
            np.testing.assert_allclose(whole.Rs_parent_part[k], truth.Rs_parent_part[k], atol=1e-9)
    np.testing.assert_allclose(
        blend_chains(scene, right, right).Rs_parent_part, truth.Rs_parent_part, atol=1e-9
    )


def test_the_way_from_one_chain_to_the_other_is_made_where_a_part_is_hidden(person: Case) -> None:
    scene, truth = person.scene(), person.truth
    arm, n = scene.skeleton.body.index("right_upper_arm"), len(truth) - 1
    hidden = n // 3

    def lost(after: bool) -> Chain:
        """0.1 rad off on the far side of the hidden step, which is where it was lost."""
        R, t = truth.writable()
        frames = slice(hidden + 1, None) if after else slice(0, hidden + 1)
        R[frames, arm] = R[frames, arm] @ exp_rotation(np.array([0.1, 0.0, 0.0]))
        chain = Chain.even(Trajectory(truth.first_frame, R, t))
        turned = np.full_like(chain.doubt.turned, 0.001)
        turned[hidden] = 1.0
        return replace(chain, doubt=Doubt(turned, chain.doubt.shifted))

    chains = lost(after=True), lost(after=False)
    alike = tuple(Chain.even(chain) for chain in chains)
    reported, unreported = blend_chains(scene, *chains), blend_chains(scene, *alike)
    assert person.error_cm(reported) < 0.5 * person.error_cm(unreported)


def test_a_limb_is_a_chain_without_branches(person: Case) -> None:
    skeleton = person.scene().skeleton
    limb = dict(zip(skeleton.body.names, skeleton.limbs.tolist(), strict=True))
    assert limb["left_upper_arm"] == limb["left_forearm"] == limb["left_hand"]
    assert limb["neck"] == limb["head"]
    assert len(set(limb.values())) == 7  # waist, chest, neck and head, two arms, two legs


def test_a_scene_is_laid_out_for_the_distance_of_its_keyframes() -> None:
    skeleton = random_body(2)
    near, far = (scene_of(skeleton, poses=[Pose.rest(skeleton, (0, 0, z))]) for z in (2.0, 8.0))
    assert isinstance(near, Scene)
    assert far.pixel_m > 3 * near.pixel_m
    assert near.visibility.cell >= 1.5 * near.points.spacing_m / near.pixel_m
