"""A stretch of frames is solved in one, or in windows that come out as if it had been."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from keypose.tracker.body.pose import moved
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.fitting.draft import whole
from keypose.tracker.fitting.draft.observed import Joints, Observed, turning_ends
from keypose.tracker.fitting.draft.whole import Whole, in_camera
from keypose.tracker.tracking.cues.anchors import with_free_joints
from keypose.tracker.tracking.scene import Scene
from tests.tracker.fitting.draft.clips import BODY, CAMERA, Clip, place, walk

FEW_POINTS = 1.0
SKELETON = with_free_joints(Skeleton.of(BODY))
JOINTS_OF = Joints.of(SKELETON)
COUNT = 40


def motion_of(clip: Clip) -> Trajectory:
    Rs = np.stack([pose.Rs_parent_part for pose in clip.poses])
    return Trajectory(0, Rs, np.stack([pose.p_camera_root for pose in clip.poses]))


def disturbed(motion: Trajectory, size: float, seed: int = 0) -> Trajectory:
    """Every pose moved by about so many radians and metres."""
    rng = np.random.default_rng(seed)
    poses = [
        moved(SKELETON, motion.pose(n), size * rng.normal(size=SKELETON.dof_count))
        for n in range(len(motion))
    ]
    Rs = np.stack([pose.Rs_parent_part for pose in poses])
    return Trajectory(0, Rs, np.stack([pose.p_camera_root for pose in poses]))


def problem(clip: Clip, first: Trajectory, seen: Observed | None = None) -> Whole:
    observed = Observed.of(clip.keypoints, CAMERA) if seen is None else seen
    scene = Scene.of(SKELETON, CAMERA, [clip.poses[0]], FEW_POINTS)
    made = Whole.of_joints(scene, JOINTS_OF, observed, first)
    truth = JOINTS_OF.seen.at(motion_of(clip).transforms(SKELETON))
    depth = truth[..., 2] - motion_of(clip).ps_camera_root[:, 2:]
    return replace(made, depth=depth, keep=1e-4 * made.keep)


def apart_m(one: Trajectory, other: Trajectory) -> float:
    joints = [JOINTS_OF.points.at(motion.transforms(SKELETON)) for motion in (one, other)]
    return float(np.linalg.norm(joints[0] - joints[1], axis=-1).max())


def ignored(done: int) -> None:
    del done


def test_the_truth_costs_least() -> None:
    clip = walk(COUNT, facing_deg=40)
    truth = motion_of(clip)
    made = problem(clip, truth)
    costs = [made.cost(disturbed(truth, size)) for size in (0.0, 0.01, 0.03)]
    assert costs == sorted(costs)
    assert costs[1] > 2 * costs[0]


def test_a_disturbed_motion_comes_back_to_what_was_seen() -> None:
    clip = walk(COUNT, facing_deg=40)
    truth = motion_of(clip)
    start = disturbed(truth, 0.05)
    found = problem(clip, start).solve(ignored)
    assert apart_m(start, truth) > 0.1
    assert apart_m(found, truth) < 0.03


def test_windows_give_nearly_what_one_solve_gives_and_say_where_they_begin(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    clip = walk(COUNT, facing_deg=40)
    made = problem(clip, disturbed(motion_of(clip), 0.03))
    one = made.solve(ignored)
    monkeypatch.setattr(whole, "WINDOW", 16)
    monkeypatch.setattr(whole, "OVERLAP", 6)
    began: list[int] = []
    windows = made.solve(began.append)
    assert sorted(set(began)) == [0, 10, 20, 30]
    assert began == sorted(began)
    assert apart_m(one, windows) < 0.02
    jumps, usual = (np.abs(np.diff(m.ps_camera_root, axis=0)).max() for m in (windows, one))
    assert jumps < 2 * usual


def test_what_the_report_raises_ends_the_solve() -> None:
    class Left(Exception):
        pass

    def leave(done: int) -> None:
        raise Left

    clip = walk(4)
    with pytest.raises(Left):
        problem(clip, motion_of(clip)).solve(leave)


def test_a_joint_that_is_not_known_has_no_say() -> None:
    clip = walk(COUNT)
    seen = Observed.of(clip.keypoints, CAMERA)
    doubted = np.zeros_like(seen.known)
    doubted[:, place("left_wrist")] = True
    uv = seen.uv.copy()
    uv[:, place("left_wrist")] += 500
    first = motion_of(clip)
    made = problem(clip, first, replace(seen.without(doubted), uv=uv))
    assert (made.scale[:, place("left_wrist")] == 0).all()
    assert (made.depth_scale[:, place("left_wrist")] == 0).all()
    assert made.cost(first) == pytest.approx(
        problem(clip, first, seen.without(doubted)).cost(first)
    )


def test_a_keypoint_less_sure_counts_less() -> None:
    clip = walk(3)
    seen = Observed.of(clip.keypoints, CAMERA)
    visibility = seen.visibility.copy()
    visibility[:, place("right_knee")] = 0.4
    made = problem(clip, motion_of(clip), replace(seen, visibility=visibility))
    sure, unsure = place("left_knee"), place("right_knee")
    assert (made.scale[:, unsure] < 0.8 * made.scale[:, sure]).all()
    assert (made.depth_scale[:, unsure] < 0.8 * made.depth_scale[:, sure]).all()


def test_depth_of_a_known_deviation_counts_by_it() -> None:
    clip = walk(3)
    seen = Observed.of(clip.keypoints, CAMERA)
    sigma_m = np.full_like(seen.depth_sigma_m, np.nan)
    sigma_m[1, place("left_elbow")] = 0.5
    made = problem(clip, motion_of(clip), replace(seen, depth_sigma_m=sigma_m))
    assert made.depth_scale[1, place("left_elbow")] == pytest.approx(2.0)


def test_a_head_that_sits_higher_than_the_bodys_is_not_tipped_back() -> None:
    clip = walk(8)
    seen = Observed.of(clip.keypoints, CAMERA)
    head = [place(name) for name in ("nose", "left_ear", "right_ear")]
    uv = seen.uv.copy()
    uv[:, head, 1] -= 15.0
    turning = Joints.of(turning_ends(JOINTS_OF))
    scene = Scene.of(turning.skeleton, CAMERA, [clip.poses[0]], FEW_POINTS)
    truth = motion_of(clip)
    made = Whole.of_ends(scene, turning, replace(seen, uv=uv), truth)
    part = BODY.index("head")

    def tipped_deg(motion: Trajectory) -> float:
        cosine = (
            np.trace(motion.Rs_parent_part[4, part].T @ truth.Rs_parent_part[4, part]) - 1
        ) / 2
        return float(np.degrees(np.arccos(np.clip(cosine, -1, 1))))

    assert tipped_deg(made.solve_turns(ignored)) < 0.5 * tipped_deg(made.solve(ignored))


def test_landmarks_lie_along_the_cameras_axes_and_nobody_lies_nowhere() -> None:
    clip = walk(5, place=(1.5, 0.2, 4.0))
    seen = Observed.of(clip.keypoints, CAMERA)
    nobody = np.zeros_like(seen.known)
    nobody[2] = True
    p = in_camera(CAMERA, seen.without(nobody))
    assert np.isnan(p[2]).all()
    truth = JOINTS_OF.seen.at(motion_of(clip).transforms(SKELETON))
    hips = truth[:, [place("left_hip"), place("right_hip")]].mean(axis=1, keepdims=True)
    for n in (0, 1, 3, 4):
        ours, theirs = p[n, :12].ravel(), (truth[n] - hips[n]).ravel()
        assert ours @ theirs / np.linalg.norm(ours) / np.linalg.norm(theirs) > 0.9999
