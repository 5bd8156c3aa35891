"""A limb that a keyframe has the wrong way round in depth is told, and no right one."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.body.pose import Pose, joint_positions, pose_transforms
from keypose.tracker.session.results import SpaceFinding
from keypose.tracker.solver.depth_turn import turned_in_depth
from keypose.tracker.space.findings import MotionInSpace, space_findings
from keypose.tracker.space.mirrored import Mirrored, mirrored_limbs
from tests.rendering.scenes import Scene, scene

RATE = 30.0
FRAMES = (0, 20, 40, 60, 80)


@pytest.fixture(scope="module")
def thrower() -> Scene:
    return scene("throw")


def poses(shown: Scene, *turned: tuple[int, str]) -> dict[int, Pose]:
    """The true keyframes, but for these limbs."""
    known = {frame: shown.truth.pose(frame) for frame in FRAMES}
    for frame, part in turned:
        top = shown.skeleton.body.index(part)
        known[frame] = turned_in_depth(shown.skeleton, shown.camera, known[frame], top)
    return known


def reported(shown: Scene, known: dict[int, Pose]) -> tuple[Mirrored, ...]:
    return mirrored_limbs(shown.skeleton, shown.camera, known, RATE)


def test_of_right_keyframes_nothing_is_reported(thrower: Scene) -> None:
    assert reported(thrower, poses(thrower)) == ()


@pytest.mark.parametrize(("part", "frame"), [("left_upper_arm", 40), ("right_upper_arm", 40)])
def test_a_mirrored_arm_is_reported_and_turning_it_brings_it_back(
    thrower: Scene, part: str, frame: int
) -> None:
    wrong = poses(thrower, (frame, part))
    (found,) = reported(thrower, wrong)
    assert found.frame == frame
    assert found.part in (part, part.replace("upper_arm", "forearm"))
    top = thrower.skeleton.body.index(found.part)
    back = turned_in_depth(thrower.skeleton, thrower.camera, wrong[frame], top)
    assert reported(thrower, {**wrong, frame: back}) == ()
    assert off(thrower, frame, back, part) < off(thrower, frame, wrong[frame], part) / 2


def off(shown: Scene, frame: int, pose: Pose, part: str) -> float:
    """Mean distance of an arm's joints from the truth, metres."""
    skeleton = shown.skeleton
    ours, true = (
        joint_positions(skeleton, pose_transforms(skeleton, p))[: skeleton.part_count]
        for p in (pose, shown.truth.pose(frame))
    )
    arm = skeleton.below[:, skeleton.body.index(part)]
    return float(np.linalg.norm(ours - true, axis=-1)[arm].mean())


def test_keyframes_far_apart_give_nothing_of_each_other(thrower: Scene) -> None:
    wrong = poses(thrower, (40, "left_upper_arm"))
    assert mirrored_limbs(thrower.skeleton, thrower.camera, wrong, RATE / 4) == ()


def test_two_keyframes_alone_give_nothing(thrower: Scene) -> None:
    wrong = poses(thrower, (40, "left_upper_arm"))
    assert reported(thrower, {frame: wrong[frame] for frame in (40, 60)}) == ()


def test_a_body_without_limbs_has_none() -> None:
    shown = scene("tumbling_box")
    known = {frame: shown.truth.pose(frame) for frame in (0, 10, 20)}
    assert mirrored_limbs(shown.skeleton, shown.camera, known, RATE) == ()


def test_it_is_among_what_is_not_plausible_in_space(thrower: Scene) -> None:
    wrong = poses(thrower, (40, "left_upper_arm"))
    Rs, ps = thrower.truth.writable()
    Rs[40], ps[40] = wrong[40].Rs_parent_part, wrong[40].p_camera_root
    motion = type(thrower.truth)(0, Rs, ps)
    found: tuple[SpaceFinding, ...] = space_findings(
        MotionInSpace(
            thrower.skeleton, thrower.camera, motion, motion, RATE, stances=(), pinned=(),
            keyframes=FRAMES, up_world=None, floor_m=None,
        )
    )  # fmt: skip
    (one,) = (finding for finding in found if finding.kind == "mirrored")
    assert (one.go, one.first_frame) == (40, 40)
    assert one.amount > 0.1
