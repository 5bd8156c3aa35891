"""One segment at its limits: what diverges, hides or cannot be seen is told and never returned."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.body.body import Body
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import exp_rotation
from keypose.tracker.session.settings import IgnoreMask
from keypose.tracker.tracking import cycle as segment_module
from keypose.tracker.tracking.drift import Motions
from keypose.tracker.tracking.frame_pair import printed_score, robust_pass
from keypose.tracker.tracking.initial import chains as chains_module
from keypose.tracker.tracking.initial.chains import Chain
from keypose.tracker.tracking.method import FULL, PREVIEW, Method, Paper
from keypose.tracker.tracking.result import SegmentResult
from keypose.tracker.tracking.scene import Scene
from keypose.tracker.video.pyramid import Clip
from tests.rendering.settings import Occluder, RenderSettings
from tests.tracker.tracking_cases import Case, case, plain, segment_of, tracked, worked

METHODS: dict[str, Method] = {"full": FULL, "preview": PREVIEW, "paper": Paper()}
every_method = pytest.mark.parametrize("method", METHODS)


@pytest.fixture(scope="module")
def cases() -> dict[str, Case]:
    return {"box": case("tumbling_box", 30, 50), "person": case("stride", 30, 50)}


def without_dofs(body: Body) -> Skeleton:
    parts = [part.model_copy(update={"tracked": ()}) for part in body.parts]
    return Skeleton.of(body.replaced(parts))


@every_method
def test_a_body_of_which_nothing_is_tracked_is_interpolated(
    cases: dict[str, Case], method: str
) -> None:
    shown = cases["box"]
    still = Case(without_dofs(shown.skeleton.body), shown.camera, shown.truth, shown.pictures)
    _, outcome = worked(still, segment_of(still), METHODS[method])
    np.testing.assert_allclose(
        outcome.trajectory.Rs_parent_part, plain(shown).Rs_parent_part, atol=1e-9
    )


def wild(place: float) -> object:
    """A pass whose motions lead to a place that no body can be at."""

    def lost(
        scene: Scene, clip: Clip, trajectory: Trajectory, *how: object
    ) -> tuple[Motions, float]:
        n, parts = len(trajectory) - 1, scene.skeleton.part_count
        ps = trajectory.ps_camera_root[1:] + np.where(np.arange(n) < n / 2, place, -place)[:, None]
        return Motions(np.tile(np.eye(3), (n, parts, 1, 1)), ps), 1e-3

    return lost


@pytest.mark.parametrize("place", [np.nan, np.inf, 400.0, -400.0])
@pytest.mark.parametrize("method", ["keypose", "paper"])
def test_a_pass_that_leaves_the_scene_is_reported_and_not_returned(
    cases: dict[str, Case], monkeypatch: pytest.MonkeyPatch, place: float, method: str
) -> None:
    shown = cases["person"]
    loop = "robust_pass" if method == "keypose" else "least_squares_pass"
    monkeypatch.setattr(segment_module, loop, wild(place))
    with np.errstate(all="ignore"):
        steps, outcome = worked(shown, segment_of(shown), FULL if method == "keypose" else Paper())
    assert outcome.diverged
    for step in steps:
        assert np.isfinite(step.trajectory.joints(shown.skeleton)).all()
        assert (step.trajectory.joints(shown.skeleton)[..., 2] > 0).all()
    assert shown.error_cm(outcome.trajectory) <= shown.error_cm(plain(shown)) + 1e-9


@pytest.mark.parametrize(
    ("method", "place"),
    [
        ("keypose", np.nan),
        ("keypose", 400.0),
        ("paper", np.nan),
        ("paper", 400.0),
    ],
)
def test_a_diverged_segment_is_never_called_good(
    cases: dict[str, Case], monkeypatch: pytest.MonkeyPatch, method: str, place: float
) -> None:
    shown = cases["box"]
    loop = "robust_pass" if method == "keypose" else "least_squares_pass"
    monkeypatch.setattr(segment_module, loop, wild(place))
    with np.errstate(all="ignore"):
        (result,) = tracked(shown.tracker(0, 20), method=method)
    assert result.verdict.kind != "good"


def test_chains_that_leave_the_scene_are_not_followed(
    cases: dict[str, Case], monkeypatch: pytest.MonkeyPatch
) -> None:
    shown = cases["box"]

    def gone(scene: Scene, clip: Clip, start: Pose, first: int, last: int, *how: object) -> object:
        n = abs(last - first) + 1
        return Chain.even(
            Trajectory(
                min(first, last), np.stack([start.Rs_parent_part] * n), np.full((n, 3), -5.0)
            )
        )

    monkeypatch.setattr(chains_module, "follow", gone)
    steps, outcome = worked(shown, segment_of(shown), FULL)
    assert not outcome.followed
    assert {step.what for step in steps} <= {"interpolation", "templates", "pass", "refinement"}
    assert any("lost on the way" in note for note in outcome.notes)
    assert shown.error_cm(outcome.trajectory) < 0.5 * shown.error_cm(plain(shown))


@pytest.mark.parametrize("z", [np.nan, -3.0, 1e4])
def test_a_refinement_that_leaves_the_scene_is_dropped(
    cases: dict[str, Case], monkeypatch: pytest.MonkeyPatch, z: float
) -> None:
    def away(scene: Scene, clip: Clip, start: Trajectory, *_: object) -> Trajectory:
        ps = start.ps_camera_root.copy()
        ps[3, 2] = z
        return Trajectory(start.first_frame, start.Rs_parent_part, ps)

    monkeypatch.setattr(segment_module, "refine", away)
    steps, outcome = worked(cases["box"], segment_of(cases["box"]), FULL)
    assert all(step.what != "refinement" for step in steps)
    assert np.isfinite(outcome.trajectory.ps_camera_root).all()


def test_a_hopeless_keyframe_is_said_to_be_lost(cases: dict[str, Case]) -> None:
    shown = cases["person"]
    tracker = shown.tracker(0, 20)
    end = shown.truth.pose(20)
    aside = Pose(
        end.Rs_parent_part @ exp_rotation([0.0, 1.5, 0.0]),
        end.p_camera_root + np.array([0.9, 0.0, -1.0]),
    )
    tracker.move_keyframe(20, aside)
    for method in ("keypose", "paper"):
        (result,) = tracked(tracker, method=method)
        assert np.isfinite(result.trajectory.joints(shown.skeleton)).all()
        assert result.closing_error < 1e-9
        if method == "keypose":
            assert result.verdict.kind == "lost"
            assert result.verdict.cause == "not_followed"
            assert result.verdict.frames is not None
            assert 0 < result.verdict.frames[0] < 20
        else:
            assert result.verdict.kind != "good"


def textureless(shown: Case) -> Case:
    return Case(shown.skeleton, shown.camera, shown.truth, np.full_like(shown.pictures, 127))


@pytest.mark.parametrize("method", ["keypose", "paper"])
def test_where_there_is_nothing_to_see_the_verdict_is_not_good(
    cases: dict[str, Case], method: str
) -> None:
    blank = textureless(cases["person"])
    (result,) = tracked(blank.tracker(0, 20), method=method)
    assert result.verdict.kind != "good"
    assert (result.diagnostics.rank == 0).all()
    joints = result.trajectory.joints(blank.skeleton)
    assert np.isfinite(joints).all()
    assert blank.error_cm(result.trajectory) < 3 * blank.error_cm(plain(blank))


def behind_a_bar(masks: tuple[IgnoreMask, ...]) -> tuple[Case, SegmentResult]:
    bar = Occluder(left_px=150.0, width_px=24.0)
    shown = case("tumbling_box", 30, 50, RenderSettings(occluder=bar))
    (result,) = tracked(shown.tracker(0, 20, masks=masks))
    return shown, result


def test_a_mask_over_a_bar_before_the_body_brings_the_accuracy_back(
    cases: dict[str, Case],
) -> None:
    corners = ((148.0, -5.0), (176.0, -5.0), (176.0, 185.0), (148.0, 185.0))
    mask = IgnoreMask(polygon=corners, first_frame=0, last_frame=20)
    shown, barred = behind_a_bar(())
    _, masked = behind_a_bar((mask,))
    (free,) = tracked(cases["box"].tracker(0, 20))
    errors = [shown.error_cm(r.trajectory) for r in (free, masked, barred)]
    assert errors[1] < 0.7 * errors[2]
    assert errors[1] < 3 * errors[0]


@pytest.mark.parametrize("method", ["keypose", "paper"])
@pytest.mark.parametrize("name", ["box", "person"])
def test_a_long_way_out_of_the_picture_never_scores_best(
    cases: dict[str, Case], name: str, method: str
) -> None:
    shown = cases[name]
    segment = segment_of(shown)
    straight = plain(shown)
    ps = straight.ps_camera_root.copy()
    ps[1:-1, 0] += 50.0
    out = Trajectory(0, straight.Rs_parent_part, ps)
    paths = (shown.truth, straight, out)
    if method == "paper":
        scores = [printed_score(shown.scene(), segment.clip, path) for path in paths]
    else:
        scores = [robust_pass(shown.scene(), segment.clip, path, 4, 1, 1e-3)[1] for path in paths]
    assert scores[0] < scores[1] < scores[2]


def test_a_body_of_one_part_without_landmarks_is_judged_by_its_turn_too(
    cases: dict[str, Case],
) -> None:
    shown = cases["box"]
    bare = shown.skeleton.body.parts[0].model_copy(update={"landmarks": {}})
    skeleton = Skeleton.of(shown.skeleton.body.replaced([bare]))
    tracker = Case(skeleton, shown.camera, shown.truth, shown.pictures).tracker(0, 20)
    end = shown.truth.pose(20)
    turned = Pose(end.Rs_parent_part @ exp_rotation([0.0, 0.0, 0.7]), end.p_camera_root)
    assert tracked(tracker)[0].verdict.kind == "good"
    tracker.move_keyframe(20, turned)
    assert tracked(tracker)[0].verdict.kind != "good"
