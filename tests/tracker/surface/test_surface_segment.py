"""Steps one after another, from one keyframe or from two; what is wrong with one costs no other."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from keypose.tracker.body.body import Part
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.shapes import Box
from keypose.tracker.body.trajectory import Pass
from keypose.tracker.errors import SessionError, SurfaceError
from keypose.tracker.geometry.rotations import exp_rotation
from keypose.tracker.session.verdict import Verdict
from keypose.tracker.surface.fit.options import Options
from keypose.tracker.surface.fit.segment import SurfaceTracker
from keypose.tracker.surface.mesh import SurfaceMesh
from keypose.tracker.tracking.pool import Cancelled
from keypose.tracker.tracking.result import SegmentResult
from tests.tracker.surface.surfaces import Given, bent, joints, surface_of, two_bars

BODY = two_bars()
OPTIONS = Options(points=700)
COUNT = 9
ASTRAY = np.array([0.0, 0.0, 0.1])


def _pose(frame: int) -> Pose:
    """A fold and a turn, eight steps long."""
    return bent(BODY, 0.1 + 0.1 * frame, (0.0, 0.05 * frame, 0.0), (0.01 * frame, 0.0, 3.0))


TRUE = [_pose(frame) for frame in range(COUNT)]
MESHES = [surface_of(BODY, pose, pieces=2) for pose in TRUE]


def _tracker(
    keys: dict[int, Pose], meshes: list[SurfaceMesh | str] | None = None, model: int = 0
) -> SurfaceTracker:
    return SurfaceTracker(Given(meshes or list(MESHES)), BODY, keys, model, OPTIONS)


def _run(tracker: SurfaceTracker, span: tuple[int, int] = (0, COUNT - 1)) -> SegmentResult:
    return tracker.run_segment(span, lambda step, number: None)


def _errors_m(result: SegmentResult) -> np.ndarray:
    first = result.trajectory.first_frame
    found = [result.trajectory.pose(first + k) for k in range(len(result.trajectory))]
    return np.array(
        [
            np.linalg.norm(joints(BODY, pose) - joints(BODY, TRUE[first + k]), axis=1).max()
            for k, pose in enumerate(found)
        ]
    )


def _is_pose(one: Pose, other: Pose) -> bool:
    return np.array_equal(one.Rs_parent_part, other.Rs_parent_part) and np.array_equal(
        one.p_camera_root, other.p_camera_root
    )


def test_one_keyframe_is_enough_to_follow_all_steps_after_it() -> None:
    result = _run(_tracker({0: TRUE[0]}))
    assert _errors_m(result).max() < 0.005
    assert result.verdict.kind == "good"
    assert result.diagnostics.residual.shape == (COUNT - 1, 2)
    assert result.diagnostics.observability.min() > 0.5


def test_the_steps_before_a_keyframe_are_followed_backward() -> None:
    result = _run(_tracker({COUNT - 1: TRUE[-1]}, model=COUNT - 1))
    assert result.trajectory.first_frame == 0
    assert _errors_m(result).max() < 0.005


def test_keyframes_are_never_changed_and_what_lies_between_comes_from_both() -> None:
    off = Pose(TRUE[-1].Rs_parent_part @ exp_rotation([0.05, 0, 0]), TRUE[-1].p_camera_root + 0.01)
    tracker = _tracker({0: TRUE[0], COUNT - 1: off})
    result = _run(tracker)
    assert _is_pose(result.trajectory.pose(0), TRUE[0])
    assert _is_pose(result.trajectory.pose(COUNT - 1), off)
    assert _errors_m(result)[1:-1].max() < 0.005


def test_a_chain_that_is_lost_gives_way_to_the_one_from_the_other_keyframe() -> None:
    meshes: list[SurfaceMesh | str] = list(MESHES)
    meshes[1] = SurfaceMesh(MESHES[1].vertices + ASTRAY, MESHES[1].faces)
    alone = _errors_m(_run(_tracker({0: TRUE[0]}, meshes)))
    both = _errors_m(_run(_tracker({0: TRUE[0], COUNT - 1: TRUE[-1]}, meshes)))
    assert both[2:].max() < 0.01
    assert alone[1] > 0.03


def test_a_step_that_cannot_be_used_is_led_over_and_reported() -> None:
    meshes: list[SurfaceMesh | str] = list(MESHES)
    meshes[3] = "Step 3 holds no faces: export it again."
    meshes[4] = "Step 4 is missing."
    result = _run(_tracker({0: TRUE[0]}, meshes))
    assert _errors_m(result).max() < 0.02
    assert result.verdict == Verdict.check("no_surface", (3, 4))
    assert result.notes[:2] == ("Step 3 holds no faces: export it again.", "Step 4 is missing.")
    assert result.diagnostics.rank[2:4].tolist() == [-1, -1]
    assert np.isfinite(result.diagnostics.residual[4:]).all()


def test_when_the_last_steps_cannot_be_used_the_last_pose_stays() -> None:
    meshes: list[SurfaceMesh | str] = [*MESHES[:6], *["Gone."] * 3]
    result = _run(_tracker({0: TRUE[0]}, meshes))
    assert _is_pose(result.trajectory.pose(8), result.trajectory.pose(5))
    assert result.notes[0] == "Gone."


def test_many_unusable_steps_are_reported_in_a_few_words() -> None:
    meshes: list[SurfaceMesh | str] = [MESHES[0], *[f"Step {k} is bad." for k in range(1, 9)]]
    notes = _run(_tracker({0: TRUE[0]}, meshes)).notes
    assert notes[5] == "3 more steps could not be used either."


@pytest.fixture
def report_all(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every step is told, however quick it was."""
    monkeypatch.setattr("keypose.tracker.surface.fit.segment.REPORT_S", 0.0)


def _stop_at(step: int) -> Callable[[Pass, int], None]:
    def emit(path: Pass, done: int) -> None:
        if done == step:
            raise Cancelled

    return emit


def _is_same(one: SegmentResult, other: SegmentResult) -> bool:
    return (
        np.array_equal(one.trajectory.Rs_parent_part, other.trajectory.Rs_parent_part)
        and np.array_equal(one.trajectory.ps_camera_root, other.trajectory.ps_camera_root)
        and all(
            np.array_equal(mine, its, equal_nan=True)
            for (_, mine), (_, its) in zip(
                one.diagnostics.arrays(), other.diagnostics.arrays(), strict=True
            )
        )
        and one.verdict == other.verdict
        and (one.notes, one.missing) == (other.notes, other.missing)
    )


@pytest.mark.usefixtures("report_all")
def test_a_fit_that_is_stopped_keeps_what_was_done_and_says_what_was_not() -> None:
    found = _tracker({0: TRUE[0]}).run_segment((0, 8), _stop_at(5))
    assert found.missing == 3
    assert found.verdict == Verdict.check("not_fitted", (6, 8))
    assert _errors_m(found)[:6].max() < 0.005
    assert _is_pose(found.trajectory.pose(8), found.trajectory.pose(5))
    assert found.diagnostics.rank[5:].tolist() == [-1] * 3
    assert np.isnan(found.diagnostics.residual[5:]).all()
    assert (found.unreached, found.notes) == ((6, 8), ())


@pytest.mark.usefixtures("report_all")
@pytest.mark.parametrize(
    ("ends", "steps"),
    [
        *(((end,), steps) for end in (0, 8) for steps in ((1,), (5,), (2, 4, 7))),
        *(((0, 8), steps) for steps in ((1,), (8,), (9,), (2, 7, 15))),
    ],
)
@pytest.mark.parametrize("bad", [None, 4])
def test_a_fit_goes_on_where_it_was_stopped_and_comes_out_the_same(
    ends: tuple[int, ...], steps: tuple[int, ...], bad: int | None
) -> None:
    meshes = ["Gone." if k == bad else mesh for k, mesh in enumerate(MESHES)]
    keys = {frame: TRUE[frame] for frame in ends}
    tracker = _tracker(keys, meshes, ends[0])
    for step in steps:
        assert tracker.run_segment((0, 8), _stop_at(step)).missing in (len(ends) * 8 - step, 0)
    numbers: list[int] = []
    went_on = tracker.run_segment((0, 8), lambda step, number: numbers.append(number))
    assert not numbers or numbers[0] == steps[-1] + 1
    assert _is_same(went_on, _run(_tracker(keys, meshes, ends[0])))
    assert went_on.missing == 0


@pytest.mark.usefixtures("report_all")
def test_between_two_keyframes_what_one_chain_has_reached_leads_over_to_the_other() -> None:
    tracker = _tracker({0: TRUE[0], 8: TRUE[8]})
    early = tracker.run_segment((0, 8), _stop_at(3))
    assert (early.missing, early.unreached) == (13, (4, 7))
    assert early.verdict == Verdict.check("not_fitted", (4, 7))
    assert _is_pose(early.trajectory.pose(8), TRUE[8])
    assert _errors_m(early).max() < 0.02  # an even motion
    late = tracker.run_segment((0, 8), _stop_at(12))
    assert (late.missing, late.unreached) == (4, None)
    assert late.verdict == Verdict.check("one_keyframe", (1, 7))
    assert _errors_m(late).max() < 0.005


@pytest.mark.usefixtures("report_all")
def test_a_stopped_fit_that_was_lost_before_says_so() -> None:
    meshes = [MESHES[0], *(surface_of(BODY, bent(BODY, 2.5, (0, 0, 2.0)), 2) for _ in range(5))]
    tracker = SurfaceTracker(Given(meshes), BODY, {0: TRUE[0]}, 0, OPTIONS)
    assert tracker.run_segment((0, 5), _stop_at(3)).verdict.kind == "lost"


def test_what_is_stopped_before_the_first_step_is_left_as_it_was() -> None:
    def stop(step: Pass, done: int) -> None:
        raise Cancelled

    class Stopped(Given):
        def mesh(self, frame: int) -> SurfaceMesh:
            if frame == 1:
                raise Cancelled
            return super().mesh(frame)

    tracker = SurfaceTracker(Stopped(list(MESHES)), BODY, {0: TRUE[0]}, 0, OPTIONS)
    with pytest.raises(Cancelled):
        tracker.run_segment((0, 8), stop)


def test_a_motion_too_fast_to_follow_is_called_lost_not_good() -> None:
    meshes = [MESHES[0], *(surface_of(BODY, bent(BODY, 2.5, (0, 0, 2.0)), 2) for _ in range(3))]
    tracker = SurfaceTracker(Given(meshes), BODY, {0: TRUE[0]}, 0, OPTIONS)
    result = tracker.run_segment((0, 3), lambda step, number: None)
    assert result.verdict.kind == "lost"
    assert result.verdict.cause == "not_followed"


def test_a_part_whose_surface_is_missing_is_named() -> None:
    meshes: list[SurfaceMesh | str] = [
        mesh if k < 3 else SurfaceMesh(mesh.vertices, mesh.faces[: len(mesh.faces) // 2])
        for k, mesh in enumerate(MESHES)
    ]
    verdict = _run(_tracker({0: TRUE[0]}, meshes)).verdict
    assert verdict.kind == "check"
    assert verdict.part == "lower"


def test_joints_are_kept_near_their_limits_and_where_surfaces_want_more_it_is_reported() -> None:
    upper, lower = BODY.parts
    low, high = -5.0, 20.0
    stiff = lower.model_copy(update={"limits_deg": {"x": (low, high), "y": (-5, 5), "z": (-5, 5)}})
    body = BODY.replaced([upper, stiff])
    tracker = SurfaceTracker(Given(list(MESHES)), body, {0: TRUE[0]}, 0, OPTIONS)
    result = tracker.run_segment((0, COUNT - 1), lambda step, number: None)
    bend = np.degrees(np.arctan2(*result.trajectory.Rs_parent_part[-1, 1, 1:, 1][::-1]))
    assert high < bend < np.degrees(0.1 + 0.1 * (COUNT - 1)) - 3
    assert (result.verdict.cause, result.verdict.part) == ("beyond_limits", "lower")


def test_limits_are_as_wide_as_what_a_person_posed() -> None:
    upper, lower = BODY.parts
    stiff = lower.model_copy(update={"limits_deg": {"x": (-5.0, 30.0)}})
    body = BODY.replaced([upper, stiff])
    keys = {0: TRUE[0], COUNT - 1: TRUE[-1]}
    result = SurfaceTracker(Given(list(MESHES)), body, keys, 0, OPTIONS).run_segment(
        (0, COUNT - 1), lambda step, number: None
    )
    assert result.verdict.kind == "good"
    assert _errors_m(result).max() < 0.005


def test_a_keyframe_that_lies_off_its_surface_is_named_and_nothing_else_is_lost() -> None:
    off = bent(BODY, 0.1, (0.0, 1.2, 0.0), (0.2, 0.1, 3.0))
    verdict = _run(_tracker({0: TRUE[0], COUNT - 1: off})).verdict
    assert verdict == Verdict.check("keyframe_off_surface", (COUNT - 1, COUNT - 1))


def test_a_part_that_carries_no_surface_is_not_said_to_turn_unseen() -> None:
    stub = Part(
        name="stub", parent="lower", joint_m=(0.0, 0.2, 0.0),
        shape=Box(low_m=(-0.001, 0.0, -0.001), high_m=(0.001, 0.002, 0.001)),
    )  # fmt: skip
    body = BODY.replaced([*BODY.parts, stub])
    pose = Pose(np.concatenate([TRUE[0].Rs_parent_part, np.eye(3)[None]]), TRUE[0].p_camera_root)
    result = SurfaceTracker(Given(list(MESHES[:3])), body, {0: pose}, 0, OPTIONS).run_segment(
        (0, 2), lambda step, number: None
    )
    assert not any("stub" in note for note in result.notes)


def test_without_a_keyframe_nothing_is_fitted_and_the_sentence_says_so() -> None:
    with pytest.raises(SessionError, match="Frame 3 has no keyframe"):
        _tracker({0: TRUE[0]}, model=3)
    tracker = _tracker({0: TRUE[0]})
    with pytest.raises(SessionError, match="Neither 2 nor 5 has a keyframe"):
        _run(tracker, (2, 5))


def test_the_model_needs_the_surface_of_its_own_step() -> None:
    with pytest.raises(SurfaceError, match="Step 0 is empty"):
        _tracker({0: TRUE[0]}, ["Step 0 is empty.", *MESHES[1:]])


def test_work_can_be_stopped_at_every_step(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("keypose.tracker.surface.fit.segment.REPORT_S", 0.0)
    done = []

    def stop_at_three(step: Pass, number: int) -> None:
        done.append(number)
        if number == 3:
            raise InterruptedError

    with pytest.raises(InterruptedError):
        _tracker({0: TRUE[0]}).run_segment((0, 8), stop_at_three)
    assert done == [1, 2, 3]


def test_what_is_reported_on_the_way_covers_the_whole_span(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("keypose.tracker.surface.fit.segment.REPORT_S", 0.0)
    reported: list[tuple[Pass, int]] = []
    tracker = _tracker({0: TRUE[0], 8: TRUE[8]})
    tracker.run_segment((0, 8), lambda step, number: reported.append((step, number)))
    assert [number for _, number in reported] == list(range(1, tracker.expected_steps((0, 8)) + 1))
    for step, _ in reported:
        assert len(step.trajectory) == COUNT
        assert step.trajectory.first_frame == 0
    assert _is_pose(reported[2][0].trajectory.pose(8), reported[2][0].trajectory.pose(3))
    assert _is_pose(reported[9][0].trajectory.pose(0), reported[9][0].trajectory.pose(6))


def test_a_rough_pose_is_laid_onto_its_step() -> None:
    tracker = _tracker({0: TRUE[0]})
    rough = Pose(
        TRUE[4].Rs_parent_part @ exp_rotation([0.1, 0.05, 0]), TRUE[4].p_camera_root + 0.02
    )
    found = tracker.fit_frame(4, rough)
    assert np.linalg.norm(joints(BODY, found) - joints(BODY, TRUE[4]), axis=1).max() < 0.005


def test_the_same_steps_give_the_same_motion_to_the_last_bit() -> None:
    one, other = (_run(_tracker({0: TRUE[0]})).trajectory for _ in range(2))
    np.testing.assert_array_equal(one.Rs_parent_part, other.Rs_parent_part)
    np.testing.assert_array_equal(one.ps_camera_root, other.ps_camera_root)
