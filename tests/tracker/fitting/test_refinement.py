"""A pose is moved along what the picture decides, and nowhere else."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from keypose.tracker.body.joint_limits import Limits
from keypose.tracker.body.pose import moved
from keypose.tracker.fitting.pose.inputs import (
    REACH,
    SAME_SIGMAS,
    WRONG_SIGMAS,
    FitInputs,
    _is_independent,
    _without_border,
    _wrong_parts,
    keyframes_near,
)
from keypose.tracker.fitting.pose.messages import Moves, describe_moves
from keypose.tracker.fitting.pose.refinement import (
    DECISIVE,
    EdgeDistances,
    PosedKeyframe,
    RefinedPose,
    _step,
    decided_share,
    refine,
)
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.posed import Posed
from keypose.tracker.solver.projection import image_points
from keypose.tracker.solver.terms import Equations
from keypose.tracker.video.pyramid import IGNORED
from tests.tracker.tracking_cases import CAMERA, random_body, random_pose, scene_of

SKELETON = random_body(4, parts=4)
POSE = random_pose(SKELETON, 4)


def keyframe() -> PosedKeyframe:
    return PosedKeyframe(scene_of(SKELETON, CAMERA, [POSE]), POSE, Limits.of(SKELETON.body))


def motion(seed: int = 0, sigmas: float = 1.0) -> Array:
    """A motion of about so many sigmas of the pose as set."""
    rng = np.random.default_rng(seed)
    return np.asarray(sigmas * rng.normal(size=SKELETON.dof_count) * keyframe().precision ** -0.5)


# --- edges


def edges(seed: int = 1, count: int = 40) -> EdgeDistances:
    """Places on all parts, seen where the pose has them."""
    rng = np.random.default_rng(seed)
    part = rng.integers(SKELETON.part_count, size=count)
    p_part = rng.normal(0, 0.15, (count, 3))
    angle = rng.uniform(0, 2 * np.pi, count)
    normal = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    uv = image_points(CAMERA, Posed.of(SKELETON, POSE).points(part, p_part))
    target = (normal * uv).sum(axis=-1)
    return EdgeDistances(CAMERA, part, p_part, normal, target, np.full(count, 0.5), 2.0)


@pytest.mark.parametrize("seed", range(3))
def test_equations_of_edges_agree_with_differences_of_their_cost(seed: int) -> None:
    term, there = (
        edges(seed),
        moved(SKELETON, POSE, 0.03 * motion(seed) / np.abs(motion(seed)).max()),
    )
    posed = Posed.of(SKELETON, there)
    found = term.equations(posed)
    assert found.cost == pytest.approx(term.cost(posed))
    for d in range(SKELETON.dof_count):
        step = np.zeros(SKELETON.dof_count)
        step[d] = 1e-5
        ahead, back = (
            term.cost(Posed.of(SKELETON, moved(SKELETON, there, sign * step))) for sign in (1, -1)
        )
        slope = (ahead - back) / 2e-5
        assert found.b[d] == pytest.approx(slope, rel=1e-3, abs=1e-3 * np.abs(found.b).max())


def test_information_of_edges_is_how_their_slopes_change() -> None:
    """Exactly so where all of them are seen where they are."""
    term = edges()
    A = term.equations(Posed.of(SKELETON, POSE)).A
    for seed in range(3):
        step = 1e-5 * motion(seed) / np.abs(motion(seed)).max()
        slopes = term.equations(Posed.of(SKELETON, moved(SKELETON, POSE, step))).b
        np.testing.assert_allclose(A @ step, slopes, atol=0.01 * np.abs(slopes).max())


def test_edges_seen_where_they_are_cost_nothing_and_a_thicker_part_costs_little() -> None:
    term, posed = edges(), Posed.of(SKELETON, POSE)
    assert term.cost(posed) == pytest.approx(0.0, abs=1e-12)
    thicker = EdgeDistances(
        term.camera, term.part, term.p_part, term.normal, term.target_px + 1.5, term.weights, 2.0
    )
    alone = 0.5 * float(term.weights @ np.full(len(term.weights), 1.5) ** 2)
    assert 0 < thicker.cost(posed) < 0.15 * alone


# --- what is decided


def evidence(share: Array, toward: Array) -> Equations:
    """Of a picture that knows each motion by a share of what the pose as set does."""
    A = np.diag(share * keyframe().precision)
    return Equations(A, -A @ toward, 0.0)


def test_undecided_motions_stay_exactly_and_decided_ones_go_where_the_picture_says() -> None:
    made, dofs = keyframe(), SKELETON.dof_count
    share = np.where(np.arange(dofs) % 2 == 0, 50.0, 0.5 * DECISIVE)
    toward = motion(2, 0.1)
    step = _step(made, Posed.of(SKELETON, POSE), evidence(share, toward), only_decided=True)
    np.testing.assert_allclose(step[1::2], 0.0, atol=1e-12)
    np.testing.assert_allclose(step[::2], toward[::2] * 50 / 51, rtol=1e-6)


def test_a_pose_that_strayed_along_undecided_motions_is_led_straight_back() -> None:
    made = keyframe()
    away = moved(SKELETON, POSE, motion(3, 0.05))
    posed = Posed.of(SKELETON, away)
    nothing = Equations.none(SKELETON.dof_count)
    back = moved(SKELETON, away, _step(made, posed, nothing, only_decided=True))
    assert np.abs(made.away(back)).max() < 1e-3 * np.abs(made.away(away)).max()


def test_without_that_rule_a_weak_picture_still_pulls_by_its_share() -> None:
    share, toward = np.full(SKELETON.dof_count, 0.5), motion(2, 0.1)
    step = _step(keyframe(), Posed.of(SKELETON, POSE), evidence(share, toward), only_decided=False)
    np.testing.assert_allclose(step, toward / 3, rtol=1e-6)


@pytest.mark.parametrize(("share", "expected"), [(0.0, 0.0), (0.9, 0.0), (1.5, 0.6), (9.0, 0.9)])
def test_what_a_picture_decides_of_a_part_is_its_share_of_all_that_is_known(
    share: float, expected: float
) -> None:
    information = share * np.diag(keyframe().precision)
    found = decided_share(keyframe(), RefinedPose(POSE, information))
    tracked = np.isin(np.arange(SKELETON.part_count), SKELETON.dof_part)
    np.testing.assert_allclose(found[tracked], expected, atol=1e-9)
    np.testing.assert_array_equal(found[~tracked], 0.0)


def test_with_nothing_to_go_by_the_pose_is_the_one_that_was_set_wherever_it_starts() -> None:
    made = keyframe()
    found = refine(made, moved(SKELETON, POSE, motion(5, 0.3)), None, None, lambda: False)
    np.testing.assert_allclose(made.away(found.pose), 0.0, atol=1e-4)
    np.testing.assert_array_equal(found.information, 0.0)


def test_a_refinement_that_is_cancelled_is_the_pose_as_set() -> None:
    found = refine(keyframe(), moved(SKELETON, POSE, motion(5)), None, None, lambda: True)
    assert found.pose is POSE


# --- what it is fitted to


def near(frame: int, keyframes: tuple[int, ...]) -> list[int]:
    made: Any = SimpleNamespace(frame=frame)
    return list(keyframes_near(made, dict.fromkeys(keyframes, POSE)))


@pytest.mark.parametrize(
    ("keyframes", "expected"),
    [
        ((), []),
        ((50,), []),
        ((10, 50 - REACH, 50, 50 + REACH, 200), [50 - REACH, 50 + REACH]),
        ((49 - REACH, 51 + REACH), []),
        ((30, 20, 60, 70), [30, 60]),
    ],
    ids=["none", "itself", "at the reach", "beyond it", "the nearest on both sides"],
)
def test_the_nearest_keyframe_on_either_side_is_used_as_far_as_it_shows_the_same(
    keyframes: tuple[int, ...], expected: list[int]
) -> None:
    assert near(50, keyframes) == expected


def inputs(frame: int = 10) -> FitInputs:
    made: Any = SimpleNamespace(keyframe=keyframe(), scene=keyframe().scene, frame=frame)
    return made  # type: ignore[no-any-return]


def test_tracking_that_was_led_through_the_keyframe_is_not_independent_of_it() -> None:
    beside = moved(SKELETON, POSE, motion(1, 3 * SAME_SIGMAS))
    assert not _is_independent(inputs(), {})
    assert not _is_independent(inputs(), {10: POSE})
    assert _is_independent(inputs(), {10: beside})
    assert _is_independent(inputs(), {11: POSE}), "this frame is not tracked at all"


@pytest.mark.parametrize(("sigmas", "is_wrong"), [(0.8, False), (1.2, True)])
def test_a_limb_tracked_too_far_off_is_wrong_and_so_is_what_hangs_on_it(
    sigmas: float, is_wrong: bool
) -> None:
    dof = int(np.flatnonzero(SKELETON.dof_part == 1)[0])
    step = np.zeros(SKELETON.dof_count)
    step[dof] = sigmas * WRONG_SIGMAS * keyframe().precision[dof] ** -0.5
    wrong = _wrong_parts(inputs(), moved(SKELETON, POSE, step))
    expected = SKELETON.below[:, 1] if is_wrong else np.zeros(SKELETON.part_count, np.bool_)
    np.testing.assert_array_equal(wrong, expected)
    assert wrong[1] == is_wrong


def test_the_border_of_what_is_ignored_is_a_pixel_wider_and_the_rest_as_it_was() -> None:
    picture = np.full((9, 9, 4), 7, np.int16)
    assert _without_border(picture) is picture
    picture[4, 4, 3] = IGNORED
    found = _without_border(picture)
    assert np.argwhere(found[..., 3] == IGNORED).tolist() == [
        [row, column] for row in (3, 4, 5) for column in (3, 4, 5)
    ]
    np.testing.assert_array_equal(found[..., :3], picture[..., :3])
    assert picture[3, 3, 3] == 7, "the clip's own picture is not changed"


# --- what is said of it

NAMES = ("left_hand", "chest", "right_shin", "head", "left_foot")
NO = np.zeros(5, np.bool_)


@pytest.mark.parametrize(
    ("px", "decided", "tracked", "hidden", "words"),
    [
        ((6.4, 0, 0, 0, 0), (1, 1, 1, 1, 1), ~NO, NO, "Left hand moved 6 px."),
        (
            (1, 5, 4, 3, 2),
            (1, 1, 1, 1, 1),
            ~NO,
            NO,
            "Chest moved 5 px, right shin 4 px, head 3 px.",
        ),
        (
            (9, 0, 0, 0, 0),
            (1, 1, 1, 1, 1),
            np.arange(5) > 0,
            NO,
            "No part moved by more than a pixel.",
        ),
        (
            (9, 2, 0, 0, 0),
            (0.1, 1, 1, 1, 1),
            ~NO,
            NO,
            "Chest moved 2 px. Left hand cannot be seen well enough and was left unchanged.",
        ),
        (
            (0, 0, 3, 0, 0),
            (1, 1, 1, 0, 1),
            ~NO,
            np.arange(5) == 0,
            "Right shin moved 3 px. Left hand is hidden and was left unchanged.",
        ),
        (
            (0, 0, 0, 0, 0),
            (1, 1, 1, 1, 1),
            ~NO,
            ~NO,
            "No part moved by more than a pixel. "
            "Left hand, chest, right shin and 2 more are hidden and were left unchanged.",
        ),
    ],
    ids=["one", "the most", "carried along", "unclear", "hidden before unclear", "all hidden"],
)
def test_what_moved_and_what_could_not_is_said_in_plain_sentences(
    px: tuple[float, ...], decided: tuple[float, ...], tracked: Any, hidden: Any, words: str
) -> None:
    moves = Moves(NAMES, np.array(px, float), np.array(decided, float), tracked, hidden)
    assert describe_moves(moves) == words
